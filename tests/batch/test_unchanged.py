"""A crowd of which nothing changed is not made again, nor its scene read; whatever might change it is noticed."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.batch.conftest import AGENTS
from tests.digests import digests
from usdfoot.bridge.tokens import File
from usdfoot.errors import SceneError
from usdfoot.model.limits import Limits
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.provenance import CallRecord
from usdfoot.pipeline.unchanged import find_earlier

CALL = CallRecord(chunk_size=1)


@pytest.fixture
def folder(crowd, request):
    """A copy of the crowd, as far from its scene as the crowd is."""
    copy = crowd.crowd_file.parent.with_name(request.node.name.replace("[", "_").replace("]", ""))
    shutil.copytree(crowd.crowd_file.parent, copy)
    return copy


def times(folder):
    """When each file was last written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}


def mute(folder, name):
    """Say in overrides.usda that an agent is not to be made."""
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    Sdf.CreatePrimInLayer(layer, f"/Crowd/Agents/{name}").active = False
    layer.Save()


def test_nothing_is_written_and_all_is_told_again(crowd, crowd_scene, folder):
    before = times(folder)
    again = animate(crowd_scene, folder, chunk_size=1)
    assert times(folder) == before
    assert (again.chunks, again.kept, again.kept_agents) == (AGENTS, AGENTS, AGENTS)
    assert again.problems == crowd.problems and list(again.results) == list(crowd.results)
    for name, results in crowd.results.items():
        assert again.results[name].status == results.status and again.results[name].clips == results.clips
        np.testing.assert_array_equal(again.results[name].placement_error, results.placement_error)


@pytest.mark.parametrize(
    ("options", "call"),
    [
        (MotionOptions(seam="none"), CALL),
        (MotionOptions(), replace(CALL, chunk_size=2)),
        (MotionOptions(), replace(CALL, agents="Agent_[01]")),
        (MotionOptions(), replace(CALL, frames=(0, 40))),
        (MotionOptions(), replace(CALL, collect=True)),
        (MotionOptions(), replace(CALL, limits=Limits(agents=AGENTS))),
    ],
)
def test_what_is_asked_for_otherwise_is_made(crowd, crowd_scene, options, call):
    folder = crowd.crowd_file.parent
    assert find_earlier(crowd_scene, folder, options=MotionOptions(), call=CALL).unchanged is not None
    assert find_earlier(crowd_scene, folder, options=options, call=call).unchanged is None


def test_a_limit_that_is_too_low_is_one_where_nothing_changed_too(crowd, crowd_scene):
    with pytest.raises(SceneError, match=f"has {AGENTS} agents, more than {AGENTS - 1}"):
        animate(crowd_scene, crowd.crowd_file.parent, chunk_size=1, limits=Limits(agents=AGENTS - 1))


@pytest.mark.parametrize("name", ["anims.0001.usdc", "report.json", "crowd.usd", "crowd.expanded.usda"])
def test_a_damaged_crowd_is_mended(crowd_scene, folder, name):
    whole = digests(folder)
    (folder / name).write_bytes((folder / name).read_bytes()[:-200])
    assert animate(crowd_scene, folder, chunk_size=1).chunks == AGENTS
    assert digests(folder) == whole


def test_overrides_and_their_end_are_noticed(crowd, crowd_scene, folder):
    whole = digests(folder)
    mute(folder, "Agent_1")
    assert "Agent_1" not in animate(crowd_scene, folder, chunk_size=1).results
    assert find_earlier(crowd_scene, folder, options=MotionOptions(), call=CALL).unchanged is not None
    shutil.copyfile(crowd.crowd_file.parent / File.OVERRIDES, folder / File.OVERRIDES)
    assert list(animate(crowd_scene, folder, chunk_size=1).results) == list(crowd.results)
    assert digests(folder) == whole


def test_what_bytes_do_not_tell_is_read(crowd, crowd_scene, folder):
    (folder / "other.usda").write_text("#usda 1.0\n")
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    layer.subLayerPaths.append("./other.usda")
    layer.Save()
    animate(crowd_scene, folder, chunk_size=1)
    assert find_earlier(crowd_scene, folder, options=MotionOptions(), call=CALL).unchanged is None
    stage = Usd.Stage.Open(str(crowd_scene))
    stage.GetRootLayer().comment = "not saved"
    assert find_earlier(crowd_scene, crowd.crowd_file.parent, options=MotionOptions(), call=CALL).unchanged is None
    stage.Reload()
    assert find_earlier(crowd_scene, crowd.crowd_file.parent, options=MotionOptions(), call=CALL).unchanged is not None


def test_a_report_that_somebody_wrote_into_is_written_anew(crowd_scene, folder):
    whole, report = digests(folder), folder / File.REPORT
    lines = report.read_text().splitlines()
    report.write_text("\n".join([lines[0], lines[1], *lines[3:]]) + "\n")  # without its first agent
    assert animate(crowd_scene, folder, chunk_size=1).kept == AGENTS
    assert digests(folder) == whole


def test_chunks_of_which_the_report_tells_are_not_opened(crowd_scene, folder, monkeypatch):
    mute(folder, "Agent_0")
    opened = []
    monkeypatch.setattr("usdfoot.readers.chunks._opened", lambda path, **_: opened.append(path.name))
    monkeypatch.setattr("usdfoot.batch.earlier.read_data", lambda path: opened.append(path.name))
    assert animate(crowd_scene, folder, chunk_size=1).kept == AGENTS - 1
    assert not opened


def test_a_scene_with_value_clips_is_read_again_as_its_files_do_not_tell(crowd_scene, folder, monkeypatch):
    assert find_earlier(crowd_scene, folder, options=MotionOptions(), call=CALL).unchanged
    monkeypatch.setattr("usdfoot.pipeline.unchanged.has_value_clips", lambda scene, most_prims: True)
    assert find_earlier(crowd_scene, folder, options=MotionOptions(), call=CALL).unchanged is None


def move_first(stage):
    """A metre aside, for whoever looks at this stage alone."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        plan = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Crowd/Plan_0"))
        plan.AddTranslateOp(opSuffix="aside").Set(Gf.Vec3d(1.0, 0.0, 0.0))


def leave_out_first(stage):
    """As somebody does who hides a prim, for whoever looks at this stage alone."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        stage.GetPrimAtPath("/World/Crowd/Agent_0").SetActive(False)


def mask_others(stage):
    """See a part of the stage alone."""
    parts = ("Crowd/Agent_1", "Crowd/Plan_1", "Library", "Plans", "Walker")
    stage.SetPopulationMask(Usd.StagePopulationMask([f"/World/{part}" for part in parts]))


@pytest.mark.parametrize("edit", [move_first, leave_out_first, mask_others])
def test_what_is_edited_in_memory_alone_is_made_and_no_part_of_the_files(crowd, crowd_scene, folder, worker, edit):
    whole = digests(folder)
    stage = Usd.Stage.Open(str(crowd_scene))
    edit(stage)
    edited = animate(stage, folder, chunk_size=1)
    assert (len(edited.results), edited.kept_agents) != (AGENTS, AGENTS)
    fresh = folder.with_name(f"{folder.name}_fresh")
    assert list(animate(stage, fresh, chunk_size=1, executor=worker).results) == list(edited.results)
    assert digests(fresh) == digests(folder)
    assert animate(crowd_scene, folder, chunk_size=1).chunks == AGENTS
    assert digests(folder) == whole
