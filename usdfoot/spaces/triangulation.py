"""Triangulation of landings: near-duplicates merged, collinear sets as a polyline, slivers at the hull dropped."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.projection import project_on_segments

__all__ = ["boundary_edges", "drop_slivers", "merge_points", "polyline", "signed_areas", "triangulate"]

FLATTEST_ALTITUDE = 1e-6
"""Triangles lower than this [m] have no usable inside: weights would lose more than 1e-9 to rounding."""
FATTEST_SLIVER = 0.25
"""Altitude of a sliver relative to its longest edge, at most."""


def merge_points(points: FloatArray, distance: float) -> tuple[IntArray, IntArray]:
    """Vertices that stand for all points within `distance` of them.

    The lowest in (x, z) order takes in its neighbours, then the next one left, so the result does not depend on the
    order of the points.

    Args:
        points: Shape (E, 2).
        distance: Reach of a vertex [m]; 0 merges exact duplicates only.

    Returns:
        Index of the point each vertex is taken from, in (x, z) order, shape (V,), and members: indices of all points
        a vertex stands for, its own first, padded with -1, shape (V, most).
    """
    order = np.lexsort((np.arange(len(points)), points[:, 1], points[:, 0]))
    neighbours = cKDTree(points).query_ball_point(points, distance)
    free = np.ones(len(points), dtype=bool)
    groups: list[list[int]] = []
    for point in order:
        if free[point]:
            near = sorted(other for other in neighbours[point] if free[other] and other != point)
            groups.append([int(point), *near])
            free[groups[-1]] = False
    members = np.full((len(groups), max(map(len, groups))), -1, dtype=np.intp)
    for row, group in zip(members, groups, strict=True):
        row[: len(group)] = group
    return members[:, 0], members


def polyline(vertices: FloatArray, width: float) -> IntArray | None:
    """Edges (V - 1, 2) along vertices (V, 2) that lie in a strip narrower than `width` [m], None if they do not.

    The strip follows the principal axis. A single vertex gives the edge from it to itself.
    """
    if len(vertices) == 1:
        return np.zeros((1, 2), dtype=np.intp)
    centred = vertices - vertices.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    along = centred @ axes[0]
    across = centred @ np.array([-axes[0, 1], axes[0, 0]])
    if np.ptp(across) >= max(width, 1e-9 * np.ptp(along)):
        return None
    order = np.argsort(along, kind="stable")
    return np.stack([order[:-1], order[1:]], axis=1)


def triangulate(vertices: FloatArray) -> IntArray:
    """Delaunay triangles of vertices (V, 2) that are not collinear.

    Returns:
        Vertex indices, counter-clockwise in (x, z), in lexicographic order, shape (T, 3). No triangle is flat.
    """
    triangles = Delaunay(vertices - vertices.mean(axis=0)).simplices.astype(np.intp)
    corners = vertices[triangles]
    clockwise = signed_areas(corners, corners[:, 0]).sum(axis=1) < 0.0
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    first = np.argmin(triangles, axis=1)
    triangles = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    triangles = triangles[np.lexsort(triangles.T[::-1])]
    _, altitudes = _edge_lengths_and_altitudes(vertices, triangles)
    return triangles[altitudes >= FLATTEST_ALTITUDE]


def drop_slivers(vertices: FloatArray, triangles: IntArray, minimal_altitude: float) -> IntArray:
    """Triangles without the slivers along the hull, thinnest first; no vertex is lost.

    A sliver's longest edge is its only one on the hull; its altitude is less than `minimal_altitude` [m] and than a
    quarter of that edge; and the vertex it would lay bare is no deeper than that, so the hull moves by less.
    """
    hull = vertices[boundary_edges(triangles)]
    _, _, nearest = project_on_segments(hull, vertices)
    shallow = np.linalg.norm(vertices - nearest, axis=1) < minimal_altitude
    lengths, altitudes = _edge_lengths_and_altitudes(vertices, triangles)
    longest = np.argmax(lengths, axis=1)
    rows = np.arange(len(triangles))
    thin = (altitudes < minimal_altitude) & (altitudes < FATTEST_SLIVER * lengths[rows, longest])
    thin &= shallow[triangles[rows, longest]]
    kept = rows
    while True:
        outer = _is_outer(triangles[kept])
        slivers = thin[kept] & outer[np.arange(len(kept)), longest[kept]] & (outer.sum(axis=1) == 1)
        if not slivers.any():
            return triangles[kept]
        kept = np.delete(kept, np.argmin(np.where(slivers, altitudes[kept], np.inf)))


def boundary_edges(triangles: IntArray) -> IntArray:
    """Edges (H, 2) that belong to one triangle only, vertices in lexicographic order."""
    edges = np.sort(_edges(triangles)[_is_outer(triangles)], axis=1)
    return edges[np.lexsort(edges.T[::-1])]


def signed_areas(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Twice the signed areas of the triangles between each point and the edge opposite each corner.

    Divided by their sum they are the point's barycentric coordinates.

    Args:
        corners: Shape (..., 3, 2).
        points: Shape (..., 2).

    Returns:
        Shape (..., 3), all of the triangle's sign if the point is inside.
    """
    a, b, c = np.moveaxis(corners - points[..., None, :], -2, 0)
    return np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=-1)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _edges(triangles: IntArray) -> IntArray:
    """Edge opposite each corner, shape (T, 3, 2)."""
    return np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)], axis=-1)


def _is_outer(triangles: IntArray) -> BoolArray:
    """Whether the edge opposite each corner belongs to no other triangle, shape (T, 3)."""
    edges = np.sort(_edges(triangles), axis=-1).reshape(-1, 2)
    _, which, counts = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    return (counts[which.reshape(-1)] == 1).reshape(-1, 3)


def _edge_lengths_and_altitudes(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Length of the edge opposite each corner (T, 3) and the altitude on the longest (T,), [m]."""
    ends = vertices[_edges(triangles)]
    lengths = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1)
    corners = vertices[triangles]
    areas = signed_areas(corners, corners[:, 0]).sum(axis=1)
    return lengths, areas / lengths.max(axis=1)
