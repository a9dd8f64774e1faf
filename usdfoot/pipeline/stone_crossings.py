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
from usdfoot.planning.moving import Moving
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach, reach_of_biped, reach_of_examples
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.stones import plan_crossings
from usdfoot.planning.waiting import find_meetings, let_pass
from usdfoot.planning.world import Obstacle, World, clearances
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
    moving = found.moving.after(found.info.start_time)
    still = found.moving.others(found.obstacles)
    for index, agents in enumerate(alike.values()):
        progress("plan", index, len(alike))
        body = agents[0].seeker.body
        try:
            reach = _reach_of(libraries[agents[0].source.name], options)
            if body not in tops:
                tops[body] = read_stones(
                    found.stage,
                    found.info.units,
                    found.terrain,
                    pattern=options.on,
                    body=body,
                    spacing=options.spacing,
                )
            stones = _clear_stones(tops[body], agents[0].seeker, still)
            plans: list[FootstepPlan | UsdfootError] = [*_cross(found, agents, reach, stones)]
            if moving:
                plans, waits = _let_pass(found, agents, plans, reach=reach, stones=stones, moving=moving)
                faults += waits
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


def _clear_stones(stones: Stones, seeker: Seeker, obstacles: Sequence[Obstacle]) -> Stones:
    """Footholds without those that are nearer to an obstacle than a body is wide.

    Raises:
        PlanError: If none is left.
    """
    places = stones.positions
    room = clearances(World(obstacles=tuple(obstacles)), places[:, [0, 2]], places[:, 1])
    return stones.only(room >= seeker.radius)


def _let_pass(
    found: GoalScene,
    agents: Sequence[GoalAgent],
    plans: Sequence[FootstepPlan | UsdfootError],
    *,
    reach: Reach,
    stones: Stones,
    moving: Moving,
) -> tuple[list[FootstepPlan | UsdfootError], list[Problem]]:
    """The plans of agents, those that meet something that moves later, or over stones where it neither is nor stays."""
    seekers = [agent.seeker for agent in agents]
    own = [row for row, plan in enumerate(plans) if isinstance(plan, FootstepPlan)]
    known = [plan for plan in plans if isinstance(plan, FootstepPlan)]
    later, waits = list(plans), list[Problem]()
    for index, met in find_meetings(known, [seekers[row].body for row in own], moving).items():
        row, wait = own[index], 0.0
        ways: list[FootstepPlan | UsdfootError] = [known[index]]
        passed = _passed(found, seekers[row], ways[0], moving)
        if passed is None:
            ways = [*_cross_elsewhere(found, agents[row], reach, stones, moving=moving)]
            passed = _passed(found, seekers[row], ways[0], moving)
        if passed is not None and isinstance(ways[0], FootstepPlan):
            later[row], wait = passed, float(passed.strike_times[-1] - ways[0].strike_times[-1])
        if passed is None or wait > 0.0:
            waits.append(_told(seekers[row].name, met, wait))
    return later, waits


def _passed(found: GoalScene, seeker: Seeker, plan: FootstepPlan | UsdfootError, moving: Moving) -> FootstepPlan | None:
    """A plan that lets what moves pass, None if it cannot."""
    if not isinstance(plan, FootstepPlan):
        return None
    ground = Ground(found.terrain, fallback_height=float(plan.positions[:, 1].min()))
    return let_pass(plan, seeker.body, moving, ground=ground)


def _cross_elsewhere(
    found: GoalScene, agent: GoalAgent, reach: Reach, stones: Stones, *, moving: Moving
) -> list[FootstepPlan | UsdfootError]:
    """An agent's plan over the footholds that what moves is not on, neither first nor last."""
    try:
        free = _clear_stones(stones, agent.seeker, [*moving.at(0.0), *moving.at(moving.end)])
        return [*_cross(found, [agent], reach, free)]
    except PlanError as error:
        return [error]


def _told(name: str, met: tuple[str, float], wait: float) -> Problem:
    """What is said of an agent that meets an obstacle at a time [s], and waits so long for it [s], 0 = in vain."""
    what, time = met
    message = f"{name}: waits {wait:.1f} s for {what}"
    if wait <= 0.0:
        message = (
            f"{name}: meets {what} {time:.1f} s after the start, and to wait or to go over other stones does not help"
        )
    return Problem(severity="warning", where=name, message=message)


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
