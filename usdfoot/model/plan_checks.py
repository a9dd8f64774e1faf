"""Plan checks: of many drafts at once, which are plans."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray
from usdfoot.model.limits import FARTHEST
from usdfoot.model.plan import FootstepPlan, PlanDraft

__all__ = ["checked_plans"]


def checked_plans(drafts: Sequence[PlanDraft]) -> list[FootstepPlan | PlanError]:
    """As `PlanDraft.checked` of each, or what is wrong with it: one by one they take several times as long."""
    return [
        _trusted(draft) if is_fine else _checked(draft)
        for draft, is_fine in zip(drafts, _are_in_order(drafts), strict=True)
    ]


def _checked(draft: PlanDraft) -> FootstepPlan | PlanError:
    try:
        return draft.checked()
    except PlanError as error:
        return error


def _trusted(draft: PlanDraft) -> FootstepPlan:
    """A plan that is known to be one: what it would check itself is left out."""
    plan = object.__new__(FootstepPlan)
    vars(plan).update(vars(draft))
    return plan


def _are_in_order(drafts: Sequence[PlanDraft]) -> list[bool]:
    """Whether drafts are plans beyond doubt, as `FootstepPlan` checks: those that are not are to be looked at again."""
    even = [index for index, draft in enumerate(drafts) if _is_even(draft)]
    found = [False] * len(drafts)
    if not even:
        return found
    own = [drafts[index] for index in even]
    owners = np.repeat(np.arange(len(own)), [len(draft.sides) for draft in own])
    wrong = np.zeros(len(own), dtype=bool)
    wrong[owners[~_rows_in_order(own, owners)]] = True
    for index, is_wrong in zip(even, wrong.tolist(), strict=True):
        found[index] = not is_wrong
    return found


def _is_even(draft: PlanDraft) -> bool:
    """Whether there are at least two footsteps, and as many entries of each."""
    count = len(draft.sides)
    arrays = draft.positions, draft.orientations, draft.strike_times, draft.liftoff_times, draft.root_weights
    return count > 1 and {*map(len, arrays), len(draft.styles) or count} == {count}


def _rows_in_order(drafts: Sequence[PlanDraft], owners: np.ndarray) -> BoolArray:
    """Whether each of all footsteps, whose drafts are at these indices, is as it must be after those before it."""
    sides, positions, orientations, strikes, liftoffs, weights = (
        np.concatenate([getattr(draft, name) for draft in drafts])
        for name in ("sides", "positions", "orientations", "strike_times", "liftoff_times", "root_weights")
    )
    lengths = np.sqrt(np.einsum("ij,ij->i", orientations, orientations))
    fine = (sides >= 0) & (sides <= 1) & (weights >= 0.0) & (weights <= 1.0) & (np.abs(lengths - 1.0) <= 1e-3)
    fine &= (np.abs(positions) <= FARTHEST).all(axis=1)
    fine &= (strikes < liftoffs) & np.isfinite(strikes) & np.isfinite(liftoffs)
    follows, comes_third = owners[1:] == owners[:-1], owners[2:] == owners[:-2]
    fine[1:] &= ~follows | ((strikes[1:] >= strikes[:-1]) & (sides[1:] != sides[:-1]))
    fine[2:] &= ~comes_third | ((strikes[2:] > liftoffs[:-2]) & (strikes[2:] > strikes[1:-1]))
    return np.asarray(fine)
