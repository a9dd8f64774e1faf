"""Every attribute that is written, read back through USD."""

from dataclasses import replace

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from tests.writers.crowds import (
    Rig,
    character_of,
    four_steps,
    results_of,
    scene_of,
    wandering_motion,
    write_character,
    write_crowd,
)
from tests.writers.test_crowd import CENTIMETRES, write
from usdfoot.bridge import tokens
from usdfoot.bridge.schema import has_api
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.model.clip import ShapeTrack
from usdfoot.writers.attributes import layer_spec
from usdfoot.writers.footsteps import executed_plan, print_models
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.staging import staged_files

Z_UP = StageUnits(meters_per_unit=1.0, up_axis="Z", time_codes_per_second=24.0)


def opened(tmp_path, units):
    crowd, _, motions = write(tmp_path, rig=Rig(units=units), agents=1)
    return Usd.Stage.Open(str(crowd)), crowd, motions[0]


def values(prim, name):
    return np.array(prim.GetAttribute(name).Get(), dtype=float)


def xyzw(quaternions):
    return np.array([[*q.GetImaginary(), q.GetReal()] for q in quaternions], dtype=float)


@pytest.mark.parametrize("units", [CENTIMETRES, Z_UP])
def test_plan_is_kept_as_given(tmp_path, units):
    stage, _, _ = opened(tmp_path, units)
    prim, plan = stage.GetPrimAtPath("/Crowd/Plans/A0"), four_steps("p")
    assert prim.GetTypeName() == "PointInstancer" and UsdGeom.Imageable(prim).GetPurposeAttr().Get() == "guide"
    assert has_api(prim, tokens.Schema.PLAN) and has_api(prim, tokens.Schema.RESULT)
    assert values(prim, "protoIndices").tolist() == [0, 1, 0, 1]
    np.testing.assert_allclose(units.points_to_canonical(values(prim, "positions")), plan.positions, atol=1e-7)
    turns = units.rotations_to_canonical(xyzw(prim.GetAttribute("orientations").Get()))
    np.testing.assert_allclose(turns, plan.orientations, atol=5e-4)
    rate = units.time_codes_per_second
    np.testing.assert_allclose(values(prim, tokens.Plan.STRIKE_TIMES), plan.strike_times * rate, atol=1e-9)
    np.testing.assert_allclose(values(prim, tokens.Plan.LIFTOFF_TIMES), plan.liftoff_times * rate, atol=1e-9)
    for name in (tokens.Plan.STRIKE_TIMES, tokens.Plan.LIFTOFF_TIMES):
        assert prim.GetAttribute(name).GetTypeName() == "timecode[]"
        assert prim.GetAttribute(name).GetVariability().name == "VariabilityUniform"


def test_styles_of_the_plan_are_kept(tmp_path):
    plan = replace(four_steps("p"), styles=("", "sad", "sad", ""))
    path = f"{tokens.Prim.PLANS}/A"
    spec = executed_plan(path, plan, results=results_of(4), prints=print_models(0.2, Z_UP), units=Z_UP)
    layer_format = LayerFormat(units=Z_UP, frames_per_second=24.0, start_code=0.0, end_code=1.0)
    with staged_files(tmp_path) as files:
        files.add_specs("plan.usdc", layer_spec(layer_format, tokens.Prim.PLANS, {"A": spec}, data={}))
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "plan.usdc"))
    assert tuple(layer.GetAttributeAtPath(f"{path}.{tokens.Plan.STYLES}").default) == plan.styles


def test_rotations_never_change_sign(tmp_path):
    character = character_of(write_character(tmp_path / "hero.usda", Rig(units=CENTIMETRES)))
    scene = scene_of(character, CENTIMETRES, agents=1, frames=40)
    motion = wandering_motion("A0", character, frames=40, rate=30.0)
    signs = np.where(np.random.default_rng(3).random((40, len(character.skeleton.joints), 1)) < 0.5, -1.0, 1.0)
    motion = replace(motion, rotations=motion.rotations * signs, pelvis_rotations=motion.pelvis_rotations * signs[:, 0])
    crowd, _ = write_crowd(scene, [motion], tmp_path / "out")
    stage = Usd.Stage.Open(str(crowd))
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/Crowd/Anims/A0"))
    rotations = np.array([xyzw(animation.GetRotationsAttr().Get(float(code))) for code in range(40)])
    assert np.sum(rotations[1:] * rotations[:-1], axis=-1).min() > 0.9


def test_prints_lie_flat_and_point_forward(tmp_path):
    stage, _, _ = opened(tmp_path, Z_UP)
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/Crowd/Plans/A0"))
    left, right = (stage.GetPrimAtPath(path) for path in instancer.GetPrototypesRel().GetTargets())
    points = [Z_UP.points_to_canonical(values(prim, "points")) for prim in (left, right)]
    for outline in points:
        assert np.ptp(outline[:, 1]) < 1e-6
        x, z = outline[:, 0], outline[:, 2]
        area = 0.5 * np.sum(z * np.roll(x, -1) - x * np.roll(z, -1))
        assert area > 0.005  # counter-clockwise seen from above, and as large as a foot
        assert outline[:, 2].min() < -outline[:, 2].max() < 0.0  # the ball is the origin
    np.testing.assert_allclose(points[1][::-1] * (-1, 1, 1), points[0], atol=1e-6)
    stage.SetEditTarget(stage.GetSessionLayer())
    instancer.GetPurposeAttr().Set("default")  # boxes of guides are empty
    box = UsdGeom.PointInstancer(instancer).ComputeExtentAtTime(0.0, 0.0)
    low, high = np.array(instancer.GetExtentAttr().Get())
    assert (low > np.array(box[0]) - 1e-6).all() and (high < np.array(box[1]) + 1e-6).all()
    np.testing.assert_allclose([low, high], np.array(box), atol=0.03)  # USD boxes the prints before it turns them


@pytest.mark.parametrize("units", [CENTIMETRES, Z_UP])
def test_results_are_in_stage_units_and_degrees(tmp_path, units):
    stage, _, _ = opened(tmp_path, units)
    prim, results = stage.GetPrimAtPath("/Crowd/Plans/A0"), results_of(4)
    names = tokens.Result
    for name, expected in (
        (names.BLEND_ERROR, results.blend_error / units.meters_per_unit),
        (names.PLACEMENT_ERROR, results.placement_error / units.meters_per_unit),
        (names.SLIDE, results.slide / units.meters_per_unit),
        (names.YAW_ERROR, np.degrees(results.yaw_error)),
        (names.HULL_DISTANCE, results.hull_distance / units.meters_per_unit),
        (names.TIME_WARP, results.time_warp),
        (names.ROOT_VELOCITY_ERROR, results.root_velocity_error / units.meters_per_unit),
        (names.ROOT_WEIGHT, results.root_weight),
        (names.BETA, results.beta),
        (names.CLIP_COUNTS, results.clip_counts),
        (names.CLIP_WEIGHTS, results.clip_weights),
    ):
        np.testing.assert_allclose(values(prim, name), expected, rtol=1e-6, err_msg=name)
    assert tuple(prim.GetAttribute(names.STATUS).Get()) == results.status
    assert tuple(prim.GetAttribute(names.CLIPS).Get()) == results.clips


@pytest.mark.parametrize("units", [CENTIMETRES, Z_UP])
def test_contacts_are_on_the_animation(tmp_path, units):
    stage, _, motion = opened(tmp_path, units)
    prim = stage.GetPrimAtPath("/Crowd/Anims/A0")
    names, rate = tokens.Contact, units.time_codes_per_second
    for side in (0, 1):
        assert has_api(prim, tokens.Schema.CONTACT_INSTANCES[side])
        contacts = motion.contacts[side]
        for name, times in (
            (names.STRIKE_TIMES, contacts.strike_times),
            (names.FLAT_TIMES, contacts.flat_times),
            (names.LIFTOFF_TIMES, contacts.liftoff_times),
        ):
            np.testing.assert_allclose(values(prim, name[side]), times * rate, atol=1e-9)
        places = units.points_to_canonical(values(prim, names.POSITIONS[side]))
        np.testing.assert_allclose(places, contacts.positions, atol=1e-7)
        height = prim.GetAttribute(names.BALL_HEIGHT[side]).Get() * units.meters_per_unit
        assert height == pytest.approx(0.03, abs=1e-7)


def test_animation_has_all_four_arrays_and_ancestors_of_the_pelvis_rest(tmp_path):
    stage, _, _ = opened(tmp_path, CENTIMETRES)
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/Crowd/Anims/A0"))
    for attribute in (animation.GetTranslationsAttr(), animation.GetRotationsAttr()):
        assert attribute.GetTimeSamples() == list(range(20))
    assert len(animation.GetScalesAttr().Get()) == len(animation.GetJointsAttr().Get()) == 10
    agent = stage.GetPrimAtPath("/Crowd/Agents/A0")
    skeleton = UsdSkel.Skeleton(agent.GetPrimAtPath("Group/Skeleton"))
    rest = np.array(skeleton.GetRestTransformsAttr().Get()[0])
    root = [np.array(value) for value in (animation.GetTransforms(0.0)[0], animation.GetTransforms(7.0)[0])]
    np.testing.assert_allclose(root, [rest, rest], atol=1e-6)


def test_blend_shapes_of_a_motion_are_on_the_animation(tmp_path):
    character = character_of(write_character(tmp_path / "hero.usda", Rig(units=CENTIMETRES)))
    scene = scene_of(character, CENTIMETRES, agents=1, frames=4)
    weights = np.arange(8.0).reshape(4, 2) / 8.0
    motion = wandering_motion("A0", character, frames=4, rate=30.0)
    shapes = ShapeTrack(names=("smile", "blink"), weights=weights)
    crowd, _ = write_crowd(scene, [replace(motion, shapes=shapes)], tmp_path / "out")
    stage = Usd.Stage.Open(str(crowd))
    animation = UsdSkel.Animation(stage.GetPrimAtPath("/Crowd/Anims/A0"))
    assert list(animation.GetBlendShapesAttr().Get()) == ["smile", "blink"]
    found = [animation.GetBlendShapeWeightsAttr().Get(code) for code in animation.GetRotationsAttr().GetTimeSamples()]
    np.testing.assert_allclose(found, weights)


@pytest.mark.parametrize("units", [CENTIMETRES, Z_UP])
def test_agent_prim_carries_the_planar_root_path(tmp_path, units):
    stage, _, motion = opened(tmp_path, units)
    prim = stage.GetPrimAtPath("/Crowd/Agents/A0")
    assert prim.GetTypeName() == "SkelRoot" and has_api(prim, tokens.Schema.AGENT)
    assert prim.GetRelationship(tokens.Agent.PLAN).GetTargets() == ["/Crowd/Plans/A0"]
    ops = [op.GetOpName() for op in UsdGeom.Xformable(prim).GetOrderedXformOps()]
    assert ops == ["xformOp:translate", f"xformOp:rotate{units.up_axis}"]
    frame = 11
    matrix = np.array(UsdGeom.XformCache(float(frame)).GetLocalToWorldTransform(prim))
    np.testing.assert_allclose(units.points_to_canonical(matrix[3, :3]), motion.root_positions[frame], atol=1e-6)
    forward = units.directions_to_canonical(units.directions_to_stage(np.array([0.0, 0.0, 1.0])) @ matrix[:3, :3])
    expected = quaternion.rotate(quaternion.yaw_quaternion(motion.root_yaws[frame]), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(forward, expected, atol=1e-9)


@pytest.mark.parametrize("rig", [Rig(units=CENTIMETRES, scale_above=0.01), Rig(units=Z_UP)])
def test_extents_are_the_boxes_usd_computes_to_the_last_bit(tmp_path, rig):
    crowd, _, _ = write(tmp_path, rig=rig, agents=2)
    stage = Usd.Stage.Open(str(crowd))
    for name in ("A0", "A1"):
        agent = UsdGeom.Boundable(stage.GetPrimAtPath(f"/Crowd/Agents/{name}"))
        codes = agent.GetExtentAttr().GetTimeSamples()
        assert codes == list(range(20))
        own = [UsdGeom.Boundable.ComputeExtentFromPlugins(agent, code) for code in codes]
        np.testing.assert_array_equal([agent.GetExtentAttr().Get(code) for code in codes], own)
        assert np.ptp(own, axis=1).min() > 0.02 / rig.units.meters_per_unit  # padded: the skin is wider than the joints
