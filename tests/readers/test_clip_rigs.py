"""Clips made on other rigs: which skeleton they mean, and the same motion on the character's joints."""

import logging

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, UsdSkel, Vt

from tests.readers.clip_scenes import TIMES, expected_positions, positions, read
from tests.scenes import JOINTS, OFFSETS, Units, add_character, add_clip, new_stage, walk_pose
from usdfoot.bridge.tokens import Clip as Token
from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.stage import collect_prims


def test_joint_subsets_in_another_order_take_the_rest_of_the_skeleton():
    order = [9, 3, 0, 4, 5, 8, 7]
    translations, rotations = walk_pose(TIMES)
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    names = [JOINTS[i] for i in order]
    add_clip(stage, "/World/walk", Units(), TIMES, translations[:, order], rotations[:, order], joints=names)
    clip, _ = read(stage)
    missing = [i for i in range(len(JOINTS)) if i not in order]
    assert_allclose(clip.translations[:, order], translations[:, order], atol=1e-6)
    assert_allclose(clip.rotations[:, order], rotations[:, order], atol=1e-6)
    assert_allclose(
        clip.translations[:, missing], np.broadcast_to(OFFSETS[missing], (len(TIMES), len(missing), 3)), atol=1e-6
    )
    assert_allclose(clip.rotations[:, missing], np.broadcast_to([0, 0, 0, 1], (len(TIMES), len(missing), 4)), atol=1e-6)


def test_a_clip_of_a_prefixed_rig_with_an_extra_root_fits():
    joints = ["/".join(["Armature", *(f"mixamorig:{part}" for part in joint.split("/"))]) for joint in JOINTS]
    lift = np.array([0.0, 0.1, 0.0])
    offsets = np.vstack([lift, OFFSETS])
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    add_character(stage, "/World/Other", Units(), joints=["Armature", *joints], offsets=offsets)
    translations, rotations = walk_pose(TIMES)
    translations = np.concatenate([np.broadcast_to(lift, (len(TIMES), 1, 3)), translations], axis=1)
    rotations = np.concatenate([np.broadcast_to([0.0, 0, 0, 1], (len(TIMES), 1, 4)), rotations], axis=1)
    animation = add_clip(stage, "/World/walk", Units(), TIMES, translations, rotations, joints=["Armature", *joints])
    animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Other/Skeleton"])
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), expected_positions() + lift, atol=1e-6)


def test_other_proportions_stay_the_clip_s_own():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    add_character(stage, "/World/Tall", Units(), offsets=1.2 * OFFSETS)
    animation = add_clip(stage, "/World/walk", Units(), TIMES, *walk_pose(TIMES, 1.2 * OFFSETS))
    animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Tall/Skeleton"])
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), expected_positions(offsets=1.2 * OFFSETS), atol=1e-6)


def test_a_clip_of_a_rig_with_other_joint_axes_is_the_same_motion(caplog):
    """The same joints and the same motion, every joint's axes turned: local rotations mean something else there."""
    axes = quaternion.normalised(np.random.default_rng(3).normal(size=(len(JOINTS), 4)))
    parents = [JOINTS.index(joint.rsplit("/", 1)[0]) if "/" in joint else -1 for joint in JOINTS]
    above = quaternion.inverse(np.array([axes[parent] if parent >= 0 else [0.0, 0.0, 0.0, 1.0] for parent in parents]))

    def turned(translations, rotations):
        local = quaternion.compose(above, quaternion.compose(rotations, axes))
        return quaternion.rotate(above, translations), local

    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    other = add_character(stage, "/World/Other", Units())
    rest = zip(*turned(OFFSETS, np.tile([0.0, 0.0, 0.0, 1.0], (len(JOINTS), 1))), strict=True)
    matrices = [Gf.Matrix4d(Gf.Rotation(Gf.Quatd(turn[3], *turn[:3])), Gf.Vec3d(*place)) for place, turn in rest]
    other.GetRestTransformsAttr().Set(Vt.Matrix4dArray(matrices))
    animation = add_clip(stage, "/World/walk", Units(), TIMES, *turned(*walk_pose(TIMES)))
    animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Other/Skeleton"])
    with caplog.at_level(logging.WARNING):
        clip, actor = read(stage)
    assert "/World/walk: joint axes differ from those of /World/Hero/Skeleton" in caplog.text
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-5)
    own = walk_pose(TIMES)[1]
    assert_allclose(np.abs(np.sum(clip.rotations * own, axis=-1)), 1.0, atol=1e-6)


def test_a_clip_in_other_units_is_scaled_to_the_character(caplog):
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    add_character(stage, "/World/Rig", Units(0.01))
    animation = add_clip(stage, "/World/walk", Units(0.01), TIMES, *walk_pose(TIMES))
    animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Rig/Skeleton"])
    with caplog.at_level(logging.WARNING):
        clip, actor = read(stage)
    assert "/World/walk: legs are 100 times as long" in caplog.text
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-5)


def test_rotations_of_a_reordered_rig_are_the_same_world_motion():
    """The clip's rig hangs the spine elsewhere; legs keep their place in skeleton space."""
    joints = ["Root", "Root/Hips", *(joint.replace("Hips", "Root/Hips", 1) for joint in JOINTS[1:])]
    turn = quaternion.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(0.4))
    translations, rotations = walk_pose(TIMES)
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    offsets = np.vstack([np.zeros((1, 3)), OFFSETS])
    add_character(stage, "/World/Other", Units(), joints=joints, offsets=offsets)
    translations = np.concatenate([np.zeros((len(TIMES), 1, 3)), translations], axis=1)
    rotations = np.concatenate([np.broadcast_to(turn, (len(TIMES), 1, 4)), rotations], axis=1)
    animation = add_clip(stage, "/World/walk", Units(), TIMES, translations, rotations, joints=joints)
    UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/World/Other")).CreateAnimationSourceRel().SetTargets(
        [animation.GetPath()]
    )
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), quaternion.rotate(turn, expected_positions()), atol=1e-6)


class TestSkeletonOfAClip:
    """Which skeleton a clip was made on."""

    def finder_and_prims(self, stage):
        return ClipFinder(stage, collect_prims(stage)), stage.GetPrimAtPath("/World/Hero/Skeleton")

    def stage(self):
        stage = new_stage()
        add_character(stage, "/World/Hero", Units())
        add_character(stage, "/World/Library/Rig", Units())
        return stage

    def skeleton(self, stage, animation):
        finder, character = self.finder_and_prims(stage)
        source = finder.source_of(animation.GetPrim(), character)
        return str(source.skeleton_prim.GetPath()), source.is_bound

    def test_the_relationship_comes_first(self):
        stage = self.stage()
        animation = add_clip(stage, "/World/Hero/Skeleton/walk", Units(), TIMES, *walk_pose(TIMES))
        animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Library/Rig/Skeleton"])
        assert self.skeleton(stage, animation) == ("/World/Library/Rig/Skeleton", True)

    def test_then_the_skeleton_above(self):
        stage = self.stage()
        animation = add_clip(stage, "/World/Library/Rig/Skeleton/walk", Units(), TIMES, *walk_pose(TIMES))
        assert self.skeleton(stage, animation) == ("/World/Library/Rig/Skeleton", True)

    def test_then_one_that_is_bound_to_it_by_inheritance(self):
        stage = self.stage()
        animation = add_clip(stage, "/World/Hero/walk", Units(), TIMES, *walk_pose(TIMES))
        above = stage.GetPrimAtPath("/World/Library")
        UsdSkel.BindingAPI.Apply(above).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
        assert self.skeleton(stage, animation) == ("/World/Library/Rig/Skeleton", True)

    def test_then_the_nearest_with_its_joints(self):
        stage = self.stage()
        animation = add_clip(stage, "/World/Library/Clips/walk", Units(), TIMES, *walk_pose(TIMES))
        assert self.skeleton(stage, animation) == ("/World/Library/Rig/Skeleton", False)
        animation = add_clip(stage, "/World/Clips/walk", Units(), TIMES, *walk_pose(TIMES))
        assert self.skeleton(stage, animation) == ("/World/Hero/Skeleton", False)

    def test_a_relationship_to_something_else_is_refused(self):
        stage = self.stage()
        animation = add_clip(stage, "/World/walk", Units(), TIMES, *walk_pose(TIMES))
        animation.GetPrim().CreateRelationship(Token.SKELETON).SetTargets(["/World/Hero"])
        with pytest.raises(SkeletonError, match="usdfoot:clip:skeleton points at /World/Hero, which is no Skeleton"):
            self.skeleton(stage, animation)


@pytest.mark.parametrize(("scene_up", "file_up"), [("Y", "Z"), ("Z", "Y")])
def test_a_clip_whose_file_has_another_up_axis_is_turned_upright(scene_up, file_up, caplog):
    """As USD leaves it where such a file is referenced: nothing is converted."""
    stage = new_stage(None, Units(1.0, scene_up))
    written = Units(0.01, file_up)
    add_character(stage, "/World/Hero", Units(1.0, scene_up))
    add_character(stage, "/World/Takes/Rig", written)
    add_clip(stage, "/World/Takes/Rig/Skeleton/walk", written, TIMES, *walk_pose(TIMES))
    with caplog.at_level(logging.WARNING):
        clip, actor = read(stage, "/World/Takes/Rig/Skeleton/walk")
    assert "its legs do not point down, as its file has another up axis" in caplog.text
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-5)


def test_a_clip_that_lies_on_a_rig_that_stands_stays_as_it_is(caplog):
    translations, rotations = walk_pose(TIMES)
    lying = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    rotations[:, 0] = quaternion.compose(lying, rotations[:, 0])
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    add_clip(stage, "/World/walk", Units(), TIMES, translations, rotations)
    with caplog.at_level(logging.WARNING):
        clip, _ = read(stage)
    assert "upright" not in caplog.text
    assert_allclose(clip.rotations, quaternion.continuous(rotations), atol=1e-6)
