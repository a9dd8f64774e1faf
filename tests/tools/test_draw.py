"""`tools/draw.py` shows what a stage holds."""

import numpy as np
import pytest
from draw import draw_contact_sheet, main
from PIL import Image
from pxr import Usd, UsdGeom, UsdSkel
from stagedraw.raster import cover


def scene(stages, tmp_path, *, up="Y", scale=1.0):
    """One person walking over the flat terrain, animated by a clip; written as an instance."""
    stage = Usd.Stage.CreateNew(str(tmp_path / f"scene_{up}.usda"))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0 / scale)
    world = UsdGeom.Xform.Define(stage, "/World")
    if up == "Z":
        world.AddRotateXOp().Set(90.0)
    world.AddScaleOp().Set((scale, scale, scale))
    stage.DefinePrim("/World/Terrain").GetReferences().AddReference(str(stages / "terrain_flat.usda"))
    person = stage.DefinePrim("/World/Person", "SkelRoot")
    person.GetReferences().AddReference(str(stages / "human.usdc"))
    UsdSkel.BindingAPI.Apply(person).CreateAnimationSourceRel().SetTargets(["/World/Clips/walk_130"])
    person.SetInstanceable(True)
    clips = stage.DefinePrim("/World/Clips")
    clips.GetReferences().AddReference(str(stages / "clips.usdc"), "/HumanClips/Clips")
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(60)
    stage.Save()
    return tmp_path / f"scene_{up}.usda"


def shirt(png) -> np.ndarray:
    """Pixels of the blue of the shirt, shape (H, W)."""
    red, green, blue = np.moveaxis(np.asarray(Image.open(png)).astype(int), -1, 0)
    return (blue - red > 55) & (blue > green + 20) & (blue < 235)


@pytest.mark.parametrize(("up", "scale"), [("Y", 1.0), ("Z", 100.0)])
def test_the_person_is_seen_in_every_cell_whatever_the_units(stages, tmp_path, up, scale):
    png = draw_contact_sheet(
        scene(stages, tmp_path, up=up, scale=scale), tmp_path / "sheet.png", frames=[0, 30], size=(400, 300)
    )
    seen = shirt(png)
    assert seen.shape == (300, 400)
    assert seen[:120].sum() > 60  # the overview
    assert seen[120:, :200].sum() > 200 and seen[120:, 200:].sum() > 200


def test_the_command_line(stages, tmp_path, capsys):
    assert (
        main([str(scene(stages, tmp_path)), "-o", str(tmp_path / "a.png"), "--frames", "5", "--agent", "Person"]) == 0
    )
    assert "a.png" in capsys.readouterr().out
    assert Image.open(tmp_path / "a.png").size == (1600, 1000)


def test_a_stage_without_people_is_an_error(stages, tmp_path):
    with pytest.raises(ValueError, match="no skinned character"):
        draw_contact_sheet(stages / "terrain_flat.usda", tmp_path / "sheet.png")


def test_the_nearer_triangle_hides_the_other():
    square = np.array([[[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]], [[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]]])
    seen = cover(square, np.array([[0.2] * 3, [0.5] * 3]), (10, 10))
    assert (seen.triangle == 1).all()
    behind = cover(square, np.array([[0.2] * 3, [-1.0] * 3]), (10, 10))
    assert (behind.triangle == 0).all()
    assert np.allclose(behind.corners.sum(axis=2), 1.0)


def test_pixels_are_covered_once_by_triangles_that_share_an_edge():
    corners = np.array([[[0.0, 0.0], [8.0, 0.0], [8.0, 8.0]], [[0.0, 0.0], [8.0, 8.0], [0.0, 8.0]]])
    seen = cover(corners, np.ones((2, 3)), (8, 8))
    assert (seen.triangle >= 0).all()
    assert seen.triangle[1, 6] == 0 and seen.triangle[6, 1] == 1
