"""Edits of a plan's footsteps: what comes out is a plan, and nothing else changes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from usdfoot.errors import PlanError
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.edits import add_footstep, delete_footstep, move_footstep

STEP, LENGTH = 0.5, 0.7


def walk(count=7, *, contact=0.6, starts_standing=False, ends_standing=False, styles=()):
    """Footsteps 0.7 m and 0.5 s apart; those of a run with contacts below 0.5 s."""
    strikes = STEP * np.arange(count)
    liftoffs = strikes + contact
    ahead = LENGTH * np.arange(count)
    if starts_standing:
        strikes[0], liftoffs[0], ahead[0] = strikes[1], strikes[1] + 0.2, ahead[1]
    if ends_standing:
        liftoffs[-2:], ahead[-1] = strikes[-1] + 1.0, ahead[-2]
    sides = np.arange(count) % 2
    return FootstepPlan(
        name="plan",
        sides=sides,
        positions=np.stack([np.where(sides == 0, 0.1, -0.1), np.zeros(count), ahead], axis=1),
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)),
        strike_times=strikes,
        liftoff_times=liftoffs,
        root_weights=np.zeros(count),
        styles=styles,
    )


plans = st.builds(
    walk,
    st.integers(min_value=4, max_value=9),
    contact=st.sampled_from([0.25, 0.4, 0.6, 0.7]),
    starts_standing=st.booleans(),
    ends_standing=st.booleans(),
)


@given(plan=plans, data=st.data())
def test_every_edit_gives_a_plan(plan, data):
    row = data.draw(st.integers(min_value=0, max_value=len(plan) - 1))
    added = add_footstep(plan, row)
    assert len(added) - len(plan) == (1 if row == len(plan) - 1 else 2)
    assert added.starts_standing == plan.starts_standing and added.ends_standing == plan.ends_standing
    fewer = delete_footstep(plan, row)
    assert len(plan) - len(fewer) == (1 if row in (0, len(plan) - 1) else 2)
    assert set(map(tuple, fewer.positions)) <= set(map(tuple, plan.positions))
    moved = move_footstep(plan, row, position=np.array([1.0, 2.0, 3.0]))
    assert_array_equal(moved.strike_times, plan.strike_times)


def test_a_walk_goes_on_in_its_pace():
    plan = walk()
    longer = add_footstep(plan, 6)
    assert_allclose(longer.positions, walk(8).positions)
    assert_allclose(longer.strike_times, walk(8).strike_times)
    assert_allclose(longer.liftoff_times, walk(8).liftoff_times)
    assert_array_equal(longer.sides, walk(8).sides)


def test_two_footsteps_inside_are_spread_over_the_step_and_shift_the_rest():
    plan = walk()
    longer = add_footstep(plan, 3)
    assert_allclose(longer.strike_times, STEP * np.arange(9))
    assert_allclose(longer.liftoff_times, STEP * np.arange(9) + 0.6)
    assert_allclose(longer.positions[3:7, 2], LENGTH * np.array([3.0, 3.0 + 1.0 / 3.0, 3.0 + 2.0 / 3.0, 4.0]))
    assert_allclose(np.delete(longer.positions, [4, 5], axis=0), plan.positions)


def test_a_new_footstep_lies_where_it_is_put():
    place, turn = np.array([0.4, 0.1, 9.0]), np.array([0.0, 0.6, 0.0, 0.8])
    longer = add_footstep(walk(), 6, position=place, orientation=turn)
    assert_allclose(longer.positions[-1], place)
    assert_allclose(longer.orientations[-1], turn)


def test_feet_wait_where_they_stood_for_footsteps_that_are_gone():
    plan = walk()
    fewer = delete_footstep(plan, 3)
    assert_allclose(fewer.strike_times, np.delete(plan.strike_times, [3, 4]))
    assert_allclose(fewer.liftoff_times[1:3], plan.liftoff_times[[3, 4]])
    assert_allclose(np.delete(fewer.liftoff_times, [1, 2]), np.delete(plan.liftoff_times, [1, 2, 3, 4]))


def test_styles_go_with_their_footsteps():
    plan = walk(4, styles=("a", "b", "c", "d"))
    assert add_footstep(plan, 1).styles == ("a", "b", "c", "b", "c", "d")
    assert delete_footstep(plan, 0).styles == ("b", "c", "d")


def test_what_cannot_be_edited_is_said():
    with pytest.raises(PlanError, match=r"no footstep 7.* 0 to 6"):
        move_footstep(walk(), 7, position=np.zeros(3))
    with pytest.raises(PlanError, match="at least two"):
        delete_footstep(walk(3), 1)
