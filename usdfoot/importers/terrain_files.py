"""Terrain from files: meshes (OBJ, PLY, STL) and grids of heights."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.errors import TerrainError
from usdfoot.importers.height_grids import GRID_SUFFIXES, PICTURE_SUFFIXES, HeightGrid, read_height_grid
from usdfoot.importers.units import metres_in
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain

__all__ = ["MESH_SUFFIXES", "TerrainFormat", "import_terrain_file"]

MESH_SUFFIXES = (".obj", ".ply", ".stl")
UNREADABLE = (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError, EOFError, MemoryError)
"""What trimesh raises for files that are no meshes."""
DOWNWARD = 0.1
"""A mesh whose faces look down by more of its area than they look up by is inside out."""


@dataclass(frozen=True, kw_only=True)
class TerrainFormat:
    """What files do not say about themselves."""

    unit: str = ""
    """Of all lengths: m, cm, mm, ft, in, or metres a unit."""
    cell: float = 0.0
    """Distance of two columns of a grid [unit]; 0 = as the file says."""
    row_cell: float = 0.0
    """Distance of two rows where it is another one [unit]; 0 = that of the columns."""
    height: float = 0.0
    """Height of white in a picture, or of the number 1 in another grid [unit]; 0 = 1 for grids of numbers."""
    up: str = "Y"
    """Axis of a mesh that points up: Y | Z."""
    limits: Limits = DEFAULT_LIMITS
    """How much a file may hold."""


def import_terrain_file(
    file: str | os.PathLike[str], *, terrain_format: TerrainFormat | None = None
) -> tuple[Terrain, tuple[Problem, ...]]:
    """Triangles of a file in the canonical world, and doubts.

    A grid lies with its middle at the origin, columns going to +X and rows to +Z; heights are kept.

    Args:
        file: .obj, .ply, .stl, .png, .tif, .asc, .npz, .npy or .txt.
        terrain_format: Units and sizes that the file does not state.

    Raises:
        TerrainError: If a unit or size is missing, or the file cannot be read or is empty.
        SceneError: If it has more triangles than the limits allow.
    """
    path, said = Path(file), terrain_format or TerrainFormat()
    suffix = path.suffix.lower()
    if suffix not in (*MESH_SUFFIXES, *GRID_SUFFIXES):
        known = ", ".join((*MESH_SUFFIXES, *GRID_SUFFIXES))
        raise TerrainError(path, f"{suffix or 'no suffix'} is unknown", f"{known} can be imported")
    if not said.unit:
        raise TerrainError(path, "does not say in which unit its lengths are", "give --unit: m, cm, or metres a unit")
    metres = metres_in(said.unit, "unit", error=TerrainError)
    if suffix in MESH_SUFFIXES:
        points, triangles, remarks = _read_mesh(path, said)
    else:
        grid = read_height_grid(path, said.limits)
        points, triangles = _grid_mesh(path, grid, said)
        remarks = grid.remarks
    terrain = Terrain(
        meshes=(path.stem,),
        points=metres * points,
        triangles=triangles,
        mesh_indices=np.zeros(len(triangles), dtype=int),
        walkable=np.array([True]),
    )
    problems = [Problem(severity="warning", where=str(path), message=f"{path}: {remark}") for remark in remarks]
    return terrain, tuple(problems)


def _grid_mesh(path: Path, grid: HeightGrid, said: TerrainFormat) -> tuple[FloatArray, IntArray]:
    """Points [unit] (P, 3) and triangles (T, 3); cells with a corner without height are left out."""
    sizes = said.cell, said.row_cell
    if not (np.isfinite([*sizes, said.height]).all() and min(sizes) >= 0.0):
        raise TerrainError(path, f"cell {said.cell:g} or height {said.height:g} is no size", "give numbers above 0")
    if said.cell and grid.cell and not np.isclose(said.cell, grid.cell):
        raise TerrainError(path, f"says its cells are {grid.cell:g} wide, not {said.cell:g}", "leave --cell out")
    cell = grid.cell or said.cell
    if not cell:
        raise TerrainError(path, "does not say how far its columns are apart", _cell_remedy(grid))
    if path.suffix.lower() in PICTURE_SUFFIXES and not said.height:
        raise TerrainError(path, "does not say how high white is", "give --height, in the unit")
    rows, columns = grid.values.shape
    z, x = np.meshgrid(np.arange(rows) - 0.5 * (rows - 1), np.arange(columns) - 0.5 * (columns - 1), indexing="ij")
    heights = (said.height or 1.0) * grid.values
    points = np.stack([cell * x, heights, (said.row_cell or cell) * z], axis=-1).reshape(-1, 3)
    corners = np.arange(rows * columns).reshape(rows, columns)
    first, second, third, fourth = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    halves = np.stack([first, second, third, first, third, fourth], axis=-1).reshape(-1, 3)
    solid = np.isfinite(points[:, 1])
    triangles = halves[np.repeat(solid[halves].reshape(-1, 6).all(axis=1), 2)]
    if not len(triangles):
        raise TerrainError(path, "has no cell with heights at all four corners", "it may be all NODATA")
    used, places = np.unique(triangles, return_inverse=True)
    return points[used], places.reshape(-1, 3)


def _cell_remedy(grid: HeightGrid) -> str:
    """What to give for a grid of which nobody says how wide its cells are."""
    remedy = "give --cell, in the unit"
    if not grid.degrees[0]:
        return remedy
    columns, rows = grid.degrees
    return f"{remedy}; if its dx and dy are degrees of a map, --unit m --cell {columns:.5g} --row-cell {rows:.5g}"


def _read_mesh(path: Path, said: TerrainFormat) -> tuple[FloatArray, IntArray, tuple[str, ...]]:
    """Points [unit] (P, 3), triangles (T, 3) that look up, and doubts."""
    if said.up not in ("Y", "Z"):
        raise TerrainError("up", f"is {said.up!r}", "Y or Z is up")
    mesh = _load(path)
    points, triangles = np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=int)
    if not len(triangles):
        raise TerrainError(path, "has no faces", "a terrain is a mesh with faces")
    check_limit(path, "triangles", len(triangles), limit=said.limits.triangles)
    if not np.isfinite(points).all():
        raise TerrainError(path, "has points that are not finite", "repair the mesh")
    if said.up == "Z":
        points = points[:, [0, 2, 1]] * (1.0, 1.0, -1.0)
    normals = np.cross(*(points[triangles[:, corner]] - points[triangles[:, 0]] for corner in (1, 2)))
    areas = np.abs(normals).sum(axis=0)
    remarks = []
    if not areas.max() > 0.0:
        raise TerrainError(path, "has only faces without area", "repair the mesh")
    if int(np.argmax(areas)) != 1:
        remarks.append("most of its faces do not look up. Is --up right?")
    elif normals[:, 1].sum() < -DOWNWARD * areas[1]:
        triangles = triangles[:, ::-1]
        remarks.append("its faces look down and were turned over")
    return points, triangles, tuple(remarks)


def _load(path: Path) -> Any:
    try:
        import trimesh
    except ImportError as error:
        raise TerrainError(path, "cannot be read: trimesh is not installed", "pip install 'usdfoot[import]'") from error
    try:
        return trimesh.load_mesh(path, process=False)
    except UNREADABLE as error:
        raise TerrainError(path, f"cannot be read as a mesh ({error})", "export it again") from error
