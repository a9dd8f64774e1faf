"""Warp functions of contacts: what step each belongs to, when its foot carries weight, how its foot turns."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = [
    "AgentRow",
    "ContactArrays",
    "ContactFooting",
    "ContactRow",
    "LegArrays",
    "clamped",
    "lay_agent",
    "lay_footings",
    "wrapped",
]

Pair = wp.types.matrix(shape=(2, 3), dtype=wp.float64)

DOUBLE_STANCE = wp.constant(wp.float64(0.284))
DOUBLE_STANCE_LOSS = wp.constant(wp.float64(0.07))
"""Part of a walking step in which both feet carry: this at no speed, and less by this for every m/s on a leg of 0.86 m
(Kirtley, Whittle and Jefferson 1985: a foot stands for 64.2 % of a stride, less 3.5 % for every m/s)."""
TOE_ALONE = wp.constant(wp.float64(0.09))
"""Longest part of a step for which the toe still presses when the ball has left the ground, or presses before the ball
does in steps backward: the longest in the five liftoffs of CMU's fast walk and run (02_02, 02_03) that are detected for
both, where the tip of the toe leaves 0.01 of a step before to 0.09 after the ball. Measured, not published: that the
great toe leaves last is (De Cock et al. 2005, of runs). Without a bound the toe would press for up to 0.2 of a step
where contacts are as short as those found in fast walks: the pelvis would rise by 37 % more than in CMU's walk and 6 %
more than in Bandai Namco's; with it by 23 % more and 14 % less."""
HEEL_ALONE = wp.constant(wp.float64(0.118))
"""Part of the contact for which the heel carries without the ball: at its begin (Chiu, Wu and Chang 2013: initial and
forefoot contact), so in steps backward when the ball has left."""
LONGEST_SHIFT = wp.constant(wp.float64(0.4))
"""The weight changes over in this time at most, on a leg of 0.86 m [s]."""
AT_ONCE = wp.constant(wp.float64(1.0e-9))
WALK_FLIGHT = wp.constant(wp.float64(0.1))
RUN_FLIGHT = wp.constant(wp.float64(0.25))
"""Part of a step that a flight takes, at most in a walk and at least in a run. By the ball's contacts walks seem to
have short flights."""
NO_DISTANCE = wp.constant(wp.float64(1.0e-9))
SHORTEST_SWING = wp.constant(wp.float64(1.0e-6))
PI = wp.constant(wp.float64(wp.pi))


@wp.struct
class ContactRow:
    """A contact, as in `ContactTable`."""

    side: wp.int32
    position: wp.vec3d  # [m]
    normal: wp.vec3d
    yaw: wp.float64  # [rad]
    strike: wp.float64  # [s]
    liftoff: wp.float64  # [s]


@wp.struct
class AgentRow:
    """An agent's contacts, as in `ContactTable`."""

    first: wp.int32
    end: wp.int32
    start: wp.float64  # [s]
    finish: wp.float64  # [s]


@wp.struct
class ContactArrays:
    """C contacts of A agents."""

    rows: wp.array(dtype=ContactRow)
    agents: wp.array(dtype=AgentRow)


@wp.struct
class LegArrays:
    """The biped's legs and how they are used; rows of pairs are (left, right)."""

    hips: Pair  # in the body's frame [m]
    ankles: Pair  # in the prints' frames [m]
    nominal_length: wp.float64  # [m]
    maximal_length: wp.float64  # [m]
    size: wp.float64  # of the leg, 1 = a person's
    heel: wp.float64  # [m]
    toe: wp.float64  # [m]
    play: wp.float64  # share of how people hold their legs
    smooth: bool  # whether the feet press from heel to toe


@wp.struct
class ContactFooting:
    """What a contact means for a biped."""

    alignment: wp.float64  # cosine between the foot's heading and the way the body travels over it
    reach: wp.float64  # mean distance to the contacts before and after, as a part of the leg's length
    lands: wp.float64  # how much a flight ends with its strike: 1 if it takes a quarter of the step or more
    leaps: wp.float64  # how much a flight begins with its liftoff
    rise: wp.float64  # height gained from the contact before, 0 when lost [m]
    drop: wp.float64  # height lost to the contact after, 0 when gained [m]
    stands_before: bool  # whether it stands on both feet when the motion begins
    stands_after: bool  # whether it stands when the motion ends
    begin: wp.float64  # the foot takes weight: at its strike, in steps backward when the toe comes down [s]
    end: wp.float64  # no weight is left on it: when toe (ahead) or heel (backward) leaves after the ball [s]
    change: wp.float64  # the weight goes over to it: at its strike, without leaps in the middle of double stance [s]
    taking: wp.float64  # time in which it takes over from the foot before [s]
    giving: wp.float64  # time in which it gives over to the foot after [s]
    frame: wp.quatd  # of the print to world: +Y along the ground's normal, +Z the foot's heading
    heading: wp.float64  # yaw, continuous along the plan [rad]
    swing: wp.float64  # duration of the swing after it [s], 1 where there is none
    turn: wp.float64  # of the foot in that swing [rad]
    integral: wp.float64  # of the foot's yaw over time up to the strike [rad s]


@wp.func
def clamped(value: wp.float64) -> wp.float64:
    """A share brought into 0 to 1."""
    return wp.clamp(value, wp.float64(0.0), wp.float64(1.0))


@wp.func
def wrapped(angle: wp.float64) -> wp.float64:
    """An angle brought into -pi to pi [rad]."""
    turn = wp.float64(2.0) * PI
    return angle - turn * wp.floor((angle + PI) / turn)


@wp.func
def heel_after(contacts: ContactArrays, footing: wp.array(dtype=ContactFooting), i: int) -> wp.float64:
    """Time for which the heel of contact i stays when the ball has left the ground, in steps backward [s]."""
    backward = wp.max(-footing[i].alignment, wp.float64(0.0))
    return backward * HEEL_ALONE * (contacts.rows[i].liftoff - contacts.rows[i].strike)


@wp.func
def flight_share(
    contacts: ContactArrays, footing: wp.array(dtype=ContactFooting), before: int, after: int
) -> wp.float64:
    """How much the step between two contacts is a running step, 0 to 1; the first one's alignment must be known."""
    step = contacts.rows[after].strike - contacts.rows[before].strike
    if step <= wp.float64(0.0):
        return wp.float64(0.0)
    left = contacts.rows[before].liftoff + heel_after(contacts, footing, before)
    share = (contacts.rows[after].strike - left) / step
    return clamped((share - WALK_FLIGHT) / (RUN_FLIGHT - WALK_FLIGHT))


@wp.func
def lay_gait(
    contacts: ContactArrays, legs: LegArrays, footing: wp.array(dtype=ContactFooting), i: int, before: int, after: int
):
    """Sets what kind of step contact i belongs to; `before` and `after` are its neighbours, or itself without one."""
    zero = wp.float64(0.0)
    place = contacts.rows[i].position
    x = contacts.rows[after].position[0] - contacts.rows[before].position[0]
    z = contacts.rows[after].position[2] - contacts.rows[before].position[2]
    distance = wp.sqrt(x * x + z * z)
    footing[i].alignment = zero
    if distance > NO_DISTANCE:
        footing[i].alignment = (x * wp.sin(contacts.rows[i].yaw) + z * wp.cos(contacts.rows[i].yaw)) / distance
    footing[i].reach = distance / wp.float64(wp.max(after - before, 1)) / legs.maximal_length
    footing[i].lands = flight_share(contacts, footing, before, i)
    footing[i].leaps = flight_share(contacts, footing, i, after)
    footing[i].rise = wp.max(place[1] - contacts.rows[before].position[1], zero)
    footing[i].drop = wp.max(place[1] - contacts.rows[after].position[1], zero)


@wp.func
def lay_load(contacts: ContactArrays, legs: LegArrays, footing: wp.array(dtype=ContactFooting), i: int):
    """Sets when the weight goes over from contact i to the next, as people put it on their feet.

    Flights of runs and leaps stay what they are.
    """
    zero = wp.float64(0.0)
    j = i + 1
    duration = contacts.rows[j].strike - contacts.rows[i].strike
    speed = zero
    if duration > zero:
        speed = wp.length(contacts.rows[j].position - contacts.rows[i].position) / duration / wp.sqrt(legs.size)
    known = contacts.rows[i].liftoff - contacts.rows[j].strike
    missing = wp.max(DOUBLE_STANCE - DOUBLE_STANCE_LOSS * speed, zero) * duration - known
    missing = wp.max(missing, zero) * (wp.float64(1.0) - footing[i].leaps)
    toe = wp.min(missing, TOE_ALONE * duration)
    heel = wp.min(missing - toe, heel_after(contacts, footing, i))
    ahead = wp.float64(0.5) + wp.float64(0.25) * (footing[i].alignment + footing[j].alignment)
    footing[i].end = contacts.rows[i].liftoff + ahead * toe + heel
    footing[j].begin = contacts.rows[j].strike - (wp.float64(1.0) - ahead) * toe
    if footing[i].end > footing[j].begin and not footing[j].stands_before:
        middle = wp.float64(0.5) * (footing[i].end + footing[j].begin)
        footing[j].change = middle + footing[j].leaps * (contacts.rows[j].strike - middle)
    shift = wp.clamp(footing[i].end - footing[j].begin, AT_ONCE, LONGEST_SHIFT * wp.sqrt(legs.size))
    if not footing[i].stands_after:
        footing[i].giving = shift
    if not footing[j].stands_before:
        footing[j].taking = shift


@wp.func
def print_turn(normal: wp.vec3d, yaw: wp.float64) -> wp.quatd:
    """Rotation of a print's frame: +Y along the ground's normal, +Z the foot's heading."""
    zero = wp.float64(0.0)
    half = wp.float64(0.5) * yaw
    tilt = wp.normalize(wp.quatd(normal[2], zero, -normal[0], wp.float64(1.0) + normal[1]))
    return tilt * wp.quatd(zero, wp.sin(half), zero, wp.cos(half))


@wp.func
def lay_turn(contacts: ContactArrays, footing: wp.array(dtype=ContactFooting), i: int, first: int):
    """Sets the yaw of contact i continuous with the one before, and carries the integral over to the foot's next."""
    footing[i].heading = contacts.rows[i].yaw
    if i > first:
        footing[i].heading = footing[i - 1].heading + wrapped(contacts.rows[i].yaw - contacts.rows[i - 1].yaw)
    footing[i].swing = wp.float64(1.0)
    footing[i].turn = wp.float64(0.0)
    if i < first + 2:
        footing[i].integral = wp.float64(0.0)
    else:
        b = i - 2
        swing = wp.max(contacts.rows[i].strike - contacts.rows[b].liftoff, SHORTEST_SWING)
        turn = footing[i].heading - footing[b].heading
        footing[b].swing = swing
        footing[b].turn = turn
        footing[i].integral = (
            footing[b].integral
            + footing[b].heading * (contacts.rows[i].strike - contacts.rows[b].strike)
            + wp.float64(0.5) * turn * swing
        )


@wp.func
def lay_agent(contacts: ContactArrays, legs: LegArrays, footing: wp.array(dtype=ContactFooting), agent: int):
    """Sets the footing of all contacts of an agent."""
    first = contacts.agents[agent].first
    end = contacts.agents[agent].end
    for i in range(first, end):
        before = wp.max(i - 1, first)
        together = i > first and contacts.rows[i].strike == contacts.rows[before].strike
        footing[i].stands_before = together or (i == first and contacts.rows[i].strike <= contacts.agents[agent].start)
        footing[i].stands_after = i + 2 >= end and contacts.rows[i].liftoff >= contacts.agents[agent].finish
        lay_gait(contacts, legs, footing, i, before, wp.min(i + 1, end - 1))
        footing[i].begin = contacts.rows[i].strike
        footing[i].end = contacts.rows[i].liftoff
        footing[i].change = contacts.rows[i].strike
        footing[i].taking = AT_ONCE
        footing[i].giving = AT_ONCE
        footing[i].frame = print_turn(contacts.rows[i].normal, contacts.rows[i].yaw)
        lay_turn(contacts, footing, i, first)
    if legs.smooth:
        for i in range(first, end - 1):
            lay_load(contacts, legs, footing, i)


@wp.kernel(enable_backward=False)
def lay_footings(contacts: ContactArrays, legs: LegArrays, footing: wp.array(dtype=ContactFooting)):
    """Sets the footing of all contacts, one thread an agent."""
    lay_agent(contacts, legs, footing, wp.tid())
