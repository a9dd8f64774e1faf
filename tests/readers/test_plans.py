"""Footstep plans in any units and under any transform; what is wrong with one is said."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from tests.scenes import Units, add_plan, new_stage, straight_steps
from usdfoot.bridge.tokens import Plan as Token
from usdfoot.errors import PlanError, SceneError
from usdfoot.model.hashing import content_hash
from usdfoot.readers.plan_prints import path_orientations
from usdfoot.readers.plan_sources import ask_plan
from usdfoot.readers.plans import is_plan, plans_of, read_plan
from usdfoot.readers.stage import read_stage_info

EVERY_UNITS = [Units(m, u, r) for m, u, r in ((1.0, "Y", 24), (0.01, "Z", 30), (0.0254, "Y", 60), (1, "Z", 120))]
YAWS = np.array([0.1, -0.2, 0.4, 0.9, 1.5, 2.5])


def read(stage, path="/World/Plan"):
    return read_plan(stage.GetPrimAtPath(path), read_stage_info(stage).units)


@pytest.mark.parametrize("units", EVERY_UNITS)
@pytest.mark.parametrize("half", [True, False])
def test_units_axes_rates_and_precision_do_not_matter(units, half):
    stage = new_stage(None, units)
    add_plan(stage, "/World/Plan", units, yaws=YAWS, half=half)
    plan, problems = read(stage)
    sides, positions, strikes, liftoffs = straight_steps()
    assert_array_equal(plan.sides, sides)
    assert_allclose(plan.positions, positions, atol=1e-6)
    assert_allclose(plan.yaws, YAWS, atol=2e-3 if half else 1e-6)
    assert_allclose(plan.normals, np.tile([0.0, 1.0, 0.0], (6, 1)), atol=1e-6)
    assert_allclose(np.linalg.norm(plan.orientations, axis=1), 1.0, atol=1e-12)
    assert_allclose(plan.strike_times, strikes, atol=1e-9)
    assert_allclose(plan.liftoff_times, liftoffs, atol=1e-9)
    assert_array_equal(plan.root_weights, 0.0)
    assert problems == ()


def test_styles_are_read_as_authored():
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units())
    assert read(stage)[0].styles == ()
    styles = ("", "sad", "sad", "", "", "proud")
    attribute = instancer.GetPrim().CreateAttribute(Token.STYLES, Sdf.ValueTypeNames.TokenArray, False)
    attribute.Set(styles)
    assert read(stage)[0].styles == styles


def test_what_a_plan_says_may_be_primvars_as_houdini_writes_them(caplog):
    stage = new_stage()
    prim = add_plan(stage, "/World/Plan", Units(), yaws=YAWS).GetPrim()
    expected, _ = read(stage)
    prim.SetMetadata("apiSchemas", Sdf.TokenListOp())
    for name in (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES):
        codes = np.array([code.GetValue() for code in prim.GetAttribute(name).Get()], dtype=np.float32)
        prim.RemoveProperty(name)
        distinct, indices = np.unique(codes, return_inverse=True)
        primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
        primvar.Set(Vt.FloatArray.FromNumpy(distinct))
        primvar.SetIndices(Vt.IntArray.FromNumpy(indices.astype(np.int32)))
    styles = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(Token.STYLES, Sdf.ValueTypeNames.StringArray, "vertex")
    styles.Set(["", "sad", "", "", "", ""])
    assert is_plan(prim)
    with caplog.at_level("INFO"):
        plan, problems = read(stage)
    assert problems == ()
    assert f"/World/Plan: {Token.STRIKE_TIMES} is read from the primvar of this name" in caplog.text
    assert plan.styles == ("", "sad", "", "", "", "")
    for ours, theirs in ((plan.strike_times, expected.strike_times), (plan.liftoff_times, expected.liftoff_times)):
        assert_allclose(ours, theirs, atol=1e-6)
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(Token.STRIKE_TIMES)
    prim.RemoveProperty(primvar.GetName())
    wrong = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(Token.STRIKE_TIMES, Sdf.ValueTypeNames.StringArray, "vertex")
    wrong.Set(["a"] * 6)
    with pytest.raises(SceneError, match="primvars:usdfoot:plan:strikeTimes is of type string\\[\\]"):
        read(stage)


@pytest.mark.parametrize(
    ("name", "kind", "value", "expected"),
    [
        ("protoIndices", Sdf.ValueTypeNames.StringArray, ["left", "right"], "int[]"),
        ("protoIndices", Sdf.ValueTypeNames.Int, 3, "int[]"),
        ("positions", Sdf.ValueTypeNames.String, "here", "point3f[]"),
        ("positions", Sdf.ValueTypeNames.FloatArray, [0.0, 1.0], "point3f[]"),
        ("orientations", Sdf.ValueTypeNames.FloatArray, [0.0, 1.0], "quath[]"),
        ("orientationsf", Sdf.ValueTypeNames.Float3Array, [Gf.Vec3f(0.0)], "quatf[]"),
        ("invisibleIds", Sdf.ValueTypeNames.Float, 1.0, "int64[]"),
    ],
)
def test_prints_of_another_type_are_refused_with_that_which_is_right(name, kind, value, expected):
    stage, prim = plan_prim()
    spec = stage.GetRootLayer().GetPrimAtPath(prim.GetPath())
    if name in spec.properties:
        del spec.properties[name]
    Sdf.AttributeSpec(spec, name, kind).default = value
    with pytest.raises(SceneError, match=re.escape(f"/World/Plan: {name} is of type {kind}. author it as {expected}")):
        read(stage)


@pytest.mark.parametrize("as_primvars", [False, True])
def test_times_that_are_numbers_move_with_their_layer_as_timecodes_do(as_primvars):
    """A plan on ones at 48 codes a second, referenced into a stage of 24 from code 100 on, played at half speed."""
    asset = new_stage(units=Units(rate=48.0))
    prim = add_plan(asset, "/World/Plan", Units(rate=48.0)).GetPrim()
    stage = new_stage(units=Units(rate=24.0))
    placed = stage.DefinePrim("/World/Plan")
    placed.GetReferences().AddReference(asset.GetRootLayer().identifier, "/World/Plan", Sdf.LayerOffset(100.0, 2.0))
    expected, _ = read(stage)
    for name in (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES):
        codes = [code.GetValue() for code in prim.GetAttribute(name).Get()]
        prim.RemoveProperty(name)
        kind, shown = Sdf.ValueTypeNames.DoubleArray, f"primvars:{name}" if as_primvars else name
        prim.CreateAttribute(shown, kind, custom=False).Set(codes)
    plan, _ = read(stage)
    assert_allclose(plan.strike_times, expected.strike_times, atol=1e-9)
    assert_allclose(plan.liftoff_times, expected.liftoff_times, atol=1e-9)
    assert plan.strike_times[0] > 100.0 / 24.0 - 1e-9


def test_an_empty_array_of_root_weights_says_as_little_as_none():
    stage = new_stage()
    prim = add_plan(stage, "/World/Plan", Units()).GetPrim()
    prim.CreateAttribute(Token.ROOT_WEIGHTS, Sdf.ValueTypeNames.FloatArray, False).Set([])
    assert_array_equal(read(stage)[0].root_weights, 0.0)


def test_the_identity_faces_plus_z_on_y_up_and_minus_y_on_z_up():
    for up, forward in (("Y", (0.0, 0.0, 1.0)), ("Z", (0.0, -1.0, 0.0))):
        stage = new_stage(None, Units(1.0, up))
        instancer = add_plan(stage, "/World/Plan", Units(1.0, up))
        instancer.CreateOrientationsfAttr([Gf.Quatf(1.0)] * 6)
        plan, _ = read(stage)
        assert_allclose(
            Units(1.0, up).directions((np.sin(plan.yaws[0]), 0.0, np.cos(plan.yaws[0]))), forward, atol=1e-9
        )
        assert_allclose(plan.normals[0], (0.0, 1.0, 0.0), atol=1e-9)


def test_the_transform_of_the_plan_applies_to_positions_and_orientations():
    stage = new_stage()
    instancer = add_plan(stage, "/World/Group/Plan", Units(), yaws=np.zeros(6), half=False)
    above = UsdGeom.Xform.Define(stage, "/World/Group")
    above.AddTranslateOp().Set(Gf.Vec3d(5.0, 1.0, 0.0))
    above.AddRotateYOp().Set(90.0)
    UsdGeom.Xformable(instancer).AddScaleOp().Set(Gf.Vec3f(2.0, 2.0, 2.0))
    plan, _ = read(stage, "/World/Group/Plan")
    _, positions, _, _ = straight_steps()
    assert_allclose(
        plan.positions, np.stack([5 + 2 * positions[:, 2], 1 + 0 * positions[:, 0], -2 * positions[:, 0]], 1), atol=1e-6
    )
    assert_allclose(plan.yaws, np.pi / 2, atol=1e-6)


def test_a_stretched_plan_keeps_its_feet_on_its_surface():
    """A plan on a slope of 45 degrees, stretched sideways to the slope: normals tilt, feet keep to the ground."""
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units())
    half = np.sin(np.pi / 8), np.cos(np.pi / 8)
    instancer.CreateOrientationsfAttr([Gf.Quatf(half[1], -half[0], 0.0, 0.0)] * 6)
    UsdGeom.Xformable(instancer).AddScaleOp().Set(Gf.Vec3f(1.0, 2.0, 1.0))
    plan, _ = read(stage)
    assert_allclose(plan.normals[0], np.array([0.0, 1.0, -2.0]) / np.sqrt(5.0), atol=1e-6)
    assert_allclose(plan.yaws, 0.0, atol=1e-6)


def test_a_layer_offset_retimes_the_plan(tmp_path):
    source = new_stage()
    add_plan(source, "/World/Plan", Units(), yaws=np.zeros(6))
    source.GetRootLayer().Export(str(tmp_path / "plan.usda"))
    stage = new_stage()
    offset = Sdf.LayerOffset(48.0, 2.0)
    stage.DefinePrim("/World/Sub").GetReferences().AddReference(str(tmp_path / "plan.usda"), "/World", offset)
    plan, _ = read(stage, "/World/Sub/Plan")
    _, _, strikes, liftoffs = straight_steps()
    assert_allclose(plan.strike_times, 2.0 + 2.0 * strikes)
    assert_allclose(plan.liftoff_times, 2.0 + 2.0 * liftoffs)


def test_a_file_with_another_rate_is_retimed(tmp_path):
    """USD scales codes of a layer with another timeCodesPerSecond; seconds stay seconds."""
    fast = Units(1.0, "Y", 120.0)
    source = new_stage(tmp_path / "plan.usda", fast)
    add_plan(source, "/World/Plan", fast, yaws=np.zeros(6))
    source.GetRootLayer().Save()
    stage = new_stage(None, Units(1.0, "Y", 30.0))
    stage.DefinePrim("/World/Sub").GetReferences().AddReference(str(tmp_path / "plan.usda"), "/World")
    plan, _ = read(stage, "/World/Sub/Plan")
    assert_allclose(plan.strike_times, straight_steps()[2])


def test_without_orientations_the_feet_face_along_the_path_with_a_warning():
    stage = new_stage()
    add_plan(stage, "/World/Plan", Units())
    plan, problems = read(stage)
    assert_allclose(plan.yaws, 0.0, atol=1e-6)
    assert [problem.severity for problem in problems] == ["warning"]
    assert "/World/Plan: has no orientations, the footsteps face along their path" in problems[0].message


def test_deactivated_prints_stay_footsteps_with_a_warning():
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6))
    instancer.CreateIdsAttr(list(range(10, 16)))
    instancer.DeactivateId(12)
    plan, problems = read(stage)
    assert len(plan) == 6
    assert [problem.message for problem in problems] == [
        "/World/Plan: 1 of its prints are inactive, but stay footsteps. delete their entries from every array"
    ]


@pytest.mark.parametrize("names", [("Right", "Left"), ("foot_R", "foot_L"), ("printRight", "printLeft")])
def test_prints_in_the_other_order_are_warned_of(names):
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6))
    prints = [UsdGeom.Xform.Define(stage, f"/World/Plan/Prints/{name}").GetPath() for name in names]
    instancer.GetPrototypesRel().SetTargets(prints)
    plan, problems = read(stage)
    assert plan.sides.tolist() == [0, 1] * 3
    assert [problem.message for problem in problems] == [
        f"/World/Plan: its prototypes are {', '.join(names)}, but index 0 is a left foot. list the left print first"
    ]
    instancer.GetPrototypesRel().SetTargets(prints[::-1])
    assert read(stage)[1] == ()


def test_path_orientations_turn_with_the_path(generator):
    sides, positions, _, _ = straight_steps(8)
    for yaw in generator.uniform(-np.pi, np.pi, 5):
        turned = np.stack(
            [np.cos(yaw) * positions[:, 0] + np.sin(yaw) * positions[:, 2], positions[:, 1],
             np.cos(yaw) * positions[:, 2] - np.sin(yaw) * positions[:, 0]], axis=1,
        )  # fmt: skip
        expected = np.tile([0.0, np.sin(yaw / 2), 0.0, np.cos(yaw / 2)], (8, 1))
        found = path_orientations(sides, turned)
        assert_allclose(found * np.sign(np.sum(found * expected, axis=1))[:, None], expected, atol=1e-9)


def test_feet_side_by_side_face_at_right_angles_to_the_line_between_them():
    sides = np.array([1, 0])
    orientations = path_orientations(sides, np.array([[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    assert_allclose(orientations, [[0.0, 0.0, 0.0, 1.0]] * 2, atol=1e-12)


def test_only_instancers_with_times_or_the_schema_are_plans():
    stage = new_stage()
    with_times = add_plan(stage, "/World/A", Units(), with_api=False)
    scatter = UsdGeom.PointInstancer.Define(stage, "/World/Trees")
    assert is_plan(with_times.GetPrim())
    assert not is_plan(scatter.GetPrim())


def plan_prim(steps=None):
    stage = new_stage()
    count = len(steps[0]) if steps else 6
    return stage, add_plan(stage, "/World/Plan", Units(), steps, yaws=np.zeros(count)).GetPrim()


def steps_with(*, index=None, strike=None, liftoff=None, side=None, position=None, count=6):
    sides, positions, strikes, liftoffs = straight_steps(count)
    if strike is not None:
        strikes[index] = strike
    if liftoff is not None:
        liftoffs[index] = liftoff
    if side is not None:
        sides[index] = side
    if position is not None:
        positions[index] = position
    return sides, positions, strikes, liftoffs


@pytest.mark.parametrize("apart", [2e-8, -2e-8, 1e-2])
def test_times_that_rounding_alone_tells_apart_are_a_stand(apart):
    sides, positions, strikes, liftoffs = straight_steps()
    strikes[1], liftoffs[-1] = strikes[0] + abs(apart), liftoffs[-2] + apart
    if apart < 0:
        strikes[:2] = strikes[1::-1]
    plan, _ = read(plan_prim((sides, positions, strikes, liftoffs))[0])
    assert plan.starts_standing == plan.ends_standing == (abs(apart) < 1e-3)
    assert_allclose(plan.strike_times, strikes, atol=1e-7)
    assert_allclose(plan.liftoff_times, liftoffs, atol=1e-7)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (steps_with(index=2, strike=0.1, liftoff=0.2), "footstep 2 strikes before footstep 1. order by strike time"),
        (
            steps_with(index=0, liftoff=1.7),
            "footstep 2 strikes at 1.6 s before the same foot has left footstep 0 at 1.7 s",
        ),
        (steps_with(index=1, side=0), "footsteps 0 and 1 are both left. left and right must alternate"),
        (steps_with(index=3, position=np.nan), "positions of footstep 3 is not a finite number"),
        (steps_with(index=4, strike=np.nan), "strikeTimes of footstep 4 is not a finite number"),
        (steps_with(index=5, liftoff=3.25), "footstep 5 lifts off at 3.25 s, not after its strike at 3.25 s"),
        (steps_with(index=1, side=7), "footstep 1 has protoIndex 7. 0 = left, 1 = right"),
        (steps_with(count=1), "has 1 footstep"),
    ],
)
def test_inconsistent_plans_are_refused(steps, message):
    stage, _ = plan_prim(steps)
    with pytest.raises(PlanError, match=f"/World/Plan: {message}"):
        read(stage)


def test_arrays_of_different_length_are_listed():
    stage, prim = plan_prim()
    prim.GetAttribute(Token.LIFTOFF_TIMES).Set(Sdf.TimeCodeArray([Sdf.TimeCode(30)] * 4))
    message = (
        r"/World/Plan: arrays differ in length \(protoIndices 6, positions 6, orientations 6, strikeTimes 6, "
        r"liftoffTimes 4, rootWeights 6\). author one entry a footstep in each"
    )
    with pytest.raises(PlanError, match=message):
        read(stage)


@pytest.mark.parametrize("name", ["positions", "protoIndices", Token.STRIKE_TIMES, Token.LIFTOFF_TIMES])
def test_a_missing_array_is_named(name):
    stage, prim = plan_prim()
    prim.GetAttribute(name).Clear()
    with pytest.raises(PlanError, match=f"/World/Plan: has no {name}. author one entry a footstep"):
        read(stage)


def test_an_orientation_of_no_length_is_named():
    stage, prim = plan_prim()
    one = Gf.Quath(1.0)
    UsdGeom.PointInstancer(prim).GetOrientationsAttr().Set([one, one, one, Gf.Quath(0, 0, 0, 0), one, one])
    with pytest.raises(PlanError, match="/World/Plan: orientation of footstep 3 is zero or not finite"):
        read(stage)


def test_a_mirrored_plan_is_refused():
    stage, prim = plan_prim()
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(-1.0, 1.0, 1.0))
    with pytest.raises(PlanError, match="/World/Plan: is mirrored by its transform"):
        read(stage)


@pytest.mark.parametrize("scale", [0.0, float("nan")])
def test_a_plan_that_its_transform_flattens_is_refused(scale):
    stage, prim = plan_prim()
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(scale, 1.0, 1.0))
    with pytest.raises(PlanError, match="/World/Plan: has a transform that is not finite or flattens it"):
        read(stage)


def test_another_kind_of_prim_is_refused():
    stage = new_stage()
    UsdGeom.Xform.Define(stage, "/World/Plan")
    with pytest.raises(
        PlanError, match=r"/World/Plan: is Xform. a footstep plan is a PointInstancer with UsdfootPlanAPI"
    ):
        read(stage)


def test_the_real_plans_are_read(shared_data):
    stage = Usd.Stage.Open(str(shared_data / "scenes" / "walk_flat.usda"))
    plan, problems = read(stage, "/World/Plans/Walker")
    assert len(plan) == 12
    assert problems == ()
    assert_allclose(plan.positions[1], (-0.0020981771, 0.0, -2.6640482), atol=1e-6)
    assert_allclose(plan.strike_times[:2], np.array([7.75, 24.125]) / 30.0)
    assert_allclose(plan.yaws[0], 2 * np.arctan2(-0.0215454, 1.0), atol=1e-4)


@pytest.mark.parametrize(("turn", "angle"), [((1.0, 0.0, 0.0, 0.0), 180), ((0.8, 0.0, 0.0, 0.6), 106)])
def test_a_print_that_nothing_can_stand_on_is_refused(turn, angle):
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6), half=False)
    orientations = list(instancer.GetOrientationsfAttr().Get())
    orientations[4] = Gf.Quatf(turn[3], *turn[:3])
    instancer.GetOrientationsfAttr().Set(orientations)
    message = f"/World/Plan: footstep 4 stands on edge or upside down, its normal is {angle} degrees off the vertical"
    with pytest.raises(PlanError, match=message):
        read(stage)


@pytest.mark.parametrize("moves", [True, False])
def test_positions_that_are_animated_are_read_at_their_first_sample_with_a_warning(moves):
    stage = new_stage()
    attribute = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6)).GetPositionsAttr()
    positions = np.array(attribute.Get())
    for code in (3.0, 9.0):
        attribute.Set(Vt.Vec3fArray.FromNumpy(positions + np.float32((code - 3.0) * moves)), code)
    plan, problems = read(stage)
    assert_allclose(plan.positions, straight_steps()[1], atol=1e-6)
    assert [problem.message for problem in problems] == [
        "/World/Plan: its positions are animated, the first sample is read. author one value, not time samples"
    ] * moves


def test_times_that_are_animated_are_read_at_their_first_sample_with_a_warning():
    stage = new_stage()
    prim = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6)).GetPrim()
    first, _ = read(stage)
    for name in (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES):
        attribute = prim.GetAttribute(name)
        codes = np.array([code.GetValue() for code in attribute.Get()])
        for delay in (0.0, 10.0):
            attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(code + delay) for code in codes]), delay)
    plan, problems = read(stage)
    assert_allclose(plan.strike_times, first.strike_times)
    (problem,) = problems
    names = f"{Token.LIFTOFF_TIMES}, {Token.STRIKE_TIMES}"
    assert problem.message.startswith(f"/World/Plan: its {names} are animated, the first sample is read")


def test_hidden_prints_stay_footsteps_with_a_warning():
    stage = new_stage()
    instancer = add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6))
    instancer.CreateInvisibleIdsAttr([2, 3])
    plan, problems = read(stage)
    assert len(plan) == 6
    assert [problem.message for problem in problems] == [
        "/World/Plan: 2 of its prints are invisible, but stay footsteps. delete their entries from every array"
    ]


@pytest.mark.parametrize("path", ["/World", "/World/Plan"])
def test_a_plan_that_moves_is_read_at_the_start_with_a_warning(path):
    stage = new_stage()
    add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6))
    translation = UsdGeom.Xformable(stage.GetPrimAtPath(path)).AddTranslateOp()
    for code in (0.0, 24.0):
        translation.Set(Gf.Vec3d(1.0, 0.0, 0.0), code)
    assert read(stage)[1] == (), "sampled, but it stays where it is"
    translation.Set(Gf.Vec3d(5.0, 0.0, 0.0), 24.0)
    plan, problems = read(stage)
    assert_allclose(plan.positions[:, 0], straight_steps()[1][:, 0] + 1.0, atol=1e-6)
    assert [problem.severity for problem in problems] == ["warning"]
    assert "/World/Plan: its transform is animated, its prints are read at the stage's start" in problems[0].message


def test_many_plans_are_read_as_each_would_be_alone():
    stage, units = new_stage(None, Units(0.01, "Z", 30)), Units(0.01, "Z", 30)
    for name, yaws in (("Straight", None), ("Turning", YAWS), ("Moved", YAWS), ("Turned", YAWS), ("Mirrored", YAWS)):
        add_plan(stage, f"/World/{name}", units, yaws=yaws)
    for name, matrix in (
        ("Moved", Gf.Matrix4d(1).SetTranslate((3.0, 1.0, -2.0))),
        ("Turned", Gf.Matrix4d(1).SetRotate(Gf.Rotation((0.0, 0.0, 1.0), 40.0))),
        ("Mirrored", Gf.Matrix4d(1).SetScale(Gf.Vec3d(-1.0, 1.0, 1.0))),
    ):
        UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/{name}")).AddTransformOp().Set(matrix)
    undirected = add_plan(stage, "/World/Undirected", units)
    undirected.GetOrientationsAttr().Clear()
    on_edge = add_plan(stage, "/World/OnEdge", units, yaws=YAWS)
    on_edge.GetOrientationsAttr().Set([Gf.Quath(0.0, 1.0, 0.0, 0.0)] * 6)
    unplaced = add_plan(stage, "/World/Unplaced", units)
    unplaced.GetPositionsAttr().Clear()
    uneven = add_plan(stage, "/World/Uneven", units)
    uneven.GetProtoIndicesAttr().Set([0, 1, 0])
    prims = [prim for prim in stage.GetPrimAtPath("/World").GetChildren() if is_plan(prim)]
    assert len(prims) == 9
    stage_units = read_stage_info(stage).units
    together = plans_of([ask_plan(prim) for prim in prims], stage_units)
    assert sum(isinstance(found, PlanError) for found in together) == 4
    for prim, found in zip(prims, together, strict=True):
        if isinstance(found, PlanError):
            with pytest.raises(PlanError) as alone:
                read_plan(prim, stage_units)
            assert str(alone.value) == str(found)
        else:
            plan, problems = read_plan(prim, stage_units)
            assert content_hash(plan) == content_hash(found[0])
            assert problems == found[1]
