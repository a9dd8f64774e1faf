"""What a written crowd records of an agent's motion: what became of its footsteps, and where its root went."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import ForceResults, StepResults
from usdfoot.readers.authored import authored
from usdfoot.readers.written import WrittenAgent

__all__ = ["read_root_positions", "read_step_results"]


def read_step_results(agent: WrittenAgent, units: StageUnits) -> StepResults:
    """UsdfootResultAPI of the agent's executed plan; NaN where an array is missing or not as long as the plan.

    Footsteps without a status are taken as ok, steps whose clips cannot be told as made without any.
    """
    prim = agent.skeleton_prim.GetStage().GetPrimAtPath(agent.plan.name)
    count, metre, names = len(agent.plan), units.meters_per_unit, tokens.Result

    def column(name: str, scale: float = 1.0) -> FloatArray:
        values = np.array(authored(prim, name) or (), dtype=float)
        return scale * values if len(values) == count else np.full(count, np.nan)

    counts, clips, weights = _clips(prim, count)
    return StepResults(
        blend_error=column(names.BLEND_ERROR, metre),
        placement_error=column(names.PLACEMENT_ERROR, metre),
        slide=column(names.SLIDE, metre),
        yaw_error=np.radians(column(names.YAW_ERROR)),
        hull_distance=column(names.HULL_DISTANCE, metre),
        time_warp=column(names.TIME_WARP),
        root_weight=column(names.ROOT_WEIGHT),
        beta=column(names.BETA),
        root_velocity_error=column(names.ROOT_VELOCITY_ERROR, metre),
        status=agent.status if len(agent.status) == count else (tokens.Status.OK,) * count,
        clip_counts=counts,
        clips=clips,
        clip_weights=weights,
        forces=ForceResults(
            force_imbalance=column(names.FORCE_IMBALANCE),
            clamp_time=column(names.CLAMP_TIME),
            jump_height=column(names.JUMP_HEIGHT, metre),
        )
        if authored(prim, names.FORCE_IMBALANCE) is not None
        else None,
    )


def read_root_positions(agent: WrittenAgent, units: StageUnits, codes: FloatArray) -> FloatArray:
    """Where the agent prim stands at time codes (F,), canonical [m], shape (F, 3)."""
    prim = agent.skeleton_prim
    while str(prim.GetParent().GetPath()) != tokens.Prim.AGENTS:
        prim = prim.GetParent()
    cache = UsdGeom.XformCache()
    places = []
    for code in codes.tolist():
        cache.SetTime(Usd.TimeCode(code))
        places.append(cache.GetLocalToWorldTransform(prim).ExtractTranslation())
    return units.points_to_canonical(np.array(places, dtype=float).reshape(-1, 3))


def _clips(prim: Usd.Prim, count: int) -> tuple[Any, tuple[str, ...], FloatArray]:
    """Number of clips of each step, their names and weights; none at all if the three disagree."""
    counts = np.array(authored(prim, tokens.Result.CLIP_COUNTS) or (), dtype=int)
    clips = tuple(str(name) for name in authored(prim, tokens.Result.CLIPS) or ())
    weights = np.array(authored(prim, tokens.Result.CLIP_WEIGHTS) or (), dtype=float)
    if len(counts) != count or (counts < 0).any() or not counts.sum() == len(clips) == len(weights):
        return np.zeros(count, dtype=int), (), np.zeros(0)
    return counts, clips, weights
