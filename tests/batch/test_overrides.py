"""What artists change in overrides.usda is honoured when the crowd is made again, and never overwritten."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.batch.conftest import AGENTS, write_crowd_scene
from tests.batch.edits import edited, liftoffs, remake, strikes
from tests.digests import digests
from usdfoot.bridge.tokens import File
from usdfoot.errors import SceneError
from usdfoot.pipeline.animate import animate
from usdfoot.readers.scene import SceneReader


def test_a_muted_agent_is_not_made(shot):
    scene, folder = shot
    with edited(folder) as stage:
        stage.GetPrimAtPath("/Crowd/Agents/Agent_1").SetActive(False)
    report = remake(scene, folder)
    assert (
        sorted(report.results) == ["Agent_0", "Agent_2"] and report.kept == AGENTS - 1
    )  # the others stay as they were
    assert not (folder / "anims.0001.usdc").exists()


def test_a_retimed_agent_steps_at_the_new_times_and_the_others_are_kept(shot):
    scene, folder = shot
    _, before = strikes(folder, "Agent_1")
    with edited(folder) as stage:
        for name in ("strikeTimes", "liftoffTimes"):
            attribute = stage.GetPrimAtPath("/Crowd/Plans/Agent_1").GetAttribute(f"usdfoot:plan:{name}")
            attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(1.25 * float(code)) for code in attribute.Get()]))
    report = remake(scene, folder)
    assert report.kept == AGENTS - 1
    np.testing.assert_allclose(strikes(folder, "Agent_1")[1], 1.25 * before, atol=1e-6)


def test_footsteps_moved_deleted_or_in_a_moved_plan_are_stepped_on_where_they_are(shot):
    scene, folder = shot
    before = {name: strikes(folder, name)[0] for name in ("Agent_0", "Agent_1", "Agent_2")}
    with edited(folder) as stage:
        positions = stage.GetPrimAtPath("/Crowd/Plans/Agent_0").GetAttribute("positions")
        points = np.array(positions.Get())
        points[4, 0] += 0.05
        positions.Set(points)
        moved = UsdGeom.Xformable(stage.GetPrimAtPath("/Crowd/Plans/Agent_1"))
        moved.AddTranslateOp().Set(Gf.Vec3d(1.0, 0.0, 2.0))
        moved.AddRotateYOp().Set(90.0)
        shorter = stage.GetPrimAtPath("/Crowd/Plans/Agent_2")  # rootWeights say nothing there, and may stay as they are
        times = ("usdfoot:plan:strikeTimes", "usdfoot:plan:liftoffTimes")
        for name in ("protoIndices", "positions", "orientations", *times):
            shorter.GetAttribute(name).Set(shorter.GetAttribute(name).Get()[:-2])
    remake(scene, folder)
    np.testing.assert_allclose(strikes(folder, "Agent_2")[0], before["Agent_2"][:-1], atol=1e-5)
    change = strikes(folder, "Agent_0")[0] - before["Agent_0"]
    assert sorted(np.round(change[:, 0], 4)) == [0.0] * (len(change) - 1) + [0.05]
    x, y, z = before["Agent_1"].T
    np.testing.assert_allclose(strikes(folder, "Agent_1")[0], np.stack([z + 1.0, y, 2.0 - x], axis=-1), atol=1e-3)


def draw_trajectory(stage):
    """A way walked at 1.1 m/s."""
    translate = UsdGeom.Xform.Define(stage, "/World/Way").AddTranslateOp()
    for code in range(0, 151, 5):
        translate.Set(Gf.Vec3d(3.0, 0.0, 1.1 * code / stage.GetTimeCodesPerSecond()), code)


def draw_running_path(stage):
    """A way run at 2.9 m/s, with the flights of the clips."""
    clips = Sdf.Layer.FindOrOpen(str(Path(stage.GetRootLayer().realPath).parent / "stages" / "clips.usdc"))
    for name in ("walk_to_run", "run_260", "run_320", "run_wide", "run_to_walk", "walk_wide_long"):
        clips.GetPrimAtPath(f"/HumanClips/Clips/{name}").active = True
    clips.Save()
    way = UsdGeom.BasisCurves.Define(stage, "/World/Way")
    way.CreateTypeAttr("linear")
    way.CreatePointsAttr([Gf.Vec3f(3.0, 0.0, 0.0), Gf.Vec3f(3.0, 0.0, 8.0)])
    way.CreateCurveVertexCountsAttr([2])
    prim = way.GetPrim()
    prim.AddAppliedSchema("UsdfootPathAPI")
    prim.CreateAttribute("usdfoot:path:speed", Sdf.ValueTypeNames.Float, custom=False).Set(2.9)


@pytest.mark.parametrize("kind", ["trajectory", "path"])
def test_footsteps_found_for_a_trajectory_or_a_path_can_be_edited_and_walked_again(stages, tmp_path, kind):
    scene, folder = write_crowd_scene(stages, tmp_path / "scene"), tmp_path / "out"
    stage = Usd.Stage.Open(str(scene))
    draw_trajectory(stage) if kind == "trajectory" else draw_running_path(stage)
    agent = stage.GetPrimAtPath("/World/Crowd/Agent_1")
    agent.GetRelationship("usdfoot:agent:plan").ClearTargets(True)
    agent.CreateRelationship(f"usdfoot:agent:{kind}", custom=False).SetTargets(["/World/Way"])
    stage.Save()
    animate(scene, folder, chunk_size=1)
    before, times = strikes(folder, "Agent_1")
    left = liftoffs(folder, "Agent_1")
    with edited(folder) as crowd:
        positions = crowd.GetPrimAtPath("/Crowd/Plans/Agent_1").GetAttribute("positions")
        points = np.array(positions.Get())
        points[6, 0] += 0.05
        positions.Set(points)
    report = remake(scene, folder)
    assert report.kept == AGENTS - 1
    after, same_times = strikes(folder, "Agent_1")
    np.testing.assert_allclose(same_times, times, atol=1e-6)
    np.testing.assert_allclose(liftoffs(folder, "Agent_1"), left, atol=1e-6)
    assert sorted(np.round((after - before)[:, 0], 3)) == [0.0] * (len(after) - 1) + [0.05]
    (folder / File.OVERRIDES).write_text("#usda 1.0\n")
    animate(scene, folder, chunk_size=1)
    np.testing.assert_allclose(strikes(folder, "Agent_1")[0], before, atol=1e-6)  # what the scene says again


def test_an_agent_given_another_plan_walks_it(shot):
    scene, folder = shot
    with edited(folder) as stage:
        agent = stage.GetPrimAtPath("/Crowd/Agents/Agent_0")
        agent.GetRelationship("usdfoot:agent:plan").SetTargets(["/Crowd/Plans/Agent_2"])
    remake(scene, folder)
    for ours, theirs in zip(strikes(folder, "Agent_0"), strikes(folder, "Agent_2"), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-5)


def test_a_plan_that_is_not_there_skips_its_agent_only(shot):
    scene, folder = shot
    with edited(folder) as stage:
        agent = stage.GetPrimAtPath("/Crowd/Agents/Agent_0")
        agent.GetRelationship("usdfoot:agent:plan").SetTargets(["/Crowd/Plans/Nobody"])
    report = animate(scene, folder, chunk_size=1)
    assert sorted(report.results) == ["Agent_1", "Agent_2"]
    assert any("points at no plan: /Crowd/Plans/Nobody" in str(problem) for problem in report.skipped)


def test_a_broken_layer_of_overrides_is_named_and_nothing_is_written(shot):
    scene, folder = shot
    (folder / File.OVERRIDES).write_text("#usda 1.0\nnonsense {")
    before = digests(folder)
    with pytest.raises(ValueError, match=r"overrides\.usda: cannot be read"):
        animate(scene, folder, chunk_size=1)
    assert digests(folder) == before


def test_a_shot_can_reference_the_crowd_twice_with_other_offsets(crowd):
    shot = Usd.Stage.CreateInMemory()
    for name, offset in (("Now", 0.0), ("Later", 12.0)):
        prim = shot.DefinePrim(f"/{name}")
        prim.GetReferences().AddReference(str(crowd.crowd_file), "/Crowd", Sdf.LayerOffset(offset))

    times = [
        shot.GetPrimAtPath(f"/{name}/Anims/Agent_1").GetAttribute("rotations").GetTimeSamples()
        for name in ("Now", "Later")
    ]
    np.testing.assert_allclose(np.array(times[1]) - 12.0, times[0])
    source = shot.GetPrimAtPath("/Later/Agents/Agent_1").GetRelationship("skel:animationSource").GetTargets()
    assert source == [Sdf.Path("/Later/Anims/Agent_1")]
    strike = [
        float(shot.GetPrimAtPath(f"/{name}/Plans/Agent_1").GetAttribute("usdfoot:plan:strikeTimes").Get()[0])
        for name in ("Now", "Later")
    ]
    assert strike[1] - strike[0] == pytest.approx(12.0)


def test_what_is_said_of_a_written_agent_goes_over_what_the_scene_says(shot):
    scene, folder = shot
    said = (
        ("Agent_0", "rootWeight", Sdf.ValueTypeNames.Float, 0.5),
        ("Agent_1", "motion", Sdf.ValueTypeNames.Token, "physics"),
        ("Agent_2", "ikReach", Sdf.ValueTypeNames.Float, 0.1),
        ("Agent_2", "crouch", Sdf.ValueTypeNames.Float, 0.2),
    )
    with edited(folder) as stage:
        for name, option, kind, value in said:
            prim = stage.GetPrimAtPath(f"/Crowd/Agents/{name}")
            prim.CreateAttribute(f"usdfoot:agent:{option}", kind, False).Set(value)
    report = remake(scene, folder)
    assert report.kept == 0
    assert report.results["Agent_0"].root_weight.max() == 0.5
    assert [report.results[f"Agent_{number}"].clip_counts.any() for number in range(AGENTS)] == [True, False, True]
    rooted, _, crouched = SceneReader(scene, crowd=folder).read().crowd.agents
    assert crouched.tuning.given == pytest.approx({"crouch": 0.2}) and not rooted.tuning.given
    assert (crouched.ik_reach, rooted.ik_reach) == pytest.approx((0.1, 0.3))


def test_what_is_said_of_a_written_agent_and_no_run_follows_is_named(shot):
    scene, folder = shot
    with edited(folder) as stage:
        way = stage.GetPrimAtPath("/Crowd/Agents/Agent_1").CreateRelationship("usdfoot:agent:path", False)
        way.SetTargets(["/World/Way"])
    report = animate(scene, folder, chunk_size=1)
    assert report.kept == AGENTS
    said = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    where = "overrides.usda /Crowd/Agents"
    assert said == [f"{where}/Agent_1: usdfoot:agent:path is not followed here. author it in the scene"]


def test_what_is_said_of_nobody_in_the_scene_is_named(shot):
    """A name that is misspelt, or that an agent no longer has."""
    scene, folder = shot
    with edited(folder) as stage:
        stage.OverridePrim("/Crowd/Agents/Agent_11").SetActive(False)
        stage.OverridePrim("/Crowd/Plans/Agent_12")
        stage.OverridePrim("/Crowd/Agents/Agent_1")
        UsdGeom.Xform.Define(stage, "/Crowd/Agents/Props")
    report = animate(scene, folder, chunk_size=1, agents="Agent_0")
    said = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    assert said == [
        "overrides.usda /Crowd/Agents/Agent_11: no agent of the scene has this name. correct it, or take it away",
        "overrides.usda /Crowd/Plans/Agent_12: no agent of the scene has this name. correct it, or take it away",
    ]


def test_that_all_agents_are_muted_is_said(shot):
    scene, folder = shot
    with edited(folder) as stage:
        for number in range(AGENTS):
            stage.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}").SetActive(False)
    with pytest.raises(SceneError, match=r"no agent can be used: overrides\.usda makes all of them inactive"):
        animate(scene, folder, chunk_size=1)


def test_agents_hidden_in_the_scene_are_hidden_in_the_crowd_and_share_their_prototype(shot):
    scene, folder = shot
    stage = Usd.Stage.Open(str(scene))
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Crowd/Agent_0")).MakeInvisible()
    blinking = UsdGeom.Imageable(stage.GetPrimAtPath("/World/Crowd/Agent_1")).CreateVisibilityAttr()
    blinking.Set("inherited", 30.0)
    blinking.Set("invisible", 60.0)
    stage.Save()
    assert animate(scene, folder, chunk_size=1).kept == AGENTS - 2
    crowd = Usd.Stage.Open(str(folder / File.CROWD))
    agents = [crowd.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}") for number in range(AGENTS)]
    seen = [[str(UsdGeom.Imageable(agent).ComputeVisibility(code)) for code in (40.0, 80.0)] for agent in agents]
    assert seen == [["invisible"] * 2, ["inherited", "invisible"], ["inherited"] * 2]
    assert len({agent.GetPrototype().GetPath() for agent in agents}) == 1


def test_agents_have_the_characters_and_clips_that_artists_give_them(stages, tmp_path):
    scene, folder = write_crowd_scene(stages, tmp_path / "scene"), tmp_path / "out"
    stage = Usd.Stage.Open(str(scene))
    [human] = stage.GetPrimAtPath("/World/Crowd/Agent_0").GetRelationship("usdfoot:agent:character").GetTargets()
    [clips] = stage.GetPrimAtPath("/World/Crowd/Agent_0").GetRelationship("usdfoot:agent:clips").GetTargets()
    small = UsdGeom.Xform.Define(stage, "/World/Small")
    small.AddScaleOp().Set(Gf.Vec3f(0.9, 0.9, 0.9))
    small = stage.DefinePrim("/World/Small/Human")
    small.GetReferences().AddInternalReference(human)
    stage.GetPrimAtPath("/World/Crowd/Agent_2").GetRelationship("usdfoot:agent:character").SetTargets([small.GetPath()])
    stage.Save()
    animate(scene, folder, chunk_size=1)
    few = [f"{clips}/{name}" for name in ("walk_050", "walk_070", "walk_narrow", "stand")]
    with edited(folder) as crowd:
        agents = [crowd.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}") for number in range(AGENTS)]
        agents[0].CreateRelationship("usdfoot:agent:character", False).SetTargets(["/Crowd/Agents/Agent_2"])
        agents[1].CreateRelationship("usdfoot:agent:character", False).SetTargets([small.GetPath()])
        agents[1].CreateRelationship("usdfoot:agent:clips", False).SetTargets(few)
    report = remake(scene, folder)
    assert report.kept == 1
    assert {name.rsplit("/", 1)[-1] for name in report.results["Agent_1"].clips} <= {
        name.rsplit("/", 1)[-1] for name in few
    }
    read = SceneReader(scene, crowd=folder).read()
    assert {agent.character for agent in read.crowd.agents} == {read.crowd.agents[2].character}
    assert not [problem for problem in report.problems if problem.where.startswith("overrides.usda")]


def test_characters_and_clips_that_are_not_there_are_named(shot):
    scene, folder = shot
    with edited(folder) as stage:
        for number, kind in ((0, "character"), (1, "clips")):
            pointer = stage.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}").CreateRelationship(
                f"usdfoot:agent:{kind}", False
            )
            pointer.SetTargets(["/World/Plans"] if number == 0 else ["/World/Nowhere"])
        lost = stage.GetPrimAtPath("/Crowd/Agents/Agent_2").CreateAttribute(
            "xformOp:rotateXYZ", Sdf.ValueTypeNames.Float3
        )
        lost.Set(Gf.Vec3f(0.0, 90.0, 0.0))
        UsdGeom.Xformable(stage.GetPrimAtPath("/Crowd")).AddTranslateOp().Set(Gf.Vec3d(1.0, 0.0, 0.0))
    report = animate(scene, folder, chunk_size=1)
    assert report.kept == AGENTS
    said = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    where, keeps = "overrides.usda /Crowd/Agents/Agent_", "what the scene says is kept"
    nobody, nowhere = "points at no character: /World/Plans", "points at what does not exist: /World/Nowhere"
    assert set(said) == {
        "overrides.usda /Crowd: contacts and terrain do not go with its transform. "
        "move the prim that references the crowd",
        f"{where}0: usdfoot:agent:character {nobody}. give a prim of the scene, or an agent. {keeps}",
        f"{where}1: usdfoot:agent:clips {nowhere}. correct the target. {keeps}",
        f"{where}2: xformOp:rotateXYZ is not in xformOpOrder and moves nothing. list it there",
    }


def test_another_character_referenced_over_an_agent_is_named(shot, stages):
    scene, folder = shot
    with edited(folder) as stage:
        stage.GetPrimAtPath("/Crowd/Agents/Agent_1").GetReferences().AddReference(str(stages / "bird.usdc"))
    [said] = [p.message for p in animate(scene, folder, chunk_size=1).problems if p.where.startswith("overrides.usda")]
    assert said.startswith("overrides.usda /Crowd/Agents/Agent_1: holds a Skeleton that is not animated")


@pytest.mark.parametrize("is_muted", [False, True])
def test_a_plan_of_an_agent_that_is_not_made_is_named_where_another_one_walks_it(shot, is_muted):
    scene, folder = shot
    with edited(folder) as stage:
        agent = stage.GetPrimAtPath("/Crowd/Agents/Agent_0")
        agent.GetRelationship("usdfoot:agent:plan").SetTargets(["/Crowd/Plans/Agent_1"])
        stage.GetPrimAtPath("/Crowd/Agents/Agent_1").SetActive(not is_muted)
    report = animate(scene, folder, chunk_size=1, agents="*" if is_muted else ("Agent_0", "Agent_2"))
    [said] = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    reason = (
        "the plan it walks is not written, since Agent_1 is muted or not asked for. hide that instead, or ask for it"
    )
    assert said == f"overrides.usda /Crowd/Agents/Agent_0: {reason}"


def test_layers_below_the_overrides_count_with_their_offsets(shot):
    """As of artists who each have a layer of their own."""
    scene, folder = shot
    _, before = strikes(folder, "Agent_1")
    with edited(folder) as stage:
        for name in ("strikeTimes", "liftoffTimes"):
            attribute = stage.GetPrimAtPath("/Crowd/Plans/Agent_1").GetAttribute(f"usdfoot:plan:{name}")
            attribute.Set(attribute.Get())
        stage.GetPrimAtPath("/Crowd/Agents/Agent_2").SetActive(False)
        UsdGeom.Xformable(stage.GetPrimAtPath("/Crowd/Agents/Agent_0")).AddTranslateOp(opSuffix="edit").Set((1, 0, 0))
    overrides = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    below = Sdf.Layer.CreateNew(str(folder / "layout.usda"))
    below.TransferContent(overrides)
    below.Save()
    for path in [prim.path for prim in overrides.rootPrims]:
        del overrides.rootPrims[path.name]
    overrides.subLayerPaths = ["./layout.usda"]
    overrides.subLayerOffsets[0] = Sdf.LayerOffset(15.0)
    overrides.Save()
    report = remake(scene, folder)
    assert sorted(report.results) == ["Agent_0", "Agent_1"] and report.kept == 0
    np.testing.assert_allclose(strikes(folder, "Agent_1")[1], before + 15.0, atol=1e-6)


@pytest.mark.parametrize("collect", [False, True])
def test_a_shot_references_a_crowd_with_moved_agents_twice(shot, collect):
    scene, folder = shot
    with edited(folder) as stage:
        UsdGeom.Xformable(stage.GetPrimAtPath("/Crowd/Agents/Agent_1")).AddTranslateOp(opSuffix="edit").Set((1, 0, 0))
        UsdGeom.Imageable(stage.GetPrimAtPath("/Crowd/Agents/Agent_0")).MakeInvisible()
    animate(scene, folder, chunk_size=1, collect=collect)
    seen = Usd.Stage.CreateInMemory()
    seen.SetTimeCodesPerSecond(Usd.Stage.Open(str(folder / File.CROWD)).GetTimeCodesPerSecond())
    for name, offset in (("Now", 0.0), ("Later", 12.0)):
        prim = seen.DefinePrim(f"/{name}")
        prim.GetReferences().AddReference(str(folder / File.CROWD), layerOffset=Sdf.LayerOffset(offset))
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(0.0, 0.0, offset))
    alone = Usd.Stage.Open(str(folder / File.CROWD))

    def place(stage, path, code):
        return np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(stage.GetPrimAtPath(path)))[3, :3]

    for kind in ("Agents", "Plans"):
        wanted = place(alone, f"/Crowd/{kind}/Agent_1", 60.0)
        np.testing.assert_allclose(place(seen, f"/Now/{kind}/Agent_1", 60.0), wanted, atol=1e-9)
        np.testing.assert_allclose(place(seen, f"/Later/{kind}/Agent_1", 72.0), wanted + [0.0, 0.0, 12.0], atol=1e-9)
