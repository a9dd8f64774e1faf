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
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
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
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.wander import plan_wanders
from usdfoot.planning.wanderer import WanderOptions
from usdfoot.planning.world import World

__all__ = ["plan_scene_crowd", "plan_scene_stones", "plan_scene_wander"]

TOGETHER = 500
"""Those who wander are planned so many at a time, for memory's sake."""

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
    task = Scenario(
        seekers=seekers,
        obstacles=found.moving.others(found.obstacles),
        bounds=None,
        moving=found.moving.after(found.info.start_time),
    )
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
        steps: Footsteps of each at most; who has not arrived by then is warned of.
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
    terrain = Ground(found.terrain)
    world_at = _world_of(found, outline, terrain if terrain.has_terrain else None)
    generators = np.random.default_rng(seed).spawn(len(found.agents))
    made, problems = {}, []
    alike: dict[Proportions, list[int]] = {}
    for number, agent in enumerate(found.agents):
        alike.setdefault(agent.seeker.body, []).append(number)
    parts = [own[first : first + TOGETHER] for own in alike.values() for first in range(0, len(own), TOGETHER)]
    for index, part in enumerate(parts):
        progress("plan", index, len(parts))
        agents = [found.agents[number] for number in part]
        seekers = [agent.seeker for agent in agents]
        plans = plan_wanders(
            world_at(0.0),
            np.array([on_ground(terrain, seeker.start) for seeker in seekers]),
            np.array([float(seeker.yaw or 0.0) for seeker in seekers]),
            generators=[generators[number] for number in part],
            names=[seeker.name for seeker in seekers],
            goals=[list(seeker.goals) for seeker in seekers],
            speeds=np.array([agent.authored_speed for agent in agents]),
            steps=steps,
            options=WanderOptions(body=seekers[0].body, radius=options.radius),
            later=world_at if found.moving else None,
        )
        for seeker, plan in zip(seekers, plans, strict=True):
            if isinstance(plan, PlanError):
                problems.append(agent_problem(seeker.name, plan))
            else:
                made[seeker.name] = plan
                problems.extend(_not_arrived(seeker, plan, terrain))
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


def _not_arrived(seeker: Seeker, plan: FootstepPlan, ground: Ground) -> tuple[Problem, ...]:
    """A warning of one with goals whose plan ends before it stands at the last: how far it got, straight to go [m]."""
    if not len(seeker.goals) or plan.ends_standing:
        return ()
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    walked = float(np.linalg.norm(np.diff(middles, axis=0), axis=1).sum())
    left = float(np.linalg.norm(on_ground(ground, seeker.goals[-1]) - middles[-1]))
    message = (
        f"{seeker.name}: does not stand at its last goal after {len(plan)} footsteps: it has gone "
        f"{walked:.1f} m and is {left:.1f} m from it; more --steps lead on"
    )
    return (Problem(severity="warning", where=seeker.name, message=message),)


def _world_of(found: GoalScene, outline: FloatArray | None, ground: Ground | None) -> Callable[[float], World]:
    """What one wanders in a time after the stage's start [s]; the same for all who ask while nothing moves on."""
    still = World(bounds=outline, obstacles=found.moving.others(found.obstacles), ground=ground)
    known: dict[int, World] = {}

    def at(time: float) -> World:
        if not found.moving:
            return still
        moving = found.moving.at(found.info.start_time + time)
        if id(moving) not in known:
            known[id(moving)] = replace(still, obstacles=(*still.obstacles, *moving))
        return known[id(moving)]

    return at
