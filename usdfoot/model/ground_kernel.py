"""The vertical height queries of `Ground` as Warp kernels."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["GroundFaces", "find_ground", "find_level", "follow_ground"]


@wp.struct
class GroundFaces:
    """The faces that are no walls, around the mesh's centre."""

    mesh: wp.uint64
    corners: wp.array(dtype=wp.vec3d)  # three a face
    normals: wp.array(dtype=wp.vec3d)  # upward, unit
    walkable: wp.array(dtype=wp.bool)
    margin: wp.float32  # [m]


@wp.func
def find_level(ground: GroundFaces, limit: wp.vec3d):
    """Highest face at or below a limit, else the lowest above it: its height above the limit, and which (-1 = none).

    All faces whose bounds a thin vertical column touches are tested in float64, edges included, so a query on an edge
    or a vertex cannot slip between two faces as a ray may.
    """
    tolerance = wp.float64(1.0e-6)  # metres, and the same in barycentric coordinates
    zero = wp.float64(0.0)
    x = wp.float32(limit[0])
    z = wp.float32(limit[2])
    margin = ground.margin
    column = wp.mesh_query_aabb(
        ground.mesh, wp.vec3(x - margin, -1.0e30, z - margin), wp.vec3(x + margin, 1.0e30, z + margin)
    )
    best = wp.float64(1.0e30)  # above the limit; negative = below it
    best_face = wp.int32(-1)
    face = wp.int32(0)
    while wp.mesh_query_aabb_next(column, face):
        a = ground.corners[3 * face] - limit
        b = ground.corners[3 * face + 1] - limit
        c = ground.corners[3 * face + 2] - limit
        area_a = b[0] * c[2] - b[2] * c[0]
        area_b = c[0] * a[2] - c[2] * a[0]
        area_c = a[0] * b[2] - a[2] * b[0]
        area = area_a + area_b + area_c
        weight_a = area_a / area
        weight_b = area_b / area
        weight_c = area_c / area
        if wp.min(weight_a, wp.min(weight_b, weight_c)) >= -tolerance:
            weight_a = wp.max(weight_a, zero)
            weight_b = wp.max(weight_b, zero)
            weight_c = wp.max(weight_c, zero)
            rise = (weight_a * a[1] + weight_b * b[1] + weight_c * c[1]) / (weight_a + weight_b + weight_c)
            nearer = rise < best - tolerance  # above the limit the lowest, below it the highest
            if rise <= tolerance:
                nearer = best > tolerance or rise > best + tolerance
            if nearer or (wp.abs(rise - best) <= tolerance and face < best_face):
                best = rise
                best_face = face
    return best, best_face


@wp.kernel(enable_backward=False)
def find_ground(
    ground: GroundFaces,
    limits: wp.array(dtype=wp.vec3d),
    heights: wp.array(dtype=wp.float64),
    faces: wp.array(dtype=wp.int32),
):
    """The ground at each limit, one thread a point."""
    index = wp.tid()
    limit = limits[index]
    rise, face = find_level(ground, limit)
    heights[index] = limit[1] + rise
    faces[index] = face


@wp.kernel(enable_backward=False)
def follow_ground(
    ground: GroundFaces,
    points: wp.array(dtype=wp.vec3d),
    first: wp.array(dtype=wp.int32),
    step_up: wp.float64,
    heights: wp.array(dtype=wp.float64),
    faces: wp.array(dtype=wp.int32),
):
    """The ground along ways of points, one thread a way: each looked for from the level before it."""
    way = wp.tid()
    level = points[first[way]][1]
    for index in range(first[way], first[way + 1]):
        point = points[index]
        rise, face = find_level(ground, wp.vec3d(point[0], level + step_up, point[2]))
        height = level
        if face >= 0:
            height = level + step_up + rise
            if index == first[way] or wp.abs(height - level) <= step_up:
                level = height
        heights[index] = height
        faces[index] = face
