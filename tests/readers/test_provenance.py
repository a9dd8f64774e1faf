"""Which files a scene consists of, and when their bytes say all of it."""

import pytest
from pxr import Sdf, Usd

from usdfoot.errors import SceneError
from usdfoot.readers.provenance import has_value_clips, read_scene_files

CLIPS = {"default": {"primPath": "/Walk"}}


def write_scene(path, *, clips):
    """A scene that instances a prim with or without value clips."""
    stage = Usd.Stage.CreateNew(str(path))
    part = stage.CreateClassPrim("/Part")
    if clips:
        stage.DefinePrim("/Part/Walk").SetMetadata("clips", clips)
    instance = stage.DefinePrim("/Part_1")
    instance.GetReferences().AddInternalReference(part.GetPath())
    instance.SetInstanceable(True)
    stage.Save()
    return path


def test_the_files_of_a_scene_are_found(tmp_path):
    path = write_scene(tmp_path / "scene.usda", clips={})
    info = read_scene_files(path, tmp_path)
    assert info.identifier == str(path.resolve()) and info.layers == (str(path.resolve()),)


def test_value_clips_are_opened_later_so_that_files_do_not_tell(tmp_path):
    assert has_value_clips(write_scene(tmp_path / "scene.usda", clips=CLIPS))
    assert not has_value_clips(write_scene(tmp_path / "without.usda", clips={}))


def test_what_is_changed_in_memory_is_not_in_the_file(tmp_path):
    path = write_scene(tmp_path / "scene.usda", clips={})
    layer = Sdf.Layer.FindOrOpen(str(path))
    layer.comment = "not saved"
    assert read_scene_files(path, tmp_path) is None


def test_a_scene_that_is_gone_is_named(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        read_scene_files(tmp_path / "gone.usda", tmp_path)
