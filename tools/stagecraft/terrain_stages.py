"""The terrain files: each a default prim `Terrain` with meshes that carry `UsdfootTerrainAPI`."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd

from stagecraft.stage_file import define_mesh, new_stage, uniform
from stagecraft.stones import stepping_stones
from stagecraft.terrains import Surface, flat, hills, slope, spiral_stairs, stairs


def write_terrains(folder: Path) -> None:
    """Write all terrain files into `folder`."""
    crossing = stepping_stones()
    _write(folder / "terrain_flat.usda", [flat()], "a square of 30 m")
    _write(folder / "terrain_slope.usda", [slope()], "ramp up, top, ramp down along +Z")
    _write(folder / "terrain_stairs.usda", [stairs()], "four stairs and a landing along +Z")
    _write(folder / "terrain_stones.usda", [*crossing.stones, crossing.water], "stepping stones over water")
    _write(folder / "terrain_hills.usda", [hills()], "a smooth hilly patch of 16 m")
    _write(folder / "terrain_spiral.usda", [spiral_stairs()], "a spiral staircase of 18 stairs")


def author_surface(stage: Usd.Stage, parent: str, surface: Surface) -> None:
    """Author a terrain mesh below `parent`."""
    mesh = define_mesh(
        stage,
        f"{parent}/{surface.name}",
        points=surface.points,
        counts=surface.counts,
        indices=surface.indices,
        normals=surface.face_normals(),
        colours=surface.colours,
        per="uniform",
    )
    prim = mesh.GetPrim()
    prim.AddAppliedSchema("UsdfootTerrainAPI")
    uniform(prim, "usdfoot:terrain:walkable", Sdf.ValueTypeNames.Bool, surface.walkable)


def author_block(stage: Usd.Stage, path: str, centre: np.ndarray, size: np.ndarray, margin: float) -> None:
    """Author a box that must not be walked into."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [(4, 6, 7, 5), (0, 1, 3, 2), (2, 3, 7, 6), (0, 4, 5, 1), (1, 5, 7, 3), (0, 2, 6, 4)]
    normals = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    mesh = define_mesh(
        stage,
        path,
        points=centre + signs * size / 2,
        counts=np.full(6, 4),
        indices=np.array(faces),
        normals=normals,
        colours=np.array([[0.62, 0.36, 0.30]]),
        per="uniform",
    )
    mesh.GetPrim().AddAppliedSchema("UsdfootObstacleAPI")
    uniform(mesh.GetPrim(), "usdfoot:obstacle:margin", Sdf.ValueTypeNames.Float, margin)


def author_prism(stage: Usd.Stage, path: str, outline: np.ndarray, *, height: float, margin: float) -> None:
    """Author an upright prism that must not be walked into; its outline (K, 2) is clockwise in (x, z)."""
    count = len(outline)
    points = np.concatenate([np.insert(outline, 1, level, axis=1) for level in (0.0, height)])
    turned = np.roll(np.arange(count), -1)
    sides = np.stack([np.arange(count), turned, turned + count, np.arange(count) + count], axis=1)
    along = points[turned] - points[:count]
    walls = np.cross(along, [0.0, 1.0, 0.0])
    mesh = define_mesh(
        stage,
        path,
        points=points,
        counts=np.array([count, count, *[4] * count]),
        indices=np.concatenate([np.arange(count)[::-1], np.arange(count) + count, sides.ravel()]),
        normals=np.concatenate(
            [[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]], walls / np.linalg.norm(walls, axis=1, keepdims=True)]
        ),
        colours=np.array([[0.62, 0.36, 0.30]]),
        per="uniform",
    )
    mesh.GetPrim().AddAppliedSchema("UsdfootObstacleAPI")
    uniform(mesh.GetPrim(), "usdfoot:obstacle:margin", Sdf.ValueTypeNames.Float, margin)


def _write(path: Path, surfaces: Sequence[Surface], made_by: str) -> None:
    stage = new_stage(path, "Terrain", "Xform", made_by)
    for surface in surfaces:
        author_surface(stage, "/Terrain", surface)
    stage.Save()
