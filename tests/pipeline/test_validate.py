"""Validation sees what is wrong with a crowd, and by how much."""

import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, Vt

from usdfoot.errors import SceneError
from usdfoot.pipeline import shares
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate

SHIFT = 0.005
"""[m]"""


@pytest.fixture(scope="module")
def honest(stones):
    return validate(stones.crowd_file)


@pytest.fixture
def crowd(stones, tmp_path):
    """A copy of the stones crowd that may be tampered with; its scene and character are where they were."""
    assert tmp_path.parent == stones.crowd_file.parent.parent  # so relative paths stay right
    shutil.copytree(stones.crowd_file.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / "crowd.usd"


def figures(validation):
    return {figure.name: figure for figure in validation.total.figures}


def override(crowd, prim, name, change):
    """Replace all time samples of an attribute by changed ones, in the artists' layer."""
    stage = Usd.Stage.Open(str(crowd))
    attribute = stage.GetPrimAtPath(prim).GetAttribute(name)
    samples = [(code, change(attribute.Get(code))) for code in attribute.GetTimeSamples()]
    layer = Sdf.Layer.FindOrOpen(str(crowd.parent / "overrides.usda"))
    stage.SetEditTarget(layer)
    for code, value in samples:
        attribute.Set(value, code)
    layer.Save()


def test_figures_agree_with_those_recorded_when_written(stones, honest):
    results, measured = stones.results["Walker"], figures(honest)
    promised = np.array([status in ("ok", "outsideHull") for status in results.status])
    placement, slide = results.placement_error[promised], results.slide[promised]
    assert honest.total.steps == promised.sum() > 10
    assert measured["placement mean"].value == pytest.approx(1e3 * np.nanmean(placement), abs=0.01)
    assert measured["slide"].value == pytest.approx(1e3 * np.nanmax(slide), abs=0.01)
    assert [step for step, _, _ in honest.total.unpromised] == np.flatnonzero(~promised).tolist()
    assert measured["timing faults"].value == 0
    assert all(np.isfinite(figure.value) for figure in honest.total.figures)


def test_a_shifted_agent_misses_its_footsteps_by_the_shift(crowd, honest):
    scale = 1.0 / Usd.Stage.Open(str(crowd)).GetMetadata("metersPerUnit")
    override(
        crowd,
        "/Crowd/Agents/Walker",
        "xformOp:translate",
        lambda value: value + Gf.Vec3d(SHIFT * scale, -SHIFT * scale, 0),
    )
    shifted, before = figures(validate(crowd)), figures(honest)
    assert shifted["placement mean"].value == pytest.approx(5.0, abs=0.01)
    assert not shifted["placement mean"].passed and not shifted["placement worst"].passed
    assert shifted["lowest sole"].value == pytest.approx(before["lowest sole"].value - 5.0, abs=0.5)
    assert not shifted["lowest sole"].passed
    for name in ("slide", "yaw error", "timing faults", "heel slide"):
        assert shifted[name].value == pytest.approx(before[name].value, abs=1e-3)


def test_a_drifting_agent_slides(crowd):
    scale = 1.0 / Usd.Stage.Open(str(crowd)).GetMetadata("metersPerUnit")
    count = iter(range(10_000))
    override(
        crowd,
        "/Crowd/Agents/Walker",
        "xformOp:translate",
        lambda value: value + Gf.Vec3d(0.001 * scale * (next(count) % 2), 0, 0),
    )
    drifting = figures(validate(crowd))
    assert drifting["slide"].value == pytest.approx(1.0, abs=0.02)
    assert drifting["joint jerk / clips"].passed


def test_as_many_workers_as_there_are_measure_the_same(crowd, monkeypatch):
    stage = Usd.Stage.Open(str(crowd))
    layer = Sdf.Layer.FindOrOpen(str(crowd.parent / "overrides.usda"))
    stage.SetEditTarget(layer)
    walker = stage.GetPrimAtPath("/Crowd/Agents/Walker")
    for name in ("Lost", "Twin"):
        other = stage.DefinePrim(f"/Crowd/Agents/{name}")
        other.GetReferences().AddInternalReference(walker.GetPath())
        relationship = other.CreateRelationship("usdfoot:agent:plan", custom=False)
        relationship.SetTargets(walker.GetRelationship("usdfoot:agent:plan").GetTargets() if name == "Twin" else [])
        source = other.CreateRelationship("skel:animationSource", custom=False)
        source.SetTargets(walker.GetRelationship("skel:animationSource").GetTargets())
    layer.Save()
    alone, done = validate(crowd), []
    monkeypatch.setattr(shares, "SHARE", 1)
    with ThreadPoolExecutor(2) as executor:
        shared = validate(crowd, executor=executor, progress=lambda *told: done.append(told))
    assert shared.to_json() == alone.to_json()
    assert sorted(agent.name for agent in shared.agents) == ["Twin", "Walker"]
    assert [problem.where for problem in shared.problems if problem.severity == "error"] == ["/Crowd/Agents/Lost"]
    assert done == [("measure", number, 3) for number in range(3)]


def test_deleting_the_footsteps_leaves_the_agents(crowd):
    before = Usd.Stage.Open(str(crowd))
    matrix = before.GetPrimAtPath("/Crowd/Agents/Walker").GetAttribute("xformOp:translate").Get(20.0)
    del before
    (crowd.parent / "footsteps.usdc").unlink()
    validation = validate(crowd)
    assert not validation.passed
    assert "/Crowd/Agents/Walker: has no plan" in str(validation.problems[0])
    after = Usd.Stage.Open(str(crowd))
    assert after.GetPrimAtPath("/Crowd/Agents/Walker").GetAttribute("xformOp:translate").Get(20.0) == matrix


def test_a_lost_scene_leaves_the_terrain_unmeasured_and_says_so(crowd):
    layer = Sdf.Layer.FindOrOpen(str(crowd))
    data = layer.customLayerData
    data["usdfoot"]["scene"] = "nowhere.usda"
    layer.customLayerData = data
    layer.Save()
    validation = validate(crowd)
    assert (
        np.isnan(figures(validation)["lowest sole"].value)
        and validation.to_json()["total"]["figures"]["clearance"]["value"] is None
    )
    assert "scene not found" in str(validation.problems[0])


def test_a_shot_over_the_crowd_and_its_expanded_variant_measure_the_same(stones, honest, tmp_path):
    shot = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    shot.TransferContent(Sdf.Layer.FindOrOpen(str(stones.crowd_file)))
    shot.customLayerData = {}
    shot.subLayerPaths = [str(stones.crowd_file)]
    shot.Save()
    for file in (shot.realPath, stones.crowd_file.with_name("crowd.expanded.usda")):
        assert validate(file).to_json() == honest.to_json()


def test_a_few_frames_of_a_crowd_are_measured_by_the_feet_that_stand_in_them(scene, tmp_path):
    """What a foot looks like flat is not looked for in frames that are not there."""
    animate(scene, tmp_path / "shot", frames=(20, 40))
    lowest = figures(validate(tmp_path / "shot" / "crowd.usd"))["lowest sole"]
    assert np.isfinite(lowest.value) and lowest.passed


def test_what_is_no_crowd_is_refused(scene):
    with pytest.raises(SceneError, match="has no agents below /Crowd/Agents"):
        validate(scene)


def test_feet_in_the_air_do_not_count_as_planted(crowd):
    scale = 1.0 / Usd.Stage.Open(str(crowd)).GetMetadata("metersPerUnit")
    override(crowd, "/Crowd/Agents/Walker", "xformOp:translate", lambda value: value + Gf.Vec3d(0, 0.02 * scale, 0))
    validation = validate(crowd)
    assert figures(validation)["timing faults"].value == validation.total.steps


def test_joints_that_are_nowhere_are_an_error(crowd):
    override(
        crowd, "/Crowd/Anims/Walker", "translations", lambda value: Vt.Vec3fArray([Gf.Vec3f(np.nan), *list(value)[1:]])
    )
    validation = validate(crowd)
    assert not validation.passed
    assert "moves joints to nowhere" in str(validation.problems[0])


def test_an_animation_without_samples_is_an_error(crowd):
    layer = Sdf.Layer.FindOrOpen(str(crowd.parent / "anims.0000.usdc"))
    for name in ("rotations", "translations", "scales"):
        layer.GetAttributeAtPath(f"/Crowd/Anims/Walker.{name}").ClearInfo("timeSamples")
    layer.Save()
    assert [problem.message.split(". ")[0] for problem in validate(crowd).problems] == [
        "/Crowd/Anims/Walker: has no samples"
    ]


def test_what_files_do_not_hold_is_said(crowd):
    """An animation that ends too early, contacts at other times than the footsteps', and results that are gone."""
    stage = Usd.Stage.Open(str(crowd))
    files = ("anims.0000.usdc", "footsteps.usdc")
    anims, footsteps = (Sdf.Layer.FindOrOpen(str(crowd.parent / name)) for name in files)
    codes = anims.ListTimeSamplesForPath("/Crowd/Anims/Walker.rotations")
    for code in codes[len(codes) // 2 :]:
        for name in ("rotations", "translations"):
            anims.EraseTimeSample(f"/Crowd/Anims/Walker.{name}", code)
    strikes = anims.GetAttributeAtPath("/Crowd/Anims/Walker.usdfoot:contact:left:strikeTimes")
    strikes.default = Vt.TimeCodeArray([Sdf.TimeCode(float(code) + 1.0) for code in strikes.default])
    count = sum(side == 0 for side in stage.GetPrimAtPath("/Crowd/Plans/Walker").GetAttribute("protoIndices").Get())
    plan = footsteps.GetPrimAtPath("/Crowd/Plans/Walker")
    plan.RemoveProperty(plan.attributes["usdfoot:result:status"])
    for layer in (anims, footsteps):
        layer.Save()
    validation = validate(crowd)
    assert not validation.passed
    sampled, untold, results = map(str, validation.problems)
    assert "is sampled from" in sampled and "its footsteps need" in sampled
    assert f"{count} footstep(s) have no contact at their strike, first footstep 0" in untold
    assert "has no UsdfootResultAPI" in results and "warning" in results
