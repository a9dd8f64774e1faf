"""The examples around a landing, chosen step by step on the device as `solve_steps` chooses them."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.spaces.neighbour_kernel import best_triple, nearest_examples
from usdfoot.spaces.root_weight_kernel import Corners, is_inside, mean_corner, weigh_corners

__all__ = ["FoundCorners", "SpaceArrays", "corners_of", "find_corners"]

SLACK = wp.constant(wp.float64(1e-10))
"""A point this far outside an edge, in barycentric coordinates, still is inside: no gap between two triangles."""


@wp.struct
class SpaceArrays:
    """All footstep spaces of a library, end to end; examples are the library's, in left-swing coordinates."""

    landings: wp.array(dtype=wp.vec2d)  # of every example (E,) [m]
    neighbour_begins: wp.array(dtype=wp.int32)  # of each space, and the end of the last (S + 1,)
    neighbours: wp.array(dtype=wp.int32)  # examples
    neighbour_landings: wp.array(dtype=wp.vec2d)  # theirs [m]
    coordinates: wp.array2d(dtype=wp.float64)  # theirs, scaled (., D)
    triangle_begins: wp.array(dtype=wp.int32)  # (S + 1,)
    triangles: wp.array(dtype=wp.vec3i)  # examples
    edge_begins: wp.array(dtype=wp.int32)  # (S + 1,)
    edges: wp.array(dtype=wp.vec3i)  # examples; the end twice


@wp.struct
class FoundCorners:
    """Examples around a landing, or on the edge of the hull nearest to it."""

    examples: wp.vec3i
    hull_distance: wp.float64  # of the landing [m]


@wp.func
def corners_of(spaces: SpaceArrays, examples: wp.vec3i) -> Corners:
    """Where three examples land."""
    corners = Corners()
    for corner in range(3):
        corners[corner] = spaces.landings[examples[corner]]
    return corners


@wp.func
def find_corners(
    spaces: SpaceArrays,
    space: int,
    landing: wp.vec2d,
    wanted: wp.array2d(dtype=wp.float64),
    query: int,
    by_features: bool,
) -> FoundCorners:
    """Three examples of a space for a landing: those most like the wanted step, else those of the triangle or edge.

    `wanted` has the scaled coordinates of the step in row `query`; `by_features` says whether they count.
    """
    found = FoundCorners()
    if by_features:
        begin = spaces.neighbour_begins[space]
        end = spaces.neighbour_begins[space + 1]
        near = nearest_examples(spaces.neighbour_landings, spaces.coordinates, begin, end, landing, wanted, query)
        triple = best_triple(spaces.neighbour_landings, near, landing)
        if triple.examples[0] >= 0:
            for corner in range(3):
                found.examples[corner] = spaces.neighbours[triple.examples[corner]]
            return found
    for triangle in range(spaces.triangle_begins[space], spaces.triangle_begins[space + 1]):
        if is_inside(corners_of(spaces, spaces.triangles[triangle]), landing, SLACK):
            found.examples = spaces.triangles[triangle]
            return found
    found.hull_distance = wp.float64(wp.inf)
    for edge in range(spaces.edge_begins[space], spaces.edge_begins[space + 1]):
        corners = corners_of(spaces, spaces.edges[edge])
        distance = wp.length(landing - mean_corner(corners, weigh_corners(corners, landing)))
        if distance < found.hull_distance:
            found.hull_distance = distance
            found.examples = spaces.edges[edge]
    return found
