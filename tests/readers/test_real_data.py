"""Everything read of the real data, seen through forward kinematics, is what UsdSkel computes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Usd, UsdSkel

from tests.references import canonical_points, usdskel_positions
from usdfoot.bridge.similarity import Similarity
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.clips import read_clip
from usdfoot.readers.joints import match_joints
from usdfoot.readers.skeleton import skeleton_in
from usdfoot.readers.stage import collect_prims, read_stage_info

BIPEDS = [
    "bandai/bandai_clips.usdc",
    "cmu/cmu_clips.usdc",
    "pfnn/LocomotionFlat04_000.usdc",
    "pab/pab_walk.usdc",
    "pab/pab_jog.usdc",
    "knight/knight_Walking_A.usdc",
    "knight/knight_Walking_Backwards.usdc",
    "knight/knight_Running_A.usdc",
    "knight/knight_Running_Strafe_Right.usdc",
    "openusd/testUsdImagingGLSkeleton/skeleton.usda",
]
OTHERS = [
    "openusd/testUsdSkelRoot/root.usda",
    "openusd/testUsdviewSkinning/arm.usda",
    "openusd/doxygen/skinnedArm.usda",
    "openusd/testUsdImagingGLUsdSkel/arm.usda",
    "openusd/testUsdImagingGLSkelSkinning/test_lbs.usda",
    "openusd/testUsdSkelBakeSkinning/lbs.usda",
]


def scaled(scale):
    return Similarity(scale=scale, rotation=np.array([[0.0, 0.0, 0.0, 1.0]]), translation=np.zeros((1, 3)))


def any_biped(skeleton, animated):
    """A biped whose legs are joints the animation moves; the test needs no real legs."""
    moved = [i for i, match in enumerate(match_joints(animated, skeleton.joints)) if match >= 0]
    pair = (moved[0], moved[-1])
    return Biped(
        pelvis=moved[0], hips=pair, knees=pair, ankles=pair, balls=pair,
        ball_heights=np.array([0.05, 0.05]), com=np.zeros(3), nominal_leg_length=0.9, maximal_leg_length=1.0,
    )  # fmt: skip


@pytest.mark.parametrize("name", BIPEDS + OTHERS)
def test_clips_put_every_joint_where_usdskel_does(shared_data, name):
    stage = Usd.Stage.Open(str(shared_data / name))
    units = read_stage_info(stage).units
    prims = collect_prims(stage)
    finder = ClipFinder(stage, prims)
    assert prims.animations
    for animation in prims.animations:
        source = finder.source_of(animation, prims.skeletons[0])
        skeleton = skeleton_in(source.skeleton, scaled(units.meters_per_unit))
        animated = [str(joint) for joint in UsdSkel.Animation(animation).GetJointsAttr().Get()]
        clip = read_clip(source, skeleton, any_biped(skeleton, animated), units=units)
        positions, _ = forward_kinematics(skeleton.parents, clip.translations, clip.rotations)
        codes = clip.times * units.time_codes_per_second
        some = np.unique(np.linspace(0, len(codes) - 1, 12).astype(int))
        expected = usdskel_positions(stage, source.skeleton_prim, animation, codes[some])
        expected = canonical_points(stage, expected)
        assert_allclose(positions[some], expected, atol=1e-5)
