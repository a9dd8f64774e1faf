"""Warp functions of a leg over its contact as people hold it: the knee's bend, the foot's roll, where it presses."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.contact_kernel import ContactFooting, LegArrays, clamped

__all__ = ["AT_ONCE", "BACKWARD", "comfortable_length", "foot_pitch", "pressing", "rolled_ankle"]

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
RUN_START = wp.constant(wp.float64(0.5))
"""Where along the foot it presses first after a flight, 0 heel to 1 toe (Cavanagh and Lafortune 1980)."""
FOREFOOT = wp.constant(wp.float64(0.606))
"""Part of the contact after which the heel is off and the ball presses (Chiu, Wu and Chang 2013)."""
AT_ONCE = wp.constant(wp.float64(1.0e-9))
"""A time that divides nothing by zero [s], and a weight that is hardly one."""
DEGREE = wp.constant(wp.float64(wp.pi / 180.0))


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
