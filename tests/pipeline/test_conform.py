"""Footsteps drawn flat, laid on the terrain before they are walked (design.md section 3, --conform)."""

import numpy as np
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.scenes import Units, add_character, add_mesh, add_plan, new_stage
from usdfoot.cli.main import main

PLAN = "/World/Plans/Stones"


def drawn_flat(scene, file):
    """The scene with its only plan at height 0; the positions as they were [m]."""
    stage = Usd.Stage.CreateNew(str(file))
    stage.GetRootLayer().subLayerPaths = [str(scene)]
    source = Usd.Stage.Open(str(scene))
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond"):
        stage.SetMetadata(key, source.GetMetadata(key))
    plan = next(UsdGeom.PointInstancer(prim) for prim in stage.Traverse() if prim.HasAPI("UsdfootPlanAPI"))
    positions = plan.GetPositionsAttr().Get()
    plan.GetPositionsAttr().Set([Gf.Vec3f(p[0], 0.0, p[2]) for p in positions])
    stage.Save()
    return np.array(positions)


def executed(crowd):
    """Positions [m] and statuses of the crowd's only executed plan."""
    stage = Usd.Stage.Open(str(crowd))
    stage.Reload()
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointInstancer))
    statuses = prim.GetAttribute("usdfoot:result:status").Get()
    return np.array(UsdGeom.PointInstancer(prim).GetPositionsAttr().Get()), list(statuses)


def test_flat_prints_are_laid_on_the_stones(scene, stones, tmp_path):
    given = drawn_flat(scene, tmp_path / "flat.usda")
    assert main(["animate", str(tmp_path / "flat.usda"), "-o", str(tmp_path / "laid"), "--conform", "-q"]) == 0
    positions, statuses = executed(tmp_path / "laid/crowd.usd")
    assert_allclose(positions, given, atol=1e-4)
    assert statuses == executed(stones.crowd_file)[1]


def test_without_being_asked_for_they_stay_as_given(scene, tmp_path, capsys):
    drawn_flat(scene, tmp_path / "flat.usda")
    main(["animate", str(tmp_path / "flat.usda"), "-o", str(tmp_path / "given")])
    assert "put them on walkable terrain, by --conform where some is above or below them" in capsys.readouterr().err
    positions, _ = executed(tmp_path / "given/crowd.usd")
    assert_allclose(positions[:, 1], 0.0, atol=1e-6)
    assert main(["animate", str(tmp_path / "flat.usda"), "-o", str(tmp_path / "given"), "--conform", "-q"]) == 0
    assert executed(tmp_path / "given/crowd.usd")[0][:, 1].max() > 0.2  # made anew, not kept


def test_prints_that_lie_there_already_stay(scene, stones, tmp_path):
    assert main(["animate", str(scene), "-o", str(tmp_path / "laid"), "--conform", "-q"]) == 0
    assert_allclose(executed(tmp_path / "laid/crowd.usd")[0], executed(stones.crowd_file)[0], atol=1e-5)


def test_without_terrain_that_is_said(scene, tmp_path, capsys):
    stage = Usd.Stage.CreateNew(str(tmp_path / "bare.usda"))
    stage.GetRootLayer().subLayerPaths = [str(scene)]
    source = Usd.Stage.Open(str(scene))
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond"):
        stage.SetMetadata(key, source.GetMetadata(key))
    stage.GetPrimAtPath("/World/Terrain").SetActive(False)
    stage.Save()
    main(["animate", str(tmp_path / "bare.usda"), "-o", str(tmp_path / "bare"), "--conform"])
    assert "no terrain to lay footsteps on" in " ".join(capsys.readouterr().err.split())


def test_an_agent_that_artists_moved_is_laid_where_it_was_moved_to(tmp_path):
    """From one side of a slope to the other; without being asked for it keeps its heights, and is off the terrain."""
    scene = write_slope(tmp_path / "slope.usda")
    out, crowd = tmp_path / "out", tmp_path / "out/crowd.usd"
    arguments = ["animate", str(scene), "-o", str(out), "--motion", "physics", "-q"]
    assert main(arguments) == 0
    overrides = Sdf.Layer.FindOrOpen(str(out / "overrides.usda"))
    stage = Usd.Stage.Open(str(crowd))
    stage.SetEditTarget(overrides)
    agent = UsdGeom.Xformable(next(iter(stage.GetPrimAtPath("/Crowd/Agents").GetChildren())))
    agent.AddTranslateOp(opSuffix="edit").Set(Gf.Vec3d(2.0, 0.0, 0.0))
    overrides.Save()
    assert main(arguments) == 0
    assert set(executed(crowd)[1]) == {"offTerrain"}
    assert main([*arguments, "--conform"]) == 0
    positions, statuses = executed(crowd)
    assert set(statuses) == {"ok"}
    assert_allclose(positions[:, 1], 0.2 * (positions[:, 0] + 2.0), atol=1e-4)
    assert main(["validate", str(crowd)]) == 0


def write_slope(path):
    """A slope that rises by a fifth to +X, along whose foot somebody walks."""
    units = Units()
    stage = new_stage(path, units)
    corners = [(x, 0.2 * x, z) for x, z in ((-5.0, -3.0), (-5.0, 12.0), (5.0, 12.0), (5.0, -3.0))]
    add_mesh(stage, "/World/Ground", corners, [[0, 1, 2, 3]], units)
    add_character(stage, "/World/Person", units, with_body=True)
    add_plan(stage, "/World/Plan", units)
    stage.Save()
    return path
