"""Opening stages and reading their metadata."""

import logging
import os

import pytest
from pxr import Sdf, Usd, UsdUtils

from tests.scenes import Units, add_character, add_plan, new_stage, simple_scene
from usdfoot.bridge.tokens import Schema
from usdfoot.errors import SceneError
from usdfoot.readers.stage import (
    collect_prims,
    composition_problems,
    has_marked,
    keep_open,
    open_stage,
    read_stage_info,
)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere.usda: no such file. give a usd, usda, usdc or usdz file"):
        open_stage(tmp_path / "nowhere.usda")


def test_a_stage_that_is_kept_open_outlives_who_opened_it(tmp_path):
    scene = str(tmp_path / "scene.usda")
    Sdf.Layer.CreateNew(scene).Save()
    cache = UsdUtils.StageCache.Get()
    try:
        keep_open(open_stage(scene))
        assert [stage.GetRootLayer().realPath for stage in cache.GetAllStages()] == [os.path.realpath(scene)]
    finally:
        cache.Clear()


def test_of_a_crowd_s_folder_its_file_is_named(tmp_path):
    (tmp_path / "crowd.usd").touch()
    with pytest.raises(SceneError, match=r"is a folder\. give .*crowd\.usd$"):
        open_stage(tmp_path)


@pytest.mark.parametrize("name", ["notes.txt", "broken.usda", "folder.usd"])
def test_what_is_not_usd_is_named(tmp_path, name):
    path = tmp_path / name
    if name == "folder.usd":
        path.mkdir()
    else:
        path.write_text("this is not USD")
    with pytest.raises(SceneError, match=name):
        open_stage(path)


def test_text_that_is_not_utf_8_is_named(tmp_path):
    path = tmp_path / "latin.usda"
    path.write_bytes('#usda 1.0\ndef "Läufer" {}\n'.encode("latin-1"))
    with pytest.raises(SceneError, match=r"latin.usda: cannot be opened as USD"):
        open_stage(path)


def test_an_open_stage_is_taken_as_it_is():
    stage = new_stage()
    assert open_stage(stage) is stage


def test_a_file_is_opened_as_others_wrote_it_meanwhile(tmp_path):
    """USD gives what a notebook has open of it; the crowd made of that was then told unchanged for good."""
    scene, part = tmp_path / "scene.usda", tmp_path / "part.usda"
    scene.write_text("#usda 1.0\n(\n    subLayers = [@./part.usda@]\n)\n")
    part.write_text('#usda 1.0\ndef "Before"\n{\n}\n')
    held = Usd.Stage.Open(str(scene))
    assert held.GetPrimAtPath("/Before")
    part.write_text("#usda 1.0\n(\n    subLayers = [@./other.usda@]\n)\n")
    (tmp_path / "other.usda").write_text('#usda 1.0\ndef "After"\n{\n}\n')
    os.utime(part, ns=(0, part.stat().st_mtime_ns + 10**9))
    held.DefinePrim("/Unsaved")
    opened = open_stage(scene)
    assert sorted(prim.GetName() for prim in opened.GetPseudoRoot().GetChildren()) == ["After", "Unsaved"]


def test_metadata_is_read(tmp_path):
    stage = simple_scene(tmp_path / "scene.usda", Units(0.0254, "Z", 48.0))
    stage.SetStartTimeCode(3)
    stage.SetEndTimeCode(99)
    info = read_stage_info(stage)
    assert info.identifier == str((tmp_path / "scene.usda").resolve())
    assert (info.units.meters_per_unit, info.units.up_axis, info.units.time_codes_per_second) == (0.0254, "Z", 48.0)
    assert (info.frames_per_second, info.start_code, info.end_code) == (48.0, 3.0, 99.0)
    assert info.layers == (info.identifier,)


def test_fallbacks_are_used_knowingly(caplog):
    stage = Usd.Stage.CreateInMemory()
    with caplog.at_level(logging.INFO):
        info = read_stage_info(stage)
    assert (info.units.meters_per_unit, info.units.up_axis, info.units.time_codes_per_second) == (0.01, "Y", 24.0)
    for name in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        assert f"{name} is not authored, USD's fallback" in caplog.text


def test_the_rate_of_the_samples_is_not_the_playback_rate():
    stage = new_stage(None, Units(1.0, "Y", 30.0))
    stage.SetFramesPerSecond(24.0)
    info = read_stage_info(stage)
    assert (info.units.time_codes_per_second, info.frames_per_second) == (30.0, 24.0)


def test_a_rate_beyond_all_limits_is_refused():
    stage = new_stage(None, Units(1.0, "Y", 1e6))
    with pytest.raises(SceneError, match=r"timeCodesPerSecond is 1e\+06, more frames in one .* author at most 100000"):
        read_stage_info(stage)


def test_what_the_stage_refers_to_in_vain_is_said(tmp_path):
    stage = new_stage(tmp_path / "scene.usda")
    assert composition_problems(stage) == ()
    stage.DefinePrim("/World/Hero").GetReferences().AddReference("gone.usda")
    stage.DefinePrim("/World/Loop").GetReferences().AddInternalReference("/World")
    messages = [problem.message for problem in composition_problems(stage)]
    assert any("gone.usda" in message and "</World/Hero>" in message for message in messages)
    assert any("Cycle" in message and "</World/Loop>" in message for message in messages)
    assert all(message.startswith(stage.GetRootLayer().identifier) for message in messages)
    assert not any("anon:" in message for message in messages), "same input, same words"


def test_prims_are_collected_by_kind():
    stage = simple_scene()
    prims = collect_prims(stage)
    assert [prim.GetName() for prim in prims.skeletons] == ["Skeleton"]
    assert [prim.GetName() for prim in prims.animations] == ["walk"]
    assert [prim.GetName() for prim in prims.meshes] == ["Body", "Ground"]
    assert [prim.GetName() for prim in prims.instancers] == ["Walk"]
    assert {name: len(found) for name, found in prims.with_apis.items()} == {
        Schema.AGENT: 1,
        Schema.PLAN: 1,
        Schema.TERRAIN: 1,
    }


def test_instances_are_looked_into(tmp_path):
    source = new_stage()
    add_character(source, "/World/Hero", Units())
    add_plan(source, "/World/Plan", Units())
    source.GetPrimAtPath("/World/Hero").AddAppliedSchema(Schema.AGENT)
    source.GetRootLayer().Export(str(tmp_path / "asset.usda"))
    stage = new_stage()
    prim = stage.DefinePrim("/World/A")
    prim.GetReferences().AddReference(str(tmp_path / "asset.usda"))
    prim.SetInstanceable(True)
    prims = collect_prims(stage)
    assert [str(found.GetPath()) for found in prims.skeletons] == ["/World/A/Hero/Skeleton"]
    assert [str(found.GetPath()) for found in prims.with_apis[Schema.AGENT]] == ["/World/A/Hero"]


def test_a_usdz_package_is_a_scene(tmp_path):
    simple_scene(tmp_path / "scene.usdc")
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "scene.usdc")), str(tmp_path / "scene.usdz"))
    stage = open_stage(tmp_path / "scene.usdz")
    assert len(collect_prims(stage).skeletons) == 1


@pytest.mark.parametrize(("count", "is_so"), [(2, True), (3, False)])
def test_whether_many_prims_are_marked_is_known_of_the_first_of_them(count, is_so):
    stage = new_stage()
    for number in range(5):
        stage.DefinePrim(f"/Agent{number}").AddAppliedSchema(Schema.AGENT if number % 2 == 0 else "OtherAPI")
    assert has_marked(stage, more_than=count) == is_so
