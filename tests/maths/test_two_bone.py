"""Two bones reach, in the plane of their pose."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.maths import quaternion
from usdfoot.maths.two_bone import bend_two_bones


def limbs(generator, count=200):
    upper, lower = generator.normal(size=(2, count, 3)) + [0.0, -2.0, 0.0]
    hinge = np.cross(upper, lower)
    return upper, lower, hinge / np.linalg.norm(hinge, axis=-1, keepdims=True)


def ends(upper, lower, turns):
    return quaternion.rotate(turns[0], upper), quaternion.rotate(turns[0], upper) + quaternion.rotate(turns[1], lower)


def test_the_end_comes_to_where_it_should(generator):
    upper, lower, hinge = limbs(generator)
    lengths = np.linalg.norm(upper, axis=-1) + np.linalg.norm(lower, axis=-1)
    least = np.abs(np.linalg.norm(upper, axis=-1) - np.linalg.norm(lower, axis=-1))
    wanted = generator.normal(size=upper.shape)
    spans = least + (0.05 + 0.9 * generator.random(len(upper))) * (lengths - least)
    wanted *= (spans / np.linalg.norm(wanted, axis=-1))[:, None]
    knee, end = ends(upper, lower, bend_two_bones(upper, lower, hinge, reach=wanted))
    assert_allclose(end, wanted, atol=1e-9)
    assert_allclose(np.linalg.norm(knee, axis=-1), np.linalg.norm(upper, axis=-1))


def test_a_limb_that_is_there_keeps_its_pose(generator):
    upper, lower, hinge = limbs(generator)
    lower[:50] = upper[:50] + 1e-3 * generator.normal(size=(50, 3))  # about straight
    for turn in bend_two_bones(upper, lower, np.roll(hinge, 1, axis=0), reach=upper + lower):
        assert_allclose(np.abs(turn[:, 3]), 1.0, atol=1e-12)


@pytest.mark.parametrize("bend", [0.0, -0.03, 0.03])
def test_straight_limbs_bend_about_the_hinge(bend):
    upper, hinge = np.array([[0.0, -0.4, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    lower = 0.4 * np.array([[0.0, -np.cos(bend), -np.sin(bend)]])
    knee, end = ends(upper, lower, bend_two_bones(upper, lower, hinge, reach=np.array([[0.0, -0.6, 0.0]])))
    assert_allclose(end, [[0.0, -0.6, 0.0]], atol=1e-9)
    assert knee[0, 2] > 0.2  # forward, as a knee does


def test_what_is_out_of_reach_is_approached_straight():
    upper, lower = np.array([[0.0, -0.4, 0.1]]), np.array([[0.0, -0.4, -0.1]])
    _, end = ends(
        upper, lower, bend_two_bones(upper, lower, np.array([[1.0, 0.0, 0.0]]), reach=np.array([[0.0, -3.0, 0.0]]))
    )
    assert_allclose(end, [[0.0, -2.0 * np.hypot(0.4, 0.1), 0.0]], atol=1e-7)
