"""The vertical height query of `Ground` as a Warp kernel."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["find_ground"]


@wp.kernel(enable_backward=False)
def find_ground(
    mesh: wp.uint64,
    corners: wp.array(dtype=wp.vec3d),
    limits: wp.array(dtype=wp.vec3d),
    margin: wp.float32,
    heights: wp.array(dtype=wp.float64),
    faces: wp.array(dtype=wp.int32),
):
    """Highest face at or below each limit, else the lowest above it.

    All faces whose bounds a thin vertical column touches are tested in float64, edges included, so a query on an edge
    or a vertex cannot slip between two faces as a ray may.
    """
    index = wp.tid()
    limit = limits[index]
    tolerance = wp.float64(1.0e-6)  # metres, and the same in barycentric coordinates
    zero = wp.float64(0.0)
    x = wp.float32(limit[0])
    z = wp.float32(limit[2])
    column = wp.mesh_query_aabb(mesh, wp.vec3(x - margin, -1.0e30, z - margin), wp.vec3(x + margin, 1.0e30, z + margin))
    best = wp.float64(1.0e30)  # above the limit; negative = below it
    best_face = wp.int32(-1)
    face = wp.int32(0)
    while wp.mesh_query_aabb_next(column, face):
        a = corners[3 * face] - limit
        b = corners[3 * face + 1] - limit
        c = corners[3 * face + 2] - limit
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
    heights[index] = limit[1] + best
    faces[index] = best_face
