"""Plan checks: of many drafts at once, which are plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.model.plan_rules import RULES, entries

__all__ = ["checked_plans", "cut_plans"]

ARRAYS = ("sides", "positions", "orientations", "strike_times", "liftoff_times", "root_weights")
"""Of a draft, with a row each footstep."""


def checked_plans(drafts: Sequence[PlanDraft]) -> list[FootstepPlan | PlanError]:
    """As `FootstepPlan.checked` of each, or what is wrong with it: one by one they take several times as long."""
    even = [
        index for index, draft in enumerate(drafts) if len(draft.sides) > 1 and len({*entries(draft).values()}) == 1
    ]
    fine = set(np.array(even, dtype=int)[_follow_rules([drafts[index] for index in even])].tolist())
    return [_trusted(draft) if index in fine else _checked(draft) for index, draft in enumerate(drafts)]


def cut_plans(table: PlanDraft, counts: IntArray, *, names: Sequence[str]) -> list[FootstepPlan]:
    """The plans of so many footsteps each (P,) of a table that has those of all, one plan after the other.

    Raises:
        PlanError: If one is none.
    """
    ends = np.cumsum(counts)
    fine = (counts > 1) & _are_fine(table, np.repeat(np.arange(len(counts)), counts), len(counts))
    drafts = [
        PlanDraft(name=name, **{field: getattr(table, field)[begin:end] for field in ARRAYS})
        for name, begin, end in zip(names, (ends - counts).tolist(), ends.tolist(), strict=True)
    ]
    return [
        _trusted(draft) if is_plan else FootstepPlan.checked(draft)
        for draft, is_plan in zip(drafts, fine.tolist(), strict=True)
    ]


def _checked(draft: PlanDraft) -> FootstepPlan | PlanError:
    try:
        return FootstepPlan.checked(draft)
    except PlanError as error:
        return error


def _trusted(draft: PlanDraft) -> FootstepPlan:
    """A plan that is known to be one: what it would check itself is left out."""
    plan = object.__new__(FootstepPlan)
    vars(plan).update(vars(draft))
    return plan


def _follow_rules(drafts: Sequence[PlanDraft]) -> BoolArray:
    """Whether each of the drafts, whose arrays are as long as each other, breaks no rule."""
    if not drafts:
        return np.zeros(0, dtype=bool)
    arrays: dict[str, Any] = {name: np.concatenate([getattr(draft, name) for draft in drafts]) for name in ARRAYS}
    owners = np.repeat(np.arange(len(drafts)), [len(draft.sides) for draft in drafts])
    return _are_fine(replace(drafts[0], **arrays), owners, len(drafts))


def _are_fine(table: PlanDraft, owners: IntArray, count: int) -> BoolArray:
    """Whether each of so many plans, which have these of a table's footsteps (N,), ascending, breaks no rule."""
    fine = np.ones(count, dtype=bool)
    for rule in RULES:
        first, last = owners[: len(owners) - rule.reach], owners[rule.reach :]
        fine[first[rule.is_broken(table) & (first == last)]] = False
    return fine
