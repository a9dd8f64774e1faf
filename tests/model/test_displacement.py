"""Displacements: how an agent is moved as a whole."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.model.displacement import STILL, Displacement, start_of
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.trajectory import RootTrajectory

numbers = st.floats(-20.0, 20.0)
displacements = st.builds(
    lambda x, y, z, yaw: Displacement(translation=np.array([x, y, z]), yaw=yaw),
    *(numbers, numbers, numbers, st.floats(-3.0, 3.0)),
)


def plan_of(count=6, *, standing=True):
    """Straight ahead along +Z from (0.5, 0.2, 1), left first."""
    sides = np.arange(count) % 2
    strikes = 0.6 * np.arange(count)
    ahead = 0.7 * np.arange(count)
    if standing:
        strikes[1], ahead[1] = 0.0, 0.0
    positions = np.stack([np.where(sides == 0, 0.6, 0.4), np.full(count, 0.2), 1.0 + ahead], axis=1)
    return FootstepPlan(
        name="/Plan",
        sides=sides,
        positions=positions,
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)),
        strike_times=strikes,
        liftoff_times=strikes + 0.7,
        root_weights=np.zeros(count),
    )


@given(displacements, displacements)
def test_between_takes_one_place_to_another(start, end):
    between = Displacement.between(start, end)
    assert_allclose(between.points(start.translation), end.translation, atol=1e-9)
    assert_allclose(between.points(start.points(np.eye(3))), end.points(np.eye(3)), atol=1e-9)
    assert_allclose(Displacement.between(start, start).points(np.eye(3)), np.eye(3), atol=1e-9)


@given(displacements)
def test_whoever_is_displaced_starts_displaced(move):
    times, positions = np.array([0.0, 1.0]), np.array([[1.0, 0.0, 2.0], [2.0, 0.0, 2.0]])
    trajectory = RootTrajectory(name="/Way", times=times, positions=positions)
    for walk in (plan_of(), plan_of(standing=False), trajectory):
        before, after = start_of(walk), start_of(move.walk(walk))
        assert_allclose(after.translation, move.points(before.translation), atol=1e-9)
        turned = after.yaw - before.yaw - move.yaw
        assert_allclose([np.cos(turned), np.sin(turned)], [1.0, 0.0], atol=1e-9)


def test_a_plan_starts_between_its_first_contacts_and_a_trajectory_where_it_begins():
    assert_allclose(start_of(plan_of()).translation, [0.5, 0.2, 1.0])
    assert_allclose(start_of(plan_of(standing=False)).translation, [0.5, 0.2, 0.65])
    still = np.zeros((2, 3))
    given_yaws = RootTrajectory(name="/Way", times=np.array([0.0, 1.0]), positions=still, yaws=np.array([0.3, 0.9]))
    assert start_of(given_yaws).yaw == 0.3
    resting = RootTrajectory(name="/Way", times=np.array([0.0, 1.0]), positions=still, rest_yaw=0.4)
    assert start_of(resting).yaw == 0.4


def test_whoever_is_not_turned_keeps_every_bit_of_the_heading():
    plan = plan_of()
    assert Displacement(translation=np.ones(3), yaw=0.0).plan(plan).orientations is plan.orientations
    assert_allclose(STILL.plan(plan).positions, plan.positions, atol=0.0)
