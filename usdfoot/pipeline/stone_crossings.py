"""Stone crossings: agents of a scene led over its stepping stones to their goals ([P] Figure 13)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from usdfoot.batch.analysed import build_once
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
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
from usdfoot.planning.stones import plan_stones
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
        progress: Told of every agent.
    """
    libraries, problems = read_agent_libraries(
        found.stage, found.prims, found.info.units, sources=[agent.source for agent in found.agents]
    )
    made, faults = {}, list(problems)
    reaches: dict[int, Reach] = {}
    tops: dict[Proportions, Stones] = {}
    for index, agent in enumerate(found.agents):
        progress("plan", index, len(found.agents))
        library = libraries.get(agent.source.name)
        if library is None:
            continue
        try:
            if id(library) not in reaches:
                reaches[id(library)] = _reach_of(library, options)
            if agent.seeker.body not in tops:
                tops[agent.seeker.body] = _stones_for(found, agent.seeker, options)
            made[agent.seeker.name] = _cross(found, agent, reaches[id(library)], tops[agent.seeker.body])
        except UsdfootError as error:
            faults.append(agent_problem(agent.seeker.name, error))
    return made, faults


def _reach_of(library: ClipLibrary, options: StoneOptions) -> Reach:
    """How far a library's steps go; without clips as far as its legs allow."""
    if options.reach == "biped" or not library.clips:
        return reach_of_biped(library.biped)
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


def _cross(found: GoalScene, agent: GoalAgent, reach: Reach, stones: Stones) -> FootstepPlan:
    """The agent's plan from where it stands to its last goal, where it faces as it came."""
    seeker = agent.seeker
    ground = Ground(found.terrain, fallback_height=float(seeker.start[1]))
    start, goal = on_ground(ground, seeker.start), on_ground(ground, seeker.goals[-1])
    ahead = float(planar.yaw_of((goal - start)[[0, 2]]))
    yaw = ahead if seeker.yaw is None else seeker.yaw
    plan = plan_stones(
        stones,
        stance_at(start, yaw, reach),
        stance_at(goal, ahead, reach),
        reach=reach,
        body=seeker.body,
        speed=agent.authored_speed,
        name=seeker.name,
    )
    return replace(plan, name=seeker.name)
