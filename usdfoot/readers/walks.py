"""Walks: where agents go, by plans, trajectories and paths of the scene and by what artists changed of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from pxr import Usd

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.casting import skipped
from usdfoot.readers.overrides import Overrides
from usdfoot.readers.plan_sources import PlanSource, ask_plan
from usdfoot.readers.plans import Planned, plans_of
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.trajectories import TrajectoryReader

__all__ = ["WalkReader"]

_AT_ONCE = 256
"""Plans that are read at once: USD is asked about all of them before any is computed, which by turns takes longer."""


class WalkReader:
    """Where the agents of a stage go; each is read once.

    Args:
        stage: Open stage.
        units: Its units.
        everyone: All of its agents.
        overrides: Of the artists.
        planned: Plans of agents that follow a path, or why there are none, by agent name.
        most_footsteps: How many a plan may have.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        units: StageUnits,
        *,
        everyone: Sequence[AgentSource],
        overrides: Overrides,
        planned: Mapping[str, FootstepPlan | UsdfootError],
        most_footsteps: int,
    ) -> None:
        self._units = units
        self._everyone = everyone
        self._overrides = overrides
        self._planned = planned
        self._most = most_footsteps
        self._transforms = StartTransforms(stage)
        self._trajectories = TrajectoryReader(units=units)
        self._asked: dict[str, tuple[PlanSource, Planned | UsdfootError]] = {}
        self._walks: dict[str, FootstepPlan | RootTrajectory | UsdfootError] = {}
        self.problems: list[Problem] = []
        """Of what has been read."""
        self.roots: dict[str, RootTrajectory] = {}
        """Root trajectories given with plans, by agent name."""
        self.frames: dict[str, FloatArray] = {}
        """From the written plan prim to the world, where artists moved it, by agent name, shape (4, 4)."""

    def read_all(self, sources: Sequence[AgentSource]) -> Iterator[FootstepPlan | RootTrajectory]:
        """Every plan and trajectory of these agents that can be read."""
        for start in range(0, len(sources), _AT_ONCE):
            some = sources[start : start + _AT_ONCE]
            self.ask(some)
            yield from (walk for walk in map(self.walk_of, some) if not isinstance(walk, UsdfootError))

    def ask(self, sources: Iterable[AgentSource]) -> None:
        """Reads what the scene says of plans that are yet to be read, all at once."""
        asked: dict[str, PlanSource] = {}
        for source in sources:
            if source.trajectory is None and not (source.name in self._walks or source.name in self._planned):
                try:
                    asked[source.name] = self._source_of(source)
                except UsdfootError:  # asked again and told when it is read
                    continue
        plans = plans_of(list(asked.values()), self._units)
        self._asked.update(zip(asked, zip(asked.values(), plans, strict=True), strict=True))

    def walk_of(self, source: AgentSource) -> FootstepPlan | RootTrajectory | UsdfootError:
        """An agent's plan, or trajectory, or why there is none."""
        if source.name not in self._walks:
            try:
                self._walks[source.name], warnings = self._read(source)
                self.problems.extend(warnings)
            except UsdfootError as error:
                self._walks[source.name] = error
                self.problems.append(skipped(source, error))
            self._asked.pop(source.name, None)
        return self._walks[source.name]

    def given_walk(self, source: AgentSource) -> FootstepPlan | RootTrajectory:
        """What the scene has an agent walk, whatever artists changed of it.

        Raises:
            UsdfootError: If it goes nowhere.
        """
        if source.trajectory is not None:
            return self._trajectories.read(source.trajectory, source.number)
        return self._scene_plan(source)[0]

    def is_planned(self, name: str, walk: FootstepPlan | RootTrajectory) -> bool:
        """Whether what an agent walks is the plan made of the path it follows."""
        return walk is self._planned.get(name)

    def _read(self, source: AgentSource) -> tuple[FootstepPlan | RootTrajectory, tuple[Problem, ...]]:
        """Raises UsdfootError if the agent goes nowhere."""
        changed = self._overrides.plan(source.name, self._plan_of_name)
        if changed is not None:
            self.frames[source.name] = changed.frame
            return changed.plan, changed.problems
        if source.trajectory is not None:
            return self.given_walk(source), ()
        plan, warnings = self._scene_plan(source)
        return plan, (*warnings, *self._read_root(source, plan))

    def _read_root(self, source: AgentSource, plan: FootstepPlan) -> tuple[Problem, ...]:
        """Reads the root trajectory given with a plan, if there is one; one that cannot be used is a warning."""
        asked = self._asked.get(source.name)
        if asked and not asked[0].has_root:
            return ()
        try:
            root = self._trajectories.read_for_plan(source.plan, plan, source.number)
        except UsdfootError as error:
            message = f"{error}. The root goes along the footsteps instead"
            return (Problem(severity="warning", where=str(source.plan.GetPath()), message=message),)
        self.roots.update({source.name: root} if root else {})
        return ()

    def _scene_plan(self, source: AgentSource) -> Planned:
        """The plan that the scene gives an agent, and warnings.

        Raises:
            UsdfootError: If there is none.
        """
        planned = self._planned.get(source.name)
        if planned is None:
            asked = self._asked.get(source.name)
            found = asked[1] if asked else plans_of([self._source_of(source)], self._units)[0]
        else:
            found = planned if isinstance(planned, UsdfootError) else (planned, ())
        if isinstance(found, UsdfootError):
            raise found
        return found

    def _source_of(self, source: AgentSource) -> PlanSource:
        """Raises UsdfootError if the agent's plan is none, or too long."""
        return ask_plan(source.plan, self._transforms, most=self._most)

    def _plan_of_name(self, name: str) -> FootstepPlan | None:
        """The plan that the scene gives the agent of a name; of one that has none there, what it last walked."""
        source = next((source for source in self._everyone if source.name == name), None)
        if source is None:
            return None
        given = source.trajectory is None and source.path is None
        walked = None if given else self._overrides.executed_plan(name)
        return self._scene_plan(source)[0] if walked is None and source.trajectory is None else walked
