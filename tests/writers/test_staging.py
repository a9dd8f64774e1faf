"""All files appear together or not at all."""

import os
import resource

import pytest
from pxr import Sdf

from tests.writers.crowds import Rig, character_of, scene_of, wandering_motion, write_character, write_crowd
from tests.writers.test_crowd import write
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import OutputError
from usdfoot.writers import staging
from usdfoot.writers.staging import staged_files


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_a_failure_while_writing_leaves_nothing_behind(tmp_path):
    with pytest.raises(RuntimeError), staged_files(tmp_path / "out") as files:
        files.add_text("a.txt", "new")
        raise RuntimeError("power cut")
    assert not list((tmp_path / "out").iterdir())


def test_a_file_elsewhere_that_cannot_be_read_meanwhile_is_not_told_as_the_folder_s(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"gone\.usd"), staged_files(tmp_path / "out") as files:
        files.add_file("a.usd", tmp_path / "gone.usd")
    with pytest.raises(OutputError, match="out: cannot be written to"), staged_files(tmp_path / "out"):
        (tmp_path / "out" / "gone.usd").read_bytes()
    assert not list((tmp_path / "out").iterdir())


def test_a_failure_while_writing_a_crowd_again_leaves_the_old_one(tmp_path, monkeypatch):
    crowd, _, _ = write(tmp_path)
    before = contents(crowd.parent)

    def full_disk(self, name, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(staging.StagedFiles, "add_bytes", full_disk)
    with pytest.raises(OutputError, match=r"cannot be written to \(No space left on device\)"):
        write(tmp_path, frames=5)
    assert contents(crowd.parent) == before


def test_a_layer_for_which_there_is_no_room_is_refused_with_the_reason(tmp_path):
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    values = Sdf.CreatePrimInLayer(layer, "/Values")
    for index in range(2000):
        Sdf.AttributeSpec(values, f"value{index}", Sdf.ValueTypeNames.Double).default = index / 7.0
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        refusal = pytest.raises(OutputError, match=r"cannot be written to \(File too large\)\. make room")
        with refusal, staged_files(tmp_path / "out") as files:
            files.add_layer("large.usdc", layer)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list((tmp_path / "out").iterdir())


def test_two_machines_whose_processes_have_one_number_do_not_write_into_one_file(tmp_path):
    """As threads of one process do not, which a user's own executor may have."""
    with staged_files(tmp_path) as one, staged_files(tmp_path) as other:
        one.add_text("a.txt", "one")
        other.add_text("a.txt", "other")
        assert sorted(path.read_text() for path in tmp_path.iterdir()) == ["one", "other"]
    assert contents(tmp_path) == {"a.txt": b"one"}


def test_the_root_layer_is_renamed_last(tmp_path, monkeypatch):
    renamed = []
    replace = os.replace
    monkeypatch.setattr(os, "replace", lambda a, b: (renamed.append(os.path.basename(b)), replace(a, b)))
    write(tmp_path)
    assert renamed[-1] == "crowd.usd" and len(renamed) == 3 + 8  # the chunk waits first


def test_overrides_are_never_overwritten(tmp_path):
    crowd, _, _ = write(tmp_path)
    overrides = crowd.parent / "overrides.usda"
    layer = Sdf.Layer.FindOrOpen(str(overrides))
    Sdf.CreatePrimInLayer(layer, "/Crowd/Agents/A0").SetInfo("comment", "an artist was here")
    layer.Save()
    kept = overrides.read_bytes()
    write(tmp_path)
    assert overrides.read_bytes() == kept


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError, match=r"file/out: cannot be made .* name a folder you may write to"):
        write(tmp_path, folder="file/out")


def test_links_that_lead_out_of_the_folder_are_refused(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "characters").symlink_to(tmp_path / "elsewhere")
    with (
        pytest.raises(OutputError, match=r"characters/Hero: leads out of .*out\. remove the link"),
        staged_files(tmp_path / "out") as staged,
    ):
        staged.add_text("characters/Hero/note.txt", "here")
    assert not list((tmp_path / "elsewhere").iterdir())


def test_output_over_the_input_is_refused(tmp_path):
    units = StageUnits(time_codes_per_second=30.0)
    character = character_of(write_character(tmp_path / "agents.usdc", Rig(units=units)))
    source = (tmp_path / "agents.usdc").read_bytes()
    scene = scene_of(character, units, agents=1, frames=4)
    motions = [wandering_motion("A0", character, frames=4, rate=30.0)]
    with pytest.raises(OutputError, match=r"would replace layers of the scene: .*agents\.usdc\. name another folder"):
        write_crowd(scene, motions, tmp_path)
    assert (tmp_path / "agents.usdc").read_bytes() == source and not (tmp_path / "crowd.usd").exists()
