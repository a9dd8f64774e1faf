"""Finds the triangle around a point through a uniform grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.triangulation import signed_areas

__all__ = ["TriangleGrid", "build_grid", "find_triangles"]

INSIDE_TOLERANCE = 1e-10
"""A point this far outside an edge, in barycentric coordinates, still is inside: no gap between two triangles."""


@dataclass(frozen=True, kw_only=True)
class TriangleGrid:
    """Triangles listed by the square cells their bounds touch."""

    corners: FloatArray
    """Counter-clockwise, shape (T, 3, 2)."""
    origin: FloatArray
    """Lowest corner of the grid, shape (2,)."""
    cell_size: float
    """Side of a cell."""
    shape: tuple[int, int]
    """Number of cells along both axes."""
    starts: IntArray
    """Where the list of each cell begins, and the end of the last, shape (cells + 1,)."""
    listed: IntArray
    """Triangles of all cells, increasing within a cell."""


def build_grid(corners: FloatArray) -> TriangleGrid:
    """A grid of about four cells a triangle over triangles (T, 3, 2), T >= 1."""
    origin = corners.min(axis=(0, 1)) - 1e-9
    extent = corners.max(axis=(0, 1)) + 1e-9 - origin
    cell_size = float(np.sqrt(extent[0] * extent[1] / (4 * len(corners))))
    rows, columns = (np.floor(extent / cell_size).astype(int) + 1).tolist()
    lowest = np.floor((corners.min(axis=1) - 1e-9 - origin) / cell_size).astype(int)
    highest = np.floor((corners.max(axis=1) + 1e-9 - origin) / cell_size).astype(int)
    lowest, highest = np.clip(lowest, 0, [rows - 1, columns - 1]), np.clip(highest, 0, [rows - 1, columns - 1])
    spans = highest - lowest + 1
    triangles, place = _expand(spans.prod(axis=1))
    row = lowest[triangles, 0] + place // spans[triangles, 1]
    column = lowest[triangles, 1] + place % spans[triangles, 1]
    cells = row * columns + column
    order = np.lexsort((triangles, cells))
    starts = np.searchsorted(cells[order], np.arange(rows * columns + 1))
    return TriangleGrid(
        corners=corners,
        origin=origin,
        cell_size=cell_size,
        shape=(rows, columns),
        starts=starts,
        listed=triangles[order],
    )


def find_triangles(grid: TriangleGrid, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """The triangle around each point and the point's barycentric coordinates in it.

    Signed areas decide; on a shared edge or vertex the triangle of the lowest index wins.

    Args:
        grid: From `build_grid`.
        points: Shape (N, 2).

    Returns:
        Triangle indices, -1 outside all, shape (N,), and weights, not negative, sum 1 (0 outside), shape (N, 3).
    """
    found = np.full(len(points), -1, dtype=np.intp)
    weights = np.zeros((len(points), 3))
    cells = np.floor((points - grid.origin) / grid.cell_size)
    within = np.flatnonzero(((cells >= 0) & (cells < grid.shape)).all(axis=1))
    cell = cells[within, 0].astype(int) * grid.shape[1] + cells[within, 1].astype(int)
    which, place = _expand(grid.starts[cell + 1] - grid.starts[cell])
    triangles = grid.listed[grid.starts[cell[which]] + place]
    areas = signed_areas(grid.corners[triangles], points[within[which]])
    hits = np.flatnonzero(areas.min(axis=1) >= -INSIDE_TOLERANCE * areas.sum(axis=1))
    hit_points, first = np.unique(which[hits], return_index=True)
    hits = hits[first]
    clipped = np.maximum(areas[hits], 0.0)
    found[within[hit_points]] = triangles[hits]
    weights[within[hit_points]] = clipped / clipped.sum(axis=1, keepdims=True)
    return found, weights


def _expand(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Index i repeated counts[i] times, and the running number within each repetition."""
    index = np.repeat(np.arange(len(counts)), counts)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
