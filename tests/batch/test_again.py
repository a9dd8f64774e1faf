"""A crowd made again, whatever changed, has the bytes of one made from nothing."""

import os
import shutil

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from tests.batch.conftest import AGENTS, delay_plan, write_crowd_scene
from tests.digests import digests
from usdfoot.bridge.chunk_files import chunk_files
from usdfoot.bridge.tokens import File
from usdfoot.errors import OutputError
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.writers.chunks import read_chunk


@pytest.fixture
def shot(stages, tmp_path):
    """A crowd in chunks of two agents, its scene and its folder."""
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", chunk_size=2)
    return scene, tmp_path / "out"


def assert_as_new(scene, folder, **options):
    """Makes the crowd again, and with the same overrides from nothing; how many agents were kept."""
    report = animate(scene, folder, chunk_size=2, **options)
    fresh = folder.with_name("fresh")
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir()
    shutil.copyfile(folder / File.OVERRIDES, fresh / File.OVERRIDES)
    animate(scene, fresh, chunk_size=2, **options)
    assert digests(folder) == digests(fresh)
    return report.kept_agents


def add_agent(stage, name):
    """One more who walks Agent_2's plan, after all others."""
    agent = UsdGeom.Xform.Define(stage, f"/World/Crowd/{name}").GetPrim()
    agent.AddAppliedSchema("UsdfootAgentAPI")
    for relationship in stage.GetPrimAtPath("/World/Crowd/Agent_2").GetRelationships():
        agent.CreateRelationship(relationship.GetName(), custom=False).SetTargets(relationship.GetTargets())


def test_agents_that_go_and_come_leave_the_bytes_of_a_first_run(shot):
    scene, folder = shot
    stage = Usd.Stage.Open(str(scene))
    stage.GetPrimAtPath("/World/Crowd/Agent_0").SetActive(False)
    stage.Save()
    assert assert_as_new(scene, folder) == 1  # two are one chunk now, to which the one who moved up is added
    stage.GetPrimAtPath("/World/Crowd/Agent_0").SetActive(True)
    stage.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1
    add_agent(stage, "Agent_9")
    stage.Save()
    assert assert_as_new(scene, folder) == AGENTS
    delay_plan(scene, 0, 3.0)
    assert assert_as_new(scene, folder) == AGENTS


def test_a_shot_that_ends_later_leaves_the_bytes_of_a_first_run(shot):
    """Only the last liftoff of one is later: the layers of its chunk say other frames, of which the other has none."""
    scene, folder = shot
    stage = Usd.Stage.Open(str(scene))
    liftoffs = stage.GetPrimAtPath("/World/Crowd/Plan_1").GetAttribute("usdfoot:plan:liftoffTimes")
    *first, last = liftoffs.Get()
    before = Sdf.Layer.OpenAsAnonymous(str(folder / "anims.0000.usdc")).endTimeCode
    for later in (40.0, 0.0):
        liftoffs.Set(Sdf.TimeCodeArray([*first, Sdf.TimeCode(float(last) + later)]))
        stage.Save()
        assert assert_as_new(scene, folder) == AGENTS - 1
        assert (Sdf.Layer.OpenAsAnonymous(str(folder / "anims.0000.usdc")).endTimeCode > before) == (later > 0.0)


def test_agents_with_other_names_or_gone_from_the_middle_leave_the_bytes_of_a_first_run(shot):
    scene, folder = shot
    layer = Sdf.Layer.FindOrOpen(str(scene))
    layer.GetPrimAtPath("/World/Crowd/Agent_1").name = "Agent_new"
    layer.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1
    del layer.GetPrimAtPath("/World/Crowd").nameChildren["Agent_new"]
    layer.Save()
    assert assert_as_new(scene, folder) == 1  # two are one chunk now, to which the one who moved up is added


def test_other_frames_leave_the_bytes_of_a_first_run(shot):
    """An agent's frames count where it walks: an earlier end makes it again, a later one than its own does not."""
    scene, folder = shot
    for frames, kept in (((0, 40), 0), ((0, 60), 0), ((0, 900), 0), ((0, 950), AGENTS)):
        assert assert_as_new(scene, folder, frames=frames) == kept


@pytest.mark.parametrize("shared", ["clips", "character", "terrain"])
def test_what_all_agents_share_makes_all_again(shot, shared):
    scene, folder = shot
    stage = Usd.Stage.Open(str(scene))
    if shared == "clips":
        stage.GetPrimAtPath("/World/Library/Motion/Clips/walk_090").SetActive(False)
    if shared == "character":
        meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh) and prim.HasAPI(UsdSkel.BindingAPI)]
        points = UsdGeom.Mesh(meshes[0]).GetPointsAttr()
        points.Set(Vt.Vec3fArray.FromNumpy(1.2 * np.array(points.Get(), dtype=np.float32)))
    if shared == "terrain":
        stage.GetPrimAtPath("/World/Terrain").SetActive(True)
    stage.Save()
    assert assert_as_new(scene, folder) == 0


def test_changed_options_leave_the_bytes_of_a_first_run(shot):
    scene, folder = shot
    assert assert_as_new(scene, folder, options=MotionOptions(seam="crossfade")) == 0


def test_changed_overrides_leave_the_bytes_of_a_first_run(shot):
    scene, folder = shot
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    moved = Sdf.CreatePrimInLayer(layer, "/Crowd/Plans/Agent_1")
    translate = Sdf.AttributeSpec(moved, "xformOp:translate", Sdf.ValueTypeNames.Double3)
    translate.default = (0.25, 0.0, 0.0)
    order = Sdf.AttributeSpec(moved, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
    order.default = ["xformOp:translate"]
    layer.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1
    Sdf.CreatePrimInLayer(layer, "/Crowd/Agents/Agent_0").active = False
    other = Sdf.RelationshipSpec(Sdf.CreatePrimInLayer(layer, "/Crowd/Agents/Agent_2"), "usdfoot:agent:plan")
    other.targetPathList.Prepend("/Crowd/Plans/Agent_1")
    layer.Save()
    assert assert_as_new(scene, folder) == 1
    layer.Clear()
    layer.Save()
    assert assert_as_new(scene, folder) == 0
    delay_plan(scene, 2, 3.0)
    assert assert_as_new(scene, folder) == AGENTS - 1


def test_what_a_scene_is_put_together_of_leaves_the_bytes_of_a_first_run(shot):
    scene, folder = shot
    moved = Usd.Stage.Open(str(scene))
    UsdGeom.Xformable(moved.GetPrimAtPath("/World/Crowd/Plan_1")).GetOrderedXformOps()[0].Set(Gf.Vec3d(0.75, 0.0, 0.25))
    moved.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1
    moved.GetPrimAtPath("/World/Crowd").SetChildrenReorder(["Agent_2", "Agent_1", "Agent_0"])
    moved.Save()
    assert assert_as_new(scene, folder) >= AGENTS - 1  # one chunk is the source of what is kept
    over = Sdf.Layer.CreateNew(str(scene.with_name("over.usda")))
    plan, kind = Sdf.CreatePrimInLayer(over, "/World/Crowd/Plan_0"), Sdf.ValueTypeNames.FloatArray
    weights = Sdf.AttributeSpec(plan, "usdfoot:plan:rootWeights", kind, Sdf.VariabilityUniform)
    weights.default = [0.25] * len(moved.GetPrimAtPath(plan.path).GetAttribute("positions").Get())
    over.Save()
    moved.GetRootLayer().subLayerPaths.append("./over.usda")
    moved.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1
    moved.GetRootLayer().subLayerPaths.remove("./over.usda")
    moved.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1


def test_a_plan_retimed_by_overrides_is_walked_so_as_in_a_first_run(shot):
    scene, folder = shot
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    made = Sdf.Layer.OpenAsAnonymous(str(folder / File.FOOTSTEPS))
    for name in ("usdfoot:plan:strikeTimes", "usdfoot:plan:liftoffTimes"):
        path = f"/Crowd/Plans/Agent_2.{name}"
        Sdf.CreatePrimInLayer(layer, "/Crowd/Plans/Agent_2")
        Sdf.CopySpec(made, path, layer, path)
        times = layer.GetAttributeAtPath(path)
        times.default = Sdf.TimeCodeArray([Sdf.TimeCode(float(code) + 3.0) for code in times.default])
    layer.Save()
    assert assert_as_new(scene, folder) == AGENTS - 1


def test_a_crowd_whose_chunks_are_elsewhere_is_made_again(shot):
    scene, folder = shot
    parts = folder / File.CHUNKS
    for path in parts.iterdir():  # as versions before had them
        path.rename(folder / path.name)
    parts.rmdir()
    delay_plan(scene, 0, 3.0)
    assert assert_as_new(scene, folder) == 0


def test_nothing_is_written_where_a_link_leads(shot, tmp_path):
    scene, folder = shot
    (tmp_path / "elsewhere").mkdir()
    shutil.rmtree(folder / File.CHUNKS)
    (folder / File.CHUNKS).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="leads out of"):
        animate(scene, folder, chunk_size=2)
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.parametrize("is_only_change", [False, True])
def test_a_chunk_that_somebody_wrote_into_is_made_again(shot, is_only_change):
    scene, folder = shot
    path = folder / "anims.0000.usdc"
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    layer.GetPrimAtPath("/Crowd/Anims/Agent_0").documentation = "edited"
    layer.Export(str(path))
    if not is_only_change:
        delay_plan(scene, 2, 3.0)
    assert assert_as_new(scene, folder) == int(is_only_change)


@pytest.mark.parametrize(
    "notes",
    [
        lambda said: "text",
        lambda said: said | {"entries": "no JSON"},
        lambda said: said | {"entries": "[]"},
        lambda said: said | {"entries": '{"agents": 1}'},
        lambda said: said | {"entries": 3.0},
        lambda said: said | {"contentHash": "other", "agentHashes": "text"},
        lambda said: said | {"contentHash": "other", "agentHashes": {"Agent_0": {"a": "b"}}},
        lambda said: said | {"contentHash": "other", "entries": "no JSON"},
    ],
)
def test_a_chunk_whose_notes_are_none_is_made_again(shot, notes):
    scene, folder = shot
    (folder / File.REPORT).unlink()  # which would tell that somebody wrote into it
    path = folder / "anims.0000.usdc"
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    layer.customLayerData = {"usdfoot": notes(layer.customLayerData["usdfoot"])}
    layer.Export(str(path))
    assert_as_new(scene, folder)


def test_a_chunk_put_back_with_its_old_time_is_made_again(shot):
    scene, folder = shot
    path, report = folder / "anims.0000.usdc", folder / File.REPORT
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    layer.GetPrimAtPath("/Crowd/Anims/Agent_0").documentation = "edited"
    layer.Export(str(path))
    older = report.stat().st_mtime_ns - 10**9
    os.utime(path, ns=(older, older))
    delay_plan(scene, 2, 3.0)
    assert assert_as_new(scene, folder) == 0


def test_files_of_two_makings_are_no_chunk(shot):
    _, folder = shot
    first, second = (chunk_files(index, 2) for index in (0, 1))
    prims, notes = read_chunk(folder, first)
    assert set(prims.agents) == set(prims.footsteps) == set(prims.anims) == set(notes.agent_hashes)
    shutil.copyfile(folder / second.footsteps, folder / first.footsteps)
    with pytest.raises(ValueError, match="one making"):
        read_chunk(folder, first)


def test_a_clips_analysis_that_cannot_be_kept_costs_nobody_the_motion(shot, tmp_path, monkeypatch, caplog):
    scene, folder = shot
    whole = digests(folder)
    monkeypatch.setattr("usdfoot.batch.tasks.LARGE_CROWD", 2)
    (tmp_path / "elsewhere").mkdir()
    foreign = tmp_path / "elsewhere" / "foreign.npz"
    foreign.write_bytes(b"not ours")
    shutil.rmtree(folder)
    folder.mkdir()
    (folder / File.EXAMPLES).symlink_to(foreign.parent)
    animate(scene, folder, chunk_size=2)
    assert f"{File.EXAMPLES}: leads out of" in caplog.text and list(foreign.parent.iterdir()) == [foreign]
    (folder / File.EXAMPLES).unlink()
    assert digests(folder) == whole
