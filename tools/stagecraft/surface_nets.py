"""Closed quad meshes of solids: one vertex in every grid cell the surface passes through, moved onto the surface.

Gibson 1998, Constrained elastic surface nets; here without the relaxation, since the distance is known everywhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stagecraft.rotation import FloatArray
from stagecraft.solids import Solid, gradient


@dataclass(frozen=True, kw_only=True)
class QuadMesh:
    """A closed surface, seen from outside counter-clockwise."""

    points: FloatArray
    """Vertices [m], shape (N, 3)."""
    normals: FloatArray
    """Outward unit normals, shape (N, 3)."""
    quads: NDArray[np.int64]
    """Vertices of each face, shape (F, 4)."""


def mesh_solid(solid: Solid, low: FloatArray, high: FloatArray, cell: float) -> QuadMesh:
    """Surface of `solid` within the box from `low` to `high` [m] at resolution `cell` [m]."""
    axes = [np.arange(start - cell, end + 2.0 * cell, cell) for start, end in zip(low, high, strict=True)]
    shape = tuple(len(axis) for axis in axes)
    corners = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = (solid(corners) < 0.0).reshape(shape)
    cells = _mixed_cells(inside)
    number = np.full(cells.shape, -1)
    number[cells] = np.arange(int(cells.sum()))
    points = np.stack([axis[index] + 0.5 * cell for axis, index in zip(axes, np.nonzero(cells), strict=True)], axis=1)
    points = _settle(solid, points, cell)
    quads = np.concatenate([_faces(inside, number, axis) for axis in range(3)])
    normals = gradient(solid, points)
    return QuadMesh(points=points, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True), quads=quads)


def _mixed_cells(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells with corners on both sides."""
    ends = (slice(None, -1), slice(1, None))
    corners = np.stack([inside[x, y, z] for x in ends for y in ends for z in ends])
    return np.asarray(corners.any(axis=0) & ~corners.all(axis=0))


def _faces(inside: NDArray[np.bool_], number: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """One quad around every grid edge along `axis` that crosses the surface, shape (F, 4)."""
    turned, cells = np.moveaxis(inside, axis, 0), np.moveaxis(number, axis, 0)
    crossing = turned[:-1] != turned[1:]
    crossing[:, [0, -1], :] = crossing[:, :, [0, -1]] = False
    i, j, k = np.nonzero(crossing)
    around = np.stack([cells[i, j - 1, k - 1], cells[i, j, k - 1], cells[i, j, k], cells[i, j - 1, k]], axis=1)
    outward = turned[i, j, k]
    if axis == 1:  # moveaxis leaves (y, x, z), a left-handed order
        outward = ~outward
    return np.where(outward[:, None], around, around[:, ::-1])


def _settle(solid: Solid, points: FloatArray, cell: float) -> FloatArray:
    """Points moved onto the surface: a few Newton steps, each at most a cell, spread evenly by the grid."""
    for _ in range(6):
        slope = gradient(solid, points)
        move = solid(points)[:, None] * slope / np.maximum(np.sum(slope**2, axis=1, keepdims=True), 0.05)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        points = points - move * np.minimum(1.0, 0.8 * cell / np.maximum(length, 1e-12))
    return points
