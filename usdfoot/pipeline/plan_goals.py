"""Plan goals: agents with goals, and wanderers, become a layer of footstep plans."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.limits import DEFAULT_LIMITS, FARTHEST, Limits, check_range
from usdfoot.pipeline.goal_scene import (
    GoalOptions,
    GoalScene,
    agent_problem,
    on_ground,
    read_goal_scene,
    save_goal_plans,
)
from usdfoot.pipeline.goal_speeds import slow_to_clips
from usdfoot.pipeline.plan import PlanReport
from usdfoot.pipeline.stone_crossings import StoneOptions, cross_stones
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.scenario import Scenario
from usdfoot.planning.wander import WanderOptions, plan_wander
from usdfoot.planning.world import World

__all__ = ["GoalOptions", "plan_scene_crowd", "plan_scene_stones", "plan_scene_wander"]

Progress = Callable[[str, int, int], None]


def plan_scene_crowd(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    duration: float = 600.0,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress = lambda stage, done, total: None,
) -> PlanReport:
    """Plan the footsteps of all agents with usdfoot:agent:goal together and write them as a layer.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write: /Plans/<name>, and an `over` of each agent that points at its plan.
        options: Who, how fast, how wide.
        duration: Simulated at most [s].
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, or no agent has a goal or can be planned.
        PlanError: If JuPedSim is not installed.
        OutputError: If the layer cannot be written.
    """
    options, how = options or GoalOptions(), CrowdOptions(duration=duration)
    progress("read", 0, 0)
    found = read_goal_scene(scene, options, with_goals=True, limits=limits)
    progress("plan", 0, 0)
    agents, slowed = slow_to_clips(found.stage, found.prims, found.info.units, agents=found.agents)
    seekers = tuple(agent.seeker for agent in agents)
    task = Scenario(seekers=seekers, obstacles=found.obstacles, bounds=None)
    plans, problems = plan_crowd(task, found.terrain, options=how)
    made = {plan.name: plan for plan in plans}
    progress("write", 0, 0)
    return save_goal_plans(
        found,
        made,
        output,
        problems=(*slowed, *problems),
        made_by={"planner": "crowd", "duration": duration, "options": asdict(options)},
        timed=False,
    )


def plan_scene_wander(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    steps: int = 100,
    seed: int = 0,
    bounds: tuple[float, float, float, float] | None = None,
    limits: Limits = DEFAULT_LIMITS,
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
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened or nobody can be planned.
        OutputError: If the layer cannot be written.
        UsdfootError: If there are fewer than two steps, more footsteps than a plan may have, or the bounds are too far.
    """
    options = options or GoalOptions()
    check_range("steps", steps, (2, DEFAULT_LIMITS.footsteps), unit="footsteps")
    for value in bounds or ():
        check_range("bounds", value, (-FARTHEST, FARTHEST), unit="m")
    progress("read", 0, 0)
    found = read_goal_scene(scene, options, with_goals=False, limits=limits)
    outline = None if bounds is None else np.array(bounds)[[[0, 1], [0, 3], [2, 3], [2, 1]]]
    generators = np.random.default_rng(seed).spawn(len(found.agents))
    terrain = Ground(found.terrain)
    made, problems = {}, []
    for index, (agent, generator) in enumerate(zip(found.agents, generators, strict=True)):
        progress("plan", index, len(found.agents))
        seeker = agent.seeker
        ground = terrain.falling_back(float(seeker.start[1]))
        world_at = _world_of(found, outline, ground)
        try:
            made[seeker.name] = plan_wander(
                world_at(0.0),
                on_ground(ground, seeker.start),
                float(seeker.yaw or 0.0),
                generator=generator,
                goals=list(seeker.goals),
                steps=steps,
                options=WanderOptions(body=seeker.body, speed=agent.authored_speed, radius=options.radius),
                later=world_at if found.moving else None,
                name=seeker.name,
            )
        except PlanError as error:
            problems.append(agent_problem(seeker.name, error))
    progress("write", 0, 0)
    made_by = {"planner": "wander", "steps": steps, "seed": seed, "options": asdict(options)}
    return save_goal_plans(found, made, output, problems=problems, made_by=made_by, alone=True)


def plan_scene_stones(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    options: GoalOptions | None = None,
    on: str | None = None,
    spacing: float = 0.12,
    reach: str = "clips",
    leaps: bool = False,
    limits: Limits = DEFAULT_LIMITS,
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
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, the glob names nothing, or nobody gets to a goal; it says how far.
        OutputError: If the layer cannot be written.
    """
    options, ways = options or GoalOptions(), StoneOptions(on=on, spacing=spacing, reach=reach, leaps=leaps)
    progress("read", 0, 0)
    found = read_goal_scene(scene, options, with_goals=True, limits=limits)
    made, problems = cross_stones(found, ways, progress=progress)
    progress("write", 0, 0)
    made_by = {"planner": "stones", "reach": reach, "leaps": leaps, "spacing": spacing, "options": asdict(options)}
    return save_goal_plans(found, made, output, problems=problems, made_by=made_by, alone=True)


def _world_of(found: GoalScene, outline: FloatArray | None, ground: Ground) -> Callable[[float], World]:
    """What one wanders in a time after the stage's start [s]."""
    still = World(bounds=outline, obstacles=found.moving.others(found.obstacles), ground=ground)

    def at(time: float) -> World:
        moving = found.moving.at(found.info.start_time + time) if found.moving else ()
        return replace(still, obstacles=(*still.obstacles, *moving))

    return at
