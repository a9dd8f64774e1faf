"""Warp kernel over steps that no blend brings to their footstep: does it lie beyond where an edge of the hull lands?

The hull's edges are straight, but the blends of an edge's two examples land on a curve, and where their poses are far
apart it bends into the hull by centimetres. What lies between is inside the hull of the landings, and out of reach of
blends as what is outside it is.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.correction_kernel import CorrectedStep
from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, blend_landing, keep_tried, try_example
from usdfoot.spaces.corner_kernel import SpaceArrays
from usdfoot.spaces.root_weight_kernel import cross

__all__ = ["edge_each"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

PIECES = wp.constant(12)
"""A curve is looked at in so many pieces."""
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))


@wp.struct
class EdgePoint:
    """The place on an edge's curve nearest to a footstep."""

    share: wp.float64  # of the second example
    distance: wp.float64  # [m]
    beyond: bool  # the footstep lies between the curve and the straight edge


@wp.func
def land_edge(
    library: LibraryArrays, edge: wp.vec3i, share: wp.float64, blends: BlendArrays, step: int, side: int
) -> wp.vec2d:
    """Where a blend of an edge's two examples lands, in left-swing coordinates [m]; it becomes the one tried."""
    try_example(blends, step, 0, edge[0], ONE - share)
    try_example(blends, step, 1, edge[1], share)
    for k in range(2, blends.examples.shape[1]):
        try_example(blends, step, k, edge[1], ZERO)
    return blend_landing(library, blends.tried_examples, blends.tried_weights, step, side)


@wp.func
def parts_at(place: wp.vec2d, start: wp.vec2d, end: wp.vec2d) -> bool:
    """Whether a line from a place along +x crosses a piece."""
    turn = cross(end - start, place - start)
    upward = start[1] <= place[1] and place[1] < end[1] and turn > ZERO
    downward = end[1] <= place[1] and place[1] < start[1] and turn < ZERO
    return upward or downward


@wp.func
def nearest_on_edge(
    library: LibraryArrays, edge: wp.vec3i, wanted: wp.vec2d, blends: BlendArrays, step: int, side: int
) -> EdgePoint:
    """The place on an edge's curve nearest to a footstep, and whether that lies between it and the straight edge."""
    found = EdgePoint()
    found.distance = wp.float64(wp.inf)
    first = land_edge(library, edge, ZERO, blends, step, side)
    before = first
    crossings = wp.int32(0)
    for piece in range(PIECES):
        after = land_edge(library, edge, wp.float64(piece + 1) / wp.float64(PIECES), blends, step, side)
        along = after - before
        part = wp.dot(wanted - before, along) / wp.max(wp.dot(along, along), wp.float64(1e-30))
        part = wp.clamp(part, ZERO, ONE)
        distance = wp.length(wanted - before - part * along)
        if distance < found.distance:
            found.distance = distance
            found.share = (wp.float64(piece) + part) / wp.float64(PIECES)
        crossings += int(parts_at(wanted, before, after))
        before = after
    crossings += int(parts_at(wanted, before, first))
    found.beyond = crossings % 2 == 1
    return found


@wp.kernel(enable_backward=False)
def edge_each(
    library: LibraryArrays,
    spaces: SpaceArrays,
    steps: wp.array(dtype=wp.int32),  # those to look at (K,)
    numbers: wp.array(dtype=wp.int32),  # of the space each step asks (N,)
    swing_sides: wp.array(dtype=wp.int32),  # (N,)
    landings: wp.array(dtype=wp.vec2d),  # of the footsteps, in left-swing coordinates [m] (N,)
    blends: BlendArrays,
    corrected: wp.array(dtype=CorrectedStep),  # (N,)
):
    """Says of each of `steps` beyond an edge's blends how far; its blend is the nearest of those, if that is nearer.

    A space without triangles is its edges, so that all that they miss is beyond them.
    """
    step = steps[wp.tid()]
    space = numbers[step]
    wanted = landings[step]
    side = swing_sides[step]
    flat = spaces.triangle_begins[space] == spaces.triangle_begins[space + 1]
    nearest = EdgePoint()
    nearest.distance = wp.float64(wp.inf)
    chosen = wp.int32(-1)
    for edge in range(spaces.edge_begins[space], spaces.edge_begins[space + 1]):
        found = nearest_on_edge(library, spaces.edges[edge], wanted, blends, step, side)
        if (flat or found.beyond) and found.distance < nearest.distance:
            nearest = found
            chosen = edge
    if chosen >= 0:
        corners = spaces.edges[chosen]
        landed = land_edge(library, corners, nearest.share, blends, step, side)
        result = corrected[step]
        if wp.length(wanted - landed) < wp.length(result.missed):
            straight = (ONE - nearest.share) * spaces.landings[corners[0]] + nearest.share * spaces.landings[corners[1]]
            result.missed = wanted - landed
            result.bias = landed - straight
            keep_tried(blends, step)
        result.hull_distance = wp.min(nearest.distance, wp.length(result.missed))  # three may reach a little beyond two
        corrected[step] = result
