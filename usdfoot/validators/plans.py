"""Checks of footstep plans and what is written of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Result, Schema
from usdfoot.errors import UsdfootError
from usdfoot.model.plan import FootstepPlan
from usdfoot.readers.authored import authored
from usdfoot.readers.plans import is_plan, read_draft
from usdfoot.readers.stage import read_stage_info
from usdfoot.validators.findings import finding

__all__ = ["CONCATENATED", "PER_STEP", "check_plan"]

CONCATENATED = (Result.CLIPS, Result.CLIP_WEIGHTS)
"""Results with as many entries as the clip counts add up to."""
PER_STEP = tuple(value for name, value in vars(Result).items() if name.isupper() and value not in CONCATENATED)
"""Results with one entry a footstep."""


def check_plan(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """Arrays of a plan must have one entry a footstep, in order of strike, and so must its results."""
    if not is_plan(prim):
        return []
    try:
        draft, _ = read_draft(prim, read_stage_info(prim.GetStage()).units)
        late = np.flatnonzero(np.diff(draft.strike_times) < 0.0)
        if late.size:
            what = f"footstep {late[0] + 1} strikes before footstep {late[0]}"
            return [finding("FootstepOrder", prim, what, remedy="order all arrays by strike time")]
        FootstepPlan.checked(draft)
    except UsdfootError as error:
        return [finding("PlanInconsistent", prim, error.what, remedy=error.remedy)]
    return _check_results(prim, len(draft.sides)) if has_api(prim, Schema.RESULT) else []


def _check_results(prim: Usd.Prim, steps: int) -> list[Any]:
    """One finding for each array of results that is not as long as it must be."""
    counts = authored(prim, Result.CLIP_COUNTS)
    expected = dict.fromkeys(PER_STEP, steps) | dict.fromkeys(CONCATENATED, int(sum(counts or ())))
    found = []
    for name, right in expected.items():
        values = authored(prim, name)
        if values is not None and len(values) != right:
            what, remedy = f"has {len(values)} entries", f"{right} would be right: {steps} footsteps"
            found.append(finding("ResultLength", prim, what, attribute=name, remedy=remedy))
    return found
