"""Imported terrain goes under a scene, in the scene's units and axes, and feet can stand on it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd, UsdGeom, UsdValidation

from usdfoot.cli.main import main
from usdfoot.errors import OutputError
from usdfoot.importers.terrain_files import TerrainFormat
from usdfoot.model.ground import Ground
from usdfoot.pipeline.import_terrain import import_terrain
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.terrain import read_terrain


def heights_at(stage: Usd.Stage, places) -> np.ndarray:
    """Heights of the stage's ground at places (x, z) of the canonical world [m]."""
    terrain, problems = read_terrain(stage, collect_prims(stage), read_stage_info(stage).units)
    assert problems == () and terrain.walkable.all()
    points = np.array(places, dtype=float)
    return Ground(terrain).heights(points, np.full(len(points), 5.0), step_up=5.0).heights


@pytest.mark.parametrize(("up", "metres"), [("Y", 1.0), ("Z", 0.01)])
def test_it_composes_as_a_sublayer(tmp_path, up, metres):
    scene = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    UsdGeom.SetStageUpAxis(scene, up)
    UsdGeom.SetStageMetersPerUnit(scene, metres)
    scene.SetDefaultPrim(UsdGeom.Xform.Define(scene, "/World").GetPrim())
    scene.Save()
    (tmp_path / "my hills.txt").write_text("0 1 2\n1 2 3\n2 3 4\n")
    said = TerrainFormat(unit="m", cell=2.0)
    report = import_terrain(
        [tmp_path / "my hills.txt"], tmp_path / "t.usd", terrain_format=said, scene=scene.GetRootLayer().identifier
    )
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(scene.GetRootLayer())
    layer.subLayerPaths = [str(report.file)]
    stage = Usd.Stage.Open(layer)
    mesh = stage.GetPrimAtPath("/Terrain/my_hills")
    assert mesh.IsA(UsdGeom.Mesh) and stage.GetDefaultPrim().GetPath() == "/World"
    assert_allclose(heights_at(stage, [(0.0, 0.0), (1.0, -1.0), (1.0, 1.0)]), [2.0, 2.0, 3.0], atol=1e-5)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    written = Usd.Stage.Open(str(report.file))
    assert [error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(written)] == []
    with pytest.raises(OutputError, match="would replace what it is made from"):
        import_terrain(
            [tmp_path / "my hills.txt"], tmp_path / "scene.usda", terrain_format=said, scene=tmp_path / "scene.usda"
        )


def test_the_command_line(tmp_path, capsys):
    (tmp_path / "a.txt").write_text("0 1\n1 2\n")
    (tmp_path / "b.txt").write_text("0 1\n1\n")
    files = [str(tmp_path / name) for name in ("a.txt", "b.txt")]
    arguments = ["--unit", "m", "--cell", "3", "-o", str(tmp_path / "t.usda"), "-q"]
    assert main(["import", *files, *arguments]) == 1
    streams = capsys.readouterr()
    assert "a: 2 triangles, 3 x 3 m, 2 m high" in streams.out and "b.txt:2: has 1 numbers" in streams.err
    assert main(["import", files[1], *arguments]) == 2
    assert main(["import", files[0], str(tmp_path / "clip.bvh"), *arguments]) == 2
    assert "import clips, plans and terrain apart" in capsys.readouterr().err


def test_real_terrain(shared_data, tmp_path):
    pytest.importorskip("trimesh", reason="meshes need the extra import")
    folder = shared_data / "terrain"
    meshes = TerrainFormat(unit="m", up="Z")
    report = import_terrain([folder / "terrain.obj"], tmp_path / "a.usd", terrain_format=meshes)
    assert report.problems == () and len(report.terrains["terrain"].triangles) == 1682
    stairs = TerrainFormat(unit="m", cell=0.04, height=0.6)
    report = import_terrain([folder / "straight_stairs_1m_1m_60cm.png"], tmp_path / "b.usd", terrain_format=stairs)
    stage, ways = Usd.Stage.Open(str(report.file)), np.linspace(-0.9, 0.9, 40)
    along = [heights_at(stage, np.stack(way, axis=1)) for way in ((0.0 * ways, ways), (ways, 0.0 * ways))]
    levels = max(along, key=np.ptp)
    assert levels.max() == pytest.approx(0.6, abs=1e-6) and levels.min() < 0.21
