"""Plan goals: agents with goals, and wanderers, become a layer of footstep plans."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from usdfoot.batch.analysed import build_once
from usdfoot.bridge.scene import StageInfo
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import PlanError, SceneError, UsdfootError
from usdfoot.maths import planar
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.pipeline.goal_speeds import slow_to_clips
from usdfoot.pipeline.plan import PlanReport, save_plans
from usdfoot.pipeline.plan_doubts import find_doubts
from usdfoot.planning.crossings import Stones, stance_at
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach, reach_of_biped, reach_of_examples
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.stones import plan_stones
from usdfoot.planning.wander import WanderOptions, plan_wander
from usdfoot.planning.world import Obstacle, World, clearances
from usdfoot.readers.agents import AgentSource, list_agents_without_plans, select_agents
from usdfoot.readers.goals import GoalAgent, read_agent_libraries, read_goal_agents
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.readers.stones import read_stones
from usdfoot.readers.terrain import read_terrain
from usdfoot.writers.plans import PlannedAgent

__all__ = ["GoalOptions", "plan_scene_crowd", "plan_scene_stones", "plan_scene_wander"]

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, kw_only=True)
class GoalOptions:
    """What the planners take for granted of agents that do not say."""

    agents: str = "*"
    """Glob on agents' names or paths."""
    speed: float = 1.3
    """Of agents without usdfoot:agent:speed [m/s]; such wander, and cross stones, as fast as their steps are."""
    radius: float = 0.25
    """Of their bodies seen from above [m]."""


def plan_scene_crowd(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    duration: float = 600.0,
    progress: Progress = lambda stage, done, total: None,
) -> PlanReport:
    """Plan the footsteps of all agents with usdfoot:agent:goal together and write them as a layer.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write: /Plans/<name>, and an `over` of each agent that points at its plan.
        options: Who, how fast, how wide.
        duration: Simulated at most [s].
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, or no agent has a goal or can be planned.
        PlanError: If JuPedSim is not installed.
        OutputError: If the layer cannot be written.
    """
    options = options or GoalOptions()
    progress("read", 0, 0)
    found = _read(scene, options, with_goals=True)
    progress("plan", 0, 0)
    agents, slowed = slow_to_clips(found.stage, found.prims, found.info.units, agents=found.agents)
    seekers = tuple(agent.seeker for agent in agents)
    task = Scenario(seekers=seekers, obstacles=found.obstacles, bounds=None)
    plans, problems = plan_crowd(task, found.terrain, options=CrowdOptions(duration=duration))
    made = {plan.name: plan for plan in plans}
    progress("write", 0, 0)
    return _save(
        found,
        made,
        (*slowed, *problems),
        output,
        {"planner": "crowd", "duration": duration, "options": asdict(options)},
    )


def plan_scene_wander(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    steps: int = 100,
    seed: int = 0,
    bounds: tuple[float, float, float, float] | None = None,
    progress: Progress = lambda stage, done, total: None,
) -> PlanReport:
    """Plan agents without plans that wander at random, or to their goals if they have any ([P] 4.2); write a layer.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write, as for `plan_scene_crowd`.
        options: Who, how wide.
        steps: Footsteps of each at most.
        seed: Of the random numbers; each agent has its own from it and its place in the scene.
        bounds: Area to stay in: lowest x and z, highest x and z [m], canonical axes.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened or nobody can be planned.
        OutputError: If the layer cannot be written.
    """
    options = options or GoalOptions()
    progress("read", 0, 0)
    found = _read(scene, options, with_goals=False)
    outline = None if bounds is None else np.array(bounds)[[[0, 1], [0, 3], [2, 3], [2, 1]]]
    generators = np.random.default_rng(seed).spawn(len(found.agents))
    terrain = Ground(found.terrain)
    made, problems = {}, []
    for index, (agent, generator) in enumerate(zip(found.agents, generators, strict=True)):
        progress("plan", index, len(found.agents))
        seeker = agent.seeker
        ground = terrain.falling_back(float(seeker.start[1]))
        try:
            made[seeker.name] = plan_wander(
                World(bounds=outline, obstacles=found.obstacles, ground=ground),
                _on(ground, seeker.start),
                float(seeker.yaw or 0.0),
                generator=generator,
                goals=list(seeker.goals),
                steps=steps,
                options=WanderOptions(body=seeker.body, speed=agent.authored_speed, radius=options.radius),
                name=seeker.name,
            )
        except PlanError as error:
            problems.append(_problem(seeker.name, error))
    progress("write", 0, 0)
    made_by = {"planner": "wander", "steps": steps, "seed": seed, "options": asdict(options)}
    return _save(found, made, problems, output, made_by, alone=True)


def plan_scene_stones(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    on: str | None = None,
    spacing: float = 0.12,
    reach: str = "clips",
    leaps: bool = False,
    progress: Progress = lambda stage, done, total: None,
) -> PlanReport:
    """Plan agents with goals over stepping stones ([P] Figure 13) and write a layer.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write, as for `plan_scene_crowd`.
        options: Who.
        on: Glob on prim paths of the stones: terrain meshes, Points, PointInstancers; None = all walkable terrain.
        spacing: Of footholds on meshes [m].
        reach: clips = where the agent's clips land, its legs' where it has none; biped = its legs' always.
        leaps: Whether clips with flights count.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, the glob names nothing, or nobody gets to a goal; it says how far.
        OutputError: If the layer cannot be written.
    """
    options = options or GoalOptions()
    progress("read", 0, 0)
    found = _read(scene, options, with_goals=True)
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
                reaches[id(library)] = _reach_of(library, reach, leaps)
            if agent.seeker.body not in tops:
                tops[agent.seeker.body] = _stones_for(found, agent.seeker, on, spacing)
            made[agent.seeker.name] = _cross(found, agent, reaches[id(library)], tops[agent.seeker.body])
        except UsdfootError as error:
            faults.append(_problem(agent.seeker.name, error))
    progress("write", 0, 0)
    made_by = {"planner": "stones", "reach": reach, "leaps": leaps, "spacing": spacing, "options": asdict(options)}
    return _save(found, made, faults, output, made_by, alone=True)


@dataclass(frozen=True, kw_only=True)
class _Found:
    """What was read of a scene."""

    stage: Any
    prims: Any
    info: StageInfo
    agents: tuple[GoalAgent, ...]
    obstacles: tuple[Obstacle, ...]
    terrain: Terrain
    problems: tuple[Problem, ...]


def _read(scene: str | os.PathLike[str], options: GoalOptions, *, with_goals: bool) -> _Found:
    stage = open_stage(scene)
    info, prims = read_stage_info(stage), collect_prims(stage)
    everyone, agent_problems = list_agents_without_plans(stage, prims, with_goals=with_goals)
    sources: Sequence[AgentSource] = select_agents(everyone, options.agents)
    habits = HabitsReader(build=build_once)
    agents, faults = read_goal_agents(
        stage, prims, info.units, sources=sources, speed=options.speed, radius=options.radius, habits=habits
    )
    obstacles, obstacle_problems = read_obstacles(stage, prims, info.units)
    terrain, terrain_problems = read_terrain(stage, prims, info.units)
    problems = (*agent_problems, *faults, *obstacle_problems, *terrain_problems)
    if not agents:
        reasons = [problem.message for problem in problems if problem.severity == "error"]
        if reasons:
            raise SceneError(info.identifier, "no agent can be planned", names=reasons)
        what = "has no agent with a goal" if with_goals else "has no agent without a plan"
        raise SceneError(info.identifier, what, "apply UsdfootAgentAPI and point usdfoot:agent:goal at a prim")
    return _Found(
        stage=stage, prims=prims, info=info, agents=agents, obstacles=obstacles, terrain=terrain, problems=problems
    )


def _save(
    found: _Found,
    made: dict[str, FootstepPlan],
    problems: Sequence[Problem],
    output: str | os.PathLike[str],
    made_by: dict[str, Any],
    *,
    alone: bool = False,
) -> PlanReport:
    """Writes the plans, from the stage's start, with a warning of each that cannot be walked, `alone` or together."""
    everything = (*found.problems, *problems)
    if not made:
        reasons = [problem.message for problem in everything if problem.severity == "error"]
        raise SceneError(found.info.identifier, "no agent can be planned", names=reasons)
    walkers = [agent for agent in found.agents if agent.seeker.name in made]
    planned = [
        PlannedAgent(
            name=agent.source.name,
            plan=made[agent.seeker.name].later(found.info.start_time),
            size=agent.seeker.body.foot_length,
            agent=agent.seeker.name,
        )
        for agent in walkers
    ]
    bodies = [agent.seeker.body for agent in walkers]
    doubts = find_doubts(planned, found.terrain, bodies=bodies, obstacles=found.obstacles, alone=alone)
    file = save_plans(planned, output, found.info, made_by=made_by)
    return PlanReport(file=file, plans={part.name: part.plan for part in planned}, problems=(*everything, *doubts))


def _reach_of(library: ClipLibrary, kind: str, leaps: bool) -> Reach:
    """How far a library's steps go; without clips as far as its legs allow."""
    if kind == "biped" or not library.clips:
        return reach_of_biped(library.biped)
    examples, _ = build_once(library, samples=EngineOptions().samples)
    return reach_of_examples(examples, library.biped, leaps=leaps)


def _stones_for(found: _Found, seeker: Seeker, on: str | None, spacing: float) -> Stones:
    """Footholds of a body, those left out that are nearer to an obstacle than it is wide.

    Raises:
        PlanError: If none is left.
    """
    stones = read_stones(found.stage, found.info.units, found.terrain, pattern=on, body=seeker.body, spacing=spacing)
    world, places = World(obstacles=found.obstacles), stones.positions
    return stones.only(clearances(world, places[:, [0, 2]], places[:, 1]) >= seeker.radius)


def _cross(found: _Found, agent: GoalAgent, reach: Reach, stones: Stones) -> FootstepPlan:
    """The agent's plan from where it stands to its last goal, where it faces as it came."""
    seeker = agent.seeker
    ground = Ground(found.terrain, fallback_height=float(seeker.start[1]))
    start, goal = _on(ground, seeker.start), _on(ground, seeker.goals[-1])
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


def _on(ground: Ground, point: np.ndarray) -> np.ndarray:
    """The point on the ground below or just above it; itself where there is none."""
    sample = ground.heights(point[None, [0, 2]], point[[1]])
    height = sample.heights[0] if sample.hit[0] else point[1]
    return np.array([point[0], height, point[2]])


def _problem(where: str, error: UsdfootError) -> Problem:
    message = str(error) if error.where.startswith(where) else f"{where}: {error}"
    return Problem(severity="error", where=where, message=message)
