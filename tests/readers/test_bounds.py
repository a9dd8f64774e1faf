"""What bounds a skinned character, against USD's own boxes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pxr import UsdSkel

from tests.scenes import BALL_HEIGHT, JOINTS, OFFSETS, Units, add_character, new_stage
from usdfoot.errors import SkeletonError
from usdfoot.readers.bounds import read_bounds


def bounds_of(stage, path="/World/Hero", skeleton="Skeleton"):
    return read_bounds(stage.GetRootLayer().identifier, path, skeleton_path=skeleton, joints=JOINTS)


def test_skin_without_an_extent_pads_by_its_points():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), with_body=True)
    body = stage.GetPrimAtPath("/World/Hero/Body")
    body.RemoveProperty("extent")
    (bound,) = bounds_of(stage)
    assert bound.padding == pytest.approx(BALL_HEIGHT, rel=1e-6)


def test_without_a_rest_pose_the_bind_pose_pads():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), with_body=True, with_rest=False)
    (bound,) = bounds_of(stage)
    assert bound.padding == pytest.approx(BALL_HEIGHT, rel=1e-6)
    assert_allclose(bound.rest_matrices[:, 3, :3], OFFSETS, atol=1e-6)


def test_without_a_bind_pose_usd_has_nothing_to_warn_of(capfd):
    stage = new_stage()
    skeleton = add_character(stage, "/World/Hero", Units(), with_body=True)
    skeleton.GetPrim().RemoveProperty("bindTransforms")
    (bound,) = bounds_of(stage)
    assert bound.padding == pytest.approx(BALL_HEIGHT, rel=1e-6)
    assert capfd.readouterr().err == ""


def test_without_skin_the_joints_count():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), root_type="Xform")
    (bound,) = bounds_of(stage)
    assert bound.padding == 0.0
    assert_array_equal(bound.sources, np.arange(len(JOINTS)))


def test_a_character_that_does_not_come_along_where_it_is_referenced_is_named():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    stage.DefinePrim("/World/Hero/Again").GetReferences().AddInternalReference("/World")
    with pytest.raises(
        SkeletonError, match=r"/World/Hero/Again/Hero: has no Skeleton Skeleton where agents reference it"
    ):
        bounds_of(stage, "/World/Hero/Again/Hero")


def test_every_skeleton_with_skin_counts_by_the_joints_it_shares_with_the_animation():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), with_body=True)
    add_character(
        stage, "/World/Hero/Hair", Units(), joints=["Tuft", *JOINTS[0:1]], offsets=[(0, 2, 0)] * 2, with_body=True
    )
    hair, own = sorted(bounds_of(stage), key=lambda bound: len(bound.sources))
    assert hair.sources.tolist() == [-1, 0]
    assert_allclose(hair.rest_matrices[0, 3, :3], (0, 2, 0))
    assert len(own.sources) == len(JOINTS)


def test_an_animation_elsewhere_in_the_scene_is_no_matter_for_usd_to_warn_of(capfd):
    """As exporters leave it: the Skeleton is bound to an animation outside the character that is referenced."""
    stage = new_stage()
    skeleton = add_character(stage, "/World/Hero", Units(), with_body=True)
    UsdSkel.Animation.Define(stage, "/World/walk")
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/World/walk"])
    assert len(bounds_of(stage)) == 1
    assert capfd.readouterr().err == ""
