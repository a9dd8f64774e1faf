"""Terrain from files: heights where the file has them, whatever its kind; what is missing is asked for."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.errors import SceneError, TerrainError
from usdfoot.importers.terrain_files import TerrainFormat, import_terrain_file
from usdfoot.model.ground import Ground
from usdfoot.model.limits import Limits
from usdfoot.model.terrain import Terrain

HEIGHTS = np.array([[0, 10, 20, 30], [40, 50, 60, 70], [80, 90, 100, 255]], dtype=np.uint8)
"""Rows from north to south."""
PLACES = [((column - 1.5) * 0.5, (row - 1.0) * 0.5) for row in range(3) for column in range(4)]
ESRI = "ncols 4\nnrows 3\nxllcorner 500000\nyllcorner 100\ncellsize 50\nNODATA_value -9999\n"


def said(**options) -> TerrainFormat:
    return TerrainFormat(**{"unit": "cm", "cell": 50.0, **options})


def heights_at(terrain: Terrain, places) -> np.ndarray:
    """Heights of the ground at places (x, z) [m]."""
    points = np.array(places, dtype=float)
    return Ground(terrain).heights(points, np.full(len(points), 3.0), step_up=5.0).heights


def picture(file, pixels: np.ndarray) -> None:
    image = pytest.importorskip("PIL.Image", reason="pictures need the extra import")
    image.fromarray(pixels).save(file)


def write_grid(file) -> float:
    """The grid as a file of that kind; gives back the height that makes 255 of it 255 cm."""
    rows = "\n".join(" ".join(str(value) for value in row) for row in HEIGHTS)
    if file.suffix in (".png", ".tif"):
        picture(file, HEIGHTS if file.stem != "deep" else HEIGHTS.astype(np.uint16) * 257)
        return 255.0
    if file.suffix == ".asc":
        file.write_text(ESRI + rows)
    elif file.suffix == ".npy":
        np.save(file, HEIGHTS)
    elif file.suffix == ".npz":
        np.savez_compressed(file, elevation=HEIGHTS, dx=0.1, names=np.array(["a"]))
    else:
        file.write_text("# heights\n" + rows.replace(" ", ", "))
    return 0.0


@pytest.mark.parametrize("name", ["a.png", "deep.png", "a.tif", "a.asc", "a.npy", "a.npz", "a.txt"])
def test_a_grid_has_its_heights_at_its_corners(tmp_path, name):
    height = write_grid(tmp_path / name)
    terrain, problems = import_terrain_file(tmp_path / name, terrain_format=said(height=height))
    assert problems == () and len(terrain.triangles) == 12
    inside = 0.999 * np.array(PLACES)
    assert_allclose(heights_at(terrain, inside), 0.01 * HEIGHTS.ravel(), atol=0.01)
    assert_allclose(np.sort(terrain.points[:, 1]), np.sort(0.01 * HEIGHTS.ravel()), atol=1e-9)
    corners = terrain.points[terrain.triangles]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1] > 0.0).all()


def test_colours_holes_and_scales(tmp_path):
    colour = np.repeat(HEIGHTS[..., None], 4, axis=2)
    colour[0, 0] = (10, 20, 30, 40)
    picture(tmp_path / "a.png", colour)
    terrain, problems = import_terrain_file(tmp_path / "a.png", terrain_format=said(height=510.0))
    assert "red is taken" in problems[0].message and "transparent" in problems[1].message
    assert_allclose(terrain.points[:2, 1], [0.2, 0.2])
    (tmp_path / "a.asc").write_text(ESRI + "0 10 20 30\n40 -9999 60 70\n80 90 100 255\n")
    terrain, _ = import_terrain_file(tmp_path / "a.asc", terrain_format=said(cell=0.0, height=2.0))
    assert len(terrain.points) == 6 and len(terrain.triangles) == 4
    assert_allclose(np.unique(terrain.points[:, 1]), [0.4, 0.6, 1.2, 1.4, 2.0, 5.1])


def test_rows_may_be_farther_apart_than_columns_and_degrees_are_told_in_metres(tmp_path):
    file = tmp_path / "a.npz"
    np.savez(file, elevation=HEIGHTS.astype(np.int16), dx=1 / 1200, dy=1 / 1200, ymin=60.1, ymax=59.9)
    with pytest.raises(TerrainError, match=r"give --cell, .* if its dx and dy are degrees.* --cell 46.3.* 92.6"):
        import_terrain_file(file, terrain_format=said(cell=0.0))
    terrain, _ = import_terrain_file(file, terrain_format=said(unit="m", cell=46.0, row_cell=92.0))
    rows, columns = HEIGHTS.shape
    assert_allclose(np.ptp(terrain.points[:, [0, 2]], axis=0), [46.0 * (columns - 1), 92.0 * (rows - 1)])


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl"])
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_mesh_looks_up(tmp_path, suffix, up):
    trimesh = pytest.importorskip("trimesh", reason="meshes need the extra import")
    points = np.array([(0, 0, 0), (0, 0, 2), (3, 0, 2), (3, 1, 0)], dtype=float)
    stored = points if up == "Y" else points[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    for faces, remark in (([[0, 1, 2], [0, 2, 3]], False), ([[2, 1, 0], [3, 2, 0]], True)):
        trimesh.Trimesh(stored, faces, process=False).export(tmp_path / f"a{suffix}")
        terrain, problems = import_terrain_file(tmp_path / f"a{suffix}", terrain_format=said(up=up))
        assert_allclose(
            heights_at(terrain, [(0.02, 0.01), (0.029, 0.001)]),
            [(2 / 3 - 0.5) / 100, (2.9 / 3 - 0.05) / 100],
            atol=1e-6,
        )
        assert bool(problems) == remark
    other, problems = import_terrain_file(tmp_path / f"a{suffix}", terrain_format=said(up="YZ".replace(up, "")))
    assert "most of its faces do not look up. Is --up right?" in problems[0].message and len(other.triangles) == 2


@pytest.mark.parametrize(
    ("name", "content", "options", "message"),
    [
        ("a.txt", "1 2\n3 4", {"unit": ""}, "does not say in which unit"),
        ("a.txt", "1 2\n3 4", {"cell": 0.0}, "does not say how far its columns are apart. give --cell"),
        ("a.txt", "1 2\n3 4", {"cell": -1.0}, "cell -1 or height 0 is no size"),
        ("a.txt", "1 2\n3", {}, r"a.txt:2: has 1 numbers where there are 2 columns"),
        ("a.txt", "1 2\n3 x", {}, r"a.txt:2: 'x' is no finite number"),
        ("a.txt", "1 2", {}, r"a.txt: has 1 rows and 2 columns"),
        ("a.txt", "", {}, r"a.txt: has no numbers"),
        ("a.asc", "ncols 2\nnrows 2\n1 2\n3 4", {}, "lacks keywords.*cellsize"),
        ("a.asc", "ncols 2\nnrows 3\ncellsize 50\n1 2\n3 4", {}, r"a.asc:2: says 3 rows, there are 2"),
        ("a.asc", "ncols 3\nnrows 2\ncellsize 50\n1 2\n3 4", {}, r"a.asc:4: has 2 numbers where there are 3 columns"),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 0\n1 2\n3 4", {}, r"a.asc:3: is no size of a cell"),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 5\n1 2\n3 4", {}, r"says its cells are 5 wide, not 50"),
        ("a.asc", "ncols 2\nnrows 2\ncellsize 50\nNODATA_value 1\n1 2\n3 4", {}, "no cell with heights at all four"),
        ("a.png", "no picture", {"height": 1.0}, r"a.png: is no picture that can be read"),
        ("a.npz", "no arrays", {}, r"a.npz: cannot be read by numpy"),
        ("a.npy", "no array", {}, r"a.npy: cannot be read by numpy"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\n", {}, r"a.obj: (has no faces|cannot be read as a mesh)"),
        ("a.ply", "no mesh", {}, r"a.ply: cannot be read as a mesh"),
        ("a.stl", "no mesh", {}, r"a.stl: (has no faces|cannot be read as a mesh)"),
        ("a.obj", "v 0 0 0\nv 1 0 nan\nv 0 0 1\nf 1 2 3\n", {}, r"a.obj: (has points|cannot be read)"),
        ("a.fbx", "", {}, r"fbx is unknown.*\.obj"),
    ],
)
def test_what_is_missing_or_wrong_is_named(tmp_path, name, content, options, message):
    (tmp_path / name).write_text(content)
    with pytest.raises(TerrainError, match=message):
        import_terrain_file(tmp_path / name, terrain_format=said(**options))


def test_pictures_need_their_height_and_archives_one_array(tmp_path):
    write_grid(tmp_path / "a.png")
    with pytest.raises(TerrainError, match=r"does not say how high white is. give --height"):
        import_terrain_file(tmp_path / "a.png", terrain_format=said())
    np.savez(tmp_path / "a.npz", one=HEIGHTS, two=HEIGHTS)
    with pytest.raises(TerrainError, match="has 2 arrays of two dimensions: one, two"):
        import_terrain_file(tmp_path / "a.npz", terrain_format=said())
    with pytest.raises(SceneError, match=r"triangles, more than 10.*--max-triangles"):
        import_terrain_file(tmp_path / "a.png", terrain_format=said(height=1.0, limits=Limits(triangles=10)))
    with pytest.raises(TerrainError, match="cannot be read"):
        import_terrain_file(tmp_path / "none.txt", terrain_format=said())
