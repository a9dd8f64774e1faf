"""Warp functions of the body's heading: the moving mean of both feet's, over time ([P] 2.6)."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.contact_kernel import ContactArrays, ContactFooting

__all__ = ["body_yaw", "find_body_yaws", "latest_strike", "row_of_foot", "yaw_turn"]


@wp.func
def latest_strike(contacts: ContactArrays, first: int, end: int, time: wp.float64) -> int:
    """The last of the contacts `first` to `end` that has struck, or the first."""
    low = first
    high = end
    while high - low > 1:
        middle = (low + high) // 2
        if contacts.rows[middle].strike <= time:
            low = middle
        else:
            high = middle
    return low


@wp.func
def row_of_foot(contacts: ContactArrays, latest: int, first: int, end: int, side: int) -> int:
    """The contact of a foot when `latest` is the last begun: that or the one before, the one after at the begin."""
    if contacts.rows[latest].side == side:
        return latest
    if latest > first:
        return latest - 1
    return wp.min(latest + 1, end - 1)


@wp.func
def yaw_integral(
    contacts: ContactArrays, footing: wp.array(dtype=ContactFooting), agent: int, time: wp.float64
) -> wp.float64:
    """Integral of both feet's yaw over time up to `time`, from wherever each began [rad s]."""
    first = contacts.agents[agent].first
    end = contacts.agents[agent].end
    latest = latest_strike(contacts, first, end, time)
    total = wp.float64(0.0)
    for side in range(2):
        i = row_of_foot(contacts, latest, first, end, side)
        swing = footing[i].swing
        swung = wp.max(time - contacts.rows[i].liftoff, wp.float64(0.0))
        share = wp.min(swung / swing, wp.float64(1.0))
        turned = swing * share * share * share * (wp.float64(1.0) - wp.float64(0.5) * share)
        turned = turned + wp.max(swung - swing, wp.float64(0.0))
        total = total + footing[i].integral + footing[i].heading * (time - contacts.rows[i].strike)
        total = total + footing[i].turn * turned
    return total


@wp.func
def body_yaw(
    contacts: ContactArrays, footing: wp.array(dtype=ContactFooting), agent: int, time: wp.float64, window: wp.float64
) -> wp.float64:
    """Mean yaw of both feet over the window around a time, continuous [rad]."""
    half = wp.float64(0.5) * window
    later = yaw_integral(contacts, footing, agent, time + half)
    earlier = yaw_integral(contacts, footing, agent, time - half)
    return (later - earlier) / (wp.float64(2.0) * window)


@wp.func
def yaw_turn(yaw: wp.float64) -> wp.quatd:
    """Rotation about +Y."""
    half = wp.float64(0.5) * yaw
    return wp.quatd(wp.float64(0.0), wp.sin(half), wp.float64(0.0), wp.cos(half))


@wp.kernel(enable_backward=False)
def find_body_yaws(
    contacts: ContactArrays,
    footing: wp.array(dtype=ContactFooting),
    agents: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
    window: wp.float64,
    yaws: wp.array(dtype=wp.float64),
):
    """Yaws of the body, one thread a time."""
    f = wp.tid()
    yaws[f] = body_yaw(contacts, footing, agents[f], times[f], window)
