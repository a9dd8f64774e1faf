"""Many plans checked at once are what each is by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.strategies import footstep_plans
from usdfoot.errors import PlanError
from usdfoot.model.limits import FARTHEST
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import ARRAYS, checked_plans, cut_plans
from usdfoot.model.plan_draft import PlanDraft

STRANGE = st.sampled_from([0.0, 1.0, 2.0, -1.0, 0.5, np.nan, np.inf, -np.inf, 2.0 * FARTHEST, 1e300])


@st.composite
def drafts(draw: st.DrawFn) -> PlanDraft:
    """A plan, or one of which something is not as it was."""
    draft = PlanDraft(**vars(draw(footstep_plans())))
    for name in draw(st.lists(st.sampled_from(ARRAYS), max_size=2)):
        values = getattr(draft, name).copy()
        kind = draw(st.sampled_from(["value", "neighbour", "short"]))
        row = draw(st.integers(0, len(values) - 1)) if len(values) else 0
        if kind == "short":
            values = values[: draw(st.integers(0, len(values)))]
        elif len(values) and kind == "neighbour":
            values[row] = values[row - 1]
        elif len(values) and name == "sides":
            values[row] = draw(st.integers(-1, 3))
        elif len(values):
            values[row] = draw(STRANGE)
        draft = replace(draft, **{name: values})
    return replace(draft, styles=draw(st.sampled_from([draft.styles, ("calm",)])))


def one_by_one(draft: PlanDraft) -> FootstepPlan | PlanError:
    try:
        return FootstepPlan.checked(draft)
    except PlanError as error:
        return error


@given(st.lists(drafts(), max_size=6))
def test_what_is_wrong_with_many_is_what_is_wrong_with_each(many: list[PlanDraft]) -> None:
    for found, expected in zip(checked_plans(many), map(one_by_one, many), strict=True):
        assert type(found) is type(expected)
        if isinstance(found, FootstepPlan) and isinstance(expected, FootstepPlan):
            assert vars(found).keys() == vars(expected).keys()
            assert all(value is getattr(expected, name) for name, value in vars(found).items())
        else:
            assert str(found) == str(expected)


@given(st.lists(drafts(), min_size=1, max_size=6))
def test_plans_cut_from_a_table_are_its_rows_or_the_first_error(many: list[PlanDraft]) -> None:
    many = [replace(draft, styles=()) for draft in many if len({len(getattr(draft, name)) for name in ARRAYS}) == 1]
    if not many:
        return
    table = replace(many[0], **{name: np.concatenate([getattr(draft, name) for draft in many]) for name in ARRAYS})
    names, counts = [draft.name for draft in many], np.array([len(draft.sides) for draft in many])
    errors = [str(found) for found in map(one_by_one, many) if isinstance(found, PlanError)]
    try:
        plans = cut_plans(table, counts, names=names)
    except PlanError as error:
        assert str(error) == errors[0]
        return
    assert not errors
    for plan, draft in zip(plans, many, strict=True):
        assert plan.name == draft.name
        assert all(np.array_equal(getattr(plan, name), getattr(draft, name)) for name in ARRAYS)
