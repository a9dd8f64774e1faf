"""How far feet come down on their own side of the other."""

import numpy as np
from numpy.testing import assert_allclose

from usdfoot.maths import planar
from usdfoot.planning.crossed import apart_midway


def test_feet_on_their_own_side_are_apart_and_crossed_ones_are_not():
    offsets = np.array([(0.1, 0.6), (0.1, 0.6), (-0.1, 0.6), (-0.1, 0.6)])  # left is +x
    apart = apart_midway(offsets, np.array([0, 1, 0, 1]), yaws_before=np.zeros(4), turns=np.zeros(4))
    assert_allclose(apart, [0.1, -0.1, -0.1, 0.1])


def test_it_is_seen_midway_through_the_turn_wherever_that_faces():
    """Straight ahead of where the foot before points, and a turn of the swing foot to its own side crosses."""
    turn = 0.4
    for yaw in (0.0, 2.0, -3.0):
        ahead = 0.7 * planar.direction(np.array([yaw]))
        apart = apart_midway(ahead, np.array([0]), yaws_before=np.array([yaw]), turns=np.array([turn]))
        assert_allclose(apart, -0.7 * np.sin(0.5 * turn))
