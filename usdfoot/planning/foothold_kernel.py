"""What either foot would stand on along ways, as a Warp kernel, one thread a foot."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.model.ground_kernel import GroundFaces, find_level

__all__ = ["FootholdLimits", "feel_ground"]

STEP_UP = wp.constant(wp.float64(0.5))
"""Ground so far above the way, or above the ball, is still the same level [m]."""


@wp.struct
class FootholdLimits:
    """What of the ground under a sole costs what; see `planning/footholds.py`."""

    flattest: wp.float64  # upward part of the normal of ground that is too steep
    pokes: wp.float64  # [m]
    edge: wp.float64  # [m]
    hangs: wp.float64  # [m]
    hanging: wp.float64
    bad: wp.float64


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


@wp.kernel(enable_backward=False)
def feel_ground(
    ground: GroundFaces,
    limits: FootholdLimits,
    points: wp.array(dtype=wp.vec3d),
    headings: wp.array(dtype=wp.float64),
    rows: wp.array(dtype=wp.int32),
    widths: wp.array(dtype=wp.float64),
    toes_out: wp.array(dtype=wp.float64),
    outlines: wp.array(dtype=wp.vec2d, ndim=2),
    fallback: wp.float64,
    costs: wp.array(dtype=wp.float64, ndim=2),
    heights: wp.array(dtype=wp.float64, ndim=2),
):
    """Writes what it costs to stand at each point with each foot (bad as soon as it is impossible), and how high."""
    index, side = wp.tid()
    way = rows[index]
    outward = wp.float64(1.0 - 2.0 * float(side))
    zero = wp.float64(0.0)
    heading = headings[index]
    reach = wp.float64(0.5) * widths[way] * outward
    limit = points[index] + wp.vec3d(reach * wp.cos(heading), STEP_UP, -reach * wp.sin(heading))
    rise, face = find_level(ground, limit)
    cost = limits.bad
    height = fallback
    if face >= 0:
        height = limit[1] + rise
        normal = ground.normals[face]
        if ground.walkable[face] and normal[1] >= limits.flattest:
            cost = zero
            ball = wp.vec3d(limit[0], height, limit[2])
            yaw = heading + outward * toes_out[way]
            for place in range(outlines.shape[1]):
                if cost < limits.bad:
                    across = outlines[way, place][0]
                    ahead = outlines[way, place][1]
                    offset = wp.vec3d(
                        across * wp.cos(yaw) + ahead * wp.sin(yaw), zero, ahead * wp.cos(yaw) - across * wp.sin(yaw)
                    )
                    cost += outline_cost(ground, limits, ball, normal, offset, across == zero)
    costs[index, side] = wp.min(cost, limits.bad)
    heights[index, side] = height
