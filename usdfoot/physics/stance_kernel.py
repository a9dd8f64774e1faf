"""Warp functions of instants: which legs stand, where they press, where the ankles are and how weight is shared."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.contact_kernel import ContactArrays, ContactFooting, LegArrays, clamped
from usdfoot.physics.leg_kernel import AT_ONCE, comfortable_length, foot_pitch, pressing, rolled_ankle
from usdfoot.physics.yaw_kernel import latest_strike, row_of_foot

__all__ = ["StanceArrays", "find_instant", "find_instants"]

HEEL_OFF = wp.constant(wp.float64(0.6))
"""Part of the contact after which the foot is on its toes."""


@wp.struct
class StanceArrays:
    """Both legs at M instants, as in `Stance`; the last axis is (left, right)."""

    contacts: wp.array2d(dtype=wp.int32)
    standing: wp.array2d(dtype=wp.bool)
    leg_shares: wp.array2d(dtype=wp.float64)
    supports: wp.array2d(dtype=wp.vec3d)
    anchors: wp.array2d(dtype=wp.vec3d)
    nominal_lengths: wp.array2d(dtype=wp.float64)


@wp.func
def latest_load(footing: wp.array(dtype=ContactFooting), strike: int, end: int, time: wp.float64) -> int:
    """The last contact that has taken weight, which may be before its strike, when `strike` is the last that struck."""
    latest = strike
    while latest + 1 < end and footing[latest + 1].begin <= time:
        latest += 1
    return latest


@wp.func
def weight_at(footing: wp.array(dtype=ContactFooting), i: int, time: wp.float64) -> wp.float64:
    """Weight on the foot of contact i, to be divided by both feet's sum; 0 where it does not stand."""
    if time < footing[i].begin or time > footing[i].end:
        return wp.float64(0.0)
    taken = clamped((time - footing[i].begin) / footing[i].taking)
    left = clamped((footing[i].end - time) / footing[i].giving)
    return wp.max(wp.min(taken, left), AT_ONCE)


@wp.func
def find_leg(
    contacts: ContactArrays,
    legs: LegArrays,
    footing: wp.array(dtype=ContactFooting),
    stance: StanceArrays,
    m: int,
    side: int,
    time: wp.float64,
    body: wp.quatd,
):
    """Sets all of a leg at instant m but its share of the weight."""
    i = stance.contacts[m, side]
    strike = contacts.rows[i].strike
    progress = clamped((time - strike) / wp.max(contacts.rows[i].liftoff - strike, AT_ONCE))
    share = wp.float64(0.5)
    if legs.smooth:
        share = pressing(legs, footing, i, time)
    elif progress > HEEL_OFF:
        share = wp.float64(1.0)
    length = legs.nominal_length
    ankle = legs.ankles[side]
    if legs.play > wp.float64(0.0):
        length = comfortable_length(legs, footing, i, progress)
        ankle = rolled_ankle(ankle, legs.heel, foot_pitch(footing, i, progress))
    under = wp.vec3d(wp.float64(0.0), wp.float64(0.0), legs.heel + (legs.toe - legs.heel) * share)
    place = contacts.rows[i].position
    turn = footing[i].frame
    stance.standing[m, side] = time >= footing[i].begin and time <= footing[i].end
    stance.supports[m, side] = place + wp.quat_rotate(turn, under)
    stance.anchors[m, side] = place + wp.quat_rotate(turn, ankle) - wp.quat_rotate(body, legs.hips[side])
    stance.nominal_lengths[m, side] = length


@wp.func
def find_instant(
    contacts: ContactArrays,
    legs: LegArrays,
    footing: wp.array(dtype=ContactFooting),
    stance: StanceArrays,
    m: int,
    agent: int,
    time: wp.float64,
    body: wp.quatd,
):
    """Sets both legs at instant m of an agent whose body is turned by `body`."""
    first = contacts.agents[agent].first
    end = contacts.agents[agent].end
    latest = latest_load(footing, latest_strike(contacts, first, end, time), end, time)
    total = wp.float64(0.0)
    for side in range(2):
        i = row_of_foot(contacts, latest, first, end, side)
        stance.contacts[m, side] = i
        weight = weight_at(footing, i, time)
        stance.leg_shares[m, side] = weight
        total = total + weight
        find_leg(contacts, legs, footing, stance, m, side, time, body)
    for side in range(2):
        share = stance.leg_shares[m, side] / wp.max(total, AT_ONCE)
        stance.leg_shares[m, side] = share / (legs.size * legs.size)


@wp.kernel(enable_backward=False)
def find_instants(
    contacts: ContactArrays,
    legs: LegArrays,
    footing: wp.array(dtype=ContactFooting),
    agents: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
    bodies: wp.array(dtype=wp.quatd),
    stance: StanceArrays,
):
    """Sets both legs at all instants, one thread an instant."""
    m = wp.tid()
    find_instant(contacts, legs, footing, stance, m, agents[m], times[m], bodies[m])
