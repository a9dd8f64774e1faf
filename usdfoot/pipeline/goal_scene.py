"""Scenes of agents with goals, or of wanderers: what planners read of them, and plans saved as a layer over them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdfoot.batch.analysed import build_once
from usdfoot.bridge.scene import StageInfo
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.limits import BODILY, Limits, check_limit, check_range
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.pipeline.flying import runs_like_clips
from usdfoot.pipeline.plan import PlanReport, save_plans
from usdfoot.pipeline.plan_doubts import find_doubts
from usdfoot.planning.world import Obstacle
from usdfoot.readers.agents import AgentSource, list_agents_without_plans, select_agents
from usdfoot.readers.casting import Casting
from usdfoot.readers.goals import GoalAgent, read_goal_agents
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.skeleton import check_skeletons
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.readers.terrain import read_terrain
from usdfoot.writers.plans import PlannedAgent

__all__ = ["GoalOptions", "GoalScene", "agent_problem", "on_ground", "read_goal_scene", "save_goal_plans"]


@dataclass(frozen=True, kw_only=True)
class GoalOptions:
    """What the planners take for granted of agents that do not say.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    agents: str = "*"
    """Glob on agents' names or paths."""
    speed: float = 1.3
    """Of agents without usdfoot:agent:speed [m/s]; such wander, and cross stones, as fast as their steps are."""
    radius: float = 0.25
    """Of their bodies seen from above [m]."""

    def __post_init__(self) -> None:
        check_range("speed", self.speed, BODILY, unit="m/s")
        check_range("radius", self.radius, BODILY, unit="m")


@dataclass(frozen=True, kw_only=True)
class GoalScene:
    """What was read of a scene."""

    stage: Any
    prims: Any
    info: StageInfo
    agents: tuple[GoalAgent, ...]
    obstacles: tuple[Obstacle, ...]
    """All of them at the stage's start."""
    moving: MovingObstacles
    """Those that are animated, at any time."""
    terrain: Terrain
    problems: tuple[Problem, ...]


def read_goal_scene(
    scene: str | os.PathLike[str], options: GoalOptions, *, with_goals: bool, limits: Limits
) -> GoalScene:
    """What there is to plan for the agents that have no plan yet.

    Args:
        scene: The USD scene.
        options: Who, how fast, how wide.
        with_goals: Only those that have one.
        limits: How much of it is read before it is refused.

    Raises:
        SceneError: If the scene cannot be opened, has no such agent or more than the limits allow.
    """
    stage = open_stage(scene)
    info, prims = read_stage_info(stage), collect_prims(stage, most=limits.prims)
    check_skeletons(prims.skeletons, limits)
    everyone, agent_problems = list_agents_without_plans(stage, prims, with_goals=with_goals)
    sources: Sequence[AgentSource] = select_agents(everyone, options.agents)
    check_limit(info.identifier, "agents", len(sources), limit=limits.agents)
    habits = HabitsReader(build=build_once)
    found, faults = read_goal_agents(
        stage, prims, info.units, sources=sources, speed=options.speed, radius=options.radius, habits=habits
    )
    obstacles, obstacle_problems = read_obstacles(stage, prims, info.units)
    terrain, terrain_problems = read_terrain(stage, prims, info.units, limits=limits)
    problems = (*agent_problems, *faults, *obstacle_problems, *terrain_problems)
    if not found:
        reasons = [problem.message for problem in problems if problem.severity == "error"]
        if reasons:
            raise SceneError(info.identifier, "no agent can be planned", names=reasons)
        what = "has no agent with a goal" if with_goals else "has no agent without a plan"
        raise SceneError(info.identifier, what, "apply UsdfootAgentAPI and point usdfoot:agent:goal at a prim")
    return GoalScene(
        stage=stage,
        prims=prims,
        info=info,
        agents=found,
        obstacles=obstacles,
        moving=MovingObstacles(prims, info.units),
        terrain=terrain,
        problems=problems,
    )


def save_goal_plans(
    found: GoalScene,
    made: dict[str, FootstepPlan],
    output: str | os.PathLike[str],
    *,
    problems: Sequence[Problem],
    made_by: dict[str, Any],
    alone: bool = False,
    timed: bool = True,
) -> PlanReport:
    """Writes the plans, from the stage's start, with a warning of each that cannot be walked, `alone` or together.

    Args:
        found: What the plans were made for.
        made: Plans by the agents' prim paths.
        output: Layer to write.
        problems: That came up on the way.
        made_by: Provenance.
        alone: Whether each was planned as if nobody else was there.
        timed: Whether flights are as they shall be; else those who run fly as long as their clips do.

    Raises:
        SceneError: If there is no plan.
        OutputError: If the layer cannot be written.
    """
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
    if not timed:
        casting = Casting.to_look(found.stage, found.prims, found.info.units)
        planned = runs_like_clips(planned, [agent.source for agent in walkers], terrain=found.terrain, casting=casting)
    bodies = [agent.seeker.body for agent in walkers]
    doubts = find_doubts(
        planned,
        found.terrain,
        bodies=bodies,
        obstacles=found.moving.others(found.obstacles),
        moving=found.moving.at if found.moving else None,
        alone=alone,
    )
    file = save_plans(planned, output, found.info, made_by=made_by)
    return PlanReport(file=file, plans={part.name: part.plan for part in planned}, problems=(*everything, *doubts))


def on_ground(ground: Ground, point: FloatArray) -> FloatArray:
    """The point on the ground below or just above it; itself where there is none."""
    sample = ground.heights(point[None, [0, 2]], point[[1]])
    height = sample.heights[0] if sample.hit[0] else point[1]
    return np.array([point[0], height, point[2]])


def agent_problem(where: str, error: UsdfootError) -> Problem:
    """Why an agent at a prim path has no plan."""
    message = str(error) if error.where.startswith(where) else f"{where}: {error}"
    return Problem(severity="error", where=where, message=message)
