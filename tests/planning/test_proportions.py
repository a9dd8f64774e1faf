"""Proportions: of the pose in which a character stands."""

from dataclasses import replace

import numpy as np
import pytest

from tests.walker_body import walker_rig
from usdfoot.maths.quaternion import compose, from_axis_angle
from usdfoot.model.skeleton import Pose, forward_kinematics
from usdfoot.planning.proportions import proportions_of


def test_feet_of_a_rest_pose_in_mid_stride_are_as_long_as_they_were_rigged():
    skeleton, biped = walker_rig()
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    bind = Pose(places=places, turns=turns)
    standing, rotations = proportions_of(skeleton, biped, bind), skeleton.rest_rotations.copy()
    ankle = biped.ankles[1]
    rotations[ankle] = compose(rotations[ankle], from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(1.2)))
    stride = replace(skeleton, rest_rotations=rotations)
    assert proportions_of(stride, biped, bind) == standing
    assert proportions_of(stride, biped).foot_length < 0.8 * standing.foot_length
    assert standing.foot_length == pytest.approx(proportions_of(skeleton, biped).foot_length)
