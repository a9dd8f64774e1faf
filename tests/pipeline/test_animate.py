"""A scene goes in, a crowd comes out, with a report of every step."""

import hashlib
import json

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdValidation

from tests.digests import digests
from usdfoot import __version__
from usdfoot.bridge import tokens
from usdfoot.errors import OutputError, SceneError
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate
from usdfoot.writers.folder_lock import lock_folder


def test_every_step_is_reported(stones):
    report = json.loads(stones.report_file.read_text())
    (agent,) = report["agents"]
    assert agent["name"] == "Walker" and agent["prim"] == "/World/Walker"
    count = len(stones.results["Walker"].status)
    assert {len(column) for column in agent["steps"].values()} == {count} and count > 10
    np.testing.assert_allclose(agent["steps"]["placementError"], stones.results["Walker"].placement_error, rtol=1e-6)
    for clips in agent["steps"]["clips"][2:]:
        assert sum(clips.values()) == pytest.approx(1.0, abs=1e-4)
    assert set(agent["source"]) == {"kneeSpeedP99", "jointJerkP99", "seamJumpP99"}
    assert min(agent["source"].values()) > 0.5
    assert set(report["versions"]) == {"usdfoot", "usd", "warp", "numpy"}
    folder = stones.report_file.parent
    for name, value in report["files"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == value
    assert set(report["files"]) == {
        "agents.usdc",
        "footsteps.usdc",
        "anims.usda",
        "anims.0000.usdc",
        "crowd.expanded.usda",
    }


def test_many_frames_a_second_show_no_kinks_between_samples_of_the_clips(scene, tmp_path):
    layer = Sdf.Layer.CreateNew(str(tmp_path / "fast.usda"))
    layer.TransferContent(Sdf.Layer.FindOrOpen(str(scene)))
    layer.timeCodesPerSecond = layer.framesPerSecond = 240.0
    layer.Save()
    animate(layer.identifier, tmp_path / "shot")
    (agent,) = validate(tmp_path / "shot/crowd.usd").agents
    (jerk,) = [figure for figure in agent.figures if figure.name == "joint jerk / clips"]
    assert jerk.passed


def test_provenance_and_metadata(stones, scene):
    layer = Sdf.Layer.FindOrOpen(str(stones.crowd_file))
    provenance = layer.customLayerData[tokens.PROVENANCE]
    assert provenance["version"] == __version__ and len(provenance["contentHash"]) == 64
    assert provenance["options"]["seam"] == "inertialise" and provenance["options"]["correction"] is True
    assert (stones.crowd_file.parent / provenance["scene"]).resolve() == scene.resolve()
    stage, source = Usd.Stage.Open(layer), Usd.Stage.Open(str(scene))
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.GetStageUpAxis(source)
    assert UsdGeom.GetStageMetersPerUnit(stage) == UsdGeom.GetStageMetersPerUnit(source)
    assert stage.GetTimeCodesPerSecond() == source.GetTimeCodesPerSecond()


def test_nothing_written_names_this_machine_or_the_day(stones):
    folder = stones.crowd_file.parent
    for path in folder.iterdir():
        content = path.read_bytes()
        assert str(folder).encode() not in content and b"/tmp/" not in content and b"20:" not in content, path.name


def test_validators_are_silent(stones):
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    for name in (tokens.File.CROWD, tokens.File.EXPANDED):
        stage = Usd.Stage.Open(str(stones.crowd_file.parent / name))
        own = [
            (error.GetName(), error.GetMessage())
            for error in context.Validate(stage)
            if any(site.GetLayer() in stage.GetLayerStack() for site in error.GetSites() if site.IsValidSpecInLayer())
        ]
        assert not own


def test_the_source_is_untouched(scene, tmp_path):
    before = digests(scene.parent)
    animate(scene, tmp_path / "out", frames=(10, 30))
    assert digests(scene.parent) == before
    stage = Usd.Stage.Open(str(tmp_path / "out" / "crowd.usd"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (10, 30)


def test_a_bad_agent_is_skipped_and_the_crowd_goes_on(scene, tmp_path):
    layer = Sdf.Layer.CreateNew(str(tmp_path / "scene.usda"))
    layer.subLayerPaths.append(str(scene))
    layer.Save()
    stage = Usd.Stage.Open(layer)
    bad = stage.DefinePrim("/World/Lost", "Xform")
    bad.AddAppliedSchema(tokens.Schema.AGENT)
    bad.CreateRelationship(tokens.Agent.PLAN, custom=False).SetTargets(["/World/Plans/Nowhere"])
    stage.Save()
    report = animate(tmp_path / "scene.usda", tmp_path / "out", frames=(0, 20))
    assert list(report.results) == ["Walker"]
    assert [problem.where for problem in report.skipped] == ["/World/Lost"]
    assert "Nowhere" in json.loads(report.report_file.read_text())["problems"][0]["message"]


def test_one_run_at_a_time_writes_into_a_folder(scene, tmp_path):
    """Of two with different options chunks of both were left, and taken for one's own by every later run."""
    with lock_folder(tmp_path / "out"), pytest.raises(OutputError, match="another run is writing into it"):
        animate(scene, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_messages_of_what_cannot_be_done(scene, tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.usda: no such file"):
        animate(tmp_path / "nowhere.usda", tmp_path)
    with pytest.raises(SceneError, match=r"match none of the scene's agents: Walker"):
        animate(scene, tmp_path, agents="Nobody")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be made"):
        animate(scene, tmp_path / "file" / "out", frames=(0, 10))
    assert {path.name for path in tmp_path.iterdir()} == {"file"}
