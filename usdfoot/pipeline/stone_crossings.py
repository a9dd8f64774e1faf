"""Stone crossings: agents of a scene led over its stepping stones to their goals ([P] Figure 13)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from usdfoot.analysis.hip_spacing import hip_width
from usdfoot.batch.analysed import build_once
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import PlanError, UsdfootError
from usdfoot.maths import planar
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.ground import Ground
from usdfoot.model.limits import BODILY, check_range
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.pipeline.goal_scene import GoalScene, agent_problem, on_ground
from usdfoot.planning.crossings import Stones, stance_at
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach, reach_of_biped, reach_of_examples
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.stones import plan_crossings
from usdfoot.planning.world import World, clearances
from usdfoot.readers.goals import GoalAgent, read_agent_libraries
from usdfoot.readers.stones import read_stones

__all__ = ["StoneOptions", "cross_stones"]


@dataclass(frozen=True, kw_only=True)
class StoneOptions:
    """Where feet may stand, and how far they step.

    Raises:
        UsdfootError: If the spacing is none.
    """

    on: str | None = None
    """Glob on prim paths of the stones: terrain meshes, Points, PointInstancers; None = all walkable terrain."""
    spacing: float = 0.12
    """Of footholds on meshes [m]."""
    reach: str = "clips"
    """clips = where the agent's clips land, its legs' where it has none; biped = its legs' always."""
    leaps: bool = False
    """Whether clips with flights count."""

    def __post_init__(self) -> None:
        check_range("spacing", self.spacing, BODILY, unit="m")


def cross_stones(
    found: GoalScene, options: StoneOptions, *, progress: Callable[[str, int, int], None]
) -> tuple[dict[str, FootstepPlan], list[Problem]]:
    """Plans by the agents' prim paths, and why some agents have none.

    Args:
        found: The scene.
        options: Where and how far.
        progress: Told of all agents of one body and clips.
    """
    libraries, problems = read_agent_libraries(
        found.stage, found.prims, found.info.units, sources=[agent.source for agent in found.agents]
    )
    made, faults = {}, list(problems)
    alike: dict[tuple[int, Proportions], list[GoalAgent]] = {}
    for agent in found.agents:
        if agent.source.name in libraries:
            alike.setdefault((id(libraries[agent.source.name]), agent.seeker.body), []).append(agent)
    tops: dict[Proportions, Stones] = {}
    for index, agents in enumerate(alike.values()):
        progress("plan", index, len(alike))
        body = agents[0].seeker.body
        try:
            reach = _reach_of(libraries[agents[0].source.name], options)
            if body not in tops:
                tops[body] = _stones_for(found, agents[0].seeker, options)
            plans: list[FootstepPlan | UsdfootError] = [*_cross(found, agents, reach, tops[body])]
        except UsdfootError as error:
            plans = [error] * len(agents)
        for agent, plan in zip(agents, plans, strict=True):
            if isinstance(plan, UsdfootError):
                faults.append(agent_problem(agent.seeker.name, plan))
            else:
                made[agent.seeker.name] = plan
    return made, faults


def _reach_of(library: ClipLibrary, options: StoneOptions) -> Reach:
    """How far a library's steps go; without clips as far as its legs allow, from hips as far apart as its own are."""
    if options.reach == "biped" or not library.clips:
        return reach_of_biped(library.biped, hip_width=hip_width(library.skeleton, library.biped))
    examples, _ = build_once(library, samples=EngineOptions().samples)
    return reach_of_examples(examples, library.biped, leaps=options.leaps)


def _stones_for(found: GoalScene, seeker: Seeker, options: StoneOptions) -> Stones:
    """Footholds of a body, those left out that are nearer to an obstacle than it is wide.

    Raises:
        PlanError: If none is left.
    """
    stones = read_stones(
        found.stage, found.info.units, found.terrain, pattern=options.on, body=seeker.body, spacing=options.spacing
    )
    world, places = World(obstacles=found.obstacles), stones.positions
    return stones.only(clearances(world, places[:, [0, 2]], places[:, 1]) >= seeker.radius)


def _cross(
    found: GoalScene, agents: Sequence[GoalAgent], reach: Reach, stones: Stones
) -> list[FootstepPlan | PlanError]:
    """The agents' plans from where each stands to its last goal, where it faces as it came."""
    terrain, starts, goals = Ground(found.terrain), [], []
    for seeker in (agent.seeker for agent in agents):
        ground = terrain.falling_back(float(seeker.start[1]))
        start, goal = on_ground(ground, seeker.start), on_ground(ground, seeker.goals[-1])
        ahead = float(planar.yaw_of((goal - start)[[0, 2]]))
        starts.append(stance_at(start, ahead if seeker.yaw is None else seeker.yaw, reach))
        goals.append(stance_at(goal, ahead, reach))
    return plan_crossings(
        stones,
        starts,
        goals,
        reach=reach,
        body=agents[0].seeker.body,
        speeds=[agent.authored_speed for agent in agents],
        names=[agent.seeker.name for agent in agents],
    )
