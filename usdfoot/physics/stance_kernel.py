"""Warp functions of instants: which legs stand, where they press, where the ankles are, where the body faces."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.contact_kernel import ContactArrays, ContactFooting, LegArrays, clamped

__all__ = ["BACKWARD", "StanceArrays", "body_yaw", "find_body_yaws", "find_instant", "find_instants", "yaw_turn"]

Flexions = wp.types.vector(length=11, dtype=wp.float64)
Pitches = wp.types.vector(length=6, dtype=wp.float64)

WALK_FLEXIONS = wp.constant(Flexions(5.0, 11.0, 17.0, 18.0, 15.0, 11.0, 8.0, 6.0, 5.0, 8.0, 15.0))
"""Knee over the contact of a walk, until the weight is off it (Winter 1991, Figure 3.32; Perry 1992) [degrees]."""
BENT = wp.constant(wp.float64(18.0))
"""Its value in early stance, where the leg has its nominal length."""
STRAIGHTEST = wp.constant(wp.float64(0.8))
"""Part of the contact at which it is least; it stays so while a foot stands at the begin or end of a motion."""
BACKWARD_FLEXIONS = wp.constant(Flexions(15.0, 8.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0))
"""The same backward: reversed (Winter, Pluck and Yang 1989; Lee et al. 2013), but without the bend under load. That the
knee only stretches is measured of Bandai Namco's four backward clips, of no others [degrees]."""
RUN_FLEXIONS = wp.constant(Flexions(20.0, 28.0, 35.0, 39.0, 40.0, 38.0, 34.0, 29.0, 24.0, 20.0, 18.0))
"""Over the contact of a run, less 20 degrees (Novacheck 1998, Figure 5)."""
PITCH_PHASES = wp.constant(Pitches(0.0, 0.15, 0.5, 0.7, 0.85, 1.0))
PITCHES = wp.constant(Pitches(20.0, 0.0, 0.0, -5.0, -17.0, -40.0))
"""Foot over the contact of a long step, positive with the toes up (Perry 1992: heel, ankle and forefoot rocker)
[degrees]."""
STAIR_BEND = wp.constant(wp.float64(0.6))
"""Part of a stair's height by which the upper leg is shorter while both stand (Riener et al. 2002)."""
LEAST_LENGTH = wp.constant(wp.float64(0.3))
"""The shortest comfortable leg, as a part of its nominal length."""
LONG_STEP = wp.constant(wp.float64(0.8))
"""Such a step, as a part of the leg's length."""
BACKWARD = 0.3
"""Feet roll less in backward steps: this part of the pitches, ball first."""
BACKWARD_ROLL = wp.constant(wp.float64(BACKWARD))
ROLL_TIME = wp.constant(wp.float64(0.4))
"""Longest time from heel to flat and from flat to toe on a leg of 0.86 m; a foot that stands longer is flat in between
[s]."""
HEEL_OFF = wp.constant(wp.float64(0.6))
"""Part of the contact after which the foot is on its toes."""
RUN_START = wp.constant(wp.float64(0.5))
"""Where along the foot it presses first after a flight, 0 heel to 1 toe (Cavanagh and Lafortune 1980)."""
FOREFOOT = wp.constant(wp.float64(0.606))
"""Part of the contact after which the heel is off and the ball presses (Chiu, Wu and Chang 2013)."""
AT_ONCE = wp.constant(wp.float64(1.0e-9))
DEGREE = wp.constant(wp.float64(wp.pi / 180.0))


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
def latest_load(footing: wp.array(dtype=ContactFooting), strike: int, end: int, time: wp.float64) -> int:
    """The last contact that has taken weight, which may be before its strike, when `strike` is the last that struck."""
    latest = strike
    while latest + 1 < end and footing[latest + 1].begin <= time:
        latest += 1
    return latest


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


@wp.func
def flexion_at(flexions: Flexions, progress: wp.float64) -> wp.float64:
    """A knee's curve at a part of the contact [degrees]."""
    place = progress * wp.float64(10.0)
    k = wp.min(int(place), 9)
    share = place - wp.float64(k)
    return flexions[k] + share * (flexions[k + 1] - flexions[k])


@wp.func
def stood(footing: wp.array(dtype=ContactFooting), i: int, progress: wp.float64) -> wp.float64:
    """Part of contact i at which the knee of a walk is: who stands has got over the foot and does not leave it."""
    phase = progress
    if footing[i].stands_before:
        phase = wp.max(phase, STRAIGHTEST)
    if footing[i].stands_after:
        phase = wp.min(phase, STRAIGHTEST)
    return phase


@wp.func
def comfortable_length(
    legs: LegArrays, footing: wp.array(dtype=ContactFooting), i: int, progress: wp.float64
) -> wp.float64:
    """How long people hold the leg over contact i [m].

    The knee bends over the contact by published figures, around the bend of the nominal length, which is that of early
    stance: with a constant length a body would not rise over the standing leg as people do. On stairs and slopes the
    leg on the higher foot is shorter while the weight changes over.
    """
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    three = wp.float64(3.0)
    bend = two * wp.acos(wp.clamp(legs.nominal_length / legs.maximal_length, -one, one))
    walk = flexion_at(WALK_FLEXIONS, stood(footing, i, progress))
    back = flexion_at(BACKWARD_FLEXIONS, progress)
    walk = walk + wp.max(-footing[i].alignment, zero) * (back - walk)
    run = flexion_at(RUN_FLEXIONS, progress)
    share = wp.float64(0.5) * (footing[i].lands + footing[i].leaps)
    flexion = bend + legs.play * (walk + share * (run - walk) - BENT) * DEGREE
    length = legs.maximal_length * wp.cos(wp.float64(0.5) * wp.max(flexion, zero))
    early = wp.max(one - two * progress, zero)
    late = wp.max(two * progress - one, zero)
    bent = footing[i].rise * early * early * (three - two * early)
    bent = bent + footing[i].drop * late * late * (three - two * late)
    return wp.max(length - STAIR_BEND * legs.play * bent, LEAST_LENGTH * legs.nominal_length)


@wp.func
def foot_pitch(footing: wp.array(dtype=ContactFooting), i: int, progress: wp.float64) -> wp.float64:
    """Pitch of the foot about heel or ball over contact i, positive with the toes up [rad].

    Short steps roll less; backward steps little and the other way round, and side steps not at all.
    """
    zero = wp.float64(0.0)
    alignment = footing[i].alignment
    phase = progress
    if alignment < zero:
        phase = wp.float64(1.0) - progress
        alignment = BACKWARD_ROLL * alignment
    k = wp.int32(0)
    while k < 4 and phase >= PITCH_PHASES[k + 1]:
        k += 1
    share = (phase - PITCH_PHASES[k]) / (PITCH_PHASES[k + 1] - PITCH_PHASES[k])
    size = wp.min(footing[i].reach / LONG_STEP, wp.float64(1.0)) * wp.abs(alignment)
    pitch = size * (PITCHES[k] + share * (PITCHES[k + 1] - PITCHES[k])) * DEGREE
    if pitch > zero:
        pitch = pitch * (wp.float64(1.0) - footing[i].lands)
    if (footing[i].stands_before and pitch > zero) or (footing[i].stands_after and pitch < zero):
        pitch = zero
    return pitch


@wp.func
def rolled_ankle(ankle: wp.vec3d, heel: wp.float64, pitch: wp.float64) -> wp.vec3d:
    """An ankle in its print's frame with the foot rolled about heel or ball [m]."""
    pivot = wp.float64(0.0)
    if pitch > pivot:
        pivot = heel
    ahead = ankle[2] - pivot
    cosine = wp.cos(pitch)
    sine = wp.sin(pitch)
    return wp.vec3d(ankle[0], ankle[1] * cosine + ahead * sine, pivot + ahead * cosine - ankle[1] * sine)


@wp.func
def pressing(legs: LegArrays, footing: wp.array(dtype=ContactFooting), i: int, time: wp.float64) -> wp.float64:
    """Where along the foot it presses, 0 heel to 1 toe.

    It goes from heel to toe in the direction of travel, in walks sooner to the ball than on to the toe; in backward
    steps from toe to heel, nowhere in side steps. A foot that stands at the begin or end of the motion presses with its
    middle, and so does, for a while, one that stands longer than it takes to roll twice.
    """
    one = wp.float64(1.0)
    middle = wp.float64(0.5)
    lasting = wp.max(footing[i].end - footing[i].begin, AT_ONCE)
    half = wp.min(middle * lasting, ROLL_TIME * wp.sqrt(legs.size))
    on = one
    off = one
    if not footing[i].stands_before:
        on = clamped((time - footing[i].begin) / half)
    if not footing[i].stands_after:
        off = clamped((footing[i].end - time) / half)
    start = RUN_START * footing[i].lands
    travelled = start + (one - start) * (middle + middle * (on - off))
    ball = legs.heel / (legs.heel - legs.toe)
    rolled = ball * travelled / FOREFOOT
    if travelled > FOREFOOT:
        rolled = one - (one - ball) * (one - travelled) / (one - FOREFOOT)
    alignment = footing[i].alignment
    rolls = wp.max(alignment, wp.float64(0.0)) * (one - footing[i].lands)
    if footing[i].stands_before or footing[i].stands_after or half < middle * lasting:
        rolls = wp.float64(0.0)
    return middle + (travelled + rolls * (rolled - travelled) - middle) * alignment


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
