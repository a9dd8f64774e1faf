"""What either foot would stand on along ways, as a Warp kernel, one thread a foot."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.model.ground_kernel import GroundFaces, find_level
from usdfoot.planning import prints

__all__ = ["FootholdLimits", "feel_ground", "feel_walls"]

STEP_UP = wp.constant(wp.float64(prints.STEP_UP))
"""Ground so far above the way, or above the ball, is still the same level [m]."""
ROOM = wp.constant(wp.float64(prints.ROOM))
"""Ground farther than this above the way is another level [m]."""


@wp.struct
class FootholdLimits:
    """What of the ground under a sole costs what; see `planning/footholds.py`."""

    flattest: wp.float64  # upward part of the normal of ground that is too steep
    pokes: wp.float64  # [m]
    edge: wp.float64  # [m]
    hangs: wp.float64  # [m]
    hanging: wp.float64
    bad: wp.float64
    aside: wp.float64  # of a place beside the way's, a metre


@wp.func
def outline_cost(
    ground: GroundFaces,
    limits: FootholdLimits,
    ball: wp.vec3d,
    normal: wp.vec3d,
    offset: wp.vec3d,
    central: bool,
) -> wp.float64:
    """What the ground at an offset from the ball costs, beside the plane in which the sole lies."""
    rise, face = find_level(ground, ball + offset + wp.vec3d(wp.float64(0.0), STEP_UP, wp.float64(0.0)))
    slope = -(normal[0] * offset[0] + normal[2] * offset[2]) / normal[1]
    above = rise + STEP_UP - slope
    most = limits.edge
    if central:
        most = limits.pokes
    cost = wp.float64(0.0)
    if face >= 0 and above > most:
        cost = limits.bad
    elif central and (face < 0 or above < -limits.hangs):
        cost = limits.hanging
    return cost


@wp.struct
class Foothold:
    """What a foot would stand on."""

    cost: wp.float64
    height: wp.float64  # of the ground under the ball
    edged: bool  # what is in the way ends on this side of the farthest place aside, or the ball itself stands badly


@wp.func
def feel_foothold(
    ground: GroundFaces,
    limits: FootholdLimits,
    limit: wp.vec3d,
    yaw: wp.float64,
    farthest: wp.vec3d,
    outlines: wp.array(dtype=wp.vec2d, ndim=2),
    way: int,
    fallback: wp.float64,
) -> Foothold:
    """The foothold below a limit, bad as soon as it is impossible; `farthest` leads from it to the farthest aside."""
    found = Foothold()
    found.cost = limits.bad
    found.height = fallback
    found.edged = True
    rise, face = find_level(ground, limit)
    if face < 0:
        return found
    found.height = limit[1] + rise
    normal = ground.normals[face]
    if not ground.walkable[face] or normal[1] < limits.flattest:
        return found
    found.cost = wp.float64(0.0)
    ball = wp.vec3d(limit[0], found.height, limit[2])
    for place in range(outlines.shape[1]):
        if found.cost < limits.bad:
            across = outlines[way, place][0]
            ahead = outlines[way, place][1]
            x = across * wp.cos(yaw) + ahead * wp.sin(yaw)
            z = ahead * wp.cos(yaw) - across * wp.sin(yaw)
            offset = wp.vec3d(x, wp.float64(0.0), z)
            central = across == wp.float64(0.0)
            found.cost += outline_cost(ground, limits, ball, normal, offset, central)
            if central and found.cost >= limits.bad:
                found.edged = outline_cost(ground, limits, ball, normal, offset + farthest, True) < limits.bad
                if not found.edged:  # the farthest place may be on what is in the way
                    found.edged = outline_cost(ground, limits, ball, normal, farthest, True) >= limits.bad
    return found


@wp.kernel(enable_backward=False)
def feel_ground(
    ground: GroundFaces,
    limits: FootholdLimits,
    points: wp.array(dtype=wp.vec3d),
    headings: wp.array(dtype=wp.float64),
    rows: wp.array(dtype=wp.int32),
    reaches: wp.array(dtype=wp.float64),
    toes_out: wp.array(dtype=wp.float64),
    outlines: wp.array(dtype=wp.vec2d, ndim=2),
    asides: wp.array(dtype=wp.float64),
    fallback: wp.float64,
    costs: wp.array(dtype=wp.float64, ndim=2),
    heights: wp.array(dtype=wp.float64, ndim=2),
    outward: wp.array(dtype=wp.float64, ndim=2),
):
    """Writes what it costs to stand at each point with each foot, how high, and how far from the way.

    Where a foot stands badly because of an edge beside it, places farther from the way or nearer to it are tried, the
    nearest first; before a riser, whose ends are out of reach, they would not help.
    """
    index, side = wp.tid()
    way = rows[index]
    sign = wp.float64(1.0 - 2.0 * float(side))
    heading = headings[index]
    across = wp.vec3d(sign * wp.cos(heading), wp.float64(0.0), -sign * wp.sin(heading))
    middle = points[index] + wp.vec3d(wp.float64(0.0), STEP_UP, wp.float64(0.0))
    yaw = heading + sign * toes_out[way]
    farthest = asides[asides.shape[0] - 1] * across
    found = feel_foothold(ground, limits, middle + reaches[way] * across, yaw, farthest, outlines, way, fallback)
    aside = wp.float64(0.0)
    if found.cost >= limits.bad and found.edged:
        for try_ in range(asides.shape[0]):
            reach = reaches[way] + asides[try_]
            if found.cost >= limits.bad and reach > wp.float64(0.0):
                other = feel_foothold(ground, limits, middle + reach * across, yaw, farthest, outlines, way, fallback)
                if other.cost < limits.bad:
                    found = other
                    aside = asides[try_]
                    found.cost += limits.aside * wp.abs(aside)
    costs[index, side] = wp.min(found.cost, limits.bad)
    heights[index, side] = found.height
    outward[index, side] = reaches[way] + aside


@wp.kernel(enable_backward=False)
def feel_walls(
    ground: GroundFaces,
    points: wp.array(dtype=wp.vec3d),
    headings: wp.array(dtype=wp.float64),
    reaches: wp.array(dtype=wp.float64),
    wall: wp.float64,
    walls: wp.array(dtype=wp.float64, ndim=2),
):
    """Writes the first of some distances from each point to the left and right at which ground rises as a wall."""
    index, side = wp.tid()
    sign = wp.float64(1.0 - 2.0 * float(side))
    across = wp.vec3d(sign * wp.cos(headings[index]), wp.float64(0.0), -sign * wp.sin(headings[index]))
    middle = points[index] + wp.vec3d(wp.float64(0.0), ROOM, wp.float64(0.0))
    found = bool(False)
    for place in range(reaches.shape[0]):
        if not found:
            rise, face = find_level(ground, middle + reaches[place] * across)
            if face >= 0 and rise <= wp.float64(0.0) and rise + ROOM > wall:
                found = True
                walls[index, side] = reaches[place]
