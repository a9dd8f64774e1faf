"""The search for treads as a Warp kernel, one thread a way."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["choose_treads"]

CHECKS = wp.constant(6)
"""Pieces of a swing between which walls are looked for."""


@wp.func
def twist(
    stride: wp.vec2d,
    before: wp.vec2d,
    after: wp.vec2d,
    turn: wp.float64,
    outward: wp.float64,
    width: wp.float64,
    crossing: wp.float64,
    easy: wp.float64,
) -> wp.float64:
    """What a step between two samples costs for feet that cross or turn far.

    Args:
        stride: From sample to sample (x, z) [m].
        before: To the left of the way at the sample before, unit.
        after: The same at the sample stepped to.
        turn: Of the way's heading [rad].
        outward: 1 = the left foot steps, -1 = the right.
        width: Between the feet across the way [m].
        crossing: Distance on the other foot's side that costs 1 [m].
        easy: Turn that costs nothing [rad]; as much again costs 1.
    """
    zero = wp.float64(0.0)
    half = wp.float64(0.5)
    turned = wp.max(wp.abs(turn) - easy, zero) / easy
    square = half + half * wp.dot(before, after)  # of the cosine of half the turn
    apart = half * outward * wp.dot(stride, before + after) + width * square
    crossed = zero
    if apart < zero:  # across the heading in the middle of the step
        crossed = -apart / wp.sqrt(wp.max(square, wp.float64(1.0e-6))) / crossing
    return crossed * crossed + turned * turned


@wp.func
def graze(
    points: wp.array(dtype=wp.vec2d),
    across: wp.array(dtype=wp.vec2d),
    widths: wp.array(dtype=wp.float64, ndim=2),
    walls: wp.array(dtype=wp.float64, ndim=2),
    before: int,
    after: int,
    side: int,
    grazed: wp.float64,
) -> wp.float64:
    """What a foot's straight swing between two samples costs for walls beside the way that it leads through."""
    half = wp.float64(0.5 - float(side))
    leaves = points[before] + half * widths[before, side] * across[before]
    lands = points[after] + half * widths[after, side] * across[after]
    deepest = wp.float64(0.0)
    for part in range(1, CHECKS):
        sample = before + part * (after - before) / CHECKS
        share = wp.float64(sample - before) / wp.float64(after - before)
        place = leaves + share * (lands - leaves) - points[sample]
        left = wp.dot(place, across[sample])
        deepest = wp.max(deepest, wp.max(left - walls[sample, 0], -left - walls[sample, 1]))
    return deepest * deepest / (grazed * grazed)


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
    points: wp.array(dtype=wp.vec2d),
    headings: wp.array(dtype=wp.float64),
    across: wp.array(dtype=wp.vec2d),
    widths: wp.array(dtype=wp.float64, ndim=2),
    walls: wp.array(dtype=wp.float64, ndim=2),
    crossings: wp.array(dtype=wp.float64),
    easy_turn: wp.float64,
    grazed: wp.float64,
    support: wp.int32,
    least: wp.float64,
    bad: wp.float64,
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
                stands = costs[sample, side]
                if stands >= bad:  # by the way of the step: where all ground is bad, longer steps are no fewer of them
                    stands *= wp.max(length, wp.float64(1.0))
                cost = least + stretch * stretch + rise * rise * rise * rise + stands
                if totals[other, 1 - side] + cost < totals[sample, side]:
                    cost += twist(
                        points[sample] - points[other],
                        across[other],
                        across[sample],
                        headings[sample] - headings[other],
                        wp.float64(1.0 - 2.0 * float(side)),
                        wp.float64(0.5) * (widths[sample, side] + widths[other, 1 - side]),
                        crossings[way],
                        easy_turn,
                    )
                if totals[other, 1 - side] + cost < totals[sample, side]:
                    swung = wp.max(before[other, 1 - side], start)
                    cost += graze(points, across, widths, walls, swung, sample, side, grazed)
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
