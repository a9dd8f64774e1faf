"""Warp functions that put the pelvis where the legs reach their feet: down first, then across the ground."""

from __future__ import annotations

import warp as wp

from usdfoot.engine.easing import ramp, soft_positive
from usdfoot.engine.legs import Leg, LegRig

__all__ = ["MOST_DROP", "longest_leg", "moved_leg", "pelvis_offset"]

MOST_DROP = wp.constant(0.35)
"""Most that the pelvis comes down for a leg, over the leg's length."""
MOST_SINK = wp.constant(1.3)
"""The pelvis comes down for a leg by at most so much of what the leg is too short by, the rest is across the ground."""
JOIN = wp.constant(0.004)
"""Width over which a drop comes in, and two drops pass into each other [m]."""
CAPPED = wp.constant(0.002)
"""Half the width over which MOST_SINK comes in [m]."""
PULLED = wp.constant(0.005)
"""Half the width over which the pull across the ground comes in [m]."""
PULLS = wp.constant(5)
"""Rounds in which the pelvis is moved towards both feet, beyond the first."""


@wp.func
def longest_leg(rig: LegRig, leg: Leg) -> float:
    """Distance from hip to ankle that the leg may be stretched to [m]."""
    return rig.reach * (wp.length(leg.knee - leg.hip) + wp.length(leg.ankle - leg.knee))


@wp.func
def needed_drop(rig: LegRig, leg: Leg, ankle: wp.vec3f) -> float:
    """How far the pelvis must come down for the leg to reach the ankle's place, as far as it may.

    Downwards alone a leg that lies flat would pull the pelvis down at once.
    """
    longest = longest_leg(rig, leg)
    offset = leg.hip - ankle
    flat = offset[0] * offset[0] + offset[2] * offset[2]
    height = wp.sqrt(wp.max(longest * longest - flat, 0.0))
    drop = wp.min(offset[1] - height, MOST_DROP * longest)
    missing = wp.max(wp.length(offset) - longest, 0.0)
    return drop - ramp(wp.max(drop, 0.0) - MOST_SINK * missing - CAPPED, CAPPED)


@wp.func
def lowered(eased: float, first: float, second: float) -> wp.vec3f:
    """Offset down by the smooth larger one of two drops on top of an eased one [m]."""
    return wp.vec3f(0.0, -eased - second - soft_positive(first - second, JOIN), 0.0)


@wp.func
def leg_pull(rig: LegRig, leg: Leg, offset: wp.vec3f, ankle: wp.vec3f) -> wp.vec3f:
    """How far across the ground a pelvis that is `offset` must still move for the leg to reach the ankle's place."""
    longest = longest_leg(rig, leg)
    apart = ankle - leg.hip - offset
    flat = wp.sqrt(apart[0] * apart[0] + apart[2] * apart[2])
    span = wp.sqrt(wp.max(longest * longest - apart[1] * apart[1], 0.0))
    share = ramp(flat - span, PULLED) / wp.max(flat, 1.0e-3)
    return wp.vec3f(share * apart[0], 0.0, share * apart[2])


@wp.func
def pelvis_offset(
    rig: LegRig,
    left: Leg,
    right: Leg,
    left_ankle: wp.vec3f,
    right_ankle: wp.vec3f,
    left_hold: float,
    right_hold: float,
    eased: float,
) -> wp.vec3f:
    """Where the pelvis goes for the legs to reach the ankles' places, as far as it keeps to what each foot needs.

    Down, and where it is as low as it may be towards the foot, between both feet if need be. All such places of one
    foot are a convex set, so that between those of both feet and those of one that one is still reached.

    Args:
        rig: Both legs.
        left: As blended, likewise `right`.
        right: Leg.
        left_ankle: Where it has to be, likewise `right_ankle`.
        right_ankle: Place.
        left_hold: How far the pelvis keeps to the foot, 0..1, likewise `right_hold`.
        right_hold: Share.
        eased: How far it is lowered anyway [m].
    """
    first = soft_positive(needed_drop(rig, left, left_ankle) - eased, JOIN)
    second = soft_positive(needed_drop(rig, right, right_ankle) - eased, JOIN)
    for_none = lowered(eased, 0.0, 0.0)
    for_left = lowered(eased, first, 0.0)
    for_right = lowered(eased, 0.0, second)
    for_both = lowered(eased, first, second)
    for_left += leg_pull(rig, left, for_left, left_ankle)
    for_right += leg_pull(rig, right, for_right, right_ankle)
    before = for_both
    pull = leg_pull(rig, left, before, left_ankle) + leg_pull(rig, right, before, right_ankle)
    for_both += pull
    if wp.length_sq(pull) > 0.0:
        for _ in range(PULLS):
            before = for_both
            for_both += leg_pull(rig, left, before, left_ankle) + leg_pull(rig, right, before, right_ankle)
    offset = (1.0 - left_hold) * (1.0 - right_hold) * for_none
    offset += left_hold * (1.0 - right_hold) * for_left + right_hold * (1.0 - left_hold) * for_right
    return offset + 0.5 * left_hold * right_hold * (before + for_both)


@wp.func
def moved_leg(leg: Leg, offset: wp.vec3f) -> Leg:
    """The leg somewhere else."""
    leg.hip += offset
    leg.knee += offset
    leg.ankle += offset
    leg.ball += offset
    return leg
