"""Clips as exporters really write them end up as the same canonical motion."""

import logging

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from tests.readers.clip_scenes import TIMES, expected_positions, positions, read, scene
from tests.scenes import JOINTS, OFFSETS, Units, add_character, add_clip, new_stage, walk_pose
from usdfoot.bridge.tokens import Clip as Token
from usdfoot.errors import ClipError
from usdfoot.maths import quaternion
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.stage import collect_prims

EVERY_UNITS = [
    Units(m, u, r) for m, u, r in ((1.0, "Y", 24), (0.01, "Z", 30), (0.0254, "Y", 60), (0.01, "Y", 48), (1, "Z", 120))
]


@pytest.mark.parametrize("units", EVERY_UNITS)
def test_units_axes_and_rates_do_not_matter(units):
    clip, actor = read(scene(units))
    assert clip.rate == pytest.approx(30.0)
    assert_allclose(clip.times, TIMES, atol=1e-9)
    assert_allclose(positions(clip, actor), expected_positions(), atol=2e-6)


def test_samples_at_fractions_of_codes_keep_their_times():
    times = 0.013 + TIMES
    clip, actor = read(scene(times=times))
    assert clip.start_time == pytest.approx(0.013)
    assert_allclose(positions(clip, actor), expected_positions(times), atol=1e-6)


def test_irregular_samples_are_resampled():
    times = np.sort(np.concatenate([np.arange(0.0, 1.0, 1.0 / 60.0), [0.1013, 0.5551, 0.7007]]))
    clip, actor = read(scene(times=times))
    assert clip.rate == pytest.approx(60.0)
    assert_allclose(positions(clip, actor), expected_positions(clip.times), atol=2e-4)


def test_translations_and_rotations_may_have_samples_of_their_own():
    stage = scene()
    attribute = UsdSkel.Animation(stage.GetPrimAtPath("/World/walk")).GetTranslationsAttr()
    for code in attribute.GetTimeSamples()[1:-1:2]:
        attribute.ClearAtTime(code)
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), expected_positions(), atol=2e-3)


def test_a_scale_and_rotation_above_the_skeleton_are_applied():
    """What Blender writes: a Z-up armature in centimetres under a scaled, turned and moving Xform, no SkelRoot."""
    units = Units(1.0, "Z", 30.0)
    inner = Units(0.01, "Y")
    stage = new_stage(None, units)
    xform = UsdGeom.Xform.Define(stage, "/World/Hero/Armature")
    add_character(stage, "/World/Hero/Armature/Rig", inner, root_type="Xform")
    xform.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0))
    xform.AddRotateXOp().Set(90.0)
    xform.AddScaleOp().Set(Gf.Vec3f(0.01))
    translations, rotations = walk_pose(TIMES)
    moved = translations.copy()
    moved[:, 0] = OFFSETS[0]
    written = Units(0.01, "Y", 30.0)
    add_clip(stage, "/World/Hero/Armature/Rig/Skeleton/walk", written, TIMES, moved, rotations)
    for time, shift in zip(TIMES, (translations - moved)[:, 0], strict=True):
        xform.GetTranslateOp().Set(Gf.Vec3d(*units.points(shift)), time * units.rate)
    clip, actor = read(stage, "/World/Hero/Armature/Rig/Skeleton/walk")
    assert actor.skeleton_to_agent.scale == pytest.approx(0.01)
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-5)


def test_a_turned_prim_turns_the_clip_and_not_its_joints():
    """3ds Max hangs the thighs on the spine: the pelvis has one bone and could be turned about it unnoticed."""
    joints = [
        joint.replace("Hips/Left", "Hips/Spine/Left").replace("Hips/Right", "Hips/Spine/Right") for joint in JOINTS
    ]
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), joints=joints)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero")).AddRotateYOp().Set(90.0)
    moved, turned = walk_pose(TIMES, OFFSETS, joints)
    add_clip(stage, "/World/Hero/Skeleton/walk", Units(), TIMES, moved, turned, joints=joints)
    clip, _ = read(stage, "/World/Hero/Skeleton/walk")
    quarter = quaternion.yaw_quaternion(np.array(0.5 * np.pi))
    turned[:, 0] = quaternion.compose(quarter, turned[:, 0])
    assert_allclose(np.abs(np.sum(clip.rotations * turned, axis=-1)), 1.0, atol=1e-6)


def test_a_moving_transform_that_is_not_the_clip_s_is_left_out():
    """The character travels along a trajectory; the clip in the library is not bound to it."""
    stage = scene()
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero")).AddTranslateOp()
    for code in range(0, 100, 5):
        op.Set(Gf.Vec3d(float(code), 0.0, 0.0), code)
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-6)


def test_a_uniform_joint_scale_is_folded_into_the_bones():
    """Root joint scaled by 100 over bones in metres, on a stage in centimetres."""
    stage = new_stage(None, Units(0.01))
    add_character(stage, "/World/Hero", Units(0.01))
    translations, rotations = walk_pose(TIMES)
    translations = translations.copy()
    translations[:, 1:] *= 0.01
    scales = np.ones((len(JOINTS), 3))
    scales[0] = 100.0
    add_clip(stage, "/World/walk", Units(0.01), TIMES, translations, rotations, scales=scales)
    clip, actor = read(stage)
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-5)


def test_uneven_joint_scales_are_left_out_with_a_warning(caplog):
    scales = np.ones((len(JOINTS), 3))
    scales[3] = (1.0, 1.5, 1.0)
    with caplog.at_level(logging.WARNING):
        read(scene(scales=scales))
    assert "/World/walk: scales of 1 joint(s) differ between axes" in caplog.text


def test_quaternions_are_unit_and_do_not_flip():
    stage = scene()
    attribute = UsdSkel.Animation(stage.GetPrimAtPath("/World/walk")).GetRotationsAttr()
    for i, code in enumerate(attribute.GetTimeSamples()):
        flipped = np.array(attribute.Get(code)) * (-1.7 if i % 2 else 0.6)
        attribute.Set(Vt.QuatfArray.FromNumpy(flipped.astype(np.float32)), code)
    clip, actor = read(stage)
    assert_allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=1e-9)
    assert np.all(np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1) > 0.0)
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-6)


def test_a_layer_offset_moves_and_stretches_the_clip(tmp_path):
    source = scene()
    source.GetRootLayer().Export(str(tmp_path / "clips.usda"))
    stage = new_stage(None, Units())
    stage.OverridePrim("/World/Sub").GetReferences().AddReference(
        str(tmp_path / "clips.usda"), "/World", Sdf.LayerOffset(48.0, 2.0)
    )
    clip, _ = read(stage, "/World/Sub/walk", "/World/Sub/Hero")
    assert clip.start_time == pytest.approx(2.0)
    assert clip.rate == pytest.approx(15.0 * 2)  # 15 Hz is too sparse and is filled in


def test_authored_attributes_are_read():
    stage = scene(Units(0.01, "Z", 30.0))
    prim = stage.GetPrimAtPath("/World/walk")

    def author(name, kind, value):
        prim.CreateAttribute(name, kind, False).Set(value)

    author(Token.STYLE, Sdf.ValueTypeNames.Token, "old")
    author(Token.ROOT_MOTION, Sdf.ValueTypeNames.Token, "inPlace")
    author(Token.CYCLIC, Sdf.ValueTypeNames.Bool, True)
    author(Token.MIRROR, Sdf.ValueTypeNames.Bool, False)
    author(Token.START, Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(3.0))
    author(Token.END, Sdf.ValueTypeNames.TimeCode, Sdf.TimeCode(24.0))
    author(
        Token.STRIKE_TIMES[1], Sdf.ValueTypeNames.TimeCodeArray, Sdf.TimeCodeArray([Sdf.TimeCode(6), Sdf.TimeCode(18)])
    )
    clip, _ = read(stage)
    assert (clip.style, clip.root_motion, clip.cyclic, clip.mirror) == ("old", "inPlace", True, False)
    assert (clip.range_start, clip.range_end) == pytest.approx((0.1, 0.8))
    assert clip.events[0].strike_times is None
    assert_allclose(clip.events[1].strike_times, [0.2, 0.6])


def test_nothing_authored_means_find_out():
    clip, _ = read(scene())
    assert (clip.style, clip.root_motion, clip.cyclic, clip.mirror) == ("default", "auto", None, True)
    assert (clip.range_start, clip.range_end) == (None, None)


def test_a_clip_without_the_legs_is_refused_by_name():
    translations, rotations = walk_pose(TIMES)
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    add_clip(stage, "/World/walk", Units(), TIMES, translations[:, :3], rotations[:, :3], joints=JOINTS[:3])
    with pytest.raises(
        ClipError, match="/World/walk: does not move the leg joints of /World/Hero/Skeleton: LeftUpLeg, Right"
    ):
        read(stage)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda a: a.GetRotationsAttr().Clear(), "has no rotations for its 11 joints"),
        (lambda a: keep_first(a), "has fewer than two time samples. a clip needs at least two"),
        (lambda a: set_nan(a), "translations at time code 2.4 are not finite"),
        (lambda a: all_scales(a, 0.0), "gives legs no length: LeftLeg, RightLeg, LeftFoot, RightFoot"),
        (lambda a: all_scales(a, np.inf), "scales at time code 0 are not finite"),
        (lambda a: token(a, Token.SOURCE, "dream"), "usdfoot:clip:source is dream. author one of recorded, synthetic"),
        (lambda a: token(a, Token.ROOT_MOTION, "hop"), "usdfoot:clip:rootMotion is hop. author one of auto"),
        (lambda a: code(a, Token.START, 900.0), "has the range 37.5 to 0.9667 s but samples from 0 to 0.9667 s"),
        (lambda a: codes(a, Token.STRIKE_TIMES[0], [5, 4]), "usdfoot:clip:left:strikeTimes do not increase"),
        (
            lambda a: codes(a, Token.STRIKE_TIMES[0], [1005, 1020]),
            "contact times from 41.88 to 42.5 s lie outside its samples from 0 to 0.9667 s",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_clip_is_said(spoil, message):
    stage = scene()
    spoil(UsdSkel.Animation(stage.GetPrimAtPath("/World/walk")))
    with pytest.raises(ClipError, match=f"/World/walk: {message}"):
        read(stage)


def test_a_clip_squeezed_into_no_time_by_an_offset_is_refused(tmp_path):
    """Analysis looks at windows of so many seconds: a billion samples of it."""
    source = scene()
    source.GetRootLayer().Export(str(tmp_path / "clips.usda"))
    stage = new_stage()
    offset = Sdf.LayerOffset(0.0, 1e-9)
    stage.DefinePrim("/World").GetReferences().AddReference(str(tmp_path / "clips.usda"), "/World", offset)
    with pytest.raises(
        ClipError, match=r"/World/walk: has 3e\+10 samples a second\. correct their times, or the offset"
    ):
        read(stage)


def keep_first(animation):
    for attribute in (animation.GetRotationsAttr(), animation.GetTranslationsAttr()):
        for time in attribute.GetTimeSamples()[1:]:
            attribute.ClearAtTime(time)


def set_nan(animation):
    attribute = animation.GetTranslationsAttr()
    broken = np.array(attribute.Get(2.4))
    broken[4, 1] = np.nan
    attribute.Set(Vt.Vec3fArray.FromNumpy(broken), attribute.GetTimeSamples()[3])


def all_scales(animation, value):
    scales = np.full((len(animation.GetJointsAttr().Get()), 3), value, dtype=np.float16)
    animation.GetScalesAttr().Set(Vt.Vec3hArray.FromNumpy(scales))


def token(animation, name, value):
    animation.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Token, False).Set(value)


def code(animation, name, value):
    animation.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.TimeCode, False).Set(Sdf.TimeCode(value))


def codes(animation, name, values):
    attribute = animation.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.TimeCodeArray, False)
    attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(value) for value in values]))


def test_the_stage_is_not_touched():
    stage = scene()
    before = stage.GetRootLayer().ExportToString()
    read(stage)
    assert stage.GetRootLayer().ExportToString() == before
    assert not stage.GetSessionLayer().ExportToString().count("def ")


def test_instances_share_one_clip(tmp_path):
    source = scene()
    source.GetRootLayer().Export(str(tmp_path / "asset.usda"))
    stage = new_stage()
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/World/{name}")
        prim.GetReferences().AddReference(str(tmp_path / "asset.usda"))
        prim.SetInstanceable(True)
    prims = collect_prims(stage)
    assert [str(prim.GetPath()) for prim in prims.animations] == ["/World/A/walk", "/World/B/walk"]
    finder = ClipFinder(stage, prims)
    assert [str(prim.GetPath()) for prim in finder.animations_below([])] == ["/World/A/walk"]
    clip, actor = read(stage, "/World/A/walk", "/World/B/Hero")
    assert_allclose(positions(clip, actor), expected_positions(), atol=1e-6)
    assert isinstance(stage, Usd.Stage)


def test_blend_shapes_come_along():
    stage = scene()
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/World/walk"))
    animation.CreateBlendShapesAttr(["smile", "blink"])
    codes = animation.GetRotationsAttr().GetTimeSamples()
    for code, smile in ((codes[0], 0.0), (codes[-1], 1.0)):
        animation.CreateBlendShapeWeightsAttr().Set([smile, 0.5], code)
    clip, _ = read(stage)
    assert clip.shapes.names == ("smile", "blink")
    assert_allclose(clip.shapes.weights, np.stack([np.linspace(0, 1, len(clip.times)), 0.5 + 0 * clip.times], axis=1))
