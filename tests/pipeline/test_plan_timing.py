"""Footprints of whole scenes get times: what is written composes, is a plan, and walks."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd, UsdGeom

from tests.scenes import Units, add_character, new_stage
from usdfoot.analysis.timing import TimingRule, time_steps
from usdfoot.bridge.tokens import Agent, Schema
from usdfoot.cli.main import main
from usdfoot.errors import OutputError, SceneError
from usdfoot.pipeline.plan_timing import time_scene_plans
from usdfoot.planning.retiming import TimingOptions
from usdfoot.readers.scene import read_scene

LENGTHS = np.array([0.6, 0.7, 0.8, 0.7, 0.7, 1.6, 0.7])
"""One of them is a leap."""


def scene_with_prints(file, units=None, *, lengths=LENGTHS, is_walked=True):
    units = units or Units()
    stage = new_stage(file, units)
    add_character(stage, "/World/Person", units)
    places = np.zeros((len(lengths) + 1, 3))
    places[1:, 2] = np.cumsum(lengths)
    prints = UsdGeom.PointInstancer.Define(stage, "/World/Prints")
    prints.CreatePositionsAttr(units.points(places).tolist())
    prints.CreateProtoIndicesAttr((np.arange(len(places)) % 2).tolist())
    prints.CreatePrototypesRel().SetTargets(
        [UsdGeom.Cube.Define(stage, f"/World/Prints/{side}").GetPath() for side in "LR"]
    )
    if is_walked:
        agent = UsdGeom.Xform.Define(stage, "/World/Walker").GetPrim()
        agent.AddAppliedSchema(Schema.AGENT)
        agent.CreateRelationship(Agent.PLAN, custom=False).SetTargets(["/World/Prints"])
        agent.CreateRelationship(Agent.CHARACTER, custom=False).SetTargets(["/World/Person"])
    stage.GetRootLayer().Save()
    return file


@pytest.mark.parametrize("units", [Units(), Units(meters=0.01, up="Z", rate=30.0), Units(meters=0.0254, rate=48.0)])
def test_steps_last_as_long_as_people_of_that_size_take_for_them_in_any_units(tmp_path, units):
    scene = scene_with_prints(tmp_path / "scene.usda", units)
    before = scene.read_bytes()
    options = TimingOptions(start_time=1.0, starts_standing=False)
    report = time_scene_plans(scene, tmp_path / "timed.usda", options=options)
    assert scene.read_bytes() == before
    plan = read_scene(report.file, motion="physics").crowd.agents[0].plan
    leg = read_scene(report.file, motion="physics").crowd.libraries[0].biped.maximal_leg_length
    expected = time_steps(LENGTHS, TimingRule(leg_length=leg))
    walked = np.flatnonzero(~expected.flies)
    assert_allclose(np.diff(plan.strike_times)[walked], expected.step_times[walked], atol=5e-5)  # six digits in text
    assert plan.strike_times[0] == pytest.approx(1.0)
    flies = plan.liftoff_times[:-1] < plan.strike_times[1:]
    assert flies.tolist() == (LENGTHS > 1.5).tolist()
    assert plan.liftoff_times[-1] == pytest.approx(plan.liftoff_times[-2])  # ends standing


def test_times_begin_where_the_stage_does(tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda", Units(rate=30.0))
    stage = Usd.Stage.Open(str(scene))
    stage.SetStartTimeCode(1001.0)
    stage.GetRootLayer().Save()
    (plan,) = time_scene_plans(scene, tmp_path / "timed.usda").plans.values()
    assert plan.start == pytest.approx(1001.0 / 30.0)


def test_a_given_speed_is_the_mean_speed(tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda", lengths=np.full(9, 0.7))
    slow, fast = (
        time_scene_plans(scene, tmp_path / "t.usda", options=TimingOptions(speed=speed, starts_standing=False)).plans[
            "/World/Prints"
        ]
        for speed in (0.8, 3.0)
    )
    for plan, speed in ((slow, 0.8), (fast, 3.0)):
        assert 9 * 0.7 / (plan.strike_times[-1] - plan.strike_times[0]) == pytest.approx(speed)
    assert (slow.liftoff_times[:-2] > slow.strike_times[1:-1]).all()  # walks
    assert (fast.liftoff_times[:-2] < fast.strike_times[1:-1]).all()  # runs


def test_who_starts_standing_stands_first_and_then_swings_as_in_a_walk(tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda", lengths=np.array([0.1, 0.6, 0.6, 0.6, 0.6, 0.6]))
    plan = time_scene_plans(scene, tmp_path / "timed.usda").plans["/World/Prints"]
    swings = plan.strike_times[2:] - plan.liftoff_times[:-2]
    assert plan.liftoff_times[0] > 0.5 and swings[0] > 0.8 * swings[1:4].mean(), "not in half the time"


def test_the_command_writes_a_stage_that_physics_can_walk(tmp_path, capsys):
    scene = scene_with_prints(tmp_path / "scene.usda", lengths=np.full(5, 0.6))
    assert main(["animate", str(scene), "-o", str(tmp_path / "shot"), "-q", "--motion", "physics"]) == 2
    assert "let usdfoot plan timing find the times" in capsys.readouterr().err
    timed = tmp_path / "timed.usda"
    assert main(["plan", "timing", str(scene), "-o", str(timed), "-q"]) == 0
    assert main(["animate", str(timed), "-o", str(tmp_path / "shot"), "-q", "--motion", "physics"]) == 0


def test_times_that_are_there_are_replaced_and_plans_chosen(tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda")
    first = time_scene_plans(scene, tmp_path / "first.usda").file
    again = time_scene_plans(first, tmp_path / "again.usda", options=TimingOptions(speed=0.5)).file
    strikes = [read_scene(file, motion="physics").crowd.agents[0].plan.strike_times for file in (first, again)]
    assert strikes[1][-1] > 1.5 * strikes[0][-1]
    with pytest.raises(SceneError, match="no plan that matches /Other"):
        time_scene_plans(scene, tmp_path / "x.usda", plans="/Other*")


def test_what_cannot_be_timed_is_named(tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda", is_walked=False)
    with pytest.raises(SceneError, match=r"has no footstep plan\. apply UsdfootPlanAPI"):
        time_scene_plans(scene, tmp_path / "x.usda")
    one_place = scene_with_prints(tmp_path / "place.usda", lengths=np.zeros(3))
    with pytest.raises(SceneError, match="/World/Prints: are all in one place"):
        time_scene_plans(one_place, tmp_path / "x.usda", options=TimingOptions(speed=1.0))
    with pytest.raises(OutputError, match="would replace what it is made from"):
        time_scene_plans(scene_with_prints(tmp_path / "own.usda"), tmp_path / "own.usda")
    layer = Sdf.Layer.FindOrOpen(str(one_place))
    layer.GetAttributeAtPath("/World/Prints.protoIndices").default = [0, 0, 1, 1]
    layer.Save()
    with pytest.raises(SceneError, match="footsteps 0 and 1 are both left"):
        time_scene_plans(one_place, tmp_path / "x.usda")


@pytest.mark.parametrize(
    ("lengths", "speed", "message"),
    [
        ([0.6, 1e7, 0.6], 0.0, "1 of its 4 footsteps cannot be walked; footstep 2 needs "),
        (LENGTHS, 100.0, "6 of its 8 footsteps cannot be walked; footstep 2 needs "),
    ],
)
def test_times_that_nobody_can_keep_are_warned_of(lengths, speed, message, tmp_path):
    scene = scene_with_prints(tmp_path / "scene.usda", lengths=lengths)
    report = time_scene_plans(scene, tmp_path / "timed.usda", options=TimingOptions(speed=speed))
    warnings = [problem.message for problem in report.problems if "cannot be walked" in problem.message]
    assert len(warnings) == 1 and message in warnings[0] and warnings[0].startswith("/World/Prints: ")
    possible = time_scene_plans(scene_with_prints(tmp_path / "walk.usda"), tmp_path / "good.usda")
    assert not any("cannot be walked" in problem.message for problem in possible.problems)
