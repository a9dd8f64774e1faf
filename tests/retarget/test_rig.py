"""Rigs: the pose a body stands in, and the legs it was rigged with."""

from dataclasses import replace

from numpy.testing import assert_allclose

from usdfoot.maths.quaternion import compose, from_axis_angle
from usdfoot.model.skeleton import Pose
from usdfoot.retarget.rig import legs_as_rigged


def exported_in_mid_stride(rig):
    """Its skeleton with a frame of an animation as the rest pose, in which one hip joint is moved up and ahead."""
    translations, rotations = rig.skeleton.rest_translations.copy(), rig.skeleton.rest_rotations.copy()
    left = rig.biped.hips[0]
    translations[left] += [0.0, 0.03, 0.02]
    rotations[left] = compose(rotations[left], from_axis_angle([1.0, 0.0, 0.0], 0.6))
    return replace(rig.skeleton, rest_translations=translations, rest_rotations=rotations)


def test_a_hip_that_animators_moved_in_the_frame_exported_is_where_it_was_rigged(person):
    rig, _ = person
    mended = legs_as_rigged(exported_in_mid_stride(rig), rig.biped, rig.reference)
    assert_allclose(mended.rest_translations, rig.skeleton.rest_translations, atol=1e-6)
    assert_allclose(mended.rest_rotations, exported_in_mid_stride(rig).rest_rotations)


def test_a_rest_pose_that_stands_keeps_its_legs(person):
    rig, _ = person
    assert legs_as_rigged(rig.skeleton, rig.biped, None) is rig.skeleton
    other = Pose(places=1.1 * rig.reference.places, turns=rig.reference.turns)
    assert legs_as_rigged(rig.skeleton, rig.biped, other) is rig.skeleton
