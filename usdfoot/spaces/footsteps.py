"""FootstepSpace: the examples of one swing side by where they land, and the blend weights for any landing ([B] 4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.locate import TriangleGrid, build_grid, find_triangles
from usdfoot.spaces.projection import project_on_segments
from usdfoot.spaces.triangulation import boundary_edges, drop_slivers, merge_points, polyline, triangulate

__all__ = ["FootstepSpace", "FootstepWeights", "build_footstep_space", "solve_footsteps"]


@dataclass(frozen=True, kw_only=True)
class FootstepSpace:
    """A triangulation of landings. Examples that land on the same spot share a vertex."""

    vertices: FloatArray
    """Landing of each vertex's first member, (x, z) [m], shape (V, 2)."""
    members: IntArray
    """Examples that land within the merge distance of the vertex, the one whose landing it is first, padded with -1,
    shape (V, most)."""
    triangles: IntArray
    """Vertex indices, counter-clockwise in (x, z), shape (T, 3); none if the landings are collinear."""
    edges: IntArray
    """Vertex indices of the hull's edges; of the polyline if the landings are collinear, shape (H, 2)."""
    grid: TriangleGrid | None
    """Finds the triangle of a landing; None without triangles."""


@dataclass(frozen=True, kw_only=True)
class FootstepWeights:
    """Up to three examples for each of N landings. Their landings, weighted, give `projections`."""

    examples: IntArray
    """First member of each vertex, shape (N, 3)."""
    weights: FloatArray
    """Blend weights, shape (N, 3)."""
    hull_distances: FloatArray
    """Distance of the query from the hull [m], 0 inside, shape (N,)."""
    projections: FloatArray
    """Point of the hull nearest to the query, inside the query itself, (x, z) [m], shape (N, 2)."""
    simplices: IntArray
    """Triangle of the space, -1 on the hull's edges and outside, shape (N,)."""
    vertices: IntArray
    """Vertices of the space behind `examples`, for a choice among their members, shape (N, 3)."""


def build_footstep_space(
    landings: FloatArray, *, merge_distance: float = 0.005, minimal_altitude: float = 0.02
) -> FootstepSpace:
    """The parametric space of examples of one swing side.

    Args:
        landings: Where each example's swing ball lands, (x, z) [m], shape (E, 2), E >= 1.
        merge_distance: Landings at most this far apart [m] become one vertex.
        minimal_altitude: Slivers along the hull lower than this [m] are dropped; a whole set no wider is a polyline.

    Returns:
        The space, the same whatever the order of the examples.
    """
    landings = np.asarray(landings, dtype=float)
    representatives, members = merge_points(landings, merge_distance)
    vertices = landings[representatives]
    edges = polyline(vertices, minimal_altitude)
    if edges is not None:
        none = np.empty((0, 3), dtype=np.intp)
        return FootstepSpace(vertices=vertices, members=members, triangles=none, edges=edges, grid=None)
    triangles = drop_slivers(vertices, triangulate(vertices), minimal_altitude)
    return FootstepSpace(
        vertices=vertices,
        members=members,
        triangles=triangles,
        edges=boundary_edges(triangles),
        grid=build_grid(vertices[triangles]),
    )


def solve_footsteps(space: FootstepSpace, queries: FloatArray) -> FootstepWeights:
    """Blend weights that land on the queries, or as near as the space allows ([B] 4.3, 5).

    Inside the hull they are the barycentric coordinates in the query's triangle ([B] Eq. 1); outside, those of the
    orthogonal projection onto the hull.

    Args:
        space: From `build_footstep_space`.
        queries: Wanted landings, (x, z) [m], shape (N, 2).

    Returns:
        The weights; third example and weight 0 repeat the second where an edge is used.
    """
    queries = np.asarray(queries, dtype=float)
    count = len(queries)
    simplices: IntArray = np.full(count, -1, dtype=np.intp)
    weights: FloatArray = np.zeros((count, 3))
    if space.grid is not None:
        simplices, weights = find_triangles(space.grid, queries)
    vertices = np.zeros((count, 3), dtype=np.intp)
    inside = simplices >= 0
    vertices[inside] = space.triangles[simplices[inside]]
    outside = np.flatnonzero(~inside)
    edges, fractions, nearest = project_on_segments(space.vertices[space.edges], queries[outside])
    vertices[outside] = space.edges[edges][:, [0, 1, 1]]
    weights[outside, 0], weights[outside, 1] = 1.0 - fractions, fractions
    projections = queries.copy()
    projections[outside] = nearest
    return FootstepWeights(
        examples=space.members[vertices, 0],
        weights=weights,
        hull_distances=np.linalg.norm(queries - projections, axis=1),
        projections=projections,
        simplices=simplices,
        vertices=vertices,
    )
