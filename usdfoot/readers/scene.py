"""Reads a whole scene: stage in, crowd and characters out."""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence

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

__all__ = ["read_scene"]

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
    stage = open_stage(scene)
    info = read_stage_info(stage)
    prims = collect_prims(stage)
    everyone, agent_problems = list_agents(stage, prims)
    chosen = select_agents(everyone, agents)
    plans, plan_problems = _read_plans(chosen, info.units)
    codes = _frame_codes(list(plans.values()), info.units, frames)
    terrain, terrain_problems = read_terrain(stage, prims, info.units)
    foreign = (*(source.plan for source in everyone), *(stage.GetPrimAtPath(path) for path in terrain.meshes))
    casting = Casting(
        prims=prims,
        foreign=foreign,
        units=info.units,
        frame_codes=codes,
        finder=ClipFinder(stage, prims),
    )
    cast = [agent for source in chosen if source.name in plans and (agent := casting.cast(source, plans[source.name]))]
    problems = (*agent_problems, *plan_problems, *casting.problems, *casting.unfit_clips(), *terrain_problems)
    _require_agents(info, everyone, cast, problems)
    for problem in problems:
        _logger.log(logging.ERROR if problem.severity == "error" else logging.WARNING, "%s", problem.message)
    crowd = Crowd(
        agents=tuple(cast),
        libraries=tuple(casting.libraries),
        terrain=terrain,
        frame_times=info.units.codes_to_times(codes),
        frame_rate=info.units.time_codes_per_second,
        problems=problems,
    )
    return Scene(stage=info, crowd=crowd, characters=tuple(casting.characters), frame_codes=codes)


def _read_plans(
    sources: Sequence[AgentSource], units: StageUnits
) -> tuple[dict[str, FootstepPlan], tuple[Problem, ...]]:
    """Plans by agent name, and problems with them."""
    plans: dict[str, FootstepPlan] = {}
    problems: list[Problem] = []
    for source in sources:
        try:
            plans[source.name], warnings = read_plan(source.plan, units)
            problems.extend(warnings)
        except UsdfootError as error:
            problems.append(skipped(source, error))
    return plans, tuple(problems)


def _frame_codes(plans: Sequence[FootstepPlan], units: StageUnits, frames: tuple[int, int] | None) -> FloatArray:
    """Whole time codes from before the first strike to after the last liftoff of all plans, shape (F,)."""
    if frames is not None:
        if frames[1] < frames[0]:
            raise SceneError("frames", f"{frames[0]}:{frames[1]} is empty", "give the first and the last time code")
        return np.arange(frames[0], frames[1] + 1, dtype=float)
    if not plans:
        return np.zeros(1)
    start = min(float(units.times_to_codes(plan.strike_times[0])) for plan in plans)
    end = max(float(units.times_to_codes(plan.liftoff_times.max())) for plan in plans)
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
