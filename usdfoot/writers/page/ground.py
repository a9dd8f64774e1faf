"""The terrain as the page draws it: the triangles near the crowd, or heights on a grid where those are too many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.terrain import Terrain

__all__ = ["GroundPicture", "picture_ground"]

MARGIN = 4.0
"""Terrain is drawn up to this far from the crowd [m]."""
MOST_TRIANGLES = 150_000
GRID = 256
"""Cells along each side of the grid that stands in for more triangles."""


@dataclass(frozen=True, kw_only=True)
class GroundPicture:
    """Triangles to draw; none = a plane at `level`."""

    points: FloatArray
    """[m], shape (P, 3)."""
    triangles: IntArray
    """Point indices, counter-clockwise seen from above, shape (T, 3)."""
    walkable: BoolArray
    """Whether feet may stand on the triangle, shape (T,)."""
    level: float
    """Height of the plane through the lowest footstep [m]."""
    sampled: float = 0.0
    """Spacing of the grid if heights were sampled [m], else 0."""


def picture_ground(terrain: Terrain | None, places: FloatArray) -> GroundPicture:
    """The terrain around places (N, 3) of the crowd [m].

    Args:
        terrain: None or without meshes = a plane.
        places: Where the crowd goes, its footsteps among them.
    """
    level = float(places[:, 1].min())
    lowest, highest = places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN
    if terrain is None or not len(terrain.triangles):
        return _plane(level)
    corners = terrain.points[terrain.triangles][..., [0, 2]]  # (T, 3, 2)
    near = (corners.min(axis=1) <= highest[[0, 2]]).all(axis=1) & (corners.max(axis=1) >= lowest[[0, 2]]).all(axis=1)
    if near.sum() > MOST_TRIANGLES:
        return _grid(Ground(terrain, fallback_height=level), lowest, highest, level)
    used, triangles = np.unique(terrain.triangles[near], return_inverse=True)
    walkable = np.asarray(terrain.walkable)[terrain.mesh_indices[near]]
    points = terrain.points[used]
    return GroundPicture(points=points, triangles=triangles.reshape(-1, 3), walkable=walkable, level=level)


def _plane(level: float) -> GroundPicture:
    none = np.zeros((0, 3))
    return GroundPicture(points=none, triangles=none.astype(int), walkable=np.zeros(0, dtype=bool), level=level)


def _grid(ground: Ground, lowest: FloatArray, highest: FloatArray, level: float) -> GroundPicture:
    """Heights of the uppermost ground on a square grid; cells with a corner off the terrain are left out."""
    spacing = float((highest - lowest)[[0, 2]].max() / GRID)
    columns, rows = (int(np.ceil((highest - lowest)[axis] / spacing)) + 1 for axis in (0, 2))
    z, x = np.meshgrid(lowest[2] + spacing * np.arange(rows), lowest[0] + spacing * np.arange(columns), indexing="ij")
    places = np.column_stack([x.ravel(), z.ravel()])
    sample = ground.heights(places, np.full(len(places), highest[1]))
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    triangles = np.concatenate(
        [
            np.column_stack([corner, corner + columns, corner + 1]),
            np.column_stack([corner + 1, corner + columns, corner + columns + 1]),
        ]
    )
    triangles = triangles[sample.hit[triangles].all(axis=1)]
    return GroundPicture(
        points=np.column_stack([places[:, 0], sample.heights, places[:, 1]]),
        triangles=triangles,
        walkable=sample.walkable[triangles].all(axis=1),
        level=level,
        sampled=spacing,
    )
