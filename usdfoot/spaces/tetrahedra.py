"""TetrahedronSpace: the examples of one swing side by where they land and how fast their root moves ([B] 7, 3-D)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, QhullError

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, solve_footsteps

__all__ = ["TetrahedronSpace", "build_tetrahedron_space", "solve_tetrahedra"]

SPEED_SCALE = 0.25
"""Landing [m] that counts as much as 1 m/s of root speed."""
INSIDE_TOLERANCE = 1e-9
SMALLEST_VOLUME = 1e-7
"""Six times the volume [m^3, speed scaled] below which a tetrahedron is flat."""
SMALLEST_AREA = 1e-9
"""Twice the area on the ground [m^2] below which a face stands upright."""
CHUNK = 1 << 18
"""Pairs of query and tetrahedron looked at in one go."""


@dataclass(frozen=True, kw_only=True)
class TetrahedronSpace:
    """Delaunay tetrahedra of landings and scaled root speeds."""

    footsteps: FootstepSpace
    """The same examples by landing alone: the hull on the ground, and all there is where every speed is one."""
    examples: IntArray
    """Examples that are vertices; the others lie within the merge distance of one, shape (V,)."""
    points: FloatArray
    """(x, z, scaled speed) of the vertices [m], shape (V, 3)."""
    tetrahedra: IntArray
    """Vertices, in lexicographic order, shape (T, 4); none if the points are in one plane."""
    faces: IntArray
    """Vertices of the hull's triangles that are not upright, shape (H, 3)."""
    inverses: FloatArray
    """Point (x, z, speed, 1) to the barycentric coordinates in each tetrahedron, shape (T, 4, 4)."""


def build_tetrahedron_space(
    footsteps: FootstepSpace, landings: FloatArray, speeds: FloatArray, *, merge_distance: float = 0.005
) -> TetrahedronSpace:
    """The space of examples with landings (E, 2) [m] and root speeds (E,) [m/s] over their footstep space.

    Points that round to the same multiple of `merge_distance` [m] share a vertex, the first in (x, z, speed) order.
    """
    points = np.column_stack([landings, SPEED_SCALE * np.asarray(speeds, dtype=float)])
    order = np.lexsort(points.T[::-1])
    _, first = np.unique(np.round(points[order] / merge_distance), axis=0, return_index=True)
    examples = order[np.sort(first)]
    points = points[examples]
    tetrahedra, faces = _tetrahedra(points)
    corners = np.concatenate([points[tetrahedra], np.ones((len(tetrahedra), 4, 1))], axis=2)  # (T, 4, 4)
    return TetrahedronSpace(
        footsteps=footsteps,
        examples=examples,
        points=points,
        tetrahedra=tetrahedra,
        faces=faces,
        inverses=np.linalg.inv(np.swapaxes(corners, 1, 2)),
    )


def solve_tetrahedra(space: TetrahedronSpace, queries: FloatArray, speeds: FloatArray) -> FootstepWeights:
    """Blend weights that land on the queries (N, 2) [m] with root speeds (N,) [m/s], or as near as the space allows.

    Inside, the barycentric coordinates in the tetrahedron. Where no blend that lands there is so quick or slow, the
    speed gives way and the landing is kept: the nearest speed on the hull above or below it. Off the ground's hull the
    landing is projected first. Of tetrahedra or faces that meet in the query the first is taken.

    Returns:
        Four examples a query, shape (N, 4); weights and distances as `solve_footsteps` has them.
    """
    plain = solve_footsteps(space.footsteps, queries)
    examples = np.concatenate([plain.examples, plain.examples[:, -1:]], axis=1)
    weights = np.concatenate([plain.weights, np.zeros((len(queries), 1))], axis=1)
    points = np.column_stack([plain.projections, SPEED_SCALE * np.asarray(speeds, dtype=float), np.ones(len(queries))])
    if len(space.tetrahedra):
        simplices, coordinates = _locate(space, points)
        inside = simplices >= 0
        examples[inside] = space.examples[space.tetrahedra[simplices[inside]]]
        weights[inside] = coordinates[inside]
        outside = np.flatnonzero(~inside)
        faces, shares = _clamp_speeds(space, points[outside])
        found = faces >= 0
        rows = outside[found]
        examples[rows, :3], examples[rows, 3] = (own := space.examples[space.faces[faces[found]]]), own[:, 2]
        weights[rows, :3], weights[rows, 3] = shares[found], 0.0
    return FootstepWeights(
        examples=examples,
        weights=weights,
        hull_distances=plain.hull_distances,
        projections=plain.projections,
        simplices=plain.simplices,
        vertices=plain.vertices,
    )


def _tetrahedra(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Tetrahedra (T, 4) that are not flat, faces (H, 3) of the hull that are not upright; none in a plane."""
    none = np.zeros((0, 4), dtype=np.intp), np.zeros((0, 3), dtype=np.intp)
    if len(points) < 4:
        return none
    centred = points - points.mean(axis=0)
    if np.linalg.svd(centred, compute_uv=False)[2] < 1e-6:
        return none
    try:
        found = Delaunay(centred)
    except QhullError:
        return none
    corners = centred[found.simplices]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    tetrahedra = np.sort(found.simplices[volumes > SMALLEST_VOLUME].astype(np.intp), axis=1)
    tetrahedra = tetrahedra[np.lexsort(tetrahedra.T[::-1])]
    faces = np.sort(found.convex_hull.astype(np.intp), axis=1)
    faces = faces[np.lexsort(faces.T[::-1])]
    return tetrahedra, faces[np.abs(_areas(points[faces])[3]) > SMALLEST_AREA]


def _locate(space: TetrahedronSpace, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """First tetrahedron around each point (N, 4), -1 if none is, and the coordinates in it (N, 4)."""
    simplices: IntArray = np.full(len(points), -1, dtype=np.intp)
    weights = np.zeros((len(points), 4))
    step = max(1, CHUNK // len(space.tetrahedra))
    for begin in range(0, len(points), step):
        part = points[begin : begin + step]
        coordinates = (space.inverses.reshape(-1, 4) @ part.T).reshape(-1, 4, len(part))  # (T, 4, n)
        inside = coordinates.min(axis=1) >= -INSIDE_TOLERANCE
        first = np.argmax(inside, axis=0)
        simplices[begin : begin + step] = np.where(inside[first, np.arange(len(part))], first, -1)
        # Once more for itself: a product of many rounds differently with who else is asked.
        weights[begin : begin + step] = np.maximum(np.einsum("nij,nj->ni", space.inverses[first], part), 0.0)
    weights[simplices < 0] = 1.0
    return simplices, weights / weights.sum(axis=1, keepdims=True)


def _clamp_speeds(space: TetrahedronSpace, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Face of the hull over or under each point (N, 4) whose speed there is nearest, -1 if none is; weights (N, 3)."""
    if not len(space.faces) or not len(points):
        return np.full(len(points), -1, dtype=np.intp), np.zeros((len(points), 3))
    corners = space.points[space.faces]
    first, second, third, total = _areas(corners[None], points[:, None])
    shares = np.stack([first, second, third], axis=-1) / total[..., None]  # (N, H, 3)
    away = np.abs(np.einsum("nhk,hk->nh", shares, corners[..., 2]) - points[:, None, 2])
    away = np.where(shares.min(axis=2) >= -INSIDE_TOLERANCE, away, np.inf)
    nearest = np.argmin(away, axis=1)
    rows = np.arange(len(points))
    chosen = np.maximum(shares[rows, nearest], 0.0)
    chosen /= np.maximum(chosen.sum(axis=1, keepdims=True), 1e-12)
    return np.where(np.isfinite(away[rows, nearest]), nearest, -1), chosen


def _areas(corners: FloatArray, points: FloatArray | None = None) -> tuple[FloatArray, ...]:
    """Twice the ground areas opposite each corner of triangles (..., 3, 3) seen from points (..., 4), and their sum."""
    a, b, c = (corners[..., i, :2] for i in range(3))
    p = a if points is None else points[..., :2]

    def cross(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    parts = cross(b - p, c - p), cross(c - p, a - p), cross(a - p, b - p)
    return (*parts, parts[0] + parts[1] + parts[2])
