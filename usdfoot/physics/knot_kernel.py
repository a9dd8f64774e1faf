"""Warp functions of knots: where the weight changes feet, where flights begin and at the end ([P] Figure 6)."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.contact_kernel import ContactArrays, ContactFooting

__all__ = ["KnotOptions", "count_knots", "lay_agent_knots", "write_knots"]

SHORTEST_SEGMENT = wp.constant(wp.float64(0.02))
"""Events closer than this share a knot [s]."""
ROUNDING = wp.constant(wp.float64(1.0e-9))


@wp.struct
class KnotOptions:
    """How steps are divided."""

    parts: int  # segments a step on the ground
    longest: wp.float64  # longer segments are divided [s]


@wp.func
def divide(
    times: wp.array(dtype=wp.float64), at: int, begin: wp.float64, end: wp.float64, least: int, longest: wp.float64
) -> int:
    """Writes knots from `begin` on, in equal parts up to `end` without it; gives back where the next one belongs.

    There are at least `least` parts, as far as they can last SHORTEST_SEGMENT, and more where one would be too long.
    Nothing is written beyond the end of `times`.
    """
    length = end - begin
    possible = wp.max(int(length / SHORTEST_SEGMENT), 1)
    parts = wp.max(int(wp.ceil(length / longest - ROUNDING)), wp.min(least, possible))
    for part in range(parts):
        if at + part < times.shape[0]:
            times[at + part] = begin + wp.float64(part) * (length / wp.float64(parts))
    return at + parts


@wp.func
def lay_agent_knots(
    contacts: ContactArrays,
    footing: wp.array(dtype=ContactFooting),
    options: KnotOptions,
    agent: int,
    times: wp.array(dtype=wp.float64),
    at: int,
) -> int:
    """Writes an agent's knots from index `at` on; gives back the index after its last.

    A flight is the time before a strike in which neither foot stands; it is one segment, and so is what is left of the
    double stance in which the motion begins. Events closer to the one before or to an end of the motion than
    SHORTEST_SEGMENT have no knot of their own.
    """
    first = contacts.agents[agent].first
    start = contacts.agents[agent].start
    end = contacts.agents[agent].finish
    knot = start
    least = options.parts
    latest = start
    for i in range(first, contacts.agents[agent].end):
        for kind in range(2):
            event = footing[i].change
            wanted = options.parts
            happens = bool(True)
            if kind == 0:  # the liftoff before the strike
                happens = i > first
                if happens:
                    event = wp.max(contacts.rows[i - 1].liftoff, contacts.rows[wp.max(i - 2, first)].liftoff)
                    wanted = 1
                    happens = event < contacts.rows[i].strike
            if happens and event > start + SHORTEST_SEGMENT and event < end - SHORTEST_SEGMENT:
                if event - latest >= SHORTEST_SEGMENT:
                    if contacts.rows[i].strike <= start:
                        least = 1
                    at = divide(times, at, knot, event, least, options.longest)
                    knot = event
                    least = wanted
                latest = event
    at = divide(times, at, knot, end, least, options.longest)
    if at < times.shape[0]:
        times[at] = end
    return at + 1


@wp.kernel(enable_backward=False)
def count_knots(
    contacts: ContactArrays,
    footing: wp.array(dtype=ContactFooting),
    options: KnotOptions,
    nowhere: wp.array(dtype=wp.float64),
    counts: wp.array(dtype=wp.int32),
):
    """Number of each agent's knots, one thread an agent; `nowhere` is empty."""
    agent = wp.tid()
    counts[agent] = lay_agent_knots(contacts, footing, options, agent, nowhere, 0)


@wp.kernel(enable_backward=False)
def write_knots(
    contacts: ContactArrays,
    footing: wp.array(dtype=ContactFooting),
    options: KnotOptions,
    starts: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
):
    """Times of all knots, each agent's from its index `starts` on, one thread an agent."""
    agent = wp.tid()
    lay_agent_knots(contacts, footing, options, agent, times, starts[agent])
