"""Planners of agents with goals from scene to layer, and the verbs that call them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdValidation

from tests.few_clips import copy_stages
from tests.scenes import OFFSETS, Units, add_character, new_stage
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.cli.main import main
from usdfoot.pipeline.goal_scene import GoalOptions
from usdfoot.pipeline.plan_goals import plan_scene_crowd, plan_scene_stones, plan_scene_wander
from usdfoot.pipeline.plan_scenario import convert_scenario
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.foot_table import feet_of
from usdfoot.planning.proportions import Proportions
from usdfoot.readers.authored import targets
from usdfoot.readers.characters import read_character
from usdfoot.readers.plans import read_plan
from usdfoot.readers.stage import read_stage_info

CASE = """<SteerBenchTestCase xmlns="http://www.magix.ucla.edu/steerbench">
<header><version>1.0</version><name>two</name><worldBounds><xmin>-9</xmin><xmax>9</xmax><ymin>0</ymin><ymax>0</ymax>
<zmin>-9</zmin><zmax>9</zmax></worldBounds></header>
<obstacle><xmin>-1</xmin><xmax>1</xmax><ymin>0</ymin><ymax>1</ymax><zmin>-1</zmin><zmax>1</zmax></obstacle>
<agent><name>One</name><initialConditions><radius>0.3</radius><position><x>-5</x><y>0</y><z>0</z></position>
<direction><x>1</x><y>0</y><z>0</z></direction><speed>0</speed></initialConditions><goalSequence><seekStaticTarget>
<targetLocation><x>5</x><y>0</y><z>0</z></targetLocation><desiredSpeed>1.2</desiredSpeed></seekStaticTarget></goalSequence></agent>
</SteerBenchTestCase>"""


def plans_of(layer, scene) -> dict:
    """Plans by agent prim path, read back over the scene."""
    over = Sdf.Layer.CreateAnonymous(".usda")
    over.subLayerPaths = [str(layer), str(scene)]
    source = Usd.Stage.Open(str(scene))
    stage = Usd.Stage.Open(over)
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        stage.SetMetadata(key, source.GetMetadata(key))
    found = {}
    for prim in stage.Traverse():
        for target in targets(prim, "usdfoot:agent:plan"):
            found[str(prim.GetPath())], _ = read_plan(stage.GetPrimAtPath(target), read_stage_info(stage).units)
    return found


def test_the_plaza_becomes_a_layer_of_plans_that_keep_apart(stages, tmp_path):
    pytest.importorskip("jupedsim")
    scene, layer = stages / "plaza.usda", tmp_path / "plans.usda"
    report = plan_scene_crowd(scene, layer, options=GoalOptions(agents="Visitor_[01]?"))
    assert report.skipped == () and len(report.plans) == 12
    plans = plans_of(layer, scene)
    assert set(plans) == {f"/World/Agents/{name}" for name in report.plans}
    assert len(find_collisions(feet_of(list(plans.values()), [Proportions()] * 12)).times) == 0


def test_the_river_is_crossed_by_the_bow_and_not_by_the_dead_end(stages, tmp_path):
    scene, layer = stages / "river.usda", tmp_path / "plans.usda"
    report = plan_scene_stones(scene, layer, reach="biped")
    (plan,) = plans_of(layer, scene).values()
    assert report.skipped == () and plan.starts_standing and plan.ends_standing
    middle = plan.positions[np.abs(plan.positions[:, 2]) < 2.5]
    assert middle[:, 0].min() > 1.0, "the straight stones lie at -0.25 m"
    assert np.all(plan.positions[:, 1] > 0.15), "never in the water"


def test_who_has_wider_hips_stands_wider_before_and_after_stones(stages, tmp_path):
    """`--reach biped` is that of the body as animated, whose hips usdfoot:agent:hipSpacing moves."""
    apart = {}
    for spacing in (1.0, 1.5):
        scene = tmp_path / f"river_{spacing}.usda"
        stage = Usd.Stage.Open(str(stages / "river.usda"))
        stage.SetEditTarget(stage.GetSessionLayer())
        agent = next(prim for prim in stage.Traverse() if prim.HasRelationship(Token.GOAL))
        agent.CreateAttribute(Token.HIP_SPACING, Sdf.ValueTypeNames.Float).Set(spacing)
        stage.Export(str(scene))
        (plan,) = plan_scene_stones(scene, tmp_path / "plans.usda", reach="biped").plans.values()
        apart[spacing] = [np.linalg.norm(np.diff(plan.positions[ends], axis=0)) for ends in ([0, 1], [-2, -1])]
    np.testing.assert_allclose(apart[1.5], 1.5 * np.array(apart[1.0]), rtol=1e-3)


def test_where_no_stones_lead_the_verb_says_how_far_they_do(stages, tmp_path, capsys):
    arguments = ["plan", "stones", str(stages / "river.usda"), "-o", str(tmp_path / "plans.usda"), "--reach", "biped"]
    assert main([*arguments, "--on", "/World/Terrain/Straight_*"]) == 2
    assert "the goal cannot be reached; the way over" in capsys.readouterr().err
    assert not (tmp_path / "plans.usda").exists()


def test_stones_are_crossed_in_the_time_that_steps_of_the_clips_take(stages, tmp_path):
    """Whose clips walk a third slower takes a third longer over the same steps, but for two short ones at the end."""
    spans = []
    for rate in (30.0, 22.5):
        copy = copy_stages(stages, tmp_path / f"{rate:g}")
        layer = Sdf.Layer.FindOrOpen(str(copy / "clips.usdc"))
        layer.timeCodesPerSecond = rate
        layer.Save()
        (plan,) = plan_scene_stones(copy / "river.usda", tmp_path / "plans.usda", reach="biped").plans.values()
        spans.append(np.diff(plan.strike_times[2:-2]))
    assert_allclose(spans[1], spans[0] * 4.0 / 3.0, rtol=0.05)


@pytest.mark.parametrize(("row", "leaves", "said"), [(10, True, "waits"), (10, False, "does not help"), (3, False, "")])
def test_over_stones_people_wait_for_what_is_on_them_or_take_others(stages, tmp_path, row, leaves, said):
    scene, layer = tmp_path / "scene.usda", tmp_path / "plans.usda"
    (free,) = plan_scene_stones(stages / "river.usda", layer).plans.values()
    source, stage = Usd.Stage.Open(str(stages / "river.usda")), Usd.Stage.CreateNew(str(scene))
    stage.GetRootLayer().subLayerPaths = [str(stages / "river.usda")]
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        stage.SetMetadata(key, source.GetMetadata(key))
    units = read_stage_info(source).units
    box = UsdGeom.Cube.Define(stage, "/World/Box")
    box.CreateSizeAttr(0.3 / units.meters_per_unit)
    box.GetPrim().AddAppliedSchema("UsdfootObstacleAPI")
    place = box.AddTranslateOp()
    away, comes, goes = np.array([0.0, 9.0, 0.0]), 0.5, float(free.strike_times[row]) + 3.0
    for time, lifted in ((0.0, 1.0), (comes, 1.0), (comes + 0.1, 0.0), (goes, 0.0), (goes + 0.1, float(leaves))):
        middle = free.positions[row] + [0.0, 0.2, 0.0] + lifted * away
        place.Set(Gf.Vec3d(*units.points_to_stage(middle).tolist()), time * units.time_codes_per_second)
    stage.Save()
    report = plan_scene_stones(scene, layer)
    (plan,) = report.plans.values()
    told = [problem.message for problem in report.problems if "/World/Box" in problem.message]
    assert said in " ".join(told) and bool(told) == bool(said)
    away_from_it = np.linalg.norm(plan.positions - free.positions[row], axis=1).min() > 0.15
    assert away_from_it == (not said), "another way"
    assert (plan.strike_times[-1] > free.strike_times[-1] + 2.0) == leaves
    assert len(told) == 1 or not leaves


def test_given_footholds_on_which_nobody_can_stand_are_named(stages, tmp_path):
    """Points a few centimetres over the stones: the way leads over them, and lint's first word on it is said."""
    scene, layer = tmp_path / "scene.usda", tmp_path / "plans.usda"
    plan_scene_stones(stages / "river.usda", layer)
    (plan,) = plans_of(layer, stages / "river.usda").values()
    stage = Usd.Stage.CreateNew(str(scene))
    stage.GetRootLayer().subLayerPaths = [str(stages / "river.usda")]
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        stage.SetMetadata(key, Usd.Stage.Open(str(stages / "river.usda")).GetMetadata(key))
    points = UsdGeom.Points.Define(stage, "/World/Holds")
    for lift, expected in ((0.0, 0), (0.08, 1)):
        points.CreatePointsAttr([Gf.Vec3f(*map(float, place + [0.0, lift, 0.0])) for place in plan.positions[2:-2]])
        stage.GetRootLayer().Save()
        problems = plan_scene_stones(scene, layer, on="/World/Holds").problems
        assert [problem.severity for problem in problems] == ["warning"] * expected
        assert all("m above the ground (and" in problem.message for problem in problems)


def test_wanderers_take_the_time_that_steps_of_their_clips_take(stages, tmp_path):
    """Whose clips walk a third slower takes a third longer over the same steps; short ones take long anyway."""
    paces = []
    for rate in (30.0, 22.5):
        copy = copy_stages(stages, tmp_path / f"{rate:g}")
        layer = Sdf.Layer.FindOrOpen(str(copy / "clips.usdc"))
        layer.timeCodesPerSecond = rate
        layer.Save()
        scene = Sdf.Layer.FindOrOpen(str(copy / "plaza.usda"))
        scene.GetAttributeAtPath("/World/Agents/Visitor_00.usdfoot:agent:speed").default = 0.0
        scene.Save()
        agents = GoalOptions(agents="Visitor_00")
        (plan,) = plan_scene_wander(
            copy / "plaza.usda", tmp_path / "plans.usda", options=agents, steps=30
        ).plans.values()
        lengths, times = np.linalg.norm(np.diff(plan.positions, axis=0), axis=1)[2:-1], np.diff(plan.strike_times)[2:-1]
        paces.append(np.median(times[lengths > 0.5] * lengths[lengths > 0.5]))
    assert paces[1] == pytest.approx(paces[0] * 4.0 / 3.0, rel=0.05)


def test_what_is_wrong_with_plans_of_wanderers_is_told_once_for_all_who_meet(stages, tmp_path, capsys):
    """Two set out from one place."""
    copy = copy_stages(stages, tmp_path / "copy")
    stage = Usd.Stage.Open(str(copy / "plaza.usda"))
    one, other = (stage.GetPrimAtPath(f"/World/Agents/Visitor_0{i}") for i in range(2))
    for name in other.GetAttribute("xformOpOrder").Get():
        other.GetAttribute(name).Set(one.GetAttribute(name).Get())
    stage.GetRootLayer().Save()
    scene = copy / "plaza.usda"
    arguments = ["plan", "wander", str(scene), "-o", str(tmp_path / "plans.usda"), "--agents", "Visitor_0[01]"]
    assert main([*arguments, "--steps", "6"]) == 0
    said = capsys.readouterr().err
    assert said.count("2 of 2 agents step on each other") == 1 and "usdfoot plan crowd keeps them apart" in said


def test_plans_begin_where_the_stage_does(stages, tmp_path):
    """Shots often start at 1001."""
    stage = Usd.Stage.Open(str(copy_stages(stages, tmp_path) / "plaza.usda"))
    plans = []
    for start in (0.0, 1001.0):
        stage.SetStartTimeCode(start)
        report = plan_scene_wander(stage, tmp_path / "plans.usdc", options=GoalOptions(agents="Visitor_00"), steps=8)
        plans += report.plans.values()
    delay = 1001.0 / stage.GetTimeCodesPerSecond()
    assert_allclose(plans[1].strike_times - plans[0].strike_times, delay)
    assert_allclose(plans[1].liftoff_times - plans[0].liftoff_times, delay)


def test_wanderers_get_the_same_bytes_from_the_same_seed(stages, tmp_path):
    layers = [tmp_path / f"{name}.usda" for name in "abc"]
    for layer, seed in zip(layers, (1, 1, 2), strict=True):
        plan_scene_wander(stages / "plaza.usda", layer, options=GoalOptions(agents="Visitor_00"), steps=12, seed=seed)
    one, same, other = (layer.read_bytes() for layer in layers)
    assert one == same != other


def test_a_scenario_becomes_a_valid_stage_that_can_be_planned(tmp_path, capsys):
    file, scene, layer = tmp_path / "case.xml", tmp_path / "scene.usda", tmp_path / "plans.usda"
    file.write_text(CASE)
    assert main(["plan", "scenario", str(file), "-o", str(scene)]) == 0
    assert "1 agents, 1 obstacles" in capsys.readouterr().out
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [str(error.GetMessage()) for error in context.Validate(Usd.Stage.Open(str(scene)))] == []
    assert main(["plan", "wander", str(scene), "-o", str(layer), "--steps", "60"]) == 0
    (plan,) = plans_of(layer, scene).values()
    assert plan.ends_standing and np.linalg.norm(plan.positions[-1] - [5.0, 0.0, 0.0]) < 0.5
    assert np.abs(plan.positions[:, [0, 2]]).max(axis=1).min() > 1.0, "around the block"
    again = tmp_path / "again.usda"
    convert_scenario(file, again)
    assert again.read_bytes() == scene.read_bytes()
    bare = str(tmp_path / "bare.usda")
    Sdf.Layer.CreateNew(bare).Save()
    for asset, message in ((str(tmp_path / "none.usd"), "no such file"), (bare, "has no defaultPrim")):
        assert main(["plan", "scenario", str(file), "-o", str(scene), "--character", asset]) == 2
        assert message in capsys.readouterr().err
    file.write_text("<SteerBenchTestCase>\n<header>")
    assert main(["plan", "scenario", str(file), "-o", str(scene)]) == 2
    assert "case.xml, line 2: is not well-formed XML" in capsys.readouterr().err


def test_who_wants_to_go_faster_than_its_clips_goes_as_fast_as_they_do(stages, tmp_path):
    pytest.importorskip("jupedsim")
    file, scene, layer = tmp_path / "case.xml", tmp_path / "scene.usda", tmp_path / "plans.usda"
    far = CASE.replace("<x>-5<", "<x>-25<").replace("<x>5<", "<x>25<")  # room to run up and to stop
    file.write_text(far.replace(">1.2<", ">10<"))
    convert_scenario(file, scene, character=str(stages / "human.usdc"), clips=str(stages / "clips.usdc"))
    report = plan_scene_crowd(scene, layer)
    (message,) = [problem.message for problem in report.problems if "wants to go" in problem.message]
    assert "wants to go 10.00 m/s; " in message and message.endswith("m/s were taken, as fast as its clips go")
    (plan,) = plans_of(layer, scene).values()
    fastest = float(message.split("; ")[1].split()[0])
    taken = np.linalg.norm(plan.positions[2:] - plan.positions[:-2], axis=1)[2:-2]
    speeds = taken / (plan.strike_times[2:] - plan.strike_times[:-2])[2:-2]
    assert 2.5 < fastest < 5.0 and speeds.max() == pytest.approx(fastest, rel=0.1)
    runs = 2 + np.flatnonzero(speeds > 0.95 * fastest)
    flights = (plan.strike_times[runs + 1] - plan.liftoff_times[runs]) / np.diff(plan.strike_times)[runs]
    assert np.median(flights) > 0.36  # run_400 0.38 and run_bounding 0.43 of a step, people 0.31


@pytest.mark.parametrize("way", ["crowd", "wander", "stones", "scenario"])
def test_every_way_has_help_with_an_example_and_a_python_twin(way, capsys):
    assert main(["plan", way, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"usdfoot plan {way}" in text and "in Python" in text and "exit codes:" in text


@pytest.mark.parametrize("bounds", ["1,2,3", "5,0,1,9", "a,b,c,d"])
def test_bounds_that_are_none_are_refused(bounds, stages, capsys):
    assert main(["plan", "wander", str(stages / "plaza.usda"), "-o", "x.usda", f"--bounds={bounds}"]) == 2
    assert "is no area" in capsys.readouterr().err


def test_a_scene_without_goals_says_what_to_do(stages, tmp_path, capsys):
    assert main(["plan", "stones", str(stages / "crowd.usda"), "-o", str(tmp_path / "plans.usda")]) == 2
    assert "has no agent with a goal" in capsys.readouterr().err


@pytest.mark.parametrize("units", [Units(0.01, "Y"), Units(0.01, "Z"), Units(1.0, "Y")])
@pytest.mark.parametrize("root_type", ["SkelRoot", "Scope"])
def test_a_scenario_takes_characters_in_other_units(units, root_type, tmp_path):
    """Whatever unit and axis its file has, the character is as tall, as wide and as upright in the scenario."""
    file, scene, asset = tmp_path / "case.xml", tmp_path / "scene.usda", tmp_path / "hero.usda"
    file.write_text(CASE)
    hero = new_stage(asset, units)
    root = UsdGeom.Xformable(add_character(hero, "/Hero", units, root_type=root_type).GetPrim().GetParent())
    if root:
        root.AddTranslateOp().Set(Gf.Vec3d(*map(float, units.points([1.0, 2.0, 3.0]))))
    hero.SetDefaultPrim(hero.GetPrimAtPath("/Hero"))
    hero.Save()
    convert_scenario(file, scene, character=str(asset))
    stage = Usd.Stage.Open(str(scene))
    prim = stage.GetPrimAtPath("/World/Library/Character")
    skeleton = UsdSkel.Skeleton(prim.GetChild("Skeleton"))
    to_world = UsdGeom.XformCache().GetLocalToWorldTransform(skeleton.GetPrim())
    joints = [(matrix * to_world).ExtractTranslation() for matrix in skeleton.GetBindTransformsAttr().Get()]
    rest = [Gf.Vec3d(*map(float, OFFSETS[0])) + (Gf.Vec3d(1, 2, 3) if root else Gf.Vec3d(0))]
    np.testing.assert_allclose(joints[0], rest[0], atol=1e-5)
    legs = read_character(prim, read_stage_info(stage).units, np.zeros(1)).biped
    assert 0.3 < legs.maximal_leg_length < 1.5
