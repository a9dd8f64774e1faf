"""The search for treads as a Warp kernel, one thread a way."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["choose_treads"]


@wp.kernel(enable_backward=False)
def choose_treads(
    first: wp.array(dtype=wp.int32),
    ends: wp.array(dtype=wp.int32, ndim=2),
    offsets: wp.array(dtype=wp.int32, ndim=2),
    spacings: wp.array(dtype=wp.float64),
    highs: wp.array(dtype=wp.float64),
    wanted: wp.array(dtype=wp.float64),
    costs: wp.array(dtype=wp.float64, ndim=2),
    heights: wp.array(dtype=wp.float64, ndim=2),
    support: wp.int32,
    least: wp.float64,
    totals: wp.array(dtype=wp.float64, ndim=2),
    before: wp.array(dtype=wp.int32, ndim=2),
    taken: wp.array(dtype=wp.bool),
):
    """Marks the samples on the cheapest way from the first end to the second, which every step leads on along."""
    way = wp.tid()
    start = first[way] + ends[way, 0]
    goal = first[way] + ends[way, 1]
    totals[start, support] = wp.float64(0.0)
    for sample in range(start + offsets[way, 0], first[way + 1]):
        for side in range(2):  # the foot that steps here
            top = heights[sample, side]
            for offset in range(1, offsets[way, 0]):
                top = wp.max(top, wp.max(heights[sample - offset, 0], heights[sample - offset, 1]))
            for offset in range(offsets[way, 0], wp.min(offsets[way, 1], sample - start) + 1):
                other = sample - offset
                length = wp.float64(offset) * spacings[way] * wp.float64(2.0) / (wanted[sample] + wanted[other])
                stretch = length - wp.float64(1.0)
                lower = wp.min(heights[sample, side], heights[other, 1 - side])
                rise = (wp.max(top, heights[other, 1 - side]) - lower) / highs[way]
                top = wp.max(top, wp.max(heights[other, 0], heights[other, 1]))
                cost = least + stretch * stretch + rise * rise * rise * rise + costs[sample, side]
                if totals[other, 1 - side] + cost < totals[sample, side]:
                    totals[sample, side] = totals[other, 1 - side] + cost
                    before[sample, side] = other
    side = wp.int32(0)
    if totals[goal, 1] < totals[goal, 0]:
        side = wp.int32(1)
    sample = goal
    taken[goal] = True
    while before[sample, side] > start:
        sample = before[sample, side]
        side = 1 - side
        taken[sample] = True
