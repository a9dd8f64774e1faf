"""Warp kernel of root velocities: the influences of gradient bands."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["find_influences"]


@wp.kernel(enable_backward=False)
def find_influences(
    constants: wp.array2d(dtype=wp.float64),
    slopes: wp.array3d(dtype=wp.float64),
    bearings: wp.array2d(dtype=wp.float64),
    others: wp.int32,
    polar: wp.bool,
    queries: wp.array2d(dtype=wp.float64),
    influences: wp.array2d(dtype=wp.float64),
):
    """Influence of every vertex on every query; a vertex is done with as soon as one band leaves it nothing.

    `queries` are (N, 3): bearing, how much it counts, speed; Cartesian x, 0, z. `others`: bands of a vertex.
    """
    query, vertex = wp.tid()
    half = wp.float64(wp.HALF_PI)
    first = queries[query, 0]
    second = queries[query, 2]
    least = wp.float64(1.0e30)
    band = wp.int32(0)
    while band < others and least > wp.float64(0.0):
        along = first
        if polar:
            beyond = wp.abs(wp.abs(first - bearings[vertex, band]) - wp.float64(2.0) * half) - half
            along = beyond * queries[query, 1]
        influence = constants[vertex, band] + along * slopes[0, vertex, band] + second * slopes[1, vertex, band]
        least = wp.min(least, influence)
        band += wp.int32(1)
    influences[query, vertex] = wp.max(least, wp.float64(0.0))
