"""Footstep plans: what is valid, what is refused and how it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose

from tests.strategies import footstep_plans
from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.model.plan import FootstepPlan


def plan() -> FootstepPlan:
    strikes = np.array([0.0, 0.5, 1.0, 1.5])
    return FootstepPlan(
        name="/World/Plan",
        sides=np.array([0, 1, 0, 1]),
        positions=np.zeros((4, 3)),
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)),
        strike_times=strikes,
        liftoff_times=strikes + 0.6,
        root_weights=np.zeros(4),
    )


def changed(field: str, index: int, value: float) -> FootstepPlan:
    values = getattr(plan(), field).copy()
    values[index] = value
    return replace(plan(), **{field: values})


@given(footstep_plans())
def test_valid_plans_are_accepted_and_know_their_directions(valid: FootstepPlan) -> None:
    turned = quaternion.rotate(valid.orientations, np.array([0.0, 0.0, 1.0]))
    assert_allclose(planar.direction(valid.yaws), turned[:, [0, 2]], atol=1e-12)
    assert_allclose(valid.normals, np.tile([0.0, 1.0, 0.0], (len(valid), 1)), atol=1e-12)
    assert not valid.starts_standing


def test_a_tilted_print_keeps_its_yaw_and_has_the_slopes_normal() -> None:
    tilt = quaternion.between(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.8, -0.6]))
    orientation = quaternion.compose(quaternion.yaw_quaternion(np.array(0.7)), tilt)
    tilted = replace(plan(), orientations=np.tile(orientation, (4, 1)))
    assert_allclose(tilted.yaws, 0.7)
    assert_allclose(tilted.normals[0], [-0.6 * np.sin(0.7), 0.8, -0.6 * np.cos(0.7)], atol=1e-12)


def test_both_feet_together_at_the_ends_is_standing() -> None:
    standing = replace(
        plan(), strike_times=np.array([0.0, 0.0, 1.0, 1.5]), liftoff_times=np.array([0.6, 1.1, 2.0, 2.0])
    )
    assert (standing.starts_standing, standing.ends_standing) == (True, True)
    assert (plan().starts_standing, plan().ends_standing) == (False, False)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: replace(plan(), positions=np.zeros((3, 3))),
            r"/World/Plan: .*protoIndices 4, positions 3.* one entry a",
        ),
        (lambda: changed("sides", 2, 3), "footstep 2 has protoIndex 3. 0 = left, 1 = right"),
        (lambda: changed("positions", 1, np.nan), "positions of footstep 1 is not a finite number"),
        (lambda: changed("positions", 2, -3e38), r"footstep 2 is 3e\+38 m from the origin. author positions within"),
        (lambda: changed("strike_times", 3, np.inf), "strikeTimes of footstep 3"),
        (lambda: changed("root_weights", 0, np.nan), "rootWeights of footstep 0"),
        (lambda: changed("root_weights", 2, 1.5), "rootWeights of footstep 2 is 1.5. 0 to 1 is possible"),
        (lambda: changed("orientations", 0, 0.0), "not unit quaternions. normalise them"),
        (lambda: changed("liftoff_times", 1, 0.5), "footstep 1 lifts off at 0.5 s, not after its strike at 0.5 s"),
        (lambda: changed("strike_times", 1, 1.05), "footstep 2 strikes before footstep 1. order by strike time"),
        (lambda: changed("sides", 1, 0), "footsteps 0 and 1 are both left. left and right must alternate"),
        (lambda: changed("liftoff_times", 0, 1.2), "footstep 2 strikes at 1 s before .* left footstep 0 at 1.2 s"),
        (lambda: changed("strike_times", 1, 1.0), "footsteps 1 and 2 strike together. only the first two"),
    ],
)
def test_inconsistent_plans_are_refused(make, message: str) -> None:
    with pytest.raises(PlanError, match=message):
        make()


def test_one_footstep_is_no_plan() -> None:
    one = {name: getattr(plan(), name)[:1] for name in ("sides", "positions", "orientations", "root_weights")}
    with pytest.raises(PlanError, match=r"has 1 footstep\(s\). a plan needs at least two"):
        replace(plan(), strike_times=np.zeros(1), liftoff_times=np.ones(1), **one)
