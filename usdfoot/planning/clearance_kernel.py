"""Distances from outlines as a Warp kernel, one thread a point."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["BODY", "UNDERFOOT", "Outlines", "find_clearance", "find_clearances"]

BODY = 1.8
"""Obstacles higher above the ground than that are in nobody's way [m]."""
UNDERFOOT = 0.1
"""As are those so far below it [m]."""
SURE = wp.constant(wp.float64(1.0e-3))
"""What is so much farther away than something else [m] is so in spite of rounding."""
FAR = wp.constant(wp.float64(1.0e300))
"""Squared, of what is nowhere."""


@wp.struct
class Outlines:
    """Polygons (x, z) [m], one after the other: of obstacles, and of the bounds if there are any, as the last."""

    corners: wp.array(dtype=wp.vec2d)
    first: wp.array(dtype=wp.int32)  # corner of each, and how many there are
    lowest: wp.array(dtype=wp.vec2d)  # of the box around each
    highest: wp.array(dtype=wp.vec2d)
    margins: wp.array(dtype=wp.float64)
    heights: wp.array(dtype=wp.vec2d)  # lowest and highest point
    velocities: wp.array(dtype=wp.vec2d)  # [m/s]
    bounds: wp.int32  # which one they are; -1 = there are none


@wp.func
def signed_distance(outlines: Outlines, outline: int, place: wp.vec2d):
    """Distance of a place from an outline, negative inside.

    The nearest edge gives the distance, the number of edges that a ray towards +x crosses gives the sign.
    """
    zero = wp.float64(0.0)
    nearest = FAR
    inside = bool(False)
    last = outlines.first[outline + 1] - 1
    for corner in range(outlines.first[outline], last + 1):
        begin = outlines.corners[corner]
        end = outlines.corners[outlines.first[outline]]
        if corner < last:
            end = outlines.corners[corner + 1]
        edge = end - begin
        offset = place - begin
        length = wp.max(edge[0] * edge[0] + edge[1] * edge[1], wp.float64(2.2250738585072014e-308))
        along = wp.clamp((offset[0] * edge[0] + offset[1] * edge[1]) / length, zero, wp.float64(1.0))
        x = offset[0] - along * edge[0]
        z = offset[1] - along * edge[1]
        nearest = wp.min(nearest, x * x + z * z)
        spans = (place[1] < begin[1]) != (place[1] < end[1])  # each corner's height alike
        if spans and offset[0] < edge[0] * offset[1] / edge[1]:
            inside = not inside
    distance = wp.sqrt(nearest)
    if inside:
        distance = -distance
    return distance


@wp.func
def find_clearance(outlines: Outlines, point: wp.vec2d, height: wp.float64, time: wp.float64, most: wp.float64):
    """Least distance of a point from all margins and from the bounds, at most `most`.

    At a height of the ground, which is no number where all obstacles count, and a time from now on. Obstacles whose box
    is farther are not asked.
    """
    zero = wp.float64(0.0)
    best = wp.float64(most)
    for outline in range(outlines.margins.shape[0]):
        place = point - time * outlines.velocities[outline]
        if outline == outlines.bounds:
            best = wp.min(best, -signed_distance(outlines, outline, place))
        else:
            reach = outlines.heights[outline]
            asked = height + wp.float64(BODY) > reach[0] and height - wp.float64(UNDERFOOT) < reach[1]
            asked = asked or wp.isnan(height)
            low = outlines.lowest[outline] - place
            high = place - outlines.highest[outline]
            x = wp.max(wp.max(low[0], high[0]), zero)
            z = wp.max(wp.max(low[1], high[1]), zero)
            apart = wp.max(best + outlines.margins[outline] + SURE, zero)
            if asked and x * x + z * z <= apart * apart:
                best = wp.min(best, signed_distance(outlines, outline, place) - outlines.margins[outline])
    return best


@wp.kernel(enable_backward=False)
def find_clearances(
    outlines: Outlines,
    points: wp.array(dtype=wp.vec2d),
    heights: wp.array(dtype=wp.float64),
    times: wp.array(dtype=wp.float64),
    distances: wp.array(dtype=wp.float64),
):
    """Least distance of each point from all margins and from the bounds.

    Heights of the ground and times from now on are those of all points, or none at all.
    """
    index = wp.tid()
    height = wp.float64(wp.nan)
    if heights.shape[0] > 0:
        height = heights[index]
    time = wp.float64(0.0)
    if times.shape[0] > 0:
        time = times[index]
    distances[index] = find_clearance(outlines, points[index], height, time, distances[index])
