"""Wanderers among obstacles that are animated on the stage."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.scenes import Units, add_ground, add_mesh, new_stage
from usdfoot.bridge.tokens import Agent, Path, Schema
from usdfoot.cli.main import main
from usdfoot.pipeline.lint import lint_scene
from usdfoot.pipeline.plan import plan_scene_paths
from usdfoot.pipeline.plan_goals import plan_scene_crowd, plan_scene_wander
from usdfoot.pipeline.plan_trajectories import plan_scene_trajectories
from usdfoot.planning.path import PathOptions
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

UNITS = Units(0.01, "Z", 30.0)
START = 2.0
"""Of the stage [s]: its time codes do not begin with 0."""
HALF = 0.6
"""Of the cart [m]."""
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def crossing(time: float) -> np.ndarray:
    """Where the cart is at a time after the start: it crosses the straight way as one gets there who goes it."""
    return np.array([np.clip(-5.0 + 1.2 * time, -5.0, 7.0), 0.0, 5.0])


def leaving(time: float) -> np.ndarray:
    """A cart that stands in the way and drives off."""
    return np.array([min(1.5 * time, 8.0), 0.0, 3.0])


def parking(time: float) -> np.ndarray:
    """A cart that drives onto the way from the left and stays there."""
    return np.array([min(2.0 * time - 8.0, 0.0), 0.0, 5.0])


def park(path, way, *, by: str) -> Usd.Stage:
    """An agent at the origin whose goal is 10 m ahead, and a cart that moves `by` what is animated."""
    stage = new_stage(path, UNITS)
    stage.SetStartTimeCode(START * UNITS.rate)
    stage.SetEndTimeCode((START + 20.0) * UNITS.rate)
    add_ground(stage, "/World/Ground", UNITS, size=30.0)
    goal = UsdGeom.Xform.Define(stage, "/World/Goal")
    goal.AddTranslateOp().Set(Gf.Vec3d(*UNITS.points([0.0, 0.0, 10.0])))
    agent = UsdGeom.Xform.Define(stage, "/World/Person").GetPrim()
    agent.AddAppliedSchema(Schema.AGENT)
    agent.CreateRelationship(Agent.GOAL, custom=False).SetTargets([goal.GetPath()])
    corners = HALF * np.array([(x, y, z) for x in (-1, 1) for y in (0, 2) for z in (-1, 1)])
    parent = UsdGeom.Xform.Define(stage, "/World/Cart")
    first = way(0.0) if by == "nothing" else np.zeros(3)
    cart = add_mesh(stage, "/World/Cart/Body", corners + first, SIDES, UNITS)
    cart.GetPrim().AddAppliedSchema(Schema.OBSTACLE)
    moved = {"parent": parent, "prim": cart}.get(by)
    operation = moved.AddTranslateOp() if moved else None
    for time in np.arange(0.0, 20.0, 0.5):
        code = (START + time) * UNITS.rate
        if operation:
            operation.Set(Gf.Vec3d(*UNITS.points(way(time))), code)
        elif by == "points":
            cart.GetPointsAttr().Set([Gf.Vec3f(*point) for point in UNITS.points(corners + way(time)).tolist()], code)
    stage.Save()
    return stage


def room(plan, way) -> float:
    """How near the cart comes to the middle of the feet, as each foot strikes [m]."""
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])[:, [0, 2]]
    return min(
        float(
            clearances(
                World(obstacles=(Obstacle(name="cart", outline=box_outline(place - HALF, place + HALF)),)), middle[None]
            )[0]
        )
        for middle, place in zip(middles, (way(time - START)[[0, 2]] for time in plan.strike_times[1:]), strict=True)
    )


@pytest.mark.parametrize("by", ["parent", "prim", "points"])
def test_what_crosses_the_way_is_avoided_where_it_will_be(tmp_path, by):
    scene, layer = tmp_path / "park.usda", tmp_path / "plans.usda"
    park(scene, crossing, by=by)
    (plan,) = plan_scene_wander(scene, layer).plans.values()
    assert plan.ends_standing and np.linalg.norm(plan.positions[-1, [0, 2]] - [0.0, 10.0]) < 0.5
    assert room(plan, crossing) > 0.15
    park(tmp_path / "still.usda", crossing, by="nothing")
    (blind,) = plan_scene_wander(tmp_path / "still.usda", layer).plans.values()
    assert room(blind, crossing) < 0.0, "who does not see it move is run over"


def test_what_leaves_the_way_is_not_walked_round_once_it_has(tmp_path):
    layers = {}
    for by in ("prim", "nothing"):
        scene = tmp_path / f"{by}.usda"
        park(scene, leaving, by=by)
        report = plan_scene_wander(scene, tmp_path / f"plans_{by}.usda")
        (layers[by],) = report.plans.values()
        assert [problem.message for problem in report.problems] == []
    aside = {by: np.abs(plan.positions[:, 0]).max() for by, plan in layers.items()}
    assert aside["prim"] < 0.4 < HALF < aside["nothing"]


def test_who_does_not_arrive_in_its_steps_is_told_how_far_it_got(tmp_path):
    scene, layer = tmp_path / "park.usda", tmp_path / "plans.usda"
    park(scene, leaving, by="prim")
    short = plan_scene_wander(scene, layer, steps=8)
    (plan,) = short.plans.values()
    (told,) = short.problems
    assert (told.severity, told.where, len(plan)) == ("warning", "/World/Person", 8)
    gone, left = (float(number) for number in re.findall(r"([0-9.]+) m ", told.message))
    middle = plan.positions[-2:].mean(axis=0)
    assert left == pytest.approx(np.linalg.norm(middle - [0.0, 0.0, 10.0]), abs=0.06)
    assert gone == pytest.approx(middle[2], abs=0.3) and "after 8 footsteps" in told.message
    whole = plan_scene_wander(scene, layer, steps=100)
    (arrived,) = whole.plans.values()
    assert whole.problems == () and arrived.ends_standing


def test_who_stands_at_its_goal_with_its_last_step_has_arrived(tmp_path):
    scene, layer = tmp_path / "park.usda", tmp_path / "plans.usda"
    park(scene, leaving, by="prim")
    (whole,) = plan_scene_wander(scene, layer, steps=100).plans.values()
    just = plan_scene_wander(scene, layer, steps=len(whole))
    (plan,) = just.plans.values()
    assert just.problems == () and plan.ends_standing
    assert np.array_equal(plan.strike_times, whole.strike_times)
    assert np.array_equal(plan.liftoff_times, whole.liftoff_times)
    short = plan_scene_wander(scene, layer, steps=len(whole) - 1)
    assert len(short.problems) == 1 and not next(iter(short.plans.values())).ends_standing


def test_lint_looks_at_animated_obstacles_as_each_foot_strikes(tmp_path, capsys):
    park(tmp_path / "prim.usda", crossing, by="prim")
    park(tmp_path / "nothing.usda", crossing, by="nothing")
    faults = {}
    for by in ("prim", "nothing"):
        plans, both = tmp_path / f"plans_{by}.usda", tmp_path / f"both_{by}.usda"
        assert main(["plan", "wander", str(tmp_path / f"{by}.usda"), "-o", str(plans), "--quiet"]) == 0
        stage = Usd.Stage.Open(str(tmp_path / "prim.usda"))
        stage.GetRootLayer().subLayerPaths = [str(plans)]
        stage.Export(str(both))
        faults[by] = [fault.message for fault in lint_scene(both).faults if fault.kind == "obstacle"]
    assert faults["prim"] == []
    assert faults["nothing"] and all("the obstacle /World/Cart/Body" in message for message in faults["nothing"])


def draw(stage: Usd.Stage) -> None:
    """A curve along the way, walked from the start on."""
    curve = UsdGeom.BasisCurves.Define(stage, "/World/Way")
    curve.CreatePointsAttr([Gf.Vec3f(*UNITS.points([0.0, 0.0, z])) for z in (0.0, 10.0)])
    curve.CreateCurveVertexCountsAttr([2])
    curve.CreateTypeAttr("linear")
    curve.GetPrim().AddAppliedSchema(Schema.PATH)
    curve.GetPrim().CreateAttribute(Path.START_TIME, Sdf.ValueTypeNames.TimeCode).Set(START * UNITS.rate)
    stage.Save()


def test_trajectories_are_kept_to_and_whose_feet_it_meets_is_told(tmp_path):
    scene, layer = tmp_path / "park.usda", tmp_path / "plans.usda"
    stage = park(scene, parking, by="prim")
    track = UsdGeom.Xform.Define(stage, "/World/Track")
    operation = track.AddTranslateOp()
    for time in (0.0, 8.0):
        operation.Set(Gf.Vec3d(*UNITS.points([0.0, 0.0, 1.2 * time])), (START + time) * UNITS.rate)
    stage.Save()
    report = plan_scene_trajectories(scene, layer, prims="/World/Track")
    warnings = [problem.message for problem in report.problems if problem.severity == "warning"]
    assert any("the obstacle /World/Cart/Body" in message for message in warnings)


def test_a_path_is_walked_later_where_something_crosses_it(tmp_path):
    scene, layer = tmp_path / "park.usda", tmp_path / "plans.usda"
    draw(park(scene, crossing, by="prim"))
    report = plan_scene_paths(scene, layer)
    (told,) = [problem.message for problem in report.problems if problem.where == "Way"]
    assert "for /World/Cart/Body. usdfoot plan path --no-around keeps its times" in told and "Way: waits" in told
    assert room(report.plans["Way"], crossing) > 0.2
    kept = plan_scene_paths(scene, layer, options=PathOptions(around=False))
    assert room(kept.plans["Way"], crossing) < 0.0
    np.testing.assert_array_equal(kept.plans["Way"].positions, report.plans["Way"].positions)
    assert any("the obstacle /World/Cart/Body" in problem.message for problem in kept.problems)


def test_a_path_goes_round_what_stays_on_it_and_not_round_what_leaves(tmp_path):
    aside = {}
    for way in (parking, leaving):
        scene = tmp_path / f"{way.__name__}.usda"
        draw(park(scene, way, by="prim"))
        plan = plan_scene_paths(scene, tmp_path / "plans.usda").plans["Way"]
        assert room(plan, way) > 0.2
        aside[way] = np.abs(plan.positions[:, 0]).max()
    assert aside[leaving] < 0.3 < HALF < aside[parking]


def test_what_a_path_cannot_wait_for_is_named_with_the_time(tmp_path):
    scene = tmp_path / "park.usda"
    draw(park(scene, lambda time: np.array([0.0, 0.0, 12.0 - time]), by="prim"))
    report = plan_scene_paths(scene, tmp_path / "plans.usda")
    told = [problem.message for problem in report.problems if "to wait does not help" in problem.message]
    assert len(told) == 1 and told[0].startswith("Way: meets /World/Cart/Body at ") and " s, and" in told[0]


@pytest.mark.parametrize("way", [crossing, parking, leaving])
def test_a_crowd_waits_for_what_crosses_its_way_and_goes_round_what_stays(tmp_path, way):
    pytest.importorskip("jupedsim")
    scene = tmp_path / "park.usda"
    park(scene, way, by="prim")
    report = plan_scene_crowd(scene, tmp_path / "plans.usda")
    (plan,) = report.plans.values()
    assert [problem.message for problem in report.problems] == []
    assert np.linalg.norm(plan.positions[-2:, [0, 2]].mean(axis=0) - [0.0, 10.0]) < 0.4
    assert room(plan, way) > 0.2


def test_an_animated_obstacle_that_is_broken_at_times_does_not_stop_anybody(tmp_path):
    scene = tmp_path / "park.usda"
    stage = park(scene, crossing, by="points")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Cart/Body"))
    mesh.GetPointsAttr().Set([Gf.Vec3f(np.nan)] * 8, (START + 3.0) * UNITS.rate)
    stage.Save()
    report = plan_scene_wander(scene, tmp_path / "plans.usda")
    assert len(report.plans) == 1 and not report.skipped


def test_the_same_stage_gives_the_same_bytes(tmp_path):
    scene = tmp_path / "park.usda"
    park(scene, crossing, by="prim")
    files = [plan_scene_wander(scene, tmp_path / f"{name}.usda").file for name in "ab"]
    assert files[0].read_bytes() == files[1].read_bytes()
