"""Fixers of what can be put right without guessing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdValidation, Vt

from usdfoot.bridge import tokens
from usdfoot.errors import UsdfootError
from usdfoot.maths import quaternion
from usdfoot.maths.types import IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.mend import mend_times, strike_order
from usdfoot.readers.authored import authored
from usdfoot.readers.plans import read_draft
from usdfoot.readers.stage import read_stage_info
from usdfoot.validators.plans import CONCATENATED, PER_STEP

__all__ = ["complete_fixers", "plan_fixers", "rotation_fixers"]

PER_FOOTSTEP = (
    UsdGeom.Tokens.protoIndices,
    UsdGeom.Tokens.positions,
    UsdGeom.Tokens.orientations,
    "orientationsf",
    tokens.Plan.STRIKE_TIMES,
    tokens.Plan.LIFTOFF_TIMES,
    tokens.Plan.ROOT_WEIGHTS,
    tokens.Plan.STYLES,
    *PER_STEP,
)
"""Arrays of a plan that are put in order together."""

Change = Callable[[Usd.Prim, str], None]


def complete_fixers() -> list[Any]:
    """Fixer of an animation without scales: nobody scales its joints."""
    return [_fixer("AuthorScales", "authors scales of 1", "MissingAttribute", _author_scales, _is_scales)]


def rotation_fixers() -> list[Any]:
    """Fixers of rotations, which do both: normalise, and take the sign of the sample before."""
    told = "normalises rotations and makes their signs continuous"
    return [
        _fixer("NormaliseRotations", told, "RotationNotUnit", _normalise, _is_editable),
        _fixer("ContinueRotations", told, "RotationSignChange", _normalise, _is_editable),
    ]


def plan_fixers() -> list[Any]:
    """Fixers of the order and the times of footsteps, where what was meant can be known."""
    told = "puts footsteps in order of strike and liftoffs between the strikes"
    return [
        _fixer("OrderFootsteps", told, "FootstepOrder", _order_footsteps, _is_mendable),
        _fixer("MendTimes", told, "PlanInconsistent", _order_footsteps, _is_mendable),
    ]


def _fixer(name: str, told: str, error_name: str, change: Change, can: Callable[[Usd.Prim, str], bool]) -> Any:
    """A fixer that changes the prim of an error at an edit target of its stage."""

    def can_apply(error: Any, edit_target: Usd.EditTarget, time_code: Usd.TimeCode) -> bool:
        prim, attribute = _place(error)
        stack = prim.GetStage().GetLayerStack() if prim else []
        return bool(prim) and edit_target.GetLayer() in stack and _is_editable(prim, attribute) and can(prim, attribute)

    def apply(error: Any, edit_target: Usd.EditTarget, time_code: Usd.TimeCode) -> bool:
        prim, attribute = _place(error)
        with Usd.EditContext(prim.GetStage(), edit_target):
            change(prim, attribute)
        return True

    return UsdValidation.ValidationFixer(
        name=name,
        description=told,
        fixerImplFn=apply,
        canApplyFn=can_apply,
        keywords=["usdfoot"],
        errorName=error_name,
    )


def _place(error: Any) -> tuple[Usd.Prim, str]:
    """Prim of an error and the attribute it is about, "" if none."""
    site = error.GetSites()[0]
    if site.IsProperty():
        return site.GetProperty().GetPrim(), site.GetProperty().GetName()
    return site.GetPrim(), ""


def _is_editable(prim: Usd.Prim, attribute: str) -> bool:
    return not prim.IsInstanceProxy() and not prim.IsInPrototype()


def _is_scales(prim: Usd.Prim, attribute: str) -> bool:
    return attribute == "scales" and bool(authored(prim, "joints"))


def _author_scales(prim: Usd.Prim, attribute: str) -> None:
    prim.GetAttribute("scales").Set(Vt.Vec3hArray(len(authored(prim, "joints")), Gf.Vec3h(1.0)))


def _normalise(prim: Usd.Prim, attribute: str) -> None:
    rotations = prim.GetAttribute("rotations")
    codes = rotations.GetTimeSamples()
    before = None
    for code in map(Usd.TimeCode, codes) if codes else [Usd.TimeCode.Default()]:
        values = np.array(rotations.Get(code), dtype=float)
        length = np.linalg.norm(values, axis=-1, keepdims=True)
        still = np.array([0.0, 0.0, 0.0, 1.0]) if before is None else before
        usable = np.isfinite(length) & (length > 1e-6)
        values = np.where(usable, values / np.where(usable, length, 1.0), still)
        if before is not None:
            values = quaternion.align_signs(values, before)
        rotations.Set(Vt.QuatfArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32)), code)
        before = values


def _mended(prim: Usd.Prim) -> tuple[PlanDraft, PlanDraft]:
    draft, _ = read_draft(prim, read_stage_info(prim.GetStage()).units)
    return draft, mend_times(draft)


def _is_mendable(prim: Usd.Prim, attribute: str) -> bool:
    try:
        FootstepPlan.checked(_mended(prim)[1])
    except UsdfootError:
        return False
    return True


def _order_footsteps(prim: Usd.Prim, attribute: str) -> None:
    draft, mended = _mended(prim)
    order = strike_order(draft)
    _order_clips(prim, order)
    for name in PER_FOOTSTEP:
        values = authored(prim, name)
        if values is not None and len(values) == len(order):
            prim.GetAttribute(name).Set(type(values)([values[step] for step in order.tolist()]))
    if np.any(draft.liftoff_times[order] != mended.liftoff_times):
        codes = read_stage_info(prim.GetStage()).units.times_to_codes(mended.liftoff_times)
        liftoffs = Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in codes.tolist()])
        prim.GetAttribute(tokens.Plan.LIFTOFF_TIMES).Set(liftoffs)


def _order_clips(prim: Usd.Prim, order: IntArray) -> None:
    """Put the clips and weights of the footsteps in a new order, while their counts are still in the old one."""
    counts = np.array(authored(prim, tokens.Result.CLIP_COUNTS) or (), dtype=int)
    if len(counts) != len(order):
        return
    stops = np.cumsum(counts)
    rows = [row for step in order.tolist() for row in range(stops[step] - counts[step], stops[step])]
    for name in CONCATENATED:
        values = authored(prim, name)
        if values is not None and len(values) == len(rows):
            prim.GetAttribute(name).Set(type(values)([values[row] for row in rows]))
