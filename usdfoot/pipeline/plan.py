"""Plan: paths and trajectories of a scene become a layer of footstep plans."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot import __version__
from usdfoot.batch.analysed import build_once
from usdfoot.bridge.scene import StageInfo
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Outcome, Problem
from usdfoot.pipeline.flying import flying_like_clips
from usdfoot.pipeline.plan_doubts import find_doubts
from usdfoot.planning.path import PathOptions
from usdfoot.readers.casting import Casting
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.listing import list_scene
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.path_plans import plan_paths
from usdfoot.readers.terrain import read_terrain
from usdfoot.readers.walkers import Walker, read_walkers
from usdfoot.writers.plan_edits import PlanEdit
from usdfoot.writers.plans import PlannedAgent, write_plans

__all__ = ["PlanReport", "plan_scene_paths", "save_plans"]

ASIDE = 0.15
"""Plans whose feet stay this near to where their curve leads them keep to it [m]."""


@dataclass(frozen=True, kw_only=True)
class PlanReport(Outcome):
    """Outcome of one run of a planner."""

    file: Path
    """The layer written."""
    plans: Mapping[str, FootstepPlan]
    """By the name of their prims."""


def plan_scene_paths(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    agents: str = "*",
    options: PathOptions | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PlanReport:
    """Plan footsteps along the paths of a scene and write them as a layer ([P] 2.1).

    Every agent with usdfoot:agent:path gets a plan; every curve with UsdfootPathAPI (or every curve, if none has it)
    that no agent follows gets one too. Where a curve leads over ground nobody walks on or through an obstacle, the
    plan goes round as `PathOptions.around` says; for obstacles that are animated it waits. Agents that have clips lift
    their feet as these do, as if they were animated.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write: /Plans/<name>, and an `over` of each agent that points at its plan.
        agents: Glob on agents' names or paths.
        options: Start and end of the plans.
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, has no path or more than the limits allow.
        OutputError: If the layer cannot be written.
    """
    options = options or PathOptions(around=True)
    progress("read", 0, 0)
    listed = list_scene(scene, agents=agents, limits=limits)
    stage, info, prims, sources = listed.stage, listed.info, listed.prims, listed.chosen
    terrain, terrain_problems = read_terrain(stage, prims, info.units, limits=limits)
    habits = HabitsReader(build=build_once)
    walkers, errors = read_walkers(
        *(stage, prims, info.units), sources=sources, everyone=listed.everyone, free_paths=agents == "*", habits=habits
    )
    progress("plan", 0, 0)
    obstacles, obstacle_problems = read_obstacles(stage, prims, info.units)
    moving = MovingObstacles(prims, info.units)
    found = plan_paths(walkers, terrain, obstacles=obstacles, moving=moving, options=options)
    errors |= found.errors
    problems = [_problem(error) for error in errors.values()] + [*terrain_problems, *obstacle_problems]
    problems += [problem for problem in listed.problems if problem.severity == "error"]
    planned = _planned(walkers, found.plans)
    if not planned:
        raise _no_paths(info, problems)
    casting = Casting.to_look(stage, prims, info.units)
    planned = flying_like_clips(planned, sources, terrain=terrain, casting=casting)
    walked = [walker for walker in walkers if walker.name in found.plans]
    problems += found.waits.values()
    problems += [doubt for walker in walked for doubt in walker.doubts()]
    problems += [doubt for walker in walked if (doubt := walker.style_doubt())]
    problems += _detours(planned, walked)
    problems += find_doubts(
        planned,
        terrain,
        bodies=[walker.proportions for walker in walked],
        obstacles=moving.others(obstacles),
        moving=moving.at if moving else None,
    )
    progress("write", 0, 0)
    chosen = {name: value for name, value in asdict(options).items() if value is not None}
    file = save_plans(planned, output, info, made_by={"planner": "path", "options": chosen})
    return PlanReport(file=file, plans={part.name: part.plan for part in planned}, problems=tuple(problems))


def save_plans(
    plans: Sequence[PlannedAgent],
    output: str | os.PathLike[str],
    info: StageInfo,
    *,
    edits: Sequence[PlanEdit] = (),
    made_by: Mapping[str, Any],
) -> Path:
    """Write plans as a layer in a scene's units; gives back its path.

    Args:
        plans: New ones.
        output: Where to.
        info: Of the scene.
        edits: Of plans where they stand.
        made_by: For the layer's provenance.

    Raises:
        OutputError: If the layer cannot be written or would replace one of the scene's.
    """
    return write_plans(
        output,
        plans,
        edits=edits,
        units=info.units,
        frames_per_second=info.frames_per_second,
        sources=info.layers,
        provenance={"version": __version__, **made_by},
    )


def _planned(walkers: Sequence[Walker], plans: Mapping[str, FootstepPlan]) -> list[PlannedAgent]:
    """The plans of walkers that have one, as they are written."""
    return [
        PlannedAgent(
            name=walker.name,
            plan=plans[walker.name],
            size=walker.proportions.foot_length,
            agent=walker.agent,
            style=walker.path.style,
        )
        for walker in walkers
        if walker.name in plans
    ]


def _detours(planned: Sequence[PlannedAgent], walkers: Sequence[Walker]) -> list[Problem]:
    """A warning for each plan that leaves its curve, with how far and where."""
    left = []
    for part, walker in zip(planned, walkers, strict=True):
        positions = part.plan.positions
        distances = walker.path.distances(positions[:, GROUND_AXES])
        ends = positions[[0, -1]] - walker.path.points[[0, -1]]
        distances[[0, -1]] = np.linalg.norm(ends[:, GROUND_AXES], axis=1)
        farthest = int(np.argmax(distances))
        if distances[farthest] > ASIDE + walker.proportions.step_width:
            place = ", ".join(f"{value:.2f}" for value in positions[farthest])
            what = f"keeps {distances[farthest]:.1f} m off its curve at ({place}) m"
            message = f"{part.name}: {what}, round what nobody walks on or through. --no-around keeps to the curve"
            left.append(Problem(severity="warning", where=part.name, message=message))
    return left


def _problem(error: UsdfootError) -> Problem:
    return Problem(severity="error", where=error.where, message=str(error))


def _no_paths(info: StageInfo, problems: Sequence[Problem]) -> SceneError:
    reasons = [problem.message for problem in problems if problem.severity == "error"]
    if reasons:
        return SceneError(info.identifier, "no path can be planned", names=reasons)
    return SceneError(
        info.identifier, "has no path", "draw BasisCurves with UsdfootPathAPI, or point usdfoot:agent:path at a curve"
    )
