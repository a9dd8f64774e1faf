"""The search for treads as a Warp kernel, one thread a way."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["TreadWays", "choose_treads"]

CHECKS = wp.constant(6)
"""Pieces of a swing between which walls are looked for."""


@wp.struct
class TreadWays:
    """P ways of M samples in all, one after the other, on which treads are chosen; see `planning/footholds.py`."""

    first: wp.array(dtype=wp.int32)  # sample of each way, (P + 1)
    ends: wp.array(dtype=wp.int32, ndim=2)  # samples within each way where the feet stand first and last
    offsets: wp.array(dtype=wp.int32, ndim=2)  # fewest and most samples of a step
    spacings: wp.array(dtype=wp.float64)  # [m]
    highs: wp.array(dtype=wp.float64)  # rise that costs 1 [m]
    crossings: wp.array(dtype=wp.float64)  # distance on the other foot's side that costs 1 [m]
    wanted: wp.array(dtype=wp.float64)  # length of a step at each sample [m]
    points: wp.array(dtype=wp.vec2d)
    headings: wp.array(dtype=wp.float64)
    across: wp.array(dtype=wp.vec2d)  # to the left, unit
    costs: wp.array(dtype=wp.float64, ndim=2)  # of either foot there
    heights: wp.array(dtype=wp.float64, ndim=2)  # [m]
    tops: wp.array(dtype=wp.float64)  # of the higher foot [m]
    widths: wp.array(dtype=wp.float64, ndim=2)  # twice the distance of the foot from the way [m]
    walls: wp.array(dtype=wp.float64, ndim=2)  # to the left and right [m]
    walled: wp.array(dtype=wp.int32)  # how many samples up to each have a wall
    least: wp.float64  # cost of a step
    bad: wp.float64  # cost of a place where no foot can stand
    easy_turn: wp.float64  # that costs nothing [rad]
    grazed: wp.float64  # depth of a swing through a wall that costs 1 [m]


@wp.func
def twist(ways: TreadWays, way: int, before: int, after: int, side: int) -> wp.float64:
    """What a step of one foot between two samples costs for feet that cross or turn far."""
    zero = wp.float64(0.0)
    half = wp.float64(0.5)
    turn = wp.abs(ways.headings[after] - ways.headings[before])
    turned = wp.max(turn - ways.easy_turn, zero) / ways.easy_turn
    across = ways.across[before] + ways.across[after]
    square = half + half * wp.dot(ways.across[before], ways.across[after])  # of the cosine of half the turn
    outward = wp.float64(1.0 - 2.0 * float(side))
    width = half * (ways.widths[after, side] + ways.widths[before, 1 - side])
    apart = half * outward * wp.dot(ways.points[after] - ways.points[before], across) + width * square
    crossed = zero
    if apart < zero:  # across the heading in the middle of the step
        crossed = -apart / wp.sqrt(wp.max(square, wp.float64(1.0e-6))) / ways.crossings[way]
    return crossed * crossed + turned * turned


@wp.func
def graze(ways: TreadWays, before: int, after: int, side: int) -> wp.float64:
    """What a foot's straight swing between two samples costs for walls beside the way that it leads through."""
    half = wp.float64(0.5 - float(side))
    leaves = ways.points[before] + half * ways.widths[before, side] * ways.across[before]
    lands = ways.points[after] + half * ways.widths[after, side] * ways.across[after]
    deepest = wp.float64(0.0)
    for part in range(1, CHECKS):
        sample = before + part * (after - before) / CHECKS
        share = wp.float64(sample - before) / wp.float64(after - before)
        place = leaves + share * (lands - leaves) - ways.points[sample]
        left = wp.dot(place, ways.across[sample])
        deepest = wp.max(deepest, wp.max(left - ways.walls[sample, 0], -left - ways.walls[sample, 1]))
    return deepest * deepest / (ways.grazed * ways.grazed)


@wp.func
def lead_to(
    ways: TreadWays,
    way: int,
    sample: int,
    side: int,
    start: int,
    totals: wp.array(dtype=wp.float64, ndim=2),
    before: wp.array(dtype=wp.int32, ndim=2),
):
    """Writes the cheapest way to a sample that ends with a step of one foot."""
    top = ways.heights[sample, side]
    for offset in range(1, ways.offsets[way, 0]):
        top = wp.max(top, ways.tops[sample - offset])
    for offset in range(ways.offsets[way, 0], wp.min(ways.offsets[way, 1], sample - start) + 1):
        other = sample - offset
        if totals[other, 1 - side] + ways.least < totals[sample, side]:
            wanted = ways.wanted[sample] + ways.wanted[other]
            length = wp.float64(offset) * ways.spacings[way] * wp.float64(2.0) / wanted
            stretch = length - wp.float64(1.0)
            lower = wp.min(ways.heights[sample, side], ways.heights[other, 1 - side])
            rise = (wp.max(top, ways.heights[other, 1 - side]) - lower) / ways.highs[way]
            stands = ways.costs[sample, side]
            if stands >= ways.bad:  # by the way of the step: where all ground is bad, longer steps are no fewer of them
                stands *= wp.max(length, wp.float64(1.0))
            cost = ways.least + stretch * stretch + rise * rise * rise * rise + stands
            if totals[other, 1 - side] + cost < totals[sample, side]:
                cost += twist(ways, way, other, sample, side)
            if totals[other, 1 - side] + cost < totals[sample, side]:
                swung = wp.max(before[other, 1 - side], start)
                if ways.walled[swung] < ways.walled[sample]:
                    cost += graze(ways, swung, sample, side)
            if totals[other, 1 - side] + cost < totals[sample, side]:
                totals[sample, side] = totals[other, 1 - side] + cost
                before[sample, side] = other
        top = wp.max(top, ways.tops[other])


@wp.kernel(enable_backward=False)
def choose_treads(
    ways: TreadWays,
    support: wp.int32,
    totals: wp.array(dtype=wp.float64, ndim=2),
    before: wp.array(dtype=wp.int32, ndim=2),
    taken: wp.array(dtype=wp.bool),
):
    """Marks the samples on the cheapest way from the first end to the second, which every step leads on along."""
    way = wp.tid()
    start = ways.first[way] + ways.ends[way, 0]
    goal = ways.first[way] + ways.ends[way, 1]
    totals[start, support] = wp.float64(0.0)
    for sample in range(start + ways.offsets[way, 0], goal + 1):
        for side in range(2):
            lead_to(ways, way, sample, side, start, totals, before)
    side = wp.int32(0)
    if totals[goal, 1] < totals[goal, 0]:
        side = wp.int32(1)
    sample = goal
    taken[goal] = True
    while before[sample, side] > start:
        sample = before[sample, side]
        side = 1 - side
        taken[sample] = True
