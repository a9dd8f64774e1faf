"""Warp kernels of root velocities: gradient band influences, and weights tilted until they meet the wish."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["find_influences", "find_tilts"]

ROUNDS = wp.constant(12)
LONGEST_STEP = wp.constant(wp.float64(2.0))
"""Largest change of an exponent in one round of Newton's method."""


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


@wp.kernel(enable_backward=False)
def find_tilts(
    weights: wp.array2d(dtype=wp.float64),
    points: wp.array2d(dtype=wp.vec2d),
    wanted: wp.array(dtype=wp.vec2d),
    softness: wp.float64,
    tilted: wp.array2d(dtype=wp.float64),
):
    """Weights of each row as `tilt_weights` has them, by Newton's method on u."""
    row = wp.tid()
    tilt = wp.vec2d()
    for point in range(weights.shape[1]):
        tilted[row, point] = weights[row, point]
    for _ in range(ROUNDS):
        mean = wp.vec2d()
        spread = softness * softness * wp.identity(n=2, dtype=wp.float64)
        for point in range(weights.shape[1]):
            mean += tilted[row, point] * (points[row, point] - wanted[row])
        for point in range(weights.shape[1]):
            around = points[row, point] - wanted[row] - mean
            spread += tilted[row, point] * wp.outer(around, around)
        step = -(wp.inverse(spread) * (mean + softness * softness * tilt))
        largest = wp.float64(1.0e-12)
        for point in range(weights.shape[1]):
            if weights[row, point] > wp.float64(0.0):
                change = wp.abs(wp.dot(points[row, point] - wanted[row] - mean, step))
                largest = wp.max(largest, change)
        tilt += wp.min(wp.float64(1.0), LONGEST_STEP / largest) * step
        highest = wp.float64(-1.0e30)
        for point in range(weights.shape[1]):
            if weights[row, point] > wp.float64(0.0):
                highest = wp.max(highest, wp.dot(points[row, point] - wanted[row], tilt))
        total = wp.float64(0.0)
        for point in range(weights.shape[1]):
            if weights[row, point] > wp.float64(0.0):
                exponent = wp.dot(points[row, point] - wanted[row], tilt) - highest
                tilted[row, point] = weights[row, point] * wp.exp(exponent)
                total += tilted[row, point]
        for point in range(weights.shape[1]):
            tilted[row, point] = tilted[row, point] / total
