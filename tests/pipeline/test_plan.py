"""Plans of whole scenes: what is written, composes, and walks."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils

from tests.few_clips import copy_stages
from tests.scenes import Units, add_agent, add_character, new_stage, simple_scene
from usdfoot.bridge.tokens import Agent, Schema
from usdfoot.bridge.tokens import Path as PathToken
from usdfoot.cli.main import main
from usdfoot.engine.animate import PreparedLibraries
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import OutputError, SceneError
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.lint import lint_scene
from usdfoot.pipeline.plan import plan_scene_paths
from usdfoot.pipeline.plan_trajectories import plan_scene_trajectories
from usdfoot.pipeline.validate import validate
from usdfoot.planning.flights import fly_like_clips
from usdfoot.readers.agents import list_agents
from usdfoot.readers.plans import read_plan
from usdfoot.readers.scene import read_scene
from usdfoot.readers.stage import collect_prims, read_stage_info

CURVE = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 3.0), (1.0, 0.0, 5.0), (4.0, 0.0, 5.0)])


def add_curve(stage, path, units, points=CURVE, **numbers):
    prim = UsdGeom.BasisCurves.Define(stage, path)
    prim.CreatePointsAttr([Gf.Vec3f(*point) for point in units.points(points).tolist()])
    prim.CreateCurveVertexCountsAttr([len(points)])
    prim.GetPrim().AddAppliedSchema(Schema.PATH)
    for name, value in numbers.items():
        prim.GetPrim().CreateAttribute(f"usdfoot:path:{name}", Sdf.ValueTypeNames.Float, custom=False).Set(value)
    return prim.GetPrim()


def scene_with_path(file, units=None, *, agent=True, **numbers):
    units = units or Units()
    stage = new_stage(file, units)
    add_character(stage, "/World/Person", units)
    curve = add_curve(stage, "/World/Way", units, **numbers)
    if agent:
        prim = UsdGeom.Xform.Define(stage, "/World/Walker").GetPrim()
        prim.AddAppliedSchema(Schema.AGENT)
        prim.CreateRelationship(Agent.PATH, custom=False).SetTargets([curve.GetPath()])
        prim.CreateRelationship(Agent.CHARACTER, custom=False).SetTargets(["/World/Person"])
    stage.GetRootLayer().Save()
    return file


def composed(*layers):
    root = Sdf.Layer.CreateAnonymous(".usda")
    UsdUtils.CopyLayerMetadata(Sdf.Layer.FindOrOpen(str(layers[-1])), root)
    root.subLayerPaths = [str(layer) for layer in layers]
    return Usd.Stage.Open(root)


@pytest.mark.parametrize("units", [Units(), Units(meters=0.01, up="Z", rate=30.0), Units(meters=0.0254, rate=48.0)])
def test_plans_mean_the_same_in_any_units_and_agents_point_at_them(tmp_path, units):
    scene = scene_with_path(tmp_path / "scene.usda", units, speed=1.1 / units.meters, stepWidth=0.2 / units.meters)
    report = plan_scene_paths(scene, tmp_path / "plans.usda")
    stage = Usd.Stage.Open(str(scene))
    over = composed(report.file, scene)
    found, problems = list_agents(over, collect_prims(over))
    assert [source.plan.GetPath() for source in found] == ["/Plans/Walker"] and not problems
    read, _ = read_plan(over.GetPrimAtPath("/Plans/Walker"), read_stage_info(stage).units)
    reference = plan_scene_paths(
        scene_with_path(tmp_path / "reference.usda", speed=1.1, stepWidth=0.2), tmp_path / "other.usdc"
    ).plans["Walker"]
    assert_allclose(read.positions, reference.positions, atol=1e-5)
    assert_allclose(read.yaws, reference.yaws, atol=3e-3)
    assert_allclose(read.strike_times, reference.strike_times, atol=1e-4)  # text keeps six digits of time codes


def test_agents_of_one_prim_keep_to_their_curves_whoever_else_is_asked_for(tmp_path):
    """Who was chosen or left alone took the first curve, so that an agent walked elsewhere where another was muted."""
    scene = scene_with_path(tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(scene))
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/World/Way"))
    points = np.concatenate([CURVE + (5.0 * number, 0.0, 0.0) for number in range(3)])
    curves.GetPointsAttr().Set([Gf.Vec3f(*point) for point in points.tolist()])
    curves.GetCurveVertexCountsAttr().Set([len(CURVE)] * 3)
    other = UsdGeom.Xform.Define(stage, "/World/Zoe").GetPrim()
    other.AddAppliedSchema(Schema.AGENT)
    for name, target in ((Agent.PATH, "/World/Way"), (Agent.CHARACTER, "/World/Person")):
        other.CreateRelationship(name, custom=False).SetTargets([target])
    stage.GetRootLayer().Save()
    both = plan_scene_paths(scene, tmp_path / "plans.usda")
    assert [round(float(plan.positions[0, 0])) for plan in both.plans.values()] == [0, 5]
    (said,) = [problem.message for problem in both.problems if "curves" in problem.message]
    assert said.startswith("Walker: /World/Way has more curves than agents follow it, 1 of them nobody walks")
    alone = plan_scene_paths(scene, tmp_path / "plans.usda", agents="Zoe")
    assert_allclose(alone.plans["Zoe"].positions, both.plans["Zoe"].positions)
    (agent,) = read_scene(scene, agents="Zoe", motion="physics").crowd.agents
    assert_allclose(agent.plan.positions[0], both.plans["Zoe"].positions[0], atol=0.05)


def test_curves_nobody_follows_get_plans_with_unique_names(tmp_path):
    scene = scene_with_path(tmp_path / "scene.usda", agent=False)
    stage = Usd.Stage.Open(str(scene))
    add_curve(stage, "/World/More/Way", Units(), CURVE + 1.0)
    two = UsdGeom.BasisCurves(add_curve(stage, "/World/Two", Units(), np.concatenate([CURVE, CURVE + 2.0])))
    two.GetCurveVertexCountsAttr().Set([4, 4])
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usda")
    assert sorted(report.plans) == ["Two", "Two_1", "Way", "Way_1"]


def test_bad_curves_are_named_and_the_others_planned(tmp_path, capsys):
    scene = scene_with_path(tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(scene))
    add_curve(stage, "/World/Point", Units(), np.tile(CURVE[:1], (4, 1)))
    add_curve(stage, "/World/Odd", Units(), CURVE[:3])
    several = add_curve(stage, "/World/Several", Units(), np.concatenate([CURVE, np.ones((4, 3)), CURVE + 9.0]))
    UsdGeom.BasisCurves(several).GetCurveVertexCountsAttr().Set([4, 4, 4])
    stage.GetRootLayer().Save()
    assert main(["plan", "path", str(scene), "-o", str(tmp_path / "plans.usda"), "-q"]) == 1
    said = capsys.readouterr().err
    assert "/World/Point: is a path of zero length" in said
    assert "/World/Odd: has 3 points" in said
    assert "/World/Several, curve 1: is a path of zero length" in said
    made = Usd.Stage.Open(str(tmp_path / "plans.usda"))
    assert [plan.GetName() for plan in made.GetPrimAtPath("/Plans").GetChildren()] == ["Walker", "Several", "Several_1"]


def test_nothing_to_plan_and_nowhere_to_write(tmp_path):
    bare = new_stage(tmp_path / "bare.usda")
    bare.GetRootLayer().Save()
    with pytest.raises(SceneError, match="has no path"):
        plan_scene_paths(tmp_path / "bare.usda", tmp_path / "plans.usda")
    scene = scene_with_path(tmp_path / "scene.usda")
    with pytest.raises(OutputError, match="would replace what it is made from"):
        plan_scene_paths(scene, scene)
    with pytest.raises(OutputError, match=r"\.usda"):
        plan_scene_paths(scene, tmp_path / "plans.txt")


def test_what_cannot_be_walked_is_said_when_it_is_planned(tmp_path):
    scene = scene_with_path(tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(scene))
    ground = UsdGeom.Mesh.Define(stage, "/World/Ground")  # ends at z = 2
    ground.CreatePointsAttr([Gf.Vec3f(*point) for point in ((-9, 0, -9), (-9, 0, 2), (9, 0, 2), (9, 0, -9))])
    ground.CreateFaceVertexCountsAttr([4])
    ground.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    stage.GetRootLayer().Save()
    (problem,) = plan_scene_paths(scene, tmp_path / "plans.usda").problems
    assert problem.severity == "warning" and "is off the terrain (and" in problem.message


def test_start_time_is_the_stages_unless_the_path_has_one(tmp_path):
    scene = scene_with_path(tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(scene))
    stage.SetStartTimeCode(48.0)
    stage.GetRootLayer().Save()
    plan = plan_scene_paths(scene, tmp_path / "plans.usda").plans["Walker"]
    assert plan.strike_times[0] == pytest.approx(2.0)
    attribute = stage.GetPrimAtPath("/World/Way").CreateAttribute(
        PathToken.START_TIME, Sdf.ValueTypeNames.TimeCode, custom=False
    )
    attribute.Set(Sdf.TimeCode(72.0))
    stage.GetRootLayer().Save()
    plan = plan_scene_paths(scene, tmp_path / "plans.usda").plans["Walker"]
    assert plan.strike_times[0] == pytest.approx(3.0)


@pytest.mark.parametrize("agent", [True, False])
@pytest.mark.parametrize("moves", ["points", "transform"])
def test_a_curve_that_is_animated_is_walked_as_it_is_at_the_start_with_a_warning(tmp_path, agent, moves):
    scene = scene_with_path(tmp_path / "scene.usda", agent=agent)
    stage = Usd.Stage.Open(str(scene))
    curve = UsdGeom.BasisCurves(stage.GetPrimAtPath("/World/Way"))
    for code in (0.0, 100.0):
        if moves == "points":
            curve.GetPointsAttr().Set([Gf.Vec3f(*point) for point in (CURVE + (code, 0.0, 0.0)).tolist()], code)
        else:
            curve.MakeMatrixXform().Set(Gf.Matrix4d().SetTranslate(Gf.Vec3d(code, 0.0, 0.0)), code)
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usda")
    (problem,) = report.problems
    name = "Walker" if agent else "Way"
    assert problem.message.startswith(f"{name}: /World/Way is animated, it is walked as it is at the stage's start")
    assert np.abs(report.plans[name].positions[:, 0]).max() < 5.0


def test_a_style_that_no_clip_has_is_named_when_the_path_is_planned(stages, tmp_path):
    copy = copy_stages(stages, tmp_path, kept=("walk_100", "walk_130", "stand"))
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    style = add_curve(stage, "/World/Way", Units()).CreateAttribute(PathToken.STYLE, Sdf.ValueTypeNames.Token, False)
    add_agent(stage, "/World/Sneak", path="/World/Way", character="/World/Person", clips="/World/Motion/Clips")
    said = []
    for value in ("sneaky", "default"):
        style.Set(value)
        stage.GetRootLayer().Save()
        said.append([problem.message for problem in plan_scene_paths(scene, tmp_path / "plans.usda").problems])
    what = "/World/Way: its style is 'sneaky', which no clip of Sneak has. the styles of these are default"
    assert said == [[what], []]


def test_who_waits_for_a_door_stands_on_both_feet_though_its_clips_hardly_do(stages, tmp_path):
    copy, opens = copy_stages(stages, tmp_path, kept=("walk_100", "walk_130", "stand")), 9.0
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    stage.SetEndTimeCode(30.0 * (opens + 1.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    add_curve(stage, "/World/Way", Units())
    add_agent(stage, "/World/Guest", path="/World/Way", character="/World/Person", clips="/World/Motion/Clips")
    door = UsdGeom.Cube.Define(stage, "/World/Door")
    door.CreateSizeAttr(1.0)
    door.GetPrim().AddAppliedSchema(Schema.OBSTACLE)
    slide = door.AddTranslateOp()
    for time, aside in ((0.0, 0.0), (opens, 0.0), (opens + 0.1, 6.0)):
        slide.Set(Gf.Vec3d(aside, 0.5, 2.0), 30.0 * time)
    stage.GetRootLayer().Save()
    plan = plan_scene_paths(scene, tmp_path / "plans.usda").plans["Guest"]
    swings = plan.strike_times[2:] - plan.liftoff_times[:-2]
    assert np.diff(plan.strike_times).max() > 3.0, "it waits"
    assert swings.max() < 1.0, "in a wait both feet stand"
    crowd = read_scene(scene).crowd
    (walked,) = crowd.agents
    np.testing.assert_array_equal(walked.plan.positions, plan.positions, "as if it was animated at once")
    np.testing.assert_allclose(walked.plan.strike_times, plan.strike_times, atol=1e-6)
    assert any("Guest: waits" in problem.message for problem in crowd.problems)


def test_a_run_that_is_planned_first_steps_and_flies_like_the_clips_as_one_that_is_animated_at_once(stages, tmp_path):
    copy = copy_stages(stages, tmp_path, kept=("jog_180", "jog_220", "run_260", "run_320", "stand"))
    points = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 3.0), (0.0, 0.0, 6.0), (0.0, 0.0, 9.0)])
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units())
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    add_curve(stage, "/World/Way", Units(), points, speed=2.8)
    add_curve(stage, "/World/Nobodys", Units(), points, speed=2.8)
    agent = add_agent(stage, "/World/Runner", path="/World/Way", character="/World/Person", clips="/World/Motion/Clips")
    stage.GetRootLayer().Save()
    planned = plan_scene_paths(scene, tmp_path / "plans.usdc").plans
    (runner,) = _flown(read_scene(scene))
    (again,) = _flown(read_scene(composed(tmp_path / "plans.usdc", scene), agents="Runner"))
    assert_allclose(planned["Runner"].liftoff_times, runner.liftoff_times, atol=1e-9)
    assert_allclose(again.liftoff_times, runner.liftoff_times, atol=1e-9)
    assert_allclose(again.strike_times, runner.strike_times, atol=1e-9)
    generic = planned["Nobodys"]
    assert np.abs(generic.strike_times - runner.strike_times).max() > 1e-3
    assert (generic.liftoff_times - runner.liftoff_times).max() > 0.02
    agent.CreateAttribute(Agent.MOTION, Sdf.ValueTypeNames.Token, custom=False).Set("physics")
    stage.GetRootLayer().Save()
    moved = plan_scene_paths(scene, tmp_path / "moved.usdc", agents="Runner").plans["Runner"]
    assert_allclose(moved.strike_times, generic.strike_times, atol=1e-9)
    assert_allclose(moved.liftoff_times, generic.liftoff_times, atol=1e-9)


def _flown(scene):
    """Plans as animating them has them."""
    options = EngineOptions()
    crowd = fly_like_clips(scene.crowd, options=options, libraries=PreparedLibraries(options))
    return [agent.plan for agent in crowd.agents]


def test_steps_too_quick_for_the_clips_take_longer_and_that_is_said(stages, tmp_path):
    """0.5 m at 1.6 m/s: a step in 0.31 s, which the clips take in 0.54 s or more."""
    copy = copy_stages(stages, tmp_path, kept=("walk_070", "walk_100", "walk_130", "walk_160", "walk_200", "stand"))
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    for name, x, length in (("Quick", 0.0, 0.5), ("Free", 3.0, 0.0)):
        points = np.array([(x, 0.0, z) for z in (0.0, 2.0, 4.0, 6.0)])
        add_curve(stage, f"/World/{name}Way", Units(), points, speed=1.6, stepLength=length)
        add_agent(
            stage,
            f"/World/{name}",
            path=f"/World/{name}Way",
            character="/World/Person",
            clips="/World/Motion/Clips",
        )
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usdc")
    (problem,) = report.problems
    assert problem.severity == "warning" and problem.where == "Quick"
    assert "is to go 1.60 m/s by steps of 0.50 m in 0.31 s; its clips cannot be hurried so much" in problem.message
    steps = report.plans["Quick"].positions[3:-2, 2]
    assert_allclose(np.diff(steps), 0.5, atol=0.03)
    assert np.diff(report.plans["Quick"].strike_times)[3:-2].min() > 0.4
    assert not _hurried(composed(report.file, scene))
    plans = Usd.Stage.Open(str(report.file))
    for name in ("strikeTimes", "liftoffTimes"):
        times = plans.GetPrimAtPath("/Plans/Quick").GetAttribute(f"usdfoot:plan:{name}")
        times.Set(Sdf.TimeCodeArray([Sdf.TimeCode(0.7 * code.GetValue()) for code in times.Get()]))
    faults = _hurried(composed(report.file, scene))
    assert {(fault.plan, fault.severity) for fault in faults} == {("/Plans/Quick", "warning")}
    assert len(faults) > 5 and "times as quickly as in the clips" in faults[4].message
    read = read_scene(scene)
    assert problem in read.crowd.problems
    quick = next(agent.plan for agent in read.crowd.agents if agent.name == "Quick")
    assert_allclose(quick.strike_times, report.plans["Quick"].strike_times, atol=1e-9)
    animate(scene, tmp_path / "crowd")
    assert validate(tmp_path / "crowd/crowd.usd").passed


def _hurried(stage):
    return [fault for fault in lint_scene(stage).faults if fault.kind == "hurried"]


def test_who_is_to_go_much_faster_than_its_clips_goes_as_fast_as_these_can_be_hurried(stages, tmp_path):
    copy = copy_stages(stages, tmp_path, kept=("run_320", "run_400", "walk_130", "stand"))
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    for name, x, speed in (("Sprinter", 0.0, 6.0), ("Runner", 3.0, 4.0)):
        points = np.array([(x, 0.0, z) for z in (0.0, 6.0, 12.0, 18.0)])
        add_curve(stage, f"/World/{name}Way", Units(), points, speed=speed)
        way, person = f"/World/{name}Way", "/World/Person"
        add_agent(stage, f"/World/{name}", path=way, character=person, clips="/World/Motion/Clips")
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usdc")
    (problem,) = report.problems
    assert problem.severity == "warning" and problem.where == "Sprinter"
    assert "is to go 6.00 m/s, 1.5 times as fast as its clips, which go up to 4.0" in problem.message
    assert "lower usdfoot:path:speed" in problem.message
    taken = float(problem.message.split(" m/s were taken")[0].rsplit(" ", 1)[-1])
    assert 4.7 < taken < 5.0
    plan = report.plans["Sprinter"]
    assert (np.diff(plan.positions[2:-1, 2]) / np.diff(plan.strike_times[2:-1])).max() < 1.02 * taken


def test_steps_narrower_than_ik_pulls_those_of_the_clips_are_wider_and_that_is_said(stages, tmp_path):
    copy = copy_stages(stages, tmp_path, kept=("walk_100", "walk_130", "stand"))
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    for name, x, reach in (("Stiff", 0.0, 0.04), ("Supple", 3.0, 0.3)):
        points = np.array([(x, 0.0, z) for z in (0.0, 2.0, 4.0, 6.0)])
        add_curve(stage, f"/World/{name}Way", Units(), points, stepWidth=0.02)
        way, person = f"/World/{name}Way", "/World/Person"
        agent = add_agent(stage, f"/World/{name}", path=way, character=person, clips="/World/Motion/Clips")
        uniform = Sdf.VariabilityUniform
        agent.CreateAttribute(Agent.IK_REACH, Sdf.ValueTypeNames.Float, False, uniform).Set(reach)
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usdc")
    (problem,) = report.problems
    assert problem.severity == "warning" and problem.where == "Stiff"
    assert "is to take steps 0.020 m wide, farther from those of its clips than IK may pull; 0.0" in problem.message
    stiff, supple = (np.abs(np.diff(report.plans[name].positions[3:-2, 0])) for name in ("Stiff", "Supple"))
    assert stiff.min() > 0.03 > supple.max()


def test_who_has_clips_without_steps_is_planned_as_asked(stages, tmp_path):
    copy = copy_stages(stages, tmp_path, kept=("stand",))
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene, Units(rate=30.0))
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    add_curve(stage, "/World/Way", Units(), speed=1.6, stepLength=0.5)
    add_agent(stage, "/World/Quick", path="/World/Way", character="/World/Person", clips="/World/Motion/Clips")
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usdc")
    assert not report.problems
    assert np.diff(report.plans["Quick"].strike_times)[3:-2].min() < 0.35


def test_agents_points_and_xforms_that_move_get_plans(tmp_path):
    times, speed = np.arange(0.0, 240.0, 12.0), 1.2
    stage = new_stage(tmp_path / "points.usda")
    cloud = UsdGeom.Points.Define(stage, "/World/Crowd")
    for code in times:
        places = [Gf.Vec3f(x, 0.0, speed * code / 24.0) for x in (0.0, 2.0)]
        cloud.GetPointsAttr().Set(places[: 1 if code < 48 else 2], code)
        cloud.GetIdsAttr().Set([7, 9][: 1 if code < 48 else 2], code)
    stage.GetRootLayer().Save()
    report = plan_scene_trajectories(tmp_path / "points.usda", tmp_path / "a.usdc")
    assert sorted(report.plans) == ["Crowd_7", "Crowd_9"]
    assert report.plans["Crowd_9"].strike_times[0] == pytest.approx(2.0)
    walker = new_stage(tmp_path / "xform.usda", Units(meters=0.01, up="Z"))
    op = UsdGeom.Xform.Define(walker, "/World/Walker").AddTranslateOp()
    for code in times:
        op.Set(Gf.Vec3d(0.0, -100.0 * speed * code / 24.0, 0.0), code)
    walker.GetRootLayer().Save()
    (plan,) = plan_scene_trajectories(tmp_path / "xform.usda", tmp_path / "b.usdc").plans.values()
    assert_allclose(plan.positions, report.plans["Crowd_7"].positions, atol=1e-5)


def test_one_point_that_cannot_be_walked_does_not_stop_the_others(tmp_path):
    """Id 3 jumps, 4 is no number once, -5 is well, 6 is deactivated, 7 is invisible at first; samples are far apart."""
    stage = new_stage(tmp_path / "points.usda")
    crowd = UsdGeom.PointInstancer.Define(stage, "/World/Crowd")
    crowd.CreateIdsAttr([3, 4, -5, 6, 7])
    for code in (0.0, 96.0, 120.0, 480.0, 516.0):
        places = np.array([[2.0 * k, 0.0, 0.6 * code / 24.0] for k in range(5)])
        places[0, 0] += 60.0 * (code > 100.0)
        places[1] *= np.nan if code == 480.0 else 1.0
        crowd.GetPositionsAttr().Set([Gf.Vec3f(*place) for place in places], code)
        crowd.GetProtoIndicesAttr().Set([0] * 5, code)
        crowd.GetInvisibleIdsAttr().Set([7] if code < 96.0 else [], code)
    crowd.DeactivateId(6)
    stage.GetRootLayer().Save()
    report = plan_scene_trajectories(tmp_path / "points.usda", tmp_path / "plans.usdc")
    assert sorted(report.plans) == ["Crowd_3", "Crowd_3_1", "Crowd_7", "Crowd__5"]
    assert report.plans["Crowd_7"].strike_times[0] == pytest.approx(4.0)
    assert [problem.severity for problem in report.problems] == ["warning", "error"]
    assert "/World/Crowd id 3: jumps" in report.problems[0].message
    assert "/World/Crowd id 4: position of sample 3 is not a finite" in report.problems[1].message


def test_skelroots_and_what_moves_in_instances_get_plans_and_points_without_ids_are_named(tmp_path):
    asset = new_stage(tmp_path / "asset.usda")
    root = UsdSkel.Root.Define(asset, "/World/Walker")
    operation = root.AddTranslateOp()
    for code in np.arange(0.0, 240.0, 12.0):
        operation.Set(Gf.Vec3d(0.0, 0.0, 1.2 * code / 24.0), code)
    asset.GetRootLayer().Save()
    stage = new_stage(tmp_path / "scene.usda")
    for number in range(2):
        prim = UsdGeom.Xform.Define(stage, f"/World/Copy{number}").GetPrim()
        prim.GetReferences().AddReference("asset.usda", "/World", Sdf.LayerOffset(24.0 * number))
        prim.SetInstanceable(True)
    stage.GetRootLayer().Save()
    plans = plan_scene_trajectories(tmp_path / "scene.usda", tmp_path / "plans.usdc").plans
    assert [plan.strike_times[0] for plan in plans.values()] == pytest.approx([0.0, 1.0])
    nameless = new_stage(tmp_path / "points.usda")
    points = UsdGeom.Points.Define(nameless, "/World/Crowd").GetPointsAttr()
    for code in (0.0, 24.0):
        points.Set([Gf.Vec3f(0.0, 0.0, code)], code)
    nameless.GetRootLayer().Save()
    with pytest.raises(SceneError, match="/World/Crowd: has no ids"):
        plan_scene_trajectories(tmp_path / "points.usda", tmp_path / "plans.usdc")


def test_trajectories_that_cannot_be_walked_are_said_when_they_are_planned(tmp_path):
    """One walks off the ground's end at z = 2, the other along it."""
    scene = tmp_path / "scene.usda"
    stage = new_stage(scene)
    ground = UsdGeom.Mesh.Define(stage, "/World/Ground")
    ground.CreatePointsAttr([Gf.Vec3f(*point) for point in ((-9, 0, -9), (-9, 0, 2), (9, 0, 2), (9, 0, -9))])
    ground.CreateFaceVertexCountsAttr([4])
    ground.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    ground.GetPrim().AddAppliedSchema("UsdfootTerrainAPI")
    for name, ahead in (("Off", (0.0, 0.0, 6.0)), ("On", (6.0, 0.0, 0.0))):
        op = UsdGeom.Xform.Define(stage, f"/World/{name}").AddTranslateOp()
        for code in np.arange(0.0, 132.0, 12.0):
            op.Set(Gf.Vec3d(*ahead) * (code / 120.0), code)
    stage.GetRootLayer().Save()
    report = plan_scene_trajectories(scene, tmp_path / "plans.usda")
    (problem,) = report.problems
    assert sorted(report.plans) == ["Off", "On"] and not report.skipped
    assert problem.severity == "warning" and problem.where == "Off" and "is off the terrain (and" in problem.message


def test_files_of_tracks_through_the_command_line(tmp_path, capsys):
    lines = [f"{10 * i}\t{person}\t{person}\t{0.4 * i}" for i in range(20) for person in (1, 2)]
    (tmp_path / "tracks.txt").write_text("\n".join(lines))
    command = ["plan", "trajectories", str(tmp_path / "tracks.txt"), "-o", str(tmp_path / "plans.usda"), "-q"]
    assert main(command) == 2
    assert "in which unit" in capsys.readouterr().err
    assert main([*command, "--unit", "m", "--rate", "25", "--prims", "/World/*"]) == 2
    assert "--prims: is for a USD scene. leave it out with" in capsys.readouterr().err
    assert main([*command, "--unit", "m", "--rate", "25"]) == 0
    stage = Usd.Stage.Open(str(tmp_path / "plans.usda"))
    names = [prim.GetName() for prim in stage.GetPrimAtPath("/Plans").GetChildren()]
    assert names == ["person_1", "person_2"]
    plan, _ = read_plan(stage.GetPrimAtPath("/Plans/person_2"), read_stage_info(stage).units)
    assert plan.positions[-1, 2] < -6.0  # north is -z


def test_where_no_clip_has_a_usable_step_plans_are_checked_without(tmp_path, capsys):
    scene = tmp_path / "scene.usda"
    simple_scene(scene, seconds=0.3).Save()
    assert main(["plan", "lint", str(scene)]) in (0, 1)
    assert "has no clip with a usable step to check against: " in capsys.readouterr().err


def test_lint_says_what_is_wrong_and_fixes_what_it_can(tmp_path, capsys):
    scene = scene_with_path(tmp_path / "scene.usda")
    plans = plan_scene_paths(scene, tmp_path / "plans.usda").file
    shot = composed(plans, scene)
    shot.GetRootLayer().Export(str(tmp_path / "shot.usda"))
    assert main(["plan", "lint", str(tmp_path / "shot.usda"), "-q"]) == 0
    over = Usd.Stage.Open(str(tmp_path / "shot.usda"))
    liftoffs = over.GetPrimAtPath("/Plans/Walker").GetAttribute("usdfoot:plan:liftoffTimes")
    times = list(liftoffs.Get())
    times[4] = Sdf.TimeCode(0.0)
    liftoffs.Set(Sdf.TimeCodeArray(times))
    over.GetRootLayer().Save()
    capsys.readouterr()
    assert main(["plan", "lint", str(tmp_path / "shot.usda"), "--json", "-q"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [(fault["plan"], fault["kind"]) for fault in found["faults"]] == [("/Plans/Walker", "malformed")]
    assert main(["plan", "lint", str(tmp_path / "shot.usda"), "--fix", str(tmp_path / "fixed.usdc"), "-q"]) == 0
    composed(tmp_path / "fixed.usdc", tmp_path / "shot.usda").GetRootLayer().Export(str(tmp_path / "good.usda"))
    assert main(["plan", "lint", str(tmp_path / "good.usda"), "-q"]) == 0
    empty = new_stage(tmp_path / "empty.usda")
    empty.GetRootLayer().Save()
    assert main(["plan", "lint", str(tmp_path / "empty.usda"), "-q"]) == 2


def test_times_that_cannot_be_mended_are_named_as_they_stand(tmp_path):
    """One strike after the next foot's: in order of strike the same foot would come twice."""
    plans = plan_scene_paths(scene_with_path(tmp_path / "path.usda", agent=False), tmp_path / "plans.usda").file
    stage = Usd.Stage.Open(str(plans))
    strikes = stage.GetPrimAtPath("/Plans/Way").GetAttribute("usdfoot:plan:strikeTimes")
    times = list(strikes.Get())
    times[4] = times[6]
    strikes.Set(Sdf.TimeCodeArray(times))
    stage.GetRootLayer().Save()
    (found,) = lint_scene(plans).faults
    assert lint_scene(plans, fix=tmp_path / "fixed.usda").faults == (found,)
    assert "footstep 4" in found.message


def test_a_fixed_plan_stays_where_it_stands_and_only_what_was_wrong_is_authored(tmp_path):
    plans = plan_scene_paths(scene_with_path(tmp_path / "path.usda", agent=False), tmp_path / "plans.usda").file
    scene = new_stage(tmp_path / "scene.usda")
    place = UsdGeom.Xform.Define(scene, "/World/Steps")
    place.AddTranslateOp().Set(Gf.Vec3d(3.0, 0.0, 1.0))
    plan = scene.DefinePrim("/World/Steps/Mine")
    plan.GetReferences().AddReference(str(plans), "/Plans/Way")
    floor = UsdGeom.Plane.Define(scene, "/World/Floor")
    floor.CreateWidthAttr(40.0)
    floor.CreateLengthAttr(40.0)
    floor.CreateAxisAttr("Y")
    floor.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    positions = UsdGeom.PointInstancer(plan).GetPositionsAttr()
    good = np.array(positions.Get())
    positions.Set(good + np.where(np.arange(len(good)) == 5, 0.1, 0.0)[:, None] * np.array([0.0, 1.0, 0.0], np.float32))
    scene.GetRootLayer().Save()
    (fault,) = lint_scene(tmp_path / "scene.usda").faults
    assert (fault.plan, fault.footstep, fault.kind) == ("/World/Steps/Mine", 5, "offGround")
    fixed = lint_scene(tmp_path / "scene.usda", fix=tmp_path / "fixed.usda")
    layer = Sdf.Layer.FindOrOpen(str(fixed.file))
    assert fixed.clean and [spec.name for spec in layer.rootPrims] == ["World"]
    assert not layer.pseudoRoot.HasInfo("defaultPrim")
    over = layer.GetPrimAtPath("/World/Steps/Mine")
    assert {spec.name for spec in over.properties} <= {"positions", "orientations"}
    composed(fixed.file, tmp_path / "scene.usda").GetRootLayer().Export(str(tmp_path / "good.usda"))
    assert lint_scene(tmp_path / "good.usda").faults == ()
    mended = Usd.Stage.Open(str(tmp_path / "good.usda"))
    assert_allclose(mended.GetPropertyAtPath("/World/Steps/Mine.positions").Get(), good, atol=1e-5)


def test_obstacles_of_the_scene_are_gone_round_and_a_path_that_cannot_be_is_refused_with_the_place(tmp_path, capsys):
    scene = scene_with_path(tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(scene))
    crate = UsdGeom.Cube.Define(stage, "/World/Crate")
    crate.CreateSizeAttr(1.0)
    crate.AddTranslateOp().Set(Gf.Vec3d(0.0, 0.5, 2.0))
    crate.GetPrim().AddAppliedSchema(Schema.OBSTACLE)
    stage.GetRootLayer().Save()
    report = plan_scene_paths(scene, tmp_path / "plans.usda")
    feet = report.plans["Walker"].positions
    assert not (np.abs(feet - (0.0, 0.0, 2.0))[:, [0, 2]] < 0.5).all(axis=1).any()
    (warning,) = report.problems
    assert "Walker: keeps 0." in warning.message and "m off its curve at (" in warning.message
    assert main(["plan", "path", str(scene), "-o", str(tmp_path / "drawn.usda"), "--no-around"]) == 0
    assert "the obstacle /World/Crate" in capsys.readouterr().err
    crate.GetOrderedXformOps()[0].Set(Gf.Vec3d(4.0, 0.5, 5.0))
    crate.AddScaleOp().Set(Gf.Vec3f(4.0, 1.0, 4.0))
    stage.GetRootLayer().Save()
    assert main(["plan", "path", str(scene), "-o", str(tmp_path / "none.usda")]) == 2
    assert "ends too near to the obstacle /World/Crate at (4.00, 0.00, 5.00) m" in capsys.readouterr().err
