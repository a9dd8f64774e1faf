"""Root trajectories as people author them: Xforms of any kind, points with ids, other units and axes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Ts, Usd, UsdGeom, Vt

from tests.scenes import Units, add_agent, new_stage, simple_scene
from usdfoot.bridge.tokens import Agent as AgentToken
from usdfoot.bridge.tokens import Plan as PlanToken
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.readers.scene import read_scene
from usdfoot.readers.trajectories import TrajectoryReader

INCHES = Units(meters=0.0254, up="Z", rate=48.0)
TIMES = np.array([0.5, 1.0, 2.0, 2.5])
PLACES = np.array([[1.0, 0.5, 2.0], [1.2, 0.5, 2.6], [2.0, 0.7, 3.0], [2.5, 0.7, 3.0]])


def reader(units: Units) -> TrajectoryReader:
    return TrajectoryReader(
        units=StageUnits(meters_per_unit=units.meters, up_axis=units.up, time_codes_per_second=units.rate)
    )


def add_way(stage, path, units, *, times=TIMES, places=PLACES):
    """An Xform with time samples of its translation."""
    xform = UsdGeom.Xform.Define(stage, path)
    operation = xform.AddTranslateOp()
    for time, place in zip(times, units.points(places), strict=True):
        operation.Set(Gf.Vec3d(*place.tolist()), time * units.rate)
    return xform


def add_cloud(stage, path, units, samples):
    """Points with ids: {time: {id: place}}."""
    points = UsdGeom.Points.Define(stage, path)
    for time, places in samples.items():
        values = np.array(list(places.values()), dtype=float).reshape(-1, 3)
        points.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(units.points(values).astype(np.float32)), time * units.rate)
        points.GetIdsAttr().Set(Vt.Int64Array(list(places)), time * units.rate)
    return points


@pytest.mark.parametrize("units", [Units(), INCHES, Units(meters=0.01, up="Y", rate=30.0)])
def test_translation_is_the_position(units):
    stage = new_stage(units=units)
    trajectory = reader(units).read(add_way(stage, "/World/Way", units).GetPrim(), None)
    assert_allclose(trajectory.times, TIMES)
    assert_allclose(trajectory.positions, PLACES, atol=1e-6)
    assert trajectory.yaws is None and trajectory.name == "/World/Way"


@pytest.mark.parametrize("units", [Units(), INCHES])
def test_animated_rotation_is_the_heading(units):
    stage = new_stage(units=units)
    way = add_way(stage, "/World/Way", units)
    turn = way.AddRotateYOp() if units.up == "Y" else way.AddRotateZOp()
    yaws = np.array([0.0, 100.0, 250.0, 400.0])
    for time, yaw in zip(TIMES, yaws, strict=True):
        turn.Set(float(yaw), float(time * units.rate))
    trajectory = reader(units).read(way.GetPrim(), None)
    assert_allclose(trajectory.yaws, np.radians(yaws), atol=1e-5)


@pytest.mark.parametrize("turn", [200.0, -360.0, 900.0])
def test_angles_that_turn_farther_than_half_around_between_two_samples_go_the_way_they_say(turn):
    stage = new_stage()
    xform = UsdGeom.Xform.Define(stage, "/World/Way")
    operation = xform.AddRotateXYZOp()
    for code, yaw in ((0.0, 0.0), (48.0, turn), (96.0, turn)):
        operation.Set(Gf.Vec3f(0.0, yaw, 0.0), code)
    trajectory = reader(Units()).read(xform.GetPrim(), None)
    assert_allclose(
        np.interp([0.5, 1.0, 2.0], trajectory.times, trajectory.yaws), np.radians(turn) * np.array([0.25, 0.5, 1.0])
    )


@pytest.mark.skipif(not hasattr(Usd.Attribute, "HasSpline"), reason="this USD has no splines on attributes")
def test_splines_are_followed_between_their_knots():
    stage = new_stage()
    xform = UsdGeom.Xform.Define(stage, "/World/Way")
    attribute = xform.AddTranslateZOp(UsdGeom.XformOp.PrecisionDouble).GetAttr()
    spline = Ts.Spline("double")
    for code, place in ((0.0, 0.0), (48.0, 3.0), (72.0, 3.0)):
        ease = {"preTanWidth": 8.0, "postTanWidth": 8.0}
        spline.SetKnot(Ts.Knot(typeName="double", time=code, value=place, nextInterp=Ts.InterpCurve, **ease))
    attribute.SetSpline(spline)
    trajectory = reader(Units()).read(xform.GetPrim(), None)
    assert_allclose(np.diff(trajectory.times), 1.0 / 24.0)
    places = [attribute.Get(float(code)) for code in 24.0 * trajectory.times]
    assert_allclose(trajectory.positions[:, 2], places)
    assert np.ptp(np.diff(places[:48])) > 0.01, "eased, not straight"


def test_rotation_that_stays_is_no_heading_but_that_of_one_at_rest():
    stage = new_stage()
    way = add_way(stage, "/World/Way", Units(rate=24.0))
    way.AddRotateYOp().Set(90.0)
    trajectory = reader(Units()).read(way.GetPrim(), None)
    assert trajectory.yaws is None
    assert_allclose(trajectory.rest_yaw, np.pi / 2)


@pytest.mark.parametrize("turns", [False, True])
def test_matrices_say_the_heading_if_they_turn(turns):
    stage = new_stage()
    xform = UsdGeom.Xform.Define(stage, "/World/Way")
    operation = xform.AddTransformOp()
    for code, yaw in ((0.0, 10.0), (24.0, 10.0 + 60.0 * turns)):
        matrix = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 1, 0), yaw))
        operation.Set(matrix.SetTranslateOnly(Gf.Vec3d(0, 0, code / 24.0)), code)
    trajectory = reader(Units()).read(xform.GetPrim(), None)
    if turns:
        assert_allclose(trajectory.yaws, np.radians([10.0, 70.0]))
    else:
        assert trajectory.yaws is None


def test_transforms_above_count():
    stage = new_stage()
    parent = UsdGeom.Xform.Define(stage, "/World/Bus")
    move = parent.AddTranslateOp()
    move.Set(Gf.Vec3d(0, 0, 0), 0.0)
    move.Set(Gf.Vec3d(0, 0, 8), 48.0)
    UsdGeom.Xform.Define(stage, "/World/Bus/Seat").AddTranslateOp().Set(Gf.Vec3d(1, 0, 2))
    trajectory = reader(Units()).read(stage.GetPrimAtPath("/World/Bus/Seat"), None)
    assert_allclose(trajectory.positions, [[1, 0, 2], [1, 0, 10]])


@pytest.mark.parametrize("units", [Units(), INCHES])
def test_points_keep_their_ids_when_they_change_places_appear_and_vanish(units):
    stage = new_stage(units=units)
    samples = {
        0.0: {7: (0, 0, 0), 3: (5, 0, 0)},
        1.0: {3: (5, 0, 1), 7: (0, 0, 1), 9: (9, 0, 0)},
        2.0: {9: (9, 0, 1), 7: (0, 0, 2)},
        3.0: {},
        4.0: {7: (0, 0, 4), 9: (9, 0, 3)},
    }
    cloud = add_cloud(stage, "/World/People", units, samples).GetPrim()
    read = reader(units)
    for number, times, depths in ((7, [0, 1, 2, 4], [0, 1, 2, 4]), (3, [0, 1], [0, 1]), (9, [1, 2, 4], [0, 1, 3])):
        trajectory = read.read(cloud, number)
        assert_allclose(trajectory.times, times)
        assert_allclose(trajectory.positions[:, 2], depths, atol=1e-5)
        assert trajectory.name == f"/World/People id {number}"


def test_points_keep_their_ids_under_a_layer_that_is_shifted_and_stretched():
    """Offsets round: at some of these time codes what is held is the sample before."""
    stage, count = new_stage(), 200
    samples = {0.4 * k: {(k + n) % 3: ((k + n) % 3, 0, 0.1 * k) for n in range(3)} for k in range(count)}
    for k in range(0, count // 2, 2):  # with a point that comes and goes, and later without
        samples[0.4 * k][9] = (9, 0, 0.1 * k)
    add_cloud(stage, "/World/People", Units(), samples)
    stretched = Usd.Stage.CreateInMemory()
    stretched.SetTimeCodesPerSecond(24.0)
    stretched.GetRootLayer().subLayerPaths.append(stage.GetRootLayer().identifier)
    stretched.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(100.0, 1.25)
    cloud = stretched.GetPrimAtPath("/World/People")
    for number in range(3):
        trajectory = reader(Units()).read(cloud, number)
        assert_allclose(trajectory.times, 100.0 / 24.0 + 0.5 * np.arange(count))
        assert_allclose(trajectory.positions[:, 0], number, atol=1e-6)
        assert_allclose(trajectory.positions[:, 2], 0.1 * np.arange(count), atol=1e-5)


def test_instances_face_as_they_are_oriented():
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/People")
    for code, yaw in ((0.0, 30.0), (24.0, 75.0)):
        instancer.GetPositionsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(0, 0, code / 24.0)]), code)
        instancer.GetIdsAttr().Set(Vt.Int64Array([4]), code)
        half = np.radians(yaw) / 2.0
        instancer.GetOrientationsAttr().Set(Vt.QuathArray([Gf.Quath(np.cos(half), 0, np.sin(half), 0)]), code)
    trajectory = reader(Units()).read(instancer.GetPrim(), 4)
    assert_allclose(np.degrees(trajectory.yaws), [30.0, 75.0], atol=0.1)


def add_instances(stage, counts_at):
    """A PointInstancer without ids: {time code: number of instances}, each walking along its own lane."""
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/People")
    for code, count in counts_at.items():
        places = [Gf.Vec3f(float(lane), 0.0, code / 24.0) for lane in range(count)]
        instancer.GetPositionsAttr().Set(Vt.Vec3fArray(places), code)
    instancer.GetProtoIndicesAttr().Set(Vt.IntArray([0] * max(counts_at.values())))
    return instancer.GetPrim()


def test_instances_without_ids_are_told_apart_by_their_index_as_usd_does():
    stage = new_stage()
    trajectory = reader(Units()).read(add_instances(stage, {0.0: 3, 24.0: 3}), 2)
    assert_allclose(trajectory.positions, [(2.0, 0.0, 0.0), (2.0, 0.0, 1.0)])
    with pytest.raises(PlanError, match="/World/People: has no ids, and 3 positions at one time, 2 at another"):
        reader(Units()).read(add_instances(stage, {0.0: 3, 24.0: 2}), 1)


def test_an_instance_is_followed_while_it_is_shown():
    """Programs park those who have left the picture somewhere far away, invisible."""
    stage = new_stage()
    prim = add_instances(stage, {0.0: 2, 24.0: 2, 48.0: 2, 72.0: 2})
    instancer = UsdGeom.PointInstancer(prim)
    instancer.GetPositionsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(0.0), Gf.Vec3f(0.0, -9e5, 0.0)]), 0.0)
    for code, hidden in ((0.0, [1]), (24.0, []), (72.0, [1])):
        instancer.GetInvisibleIdsAttr().Set(Vt.Int64Array(hidden), code)
    trajectory = reader(Units()).read(prim, 1)
    assert_allclose(trajectory.times, [1.0, 2.0])
    instancer.GetInvisibleIdsAttr().Clear()
    instancer.GetInvisibleIdsAttr().Set(Vt.Int64Array([1]))
    with pytest.raises(PlanError, match="/World/People: hides id 1 at all times"):
        reader(Units()).read(prim, 1)


def faulty(stage: Usd.Stage, what: str) -> Usd.Prim:
    samples = {0.0: {1: (0, 0, 0)}, 1.0: {1: (0, 0, 1)}}
    if what == "no samples":
        return UsdGeom.Xform.Define(stage, "/World/Way").GetPrim()
    if what == "no transform":
        return stage.DefinePrim("/World/Way", "Scope")
    cloud = add_cloud(stage, "/World/Way", Units(), samples)
    if what == "no ids":
        cloud.GetPrim().RemoveProperty("ids")
    elif what == "id twice":
        cloud.GetPointsAttr().Set(Vt.Vec3fArray(2), 24.0)
        cloud.GetIdsAttr().Set(Vt.Int64Array([1, 1]), 24.0)
    elif what == "too many points":
        cloud.GetPointsAttr().Set(Vt.Vec3fArray(2), 24.0)
    elif what == "jump":
        cloud.GetPointsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(0, 0, 90)]), 24.0)
    elif what == "not a number":
        cloud.GetPointsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(float("nan"), 0, 0)]), 24.0)
    elif what == "beyond the moon":
        for code in (0.0, 24.0):
            cloud.GetPointsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(1e12, 0, 0)]), code)
    return cloud.GetPrim()


@pytest.mark.parametrize(
    ("what", "number", "message"),
    [
        ("no samples", None, "has 0 time sample(s) of its transform"),
        ("no transform", None, "is Scope. a trajectory is an Xformable with time samples, or Points"),
        ("points", None, "holds many trajectories. author int64 usdfoot:agent:id on the agent"),
        ("points", 5, "has no id 5 at any time: 1"),
        ("no ids", 1, "has no ids"),
        ("id twice", 1, "has an id twice at time code 24"),
        ("too many points", 1, "has 2 points but 1 ids at time code 24"),
        ("jump", 1, "jumps by 90 m from 0 to 1 s. cut it there, or correct the unit or the rate"),
        ("not a number", 1, "position of sample 1 is not a finite number"),
        ("beyond the moon", 1, "sample 0 is 1e+12 m from the origin. author positions within 1e+09 m"),
    ],
)
def test_what_is_wrong_is_named(what, number, message):
    stage = new_stage()
    with pytest.raises(PlanError) as caught:
        reader(Units()).read(faulty(stage, what), number)
    assert str(caught.value).startswith("/World/Way") and message in str(caught.value)


def test_agents_with_trajectories_are_read():
    units = Units()
    stage = simple_scene()
    add_way(stage, "/World/Way", units)
    add_cloud(stage, "/World/People", units, {0.0: {8: (0, 0, 0)}, 9.0: {8: (0, 0, 9)}})
    add_agent(stage, "/World/Walker", trajectory="/World/Way", character="/World/Hero", clips="/World/Clips")
    prim = add_agent(stage, "/World/Eight", trajectory="/World/People", character="/World/Hero", clips="/World/Clips")
    prim.CreateAttribute(AgentToken.ID, Sdf.ValueTypeNames.Int64, False).Set(8)
    add_agent(stage, "/World/Lost", trajectory="/World/People", character="/World/Hero")
    scene = read_scene(stage)
    assert [agent.name for agent in scene.crowd.agents] == ["Hero"]
    followers = {follower.name: follower.trajectory for follower in scene.crowd.followers}
    assert set(followers) == {"Walker", "Eight"} and followers["Eight"].end == 9.0
    assert scene.frame_codes[0] == 0.0 and scene.frame_codes[-1] == 9.0 * units.rate
    (problem,) = [problem for problem in scene.crowd.problems if problem.severity == "error"]
    assert problem.where == "/World/Lost" and "usdfoot:agent:id" in problem.message


@pytest.mark.parametrize(
    ("times", "offset", "message"),
    [
        (
            TIMES,
            0.0,
            "/World/Root: lasts from 0.5 to 2.5 s. the footsteps of /World/Plans/Walk need it from 0.5 to 3.91",
        ),
        (np.array([-1.0, 0.0, 2.0, 9.0]), 50.0, "m away from the feet at footstep"),
    ],
)
def test_root_trajectories_that_do_not_fit_the_plan_are_warned_of(times, offset, message):
    stage = simple_scene()
    add_way(stage, "/World/Root", Units(), times=times, places=PLACES + (offset, 0.0, 0.0))
    stage.GetPrimAtPath("/World/Plans/Walk").CreateRelationship(PlanToken.ROOT_TRAJECTORY, False).SetTargets(
        [Sdf.Path("/World/Root")]
    )
    scene = read_scene(stage)
    assert scene.crowd.agents[0].root_trajectory is None
    (problem,) = scene.crowd.problems
    assert problem.severity == "warning" and problem.where == "/World/Plans/Walk" and message in problem.message
