"""Reads a whole scene: stage in, crowd and characters out."""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np
from pxr import Usd

from usdfoot.bridge.scene import Scene, StageInfo
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.readers.agents import AgentSource, list_agents, select_agents
from usdfoot.readers.casting import Casting, skipped
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.plans import read_plan
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.readers.terrain import read_terrain

__all__ = ["SceneReader", "read_scene"]

_logger = logging.getLogger(__name__)

_ROUNDING = 1e-6


def read_scene(
    scene: str | os.PathLike[str] | Usd.Stage, *, agents: str = "*", frames: tuple[int, int] | None = None
) -> Scene:
    """Everything usdfoot needs of a stage, in canonical space; the stage is not changed.

    What cannot be used becomes a problem of the crowd, and the rest goes on.

    Args:
        scene: File or open stage.
        agents: Glob on the names or prim paths of the agents to read.
        frames: First and last time code of the output; None = from the first strike to the last liftoff of all agents.

    Raises:
        SceneError: If the stage cannot be opened or no agent at all can be used.
    """
    read = SceneReader(scene, agents=agents, frames=frames).read()
    for problem in read.crowd.problems:
        _logger.log(logging.ERROR if problem.severity == "error" else logging.WARNING, "%s", problem.message)
    return read


class SceneReader:
    """A stage opened once, whose agents can be read a few at a time; the rest is read only once.

    Args:
        scene: File or open stage; never changed.
        agents: Glob on the names or prim paths of the agents that can be read.
        frames: First and last time code of the output; None = from the first strike to the last liftoff of all agents.
        reload: Read the files again where this process has read them before.

    Raises:
        SceneError: If the stage cannot be opened, the glob matches nobody or the frames are none.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str] | Usd.Stage,
        *,
        agents: str = "*",
        frames: tuple[int, int] | None = None,
        reload: bool = False,
    ) -> None:
        stage = open_stage(scene)
        if reload:
            stage.Reload()
        prims = collect_prims(stage)
        self.info = read_stage_info(stage)
        self._everyone, self._agent_problems = list_agents(stage, prims)
        self._chosen = select_agents(self._everyone, agents)
        self._plans: dict[str, FootstepPlan | UsdfootError] = {}
        self._plan_problems: list[Problem] = []
        codes = _frame_codes(self._all_plans(), self.info.units, frames)
        self._terrain, self._terrain_problems = read_terrain(stage, prims, self.info.units)
        foreign = (
            *(source.plan for source in self._everyone),
            *(stage.GetPrimAtPath(path) for path in self._terrain.meshes),
        )
        self._casting = Casting(
            prims=prims, foreign=foreign, units=self.info.units, frame_codes=codes, finder=ClipFinder(stage, prims)
        )
        self._codes = codes

    def read(self, *, names: Collection[str] | None = None) -> Scene:
        """The agents with these names and all they need.

        Args:
            names: Of agents; None = all that the glob matches.

        Raises:
            SceneError: If none of them can be used.
        """
        casting = self._casting
        cast = []
        for source in self._chosen:
            if names is not None and source.name not in names:
                continue
            plan = self._plan_of(source)
            agent = casting.cast(source, plan) if isinstance(plan, FootstepPlan) else None
            if agent is not None:
                cast.append(agent)
        problems = (
            *self._agent_problems,
            *self._plan_problems,
            *casting.problems,
            *casting.unfit_clips(),
            *self._terrain_problems,
        )
        _require_agents(self.info, self._everyone, cast, problems)
        crowd = Crowd(
            agents=tuple(cast),
            libraries=tuple(casting.libraries),
            terrain=self._terrain,
            frame_times=self.info.units.codes_to_times(self._codes),
            frame_rate=self.info.units.time_codes_per_second,
            problems=problems,
        )
        return Scene(stage=self.info, crowd=crowd, characters=tuple(casting.characters), frame_codes=self._codes)

    def _all_plans(self) -> Iterator[FootstepPlan]:
        """Every plan that can be read."""
        for source in self._chosen:
            plan = self._plan_of(source)
            if isinstance(plan, FootstepPlan):
                yield plan

    def _plan_of(self, source: AgentSource) -> FootstepPlan | UsdfootError:
        """An agent's plan or why there is none, read once."""
        if source.name not in self._plans:
            try:
                self._plans[source.name], warnings = read_plan(source.plan, self.info.units)
                self._plan_problems.extend(warnings)
            except UsdfootError as error:
                self._plans[source.name] = error
                self._plan_problems.append(skipped(source, error))
        return self._plans[source.name]


def _frame_codes(plans: Iterable[FootstepPlan], units: StageUnits, frames: tuple[int, int] | None) -> FloatArray:
    """Whole time codes from before the first strike to after the last liftoff of all plans, shape (F,)."""
    if frames is not None:
        if frames[1] < frames[0]:
            raise SceneError("frames", f"{frames[0]}:{frames[1]} is empty", "give the first and the last time code")
        return np.arange(frames[0], frames[1] + 1, dtype=float)
    ranges = np.array([(plan.strike_times[0], plan.liftoff_times.max()) for plan in plans])
    if not len(ranges):
        return np.zeros(1)
    start, end = units.times_to_codes(np.array([ranges[:, 0].min(), ranges[:, 1].max()]))
    return np.arange(np.floor(start + _ROUNDING), np.ceil(end - _ROUNDING) + 1.0)


def _require_agents(
    info: StageInfo, everyone: Sequence[AgentSource], cast: Sequence[Agent], problems: Sequence[Problem]
) -> None:
    """Raises SceneError if nothing is left to animate."""
    if cast:
        return
    errors = [problem.message for problem in problems if problem.severity == "error"]
    if not everyone and not errors:
        raise SceneError(
            info.identifier,
            "has no footstep plan",
            "add a PointInstancer with UsdfootPlanAPI: protoIndices, positions, usdfoot:plan:strikeTimes, "
            "usdfoot:plan:liftoffTimes",
        )
    raise SceneError(info.identifier, "no agent can be used", names=errors)
