"""Characters: their skeleton in the agent's space, and what a written agent must reference and hold."""

import logging

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt

from tests.references import canonical_points, usdskel_positions
from tests.scenes import BALL_HEIGHT, JOINTS, OFFSETS, Units, add_character, add_mesh, new_stage
from usdfoot.bridge.similarity import unfold_from_joints
from usdfoot.bridge.tokens import Biped as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.errors import BipedError, SkeletonError
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.assets import asset_of
from usdfoot.readers.characters import character_key, read_character
from usdfoot.readers.stage import read_stage_info

PARENTS = np.array([-1, 0, 1, 0, 3, 4, 5, 0, 7, 8, 9])
REST = forward_kinematics(PARENTS, OFFSETS, np.tile([0, 0, 0, 1.0], (11, 1)))[0]


def read(stage, path="/World/Hero", codes=(0.0,)):
    return read_character(stage.GetPrimAtPath(path), read_stage_info(stage).units, np.array(codes))


def rest_positions(character):
    skeleton = character.skeleton
    return forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)[0]


@pytest.mark.parametrize("units", [Units(), Units(0.01, "Z"), Units(0.0254, "Y"), Units(1.0, "Z")])
def test_the_rest_pose_stands_in_canonical_space(units):
    stage = new_stage(None, units)
    add_character(stage, "/World/Hero", units, with_body=True)
    character = read(stage)
    assert_allclose(rest_positions(character), REST, atol=1e-9)
    assert_allclose(character.biped.ball_heights, BALL_HEIGHT, atol=1e-6)
    assert_allclose(character.agent_rotation, (0, 0, 0, 1))
    assert character.agent_scale == 1.0
    assert character.skeleton_path == "Skeleton"
    (bound,) = character.bounds
    assert_allclose(bound.padding, units.points(np.full(3, BALL_HEIGHT)).max(), rtol=1e-5)
    assert_array_equal(bound.sources, np.arange(len(JOINTS)))


def test_where_the_prim_stands_does_not_matter_but_its_scale_and_tilt_do():
    """A Z-up asset in centimetres, stood up and scaled by whoever placed it in a Y-up stage in metres."""
    stage = new_stage()
    asset = Units(0.01, "Z")
    add_character(stage, "/World/Hero", asset)
    xform = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero"))
    xform.AddTranslateOp().Set(Gf.Vec3d(3.0, 0.0, -2.0))
    xform.AddRotateYOp().Set(40.0)
    xform.AddRotateXOp().Set(-90.0)
    xform.AddScaleOp().Set(Gf.Vec3f(0.01))
    character = read(stage)
    assert_allclose(rest_positions(character), REST, atol=1e-6)
    assert character.agent_scale == pytest.approx(0.01)
    assert_allclose(character.agent_rotation, (-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)), atol=1e-6)


def test_a_written_agent_prim_puts_the_joints_where_the_canonical_skeleton_has_them():
    """Root position, yaw, then agent_rotation and agent_scale over the unfolded joints, through UsdSkel itself."""
    units = Units(0.01, "Z", 30.0)
    stage = new_stage(None, units)
    add_character(stage, "/World/Hero/Rig", Units(0.3, "Y"))
    xform = UsdGeom.Xformable(UsdGeom.Xform.Define(stage, "/World/Hero"))
    xform.AddRotateXOp().Set(90.0)
    xform.AddScaleOp().Set(Gf.Vec3f(30.0))
    rig = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero/Rig"))
    rig.AddTranslateOp().Set(Gf.Vec3d(0.1, 0.2, 0.3))
    rig.AddRotateYOp().Set(25.0)
    character = read(stage)
    skeleton = character.skeleton
    local = unfold_from_joints(
        character.skeleton_to_agent,
        skeleton.parents,
        translations=skeleton.rest_translations[None],
        rotations=skeleton.rest_rotations[None],
    )
    usd = UsdSkel.Animation.Define(stage, "/World/pose")
    usd.CreateJointsAttr(skeleton.joints)
    usd.CreateTranslationsAttr(Vt.Vec3fArray.FromNumpy(local[0][0].astype(np.float32)))
    usd.CreateRotationsAttr(Vt.QuatfArray.FromNumpy(local[1][0].astype(np.float32)))
    usd.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * 11))
    xform.ClearXformOpOrder()
    xform.GetPrim().RemoveProperty("xformOp:rotateX")
    xform.GetPrim().RemoveProperty("xformOp:scale")
    xform.AddTranslateOp().Set(Gf.Vec3d(*units.points((2.0, 0.0, 1.0))))
    xform.AddRotateZOp().Set(float(np.degrees(0.7)))
    x, y, z, w = character.agent_rotation
    xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))
    xform.AddScaleOp().Set(Gf.Vec3f(character.agent_scale))
    skeleton_prim = stage.GetPrimAtPath(f"/World/Hero/{character.skeleton_path}")
    found = canonical_points(stage, usdskel_positions(stage, skeleton_prim, usd.GetPrim(), [0.0])[0])
    yaw = quaternion.yaw_quaternion(np.array(0.7))
    expected = quaternion.rotate(yaw, rest_positions(character)) + (2.0, 0.0, 1.0)
    assert_allclose(found, expected, atol=1e-5)


def test_a_transform_that_moves_above_the_skeleton_is_known_at_every_frame():
    stage = new_stage()
    add_character(stage, "/World/Hero/Rig", Units())
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero/Rig")).AddTranslateOp()
    for code in range(4):
        op.Set(Gf.Vec3d(0.0, 0.0, float(code)), code)
    character = read(stage, codes=(0.0, 1.0, 2.0))
    assert len(character.skeleton_to_agent) == 3
    assert_allclose(character.skeleton_to_agent.translation[:, 2], (0.0, 1.0, 2.0))


def test_a_scale_that_differs_between_axes_is_refused():
    stage = new_stage()
    add_character(stage, "/World/Hero", Units())
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero")).AddScaleOp().Set(Gf.Vec3f(1.0, 2.0, 1.0))
    with pytest.raises(SkeletonError, match="/World/Hero: has a transform above it with shear or different scales"):
        read(stage)


def test_a_character_in_other_units_is_said(caplog):
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(0.01))
    with caplog.at_level(logging.WARNING):
        read(stage)
    assert "/World/Hero: bones of 100 m" in caplog.text


def test_points_that_are_not_finite_are_left_out_of_the_skin(caplog):
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), with_body=True)
    attribute = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Hero/Body")).GetPointsAttr()
    points = np.array(attribute.Get())
    points[8 * JOINTS.index("Hips/LeftUpLeg/LeftLeg/LeftFoot/LeftToeBase")] = np.nan
    attribute.Set(Vt.Vec3fArray.FromNumpy(points))
    with caplog.at_level(logging.WARNING):
        character = read(stage)
    assert "/World/Hero/Body: 1 of its points are not finite, they are left out" in caplog.text
    assert_allclose(character.biped.ball_heights, BALL_HEIGHT, atol=1e-3)


def test_without_a_skeleton_the_way_to_one_is_said():
    stage = new_stage()
    stage.DefinePrim("/World/Hero", "Xform")
    with pytest.raises(
        SkeletonError, match=r"/World/Hero: has no Skeleton at or below it. point usdfoot:agent:character"
    ):
        read(stage)


class TestAuthoredBiped:
    """UsdfootBipedAPI."""

    def stage(self, units=None, **tokens):
        units = units or Units()
        stage = new_stage(None, units)
        names = ["/".join(f"bone{JOINTS.index('/'.join(parts[: i + 1]))}" for i in range(len(parts)))
                 for parts in (joint.split("/") for joint in JOINTS)]  # fmt: skip
        skeleton = add_character(stage, "/World/Hero", units, joints=names).GetPrim()
        skeleton.AddAppliedSchema(Schema.BIPED)
        values = {Token.PELVIS: "bone0"}
        for side, start in ((0, 3), (1, 7)):
            for i, role in enumerate((Token.HIP, Token.KNEE, Token.ANKLE, Token.BALL)):
                values[role[side]] = f"bone{start + i}"
        for name, value in (values | tokens).items():
            skeleton.CreateAttribute(name, Sdf.ValueTypeNames.Token, False, Sdf.VariabilityUniform).Set(value)
        return stage, skeleton

    def test_leaf_names_and_full_paths_are_joints(self):
        stage, _ = self.stage(**{Token.KNEE[1]: "bone0/bone7/bone8"})
        biped = read(stage).biped
        assert (biped.pelvis, biped.hips, biped.knees, biped.ankles, biped.balls) == (
            0,
            (3, 7),
            (4, 8),
            (5, 9),
            (6, 10),
        )

    @pytest.mark.parametrize("units", [Units(), Units(0.01, "Z")])
    def test_measures_are_in_the_skeleton_s_space(self, units):
        stage, skeleton = self.stage(units)
        measures = ((Token.BALL_HEIGHT[0], 0.03), (Token.BALL_HEIGHT[1], 0.04), (Token.LEG_LENGTH_MAX, 0.9),
                    (Token.LEG_LENGTH_NOMINAL, 0.8))  # fmt: skip
        for name, value in measures:
            skeleton.CreateAttribute(name, Sdf.ValueTypeNames.Float, False).Set(value / units.meters)
        com = units.points((0.01, 0.02, 0.03))
        skeleton.CreateAttribute(Token.COM, Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(*map(float, com)))
        biped = read(stage).biped
        assert_allclose(biped.ball_heights, (0.03, 0.04), rtol=1e-6)
        assert (biped.nominal_leg_length, biped.maximal_leg_length) == pytest.approx((0.8, 0.9), rel=1e-6)
        assert_allclose(biped.com, (0.01, 0.02, 0.03), atol=1e-6)

    def test_an_unknown_joint_is_named_with_those_there_are(self):
        stage, _ = self.stage(**{Token.BALL[0]: "toe"})
        message = "/World/Hero/Skeleton: usdfoot:biped:left:ball = toe is none of the joints: bone0, bone1"
        with pytest.raises(BipedError, match=message):
            read(stage)

    def test_a_negative_length_is_refused(self):
        stage, skeleton = self.stage()
        skeleton.CreateAttribute(Token.BALL_HEIGHT[0], Sdf.ValueTypeNames.Float, False).Set(-0.1)
        with pytest.raises(BipedError, match=r"usdfoot:biped:left:ballHeight is -0.1. author a positive length"):
            read(stage)

    def test_a_com_that_is_nowhere_is_refused(self):
        stage, skeleton = self.stage()
        skeleton.CreateAttribute(Token.COM, Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(0.0, float("nan"), 0.0))
        with pytest.raises(BipedError, match=r"usdfoot:biped:com is \(0, nan, 0\). author a finite point"):
            read(stage)

    def test_the_real_character_with_authored_joints(self, shared_data):
        stage = new_stage(None, Units(1.0, "Y", 120.0))
        stage.DefinePrim("/World/Hero").GetReferences().AddReference(str(shared_data / "cmu" / "cmu_character.usdc"))
        biped = read(stage).biped
        assert_allclose(biped.ball_heights, 0.04, rtol=1e-6)


class TestAsset:
    """What to reference so that agents share prototypes."""

    def stage(self, tmp_path):
        source = new_stage(tmp_path / "hero.usda")
        add_character(source, "/World/Hero", Units())
        source.GetRootLayer().Save()
        stage = new_stage(tmp_path / "scene.usda")
        prim = stage.DefinePrim("/World/A")
        prim.GetReferences().AddReference("./hero.usda", "/World/Hero")
        return stage, prim, str((tmp_path / "hero.usda").resolve())

    def test_a_placed_asset_is_the_asset(self, tmp_path):
        stage, prim, asset = self.stage(tmp_path)
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
        prim.AddAppliedSchema(Schema.AGENT)
        assert asset_of(prim) == (asset, "/World/Hero", ())
        inner = stage.DefinePrim("/World/B")
        inner.GetReferences().AddInternalReference("/World/A")
        assert asset_of(inner) == (asset, "/World/Hero", ())

    def test_an_asset_the_scene_changes_is_the_scene_s_prim(self, tmp_path):
        stage, prim, _ = self.stage(tmp_path)
        stage.OverridePrim("/World/A/Skeleton").SetCustomDataByKey("colour", "red")
        assert asset_of(prim) == (str((tmp_path / "scene.usda").resolve()), "/World/A", ())

    def test_variants_that_the_scene_selects_go_with_the_asset(self, tmp_path):
        stage, prim, asset = self.stage(tmp_path)
        inner = stage.DefinePrim("/World/B")
        inner.GetReferences().AddInternalReference("/World/A")
        for path, selected in (("/World/A", {"look": "red", "age": "old"}), ("/World/B", {"look": "blue"})):
            for name, variant in selected.items():
                stage.GetPrimAtPath(path).GetVariantSet(name).SetVariantSelection(variant)
        assert asset_of(prim) == (asset, "/World/Hero", (("age", "old"), ("look", "red")))
        assert asset_of(inner) == (asset, "/World/Hero", (("age", "old"), ("look", "blue")))
        inner.GetVariantSet("age").BlockVariantSelection()
        assert asset_of(inner).variants == (("age", ""), ("look", "blue"))

    def test_two_agents_with_one_asset_are_one_character(self, tmp_path):
        stage, prim, _ = self.stage(tmp_path)
        other = stage.DefinePrim("/World/B")
        other.GetReferences().AddReference("./hero.usda", "/World/Hero")
        UsdGeom.Xformable(other).AddRotateYOp().Set(70.0)
        units = read_stage_info(stage).units
        assert character_key(prim, units) == character_key(other, units)
        UsdGeom.Xformable(other).AddScaleOp().Set(Gf.Vec3f(1.1))
        assert character_key(prim, units) != character_key(other, units)


def test_geometry_that_is_not_skinned_counts_for_the_extent():
    units = Units(0.01, "Z")
    stage = new_stage(None, units)
    add_character(stage, "/World/Hero", units, with_body=True)
    assert read(stage).still_extent is None
    add_mesh(stage, "/World/Hero/Sword", [(0, 1, 0), (0.1, 1.2, 0.3), (0.2, 1, 0)], [(0, 1, 2)], units)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Hero")).AddRotateZOp().Set(30.0)
    assert_allclose(read(stage).still_extent, [(0, 1, 0), (0.2, 1.2, 0.3)], atol=1e-6)


def test_blend_shapes_of_the_bound_animation_are_kept():
    stage = new_stage()
    skeleton = add_character(stage, "/World/Hero", Units())
    animation = UsdSkel.Animation.Define(stage, "/World/Hero/face")
    animation.CreateBlendShapesAttr(["smile", "blink"])
    for code in (0.0, 10.0):
        animation.CreateBlendShapeWeightsAttr().Set(Vt.FloatArray([code / 10.0, 0.5]), code)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    shapes = read(stage).blend_shapes
    assert shapes.names == ("smile", "blink")
    assert_allclose(shapes.codes, (0.0, 10.0))
    assert_allclose(shapes.weights, [(0.0, 0.5), (1.0, 0.5)])


@pytest.mark.parametrize(
    ("name", "height"),
    [
        ("bandai/bandai_character.usdc", 0.045),
        ("animlab/AnimLabSimpleMale.usd", 0.0185),
        ("knight/knight_Walking_A.usdc", 0.026),
    ],
)
def test_real_characters(shared_data, name, height):
    stage = new_stage(None, Units(1.0, "Z") if "knight" in name else Units(0.01))
    stage.DefinePrim("/World/Hero").GetReferences().AddReference(str(shared_data / name))
    character = read(stage)
    assert_allclose(character.biped.ball_heights, height, atol=1e-3)
    assert character.asset == str(shared_data / name)
    skeleton = stage.GetPrimAtPath(f"/World/Hero/{character.skeleton_path}")
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(skeleton))
    to_world = UsdGeom.XformCache(0).GetLocalToWorldTransform(skeleton)
    expected = [tuple((m * to_world).ExtractTranslation()) for m in query.ComputeJointSkelTransforms(0, True)]
    assert_allclose(rest_positions(character), canonical_points(stage, expected), atol=1e-5)


def test_prims_that_select_the_same_variants_are_one_character():
    asset = new_stage()
    add_character(asset, "/World/Hero", Units())
    looks = asset.GetPrimAtPath("/World/Hero").GetVariantSets().AddVariantSet("look")
    for look in ("red", "blue"):
        looks.AddVariant(look)
    stage = new_stage()
    for number, look in enumerate(("red", "blue", "red", "red")):
        prim = UsdGeom.Xform.Define(stage, f"/World/Agent_{number}").GetPrim()
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier, "/World/Hero")
        prim.GetVariantSet("look").SetVariantSelection(look)
        UsdGeom.Xformable(prim).AddTranslateOp().Set((number, 0, 0))
    UsdGeom.Imageable(prim).MakeInvisible()
    units = read_stage_info(stage).units
    red, blue, other, hidden = (character_key(agent, units) for agent in stage.GetPrimAtPath("/World").GetChildren())
    assert red == other == hidden != blue


@pytest.mark.parametrize("stage_units", [Units(1.0, "Y"), Units(1.0, "Z"), Units(100.0, "Y")])
def test_an_asset_in_other_units_or_axes_than_the_scene_is_said(caplog, stage_units):
    stage = new_stage(None, stage_units)
    add_character(stage, "/World/Hero", Units(1.0, "Y"))
    with caplog.at_level(logging.WARNING):
        read(stage)
    said = [record.getMessage() for record in caplog.records]
    assert [message.startswith("/World/Hero: its legs do not point down") for message in said if "legs" in message] == (
        [True] if stage_units.up == "Z" else []
    )
    assert [message.startswith("/World/Hero: bones of 100 m") for message in said if "bones" in message] == (
        [True] if stage_units.meters > 1.0 else []
    )


@pytest.mark.parametrize(("ahead", "height"), [(0.9, 0.05), (0.9, 0.5), (0.2, 0.05)])
def test_a_character_that_stands_on_four_legs_is_said(caplog, ahead, height):
    """Arms that hang and skirts that reach the ground beside the feet are no legs."""
    limbs = ("Shoulder", "Elbow", "Hand")
    joints, offsets = [*JOINTS], [*OFFSETS]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        names = ["Hips/Spine", *(f"{side}{limb}" for limb in limbs)]
        joints += ["/".join(names[: count + 2]) for count in range(3)]
        offsets += [(0.1 * sign, 0.0, ahead), (0.0, -0.5, 0.0), (0.0, height - 0.7, 0.0)]
    stage = new_stage()
    add_character(stage, "/World/Hero", Units(), joints=joints, offsets=np.array(offsets))
    with caplog.at_level(logging.WARNING):
        read(stage)
    said = [record.getMessage() for record in caplog.records if "legs" in record.getMessage()]
    if height < 0.1 and ahead > 0.5:
        (message,) = said
        assert message.startswith("/World/Hero: stands on more than two legs. footsteps are of LeftFoot and RightFoot")
        assert "LeftHand, RightHand move as in clips" in message
    else:
        assert not said
