"""Feet near each other as a Warp kernel, one thread a cell of the ground."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["Stays", "find_pairs"]


@wp.struct
class Stays:
    """Feet in one place for a while, P of them, by cell of the ground and then by when they begin."""

    rows: wp.array(dtype=wp.int32)  # where each is in the table they come from
    begins: wp.array(dtype=wp.int64)  # first instant
    ends: wp.array(dtype=wp.int64)  # last one
    owners: wp.array(dtype=wp.int32)  # whose foot it is
    touched: wp.array(dtype=wp.bool)  # whether it is asked for
    points: wp.array(dtype=wp.vec3d)  # where it is [m]


@wp.func
def is_pair(stays: Stays, one: int, other: int, reach: wp.float64):
    """Whether two stays, of which the other begins during the first, are of two people and in reach of each other.

    Who begin at once meet twice, and count as one pair.
    """
    if stays.owners[one] == stays.owners[other] or not (stays.touched[one] or stays.touched[other]):
        return bool(False)
    if stays.begins[one] == stays.begins[other] and stays.rows[one] > stays.rows[other]:
        return bool(False)
    apart = stays.points[one] - stays.points[other]
    return bool(wp.dot(apart, apart) <= reach * reach)


@wp.kernel(enable_backward=False)
def find_pairs(
    stays: Stays,
    first: wp.array(dtype=wp.int32),
    around: wp.array(dtype=wp.int32, ndim=2),
    reach: wp.float64,
    places: wp.array(dtype=wp.int32),
    counts: wp.array(dtype=wp.int32),
    pairs: wp.array(dtype=wp.int32, ndim=2),
):
    """Counts, for each cell, the pairs of which the stay that begins first is in it; writes them where there is room.

    Args:
        stays: Of all feet.
        first: Stay of each cell, and how many there are, shape (C + 1,).
        around: The cells beside each, itself among them; -1 = nobody is there, shape (C, 9).
        reach: [m].
        places: Where the pairs of each cell are written, shape (C,).
        counts: Of pairs, shape (C,); changed.
        pairs: Rows of the table they come from, shape (K, 2); changed. None are written if it is empty.
    """
    cell = wp.tid()
    count = wp.int32(0)
    for side in range(around.shape[1]):
        beside = around[cell, side]
        if beside >= 0:
            begin = wp.int32(first[beside])
            end = first[beside + 1]
            for one in range(first[cell], first[cell + 1]):
                while begin < end and stays.begins[begin] < stays.begins[one]:
                    begin += 1
                other = wp.int32(begin)
                while other < end and stays.begins[other] <= stays.ends[one]:
                    if is_pair(stays, one, other, reach):
                        if pairs.shape[0] > 0:
                            pairs[places[cell] + count, 0] = stays.rows[one]
                            pairs[places[cell] + count, 1] = stays.rows[other]
                        count += 1
                    other += 1
    counts[cell] = count
