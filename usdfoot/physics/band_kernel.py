"""Warp functions of the banded system: every knot's six unknowns touch those of the knots before and after it.

Lower half by columns: entry (j + d, j) of the matrix is at [j, d], d = 0 .. 11.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["add_block", "solve_band"]

BAND = wp.constant(12)


@wp.func
def add_block(bands: wp.array2d(dtype=wp.float64), row: int, column: int, block: wp.mat33d):
    """Adds the lower half of a 3 x 3 block whose first entry is (row, column), row >= column."""
    for j in range(3):
        for i in range(3):
            offset = row + i - column - j
            if offset >= 0:
                bands[column + j, offset] = bands[column + j, offset] + block[i, j]


@wp.func
def solve_band(bands: wp.array2d(dtype=wp.float64), values: wp.array(dtype=wp.float64), first: int, end: int) -> bool:
    """Cholesky's solution of rows `first` to `end`, in place of `values`; whether the matrix is positive definite."""
    for j in range(first, end):
        pivot = bands[j, 0]
        if pivot <= wp.float64(0.0):
            return False
        inverse = wp.float64(1.0) / wp.sqrt(pivot)
        size = wp.min(BAND, end - j)
        for d in range(size):
            bands[j, d] = bands[j, d] * inverse
        for d in range(1, size):
            factor = bands[j, d]
            for e in range(d, size):
                bands[j + d, e - d] = bands[j + d, e - d] - bands[j, e] * factor
    for j in range(first, end):
        value = values[j] / bands[j, 0]
        values[j] = value
        for d in range(1, wp.min(BAND, end - j)):
            values[j + d] = values[j + d] - bands[j, d] * value
    for back in range(end - first):
        j = end - 1 - back
        value = values[j]
        for d in range(1, wp.min(BAND, end - j)):
            value = value - bands[j, d] * values[j + d]
        values[j] = value / bands[j, 0]
    return True
