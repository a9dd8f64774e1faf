"""Polygons as triangles."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["cut_polygons"]


def cut_polygons(points: FloatArray, counts: IntArray, indices: IntArray, *, holes: IntArray) -> IntArray:
    """Triangles of polygons, in the polygons' winding.

    Triangles stay, convex polygons become fans and concave ones are cut by clipping ears.

    Args:
        points: Shape (P, 3).
        counts: Corners of each face, shape (F,).
        indices: Point of each corner, all faces one after the other.
        holes: Faces to leave out.

    Returns:
        Point indices, shape (T, 3).
    """
    starts = np.cumsum(counts) - counts
    kept = np.ones(len(counts), dtype=bool)
    kept[holes[(holes >= 0) & (holes < len(counts))]] = False
    parts = [np.zeros((0, 3), dtype=int)]
    for count in np.unique(counts[kept & (counts >= 3)]):
        faces = np.flatnonzero(kept & (counts == count))
        corners = indices[starts[faces][:, None] + np.arange(count)]  # (F, count)
        convex = _are_convex(points[corners]) if count > 3 else np.ones(len(faces), dtype=bool)
        parts.append(_fans(corners[convex]))
        parts.extend(_clip_ears(points[face], face) for face in corners[~convex])
    return np.concatenate(parts)


def _fans(corners: IntArray) -> IntArray:
    """Triangles (0, i, i + 1) of each polygon, shape (F * (count - 2), 3)."""
    count = corners.shape[1]
    fan = np.array([(0, i, i + 1) for i in range(1, count - 1)])
    return corners[:, fan].reshape(-1, 3)


def _normals(polygons: FloatArray) -> FloatArray:
    """Newell normals of polygons (F, N, 3), shape (F, 3)."""
    return np.cross(polygons, np.roll(polygons, -1, axis=1)).sum(axis=1)


def _are_convex(polygons: FloatArray) -> np.ndarray:
    """Whether each polygon (F, N, 3) turns the same way at every corner."""
    centred = polygons - polygons.mean(axis=1, keepdims=True)
    normals = _normals(centred)
    edges = np.roll(centred, -1, axis=1) - centred
    turns = np.einsum("fnc,fc->fn", np.cross(np.roll(edges, 1, axis=1), edges), normals)
    size = np.einsum("fc,fc->f", normals, normals)
    return np.all(turns >= -1e-9 * size[:, None], axis=1)


def _clip_ears(polygon: FloatArray, corners: IntArray) -> IntArray:
    """Triangles of one concave polygon: cut off corners that hold no other corner, until three are left."""
    normal = _normals((polygon - polygon.mean(axis=0))[None])[0]
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(polygon, drop, axis=1)
    if (normal[drop] < 0.0) != (drop == 1):
        flat = flat * (-1.0, 1.0)  # counter-clockwise as seen along the dropped axis
    left = list(range(len(corners)))
    triangles = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(flat, left, i)), 0)
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        left.pop(ear)
    return corners[np.array([*triangles, tuple(left)])]


def _is_ear(flat: FloatArray, left: list[int], corner: int) -> bool:
    before, here, after = left[corner - 1], left[corner], left[(corner + 1) % len(left)]
    a, b, c = flat[[before, here, after]]
    if _turn(a, b, c) <= 0.0:
        return False
    others = [i for i in left if i not in (before, here, after)]
    return not any(_turn(a, b, p) >= 0.0 and _turn(b, c, p) >= 0.0 and _turn(c, a, p) >= 0.0 for p in flat[others])


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Twice the signed area of a triangle in the plane."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
