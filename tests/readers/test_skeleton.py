"""Skeletons with or without a rest pose, with joint scales, and with faults."""

import logging

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, UsdSkel, Vt

from tests.scenes import JOINTS, OFFSETS, Units, add_character, new_stage
from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.skeleton import fold_scales, read_skeleton, split_matrices


def skeleton_prim(**options):
    stage = new_stage()
    return stage, add_character(stage, "/World/Hero", Units(), **options)


def test_the_rest_pose_is_read_joint_by_joint(caplog):
    _, skeleton = skeleton_prim()
    with caplog.at_level(logging.WARNING):
        raw = read_skeleton(skeleton.GetPrim())
    assert not caplog.text
    assert raw.joints == JOINTS
    assert raw.path == "/World/Hero/Skeleton"
    assert_allclose(raw.translations, OFFSETS, atol=1e-12)
    assert_allclose(raw.rotations, np.tile([0, 0, 0, 1.0], (11, 1)))
    assert_allclose(raw.scales, 1.0)


@pytest.mark.parametrize(
    ("rest", "why"), [(0, "are not authored for every joint"), (len(JOINTS), "put all joints on one spot")]
)
def test_without_a_rest_pose_the_bind_pose_is_used_and_said(caplog, rest, why):
    _, skeleton = skeleton_prim(with_rest=False)
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1.0)] * rest))
    with caplog.at_level(logging.WARNING):
        raw = read_skeleton(skeleton.GetPrim())
    assert_allclose(raw.translations, OFFSETS, atol=1e-12)
    assert f"restTransforms {why}, the bind pose is used" in caplog.text


def test_a_bind_pose_on_one_spot_says_nothing(caplog):
    _, skeleton = skeleton_prim()
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1.0)] * len(JOINTS)))
    with caplog.at_level(logging.WARNING):
        raw = read_skeleton(skeleton.GetPrim())
    assert raw.bind_matrices is None
    assert_allclose(raw.translations, OFFSETS, atol=1e-12)
    assert "bindTransforms put all joints on one spot, the rest pose is used" in caplog.text


def test_bind_transforms_that_are_not_one_a_joint_are_said(caplog):
    _, skeleton = skeleton_prim()
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1.0)] * 3))
    with caplog.at_level(logging.WARNING):
        raw = read_skeleton(skeleton.GetPrim())
    assert raw.bind_matrices is None
    assert f"has 3 bindTransforms for its {len(JOINTS)} joints, the rest pose is used" in caplog.text


def test_names_that_usd_takes_for_no_hierarchy_are_said(caplog):
    _, skeleton = skeleton_prim(joints=["/".join(f"rig:{name}" for name in joint.split("/")) for joint in JOINTS])
    with caplog.at_level(logging.WARNING):
        raw = read_skeleton(skeleton.GetPrim())
    assert raw.parents.tolist() == [-1, 0, 1, 0, 3, 4, 5, 0, 7, 8, 9]
    assert "11 joint name(s) are no USD paths, so other programs see these joints unconnected" in caplog.text
    assert "write rig:Hips as rig_Hips" in caplog.text


def test_a_scaled_root_lengthens_the_bones_below_it():
    _, skeleton = skeleton_prim()
    rest = list(skeleton.GetRestTransformsAttr().Get())
    rest[0] = Gf.Matrix4d().SetScale(3.0) * rest[0]
    skeleton.GetRestTransformsAttr().Set(Vt.Matrix4dArray(rest))
    raw = read_skeleton(skeleton.GetPrim())
    assert_allclose(raw.translations, np.vstack([OFFSETS[:1], 3.0 * OFFSETS[1:]]), atol=1e-12)
    assert_allclose(raw.scales[0], 3.0)
    assert_allclose(raw.inherited_scales, [1.0, *[3.0] * 10])
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    expected = [tuple(m.ExtractTranslation()) for m in query.ComputeJointSkelTransforms(0, True)]
    found, _ = forward_kinematics(raw.parents, raw.translations, raw.rotations)
    assert_allclose(found, expected, atol=1e-9)


def test_scales_multiply_down_the_hierarchy():
    parents = np.array([-1, 0, 1])
    scales = np.array([[[2.0] * 3, [3.0] * 3, [5.0] * 3]])
    folded, inherited = fold_scales(parents, np.ones((4, 3, 3)), scales, where="/Rig")
    assert_allclose(inherited, [1.0, 2.0, 6.0])
    assert_allclose(folded[:, :, 0], np.tile([1.0, 2.0, 6.0], (4, 1)))


def test_matrices_split_into_what_they_were_made_of(generator):
    rotations = quaternion.normalised(generator.normal(size=(8, 4)))
    rotations *= np.sign(rotations[:, 3:])
    scales, translations = generator.uniform(0.2, 3.0, (8, 3)), generator.normal(size=(8, 3))
    matrices = np.tile(np.eye(4), (8, 1, 1))
    matrices[:, :3, :3] = scales[:, :, None] * np.swapaxes(quaternion.to_matrix(rotations), -1, -2)
    matrices[:, 3, :3] = translations
    for found, expected in zip(split_matrices(matrices), (translations, rotations, scales), strict=True):
        assert_allclose(found, expected, atol=1e-9)


def scaled(attribute, factor, joint=1):
    """Has a joint's matrix multiplied by a factor."""

    def spoil(skeleton):
        matrices = list(skeleton.GetPrim().GetAttribute(attribute).Get())
        matrices[joint] = Gf.Matrix4d().SetScale(factor) * matrices[joint]
        skeleton.GetPrim().GetAttribute(attribute).Set(Vt.Matrix4dArray(matrices))

    return spoil


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda s: s.GetJointsAttr().Clear(), "has no joints. author the joints attribute"),
        (lambda s: s.GetJointsAttr().Set(["a", "b", "a"]), "lists joints twice: a. every joint path must be unique"),
        (
            lambda s: s.GetBindTransformsAttr().Clear(),
            "has neither restTransforms nor bindTransforms for its 11 joints",
        ),
        (scaled("bindTransforms", float("nan")), f"bindTransforms are not finite: {JOINTS[1]}. author numbers"),
        (scaled("bindTransforms", 0.0), "bindTransforms have no inverse. author restTransforms"),
        (scaled("restTransforms", 0.0), f"restTransforms shrink joints to nothing: {JOINTS[1]}. author scales"),
    ],
)
def test_faults_are_named(spoil, message):
    _, skeleton = skeleton_prim(with_rest=message.startswith("restTransforms"))
    spoil(skeleton)
    with pytest.raises(SkeletonError, match=f"/World/Hero/Skeleton: {message}"):
        read_skeleton(skeleton.GetPrim())
