"""TetrahedronSpace: the examples of one swing side by where they land and how fast their root moves ([B] 7, 3-D)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from scipy.spatial import Delaunay, QhullError

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, solve_footsteps
from usdfoot.spaces.solid_kernel import CornerWeights, SolidArrays, find_solids

__all__ = ["SPEED_SCALE", "TetrahedronSpace", "build_tetrahedron_space", "device_solids", "solve_tetrahedra"]

SPEED_SCALE = 0.25
"""Landing [m] that counts as much as 1 m/s of root speed."""
SMALLEST_VOLUME = 1e-7
"""Six times the volume [m^3, speed scaled] below which a tetrahedron is flat."""
SMALLEST_AREA = 1e-9
"""Twice the area on the ground [m^2] below which a face stands upright."""


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
    plain, count = solve_footsteps(space.footsteps, queries), len(queries)
    table: Any = np.zeros(count, dtype=CornerWeights.numpy_dtype())  # type: ignore[attr-defined]
    table["examples"], table["weights"][:, :3] = plain.examples[:, [0, 1, 2, 2]], plain.weights
    known = np.zeros((1 + max(space.examples.max(), plain.examples.max(initial=0)), 3))
    known[space.examples] = space.points
    solids = device_solids([space], [np.arange(len(known))], known)
    wanted = np.column_stack([plain.projections, SPEED_SCALE * np.broadcast_to(speeds, count)])
    mixed = wp.array(table, dtype=CornerWeights)
    wp.launch(find_solids, dim=count, inputs=[solids, wp.array(wanted, dtype=wp.vec3d)], outputs=[mixed])
    found = mixed.numpy()
    return FootstepWeights(
        examples=found["examples"].astype(np.intp),
        weights=found["weights"],
        hull_distances=plain.hull_distances,
        projections=plain.projections,
        simplices=plain.simplices,
        vertices=plain.vertices,
    )


def device_solids(spaces: Sequence[TetrahedronSpace], examples: Sequence[IntArray], points: FloatArray) -> SolidArrays:
    """The tetrahedra of several spaces end to end, as device arrays.

    Args:
        spaces: The examples of each count from 0.
        examples: Index into a library's examples of those of each space.
        points: (x, z, scaled speed) of the library's examples [m], shape (E, 3).
    """
    start_warp()
    vertices = [own[space.examples] for space, own in zip(spaces, examples, strict=True)]
    tetrahedra = [own[space.tetrahedra] for space, own in zip(spaces, vertices, strict=True)]
    faces = [own[space.faces] for space, own in zip(spaces, vertices, strict=True)]
    corners = np.concatenate([space.points[space.tetrahedra] for space in spaces])
    arrays = SolidArrays()
    arrays.points = wp.array(points, dtype=wp.vec3d)
    arrays.begins = wp.array(np.cumsum([0, *map(len, tetrahedra)]), dtype=wp.int32)
    arrays.tetrahedra = wp.array(np.concatenate(tetrahedra), dtype=wp.vec4i)
    arrays.inverses = wp.array(np.concatenate([space.inverses for space in spaces]), dtype=wp.mat44d)
    arrays.lows, arrays.highs = (wp.array(ends, dtype=wp.vec3d) for ends in (corners.min(axis=1), corners.max(axis=1)))
    arrays.face_begins = wp.array(np.cumsum([0, *map(len, faces)]), dtype=wp.int32)
    arrays.faces = wp.array(np.concatenate(faces), dtype=wp.vec3i)
    return arrays


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
    ground = points[faces][:, :, :2]
    areas = np.linalg.det(ground[:, 1:] - ground[:, :1])
    return tetrahedra, faces[np.abs(areas) > SMALLEST_AREA]
