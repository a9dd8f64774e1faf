"""Feet are flat as they stand: in the rest pose, or in the clips where the rest pose does not stand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.analysis.flat_feet import ahead, flat_turns, flattest
from usdfoot.maths import quaternion

LEVEL = quaternion.normalised(np.array([0.3, 0.1, -0.2, 0.9]))
"""Any joint frame will do."""
OFFSET = quaternion.rotate(quaternion.inverse(LEVEL), np.array([0.0, -0.08, 0.13]))


def pitched(degrees, yaw=0.0):
    """The ankle with its heel raised, and turned about the vertical."""
    turn = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians(degrees))
    return quaternion.compose(quaternion.yaw_quaternion(np.asarray(yaw)), quaternion.compose(turn, LEVEL))


def stances(generator, count=9):
    """Feet that stand level to a degree, in any heading, and two that are on their toes."""
    pitches = np.append(generator.uniform(-1.0, 1.0, count), [50.0, 60.0])
    return pitched(pitches - pitches[:count].mean(), generator.uniform(-3.0, 3.0, count + 2))


@pytest.mark.parametrize("pitch", [-12.0, 30.0, 80.0])
def test_a_rest_pose_on_its_toes_is_not_flat(generator, pitch):
    flats = flat_turns(np.array([LEVEL, pitched(pitch)]), [stances(generator)] * 2, np.array([OFFSET] * 2))
    assert_allclose(quaternion.align_signs(flats, LEVEL), [LEVEL, LEVEL], atol=1e-3)


def test_walkers_say_what_flat_is_not_runners(generator):
    running = pitched(generator.uniform(4.0, 9.0, 6), generator.uniform(-3.0, 3.0, 6))
    both = [np.concatenate([stances(generator), running])] * 2
    flats = flat_turns(pitched(np.array([40.0, 40.0])), both, np.array([OFFSET] * 2))
    assert_allclose(quaternion.align_signs(flats, LEVEL), [LEVEL, LEVEL], atol=3e-3)


def test_heels_raised_a_little_do_not_count_where_most_feet_are_held_alike():
    alike = pitched(np.append(np.zeros(7), [0.5, 1.0, 1.9]))
    tilted, offsets = pitched(np.array([40.0, 40.0])), np.array([OFFSET] * 2)
    flats = flat_turns(tilted, [alike] * 2, offsets, same_pitch=np.radians(0.2))
    assert_allclose(quaternion.align_signs(flats, LEVEL), [LEVEL, LEVEL], atol=1e-9)


def test_a_foot_seen_with_its_heel_raised_is_as_flat_as_the_other():
    flats = np.array([ahead(pitched(0.8), OFFSET), ahead(LEVEL, OFFSET)])
    level = ahead(LEVEL, OFFSET)
    assert_allclose(quaternion.align_signs(flattest(flats, np.array([OFFSET] * 2)), level), [level] * 2, atol=1e-9)


def test_feet_that_stand_quite_differently_keep_their_pitch():
    flats = np.array([ahead(pitched(15.0), OFFSET), ahead(LEVEL, OFFSET)])
    assert_allclose(flattest(flats, np.array([OFFSET] * 2)), flats)


def test_stances_that_disagree_do_not_refute_a_rest_pose():
    raised = pitched(np.linspace(2.0, 30.0, 8))
    assert flat_turns(np.array([LEVEL, LEVEL]), [raised] * 2, np.array([OFFSET] * 2)) is None
    assert flat_turns(pitched(np.array([70.0, 70.0])), [raised] * 2, np.array([OFFSET] * 2)) is not None


def test_a_rest_pose_that_stands_is_kept(generator):
    rest = np.array([LEVEL, pitched(5.0)])
    assert flat_turns(rest, [stances(generator)] * 2, np.array([OFFSET] * 2)) is None


def test_a_foot_without_stances_stays_as_it_rests(generator):
    rest = np.array([LEVEL, pitched(40.0)])
    assert flat_turns(rest, [stances(generator), np.zeros((0, 4))], np.array([OFFSET] * 2)) is None


def test_ahead_is_along_z_with_the_same_elevation(generator):
    turns = pitched(generator.uniform(-20.0, 40.0, 5), generator.uniform(-3.0, 3.0, 5))
    direction = quaternion.rotate(ahead(turns, OFFSET), OFFSET)
    assert_allclose(direction[:, 0], 0.0, atol=1e-12)
    assert np.all(direction[:, 2] > 0.0)
    assert_allclose(direction[:, 1], quaternion.rotate(turns, OFFSET)[:, 1], atol=1e-12)
