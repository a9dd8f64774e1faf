"""Warp functions of the banded system: every knot's position and velocity touch those of its neighbours.

Symmetric, in blocks of 3 x 3, lower half by columns: block (j + d, j) is at [j, d]. Columns are positions and
velocities of the knots in turn; a position touches three rows below it, a velocity two.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["BAND", "solve_band"]

BAND = wp.constant(4)
"""Most blocks of a column."""


@wp.func
def positive(matrix: wp.mat33d) -> bool:
    """Whether a symmetric matrix is positive definite (Sylvester)."""
    minor = matrix[0, 0] * matrix[1, 1] - matrix[1, 0] * matrix[1, 0]
    zero = wp.float64(0.0)
    return matrix[0, 0] > zero and minor > zero and wp.determinant(matrix) > zero


@wp.func
def solve_band(blocks: wp.array2d(dtype=wp.mat33d), values: wp.array(dtype=wp.vec3d), first: int, end: int) -> bool:
    """Solution of rows `first` to `end` by block elimination, in place of `values`; whether it is positive definite."""
    for j in range(first, end):
        if not positive(blocks[j, 0]):
            return False
        inverse = wp.inverse(blocks[j, 0])
        blocks[j, 0] = inverse
        value = values[j]
        size = wp.min(BAND - (j - first) % 2, end - j)
        for d in range(1, size):
            factor = blocks[j, d] * inverse
            for e in range(d, size):
                blocks[j + d, e - d] = blocks[j + d, e - d] - blocks[j, e] * wp.transpose(factor)
            values[j + d] = values[j + d] - factor * value
    for back in range(end - first):
        j = end - 1 - back
        value = values[j]
        for d in range(1, wp.min(BAND - (j - first) % 2, end - j)):
            value = value - wp.transpose(blocks[j, d]) * values[j + d]
        values[j] = blocks[j, 0] * value
    return True
