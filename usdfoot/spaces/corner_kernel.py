"""The examples around a landing, chosen step by step on the device as `solve_steps` chooses them."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.spaces.neighbour_kernel import SMALLEST_AREA, best_triple, nearest_examples, square_distance
from usdfoot.spaces.root_weight_kernel import Corners, areas_at, cross, is_inside, mean_corner, weigh_corners
from usdfoot.spaces.solid_kernel import SolidArrays

__all__ = [
    "FoundCorners",
    "SpaceArrays",
    "adjoin_corners",
    "corners_of",
    "find_corners",
    "triangle_around",
    "way_inside",
]

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
    solids: SolidArrays


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
def triangle_around(spaces: SpaceArrays, space: int, landing: wp.vec2d) -> int:
    """The first triangle of a space around a landing, -1 outside its hull."""
    for triangle in range(spaces.triangle_begins[space], spaces.triangle_begins[space + 1]):
        if is_inside(corners_of(spaces, spaces.triangles[triangle]), landing, SLACK):
            return triangle
    return -1


@wp.func
def way_inside(spaces: SpaceArrays, space: int, landing: wp.vec2d, way: wp.vec2d, most: wp.float64) -> wp.float64:
    """How many times its way a landing goes within the hull of a space, at most so many times; 0 outside."""
    if triangle_around(spaces, space, landing + most * way) >= 0:
        return most
    if triangle_around(spaces, space, landing) < 0:
        return wp.float64(0.0)
    inside = most
    for edge in range(spaces.edge_begins[space], spaces.edge_begins[space + 1]):
        corners = corners_of(spaces, spaces.edges[edge])
        along = corners[1] - corners[0]
        turn = cross(way, along)
        if turn != wp.float64(0.0):
            times = cross(corners[0] - landing, along) / turn
            part = cross(corners[0] - landing, way) / turn
            if times >= -SLACK and part >= -SLACK and part <= wp.float64(1.0) + SLACK:
                inside = wp.min(inside, wp.max(times, wp.float64(0.0)))
    return inside


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
    triangle = triangle_around(spaces, space, landing)
    if triangle >= 0:
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


@wp.func
def adjoin_corners(
    spaces: SpaceArrays,
    space: int,
    corners: wp.vec3i,
    landing: wp.vec2d,
    wanted: wp.array2d(dtype=wp.float64),
    query: int,
) -> wp.vec3i:
    """Three examples for a landing beyond an edge of three: that edge's, and the third most like the step beyond it.

    A blend lands a little off the blend of its examples' landings, so that what triples reach has gaps between them,
    except between two that have an edge in common. Where no example lies beyond, and inside, the same three.
    """
    given = corners_of(spaces, corners)
    found = corners
    if is_inside(given, landing, wp.float64(0.0)):
        return found
    shares = weigh_corners(given, landing)
    away = wp.int32(2)
    for corner in range(2):
        if shares[1 - corner] < shares[away]:
            away = 1 - corner
    first, second = corners[(away + 1) % 3], corners[(away + 2) % 3]
    squares = wp.vec3d()
    begin, end = spaces.neighbour_begins[space], spaces.neighbour_begins[space + 1]
    for example in range(begin, end):
        if spaces.neighbours[example] == first:
            squares[0] = square_distance(spaces.coordinates, example, wanted, query)
        if spaces.neighbours[example] == second:
            squares[1] = square_distance(spaces.coordinates, example, wanted, query)
    least = wp.float64(wp.inf)
    trial = Corners()
    trial[0] = spaces.landings[first]
    trial[1] = spaces.landings[second]
    for example in range(begin, end):
        trial[2] = spaces.neighbour_landings[example]
        areas = areas_at(trial, landing)
        total = areas[0] + areas[1] + areas[2]
        areas = areas * wp.sign(total)
        total = wp.abs(total)
        if wp.min(areas) >= wp.float64(0.0) and total >= wp.float64(SMALLEST_AREA):
            squares[2] = square_distance(spaces.coordinates, example, wanted, query)
            cost = wp.dot(areas, squares) / total
            if cost < least:
                least = cost
                found = wp.vec3i(first, second, spaces.neighbours[example])
    return found
