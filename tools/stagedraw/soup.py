"""Triangles with normals and colours, and how they are read from USD meshes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, UsdGeom

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Soup:
    """Triangles in the world."""

    corners: FloatArray
    """Places [stage units], shape (T, 3, 3)."""
    normals: FloatArray
    """Unit normals at the corners, shape (T, 3, 3)."""
    colours: FloatArray
    """Linear RGB at the corners, shape (T, 3, 3)."""


@dataclass(frozen=True, kw_only=True)
class MeshShape:
    """What of a mesh does not move: its triangles and colours."""

    points: FloatArray
    """Authored points, shape (N, 3)."""
    triangles: NDArray[np.int64]
    """Points of each triangle, shape (T, 3)."""
    colours: FloatArray
    """Linear RGB at the corners, shape (T, 3, 3)."""
    faceted: bool
    """Flat shading: normals per face, or none."""


def read_mesh(mesh: UsdGeom.Mesh) -> MeshShape:
    """The shape of a mesh; colours are `primvars:displayColor`, grey where there are none."""
    points = np.array(mesh.GetPointsAttr().Get() or [], dtype=np.float64).reshape(-1, 3)
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], dtype=np.int64)
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get() or [], dtype=np.int64)
    corner_slots, faces = _fan(counts)
    triangles = indices[corner_slots] if len(indices) else np.zeros((0, 3), dtype=np.int64)
    smooth = mesh.GetNormalsInterpolation() in (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying)
    faceted = not (smooth and mesh.GetNormalsAttr().HasAuthoredValue())
    return MeshShape(
        points=points,
        triangles=triangles,
        faceted=faceted,
        colours=_corner_colours(mesh, triangles, corner_slots, faces),
    )


def read_lines(curves: UsdGeom.BasisCurves) -> MeshShape:
    """Linear curves with one colour a point as prisms with three sides, as wide as the curves."""
    points = np.array(curves.GetPointsAttr().Get() or [], dtype=np.float64).reshape(-1, 3)
    counts = np.array(curves.GetCurveVertexCountsAttr().Get() or [], dtype=np.int64)
    ends = np.cumsum(counts)
    starts = np.setdiff1d(np.arange(len(points)), ends - 1)
    radius = 0.5 * float((curves.GetWidthsAttr().Get() or [0.01])[0])
    ring = radius * np.array([[-0.87, -0.5, 0.0], [0.87, -0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corners = (points[:, None] + ring).reshape(-1, 3)
    sides = [(a, b) for a in range(4) for b in range(a)]
    quads = np.array([[a, b, 4 + b, a, 4 + b, 4 + a] for a, b in sides]).reshape(-1, 3)
    triangles = (4 * starts[:, None, None] + quads).reshape(-1, 3)
    colours = np.array(curves.GetDisplayColorPrimvar().Get() or [], dtype=np.float64).reshape(-1, 3)
    return MeshShape(points=corners, triangles=triangles, colours=colours[triangles // 4], faceted=True)


def place(shape: MeshShape, points: FloatArray) -> Soup:
    """The mesh with its points at `points` (world), shape (N, 3); smooth normals are those of the moved surface."""
    corners = points[shape.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if shape.faceted:
        normals = np.repeat(across[:, None], 3, axis=1)
    else:
        total = np.zeros_like(points)
        for corner in range(3):
            np.add.at(total, shape.triangles[:, corner], across)
        normals = total[shape.triangles]
    length = np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    return Soup(corners=corners, normals=normals / length, colours=shape.colours)


def transform(points: FloatArray, matrix: Gf.Matrix4d) -> FloatArray:
    """Points (N, 3) through a USD matrix (row vectors)."""
    whole = np.array(matrix)
    return points @ whole[:3, :3] + whole[3, :3]


def join(soups: Sequence[Soup]) -> Soup:
    """All triangles of several soups."""
    empty = np.zeros((0, 3, 3))
    return Soup(
        corners=np.concatenate([empty, *(soup.corners for soup in soups)]),
        normals=np.concatenate([empty, *(soup.normals for soup in soups)]),
        colours=np.concatenate([empty, *(soup.colours for soup in soups)]),
    )


def _fan(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Slots of faceVertexIndices of each fan triangle, shape (T, 3), and its face, shape (T,)."""
    starts = np.cumsum(counts) - counts
    pieces = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), pieces)
    number = np.arange(len(faces)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = starts[faces] if len(faces) else np.zeros(0, dtype=np.int64)
    return np.stack([first, first + number + 1, first + number + 2], axis=1), faces


def _corner_colours(
    mesh: UsdGeom.Mesh, triangles: NDArray[np.int64], slots: NDArray[np.int64], faces: NDArray[np.int64]
) -> FloatArray:
    primvar = mesh.GetDisplayColorPrimvar()
    values = np.array(primvar.ComputeFlattened() or [], dtype=np.float64).reshape(-1, 3)
    if not len(values):
        return np.full((len(triangles), 3, 3), 0.6)
    kind = primvar.GetInterpolation()
    if kind in (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying):
        return values[triangles]
    if kind == UsdGeom.Tokens.faceVarying:
        return values[slots]
    of_face = values[faces] if kind == UsdGeom.Tokens.uniform else values[np.zeros_like(faces)]
    return np.repeat(of_face[:, None], 3, axis=1)
