"""Warp functions from the time of a frame to where its segment is: phase, heading, ground, flight, seams' windows.

In double precision on the agent's clock, so that an instant means the same in every frame.
"""

from __future__ import annotations

import warp as wp

from usdfoot.engine.easing import rising
from usdfoot.model.examples import LIFTOFF_PHASES

__all__ = ["Clock", "ClockArrays", "clock_at", "phase_at", "read_samples"]

FIRST_PHASE = wp.constant(wp.float64(LIFTOFF_PHASES[0]))
SECOND_PHASE = wp.constant(wp.float64(LIFTOFF_PHASES[1]))
PUSH_TIME = wp.constant(wp.float64(0.15))
"""Time in which the legs take up the change before and after a flight, at most half the contact [s]."""
INERTIALISE = wp.constant(1)
CROSSFADE = wp.constant(2)
ENDLESS = wp.constant(wp.float64(1.0e9))


@wp.struct
class ClockArrays:
    """Segments on the device, M of them; times on their agent's clock [s]."""

    begins: wp.array(dtype=wp.float64)
    ends: wp.array(dtype=wp.float64)
    knot_times: wp.array(dtype=wp.vec4d)  # events inside the step
    knot_shares: wp.array(dtype=wp.vec4d)  # when they come in the blended examples, 0..1
    knot_slopes: wp.array(dtype=wp.vec4d)  # PCHIP
    headings: wp.array(dtype=wp.float64)  # at the support's strike [rad]
    twists: wp.array(dtype=wp.float64)  # turned about the support ball by the end [rad]
    grounds: wp.array(dtype=wp.vec4d)  # pelvis's ground at begin and end [m] and its rates there [m/s]
    releases: wp.array(dtype=wp.float64)  # liftoff of the support foot
    flights: wp.array(dtype=wp.vec3d)  # the segment's own: liftoff, duration, downward acceleration that is missing
    landed_flights: wp.array(dtype=wp.vec3d)  # the same of the segment before
    seam_lengths: wp.array(dtype=wp.vec4d)  # joints' seam at begin and end, pelvis's value, 0 [s]
    seam_kind: wp.int32


@wp.func
def hermite(
    x: wp.float64,
    length: wp.float64,
    start: wp.float64,
    end: wp.float64,
    start_slope: wp.float64,
    end_slope: wp.float64,
) -> wp.float64:
    """Cubic with given ends at a part `x`, 0..1, of its length."""
    one, two = wp.float64(1.0), wp.float64(2.0)
    rest = one - x
    value = rest * rest * (one + two * x) * start + x * x * (one + two * rest) * end
    return value + x * rest * length * (rest * start_slope - x * end_slope)


@wp.func
def phase_at(clocks: ClockArrays, segment: int, time: wp.float64) -> wp.float64:
    """Phase of a segment.

    A monotone warp (PCHIP) takes the planned events to those of the blended examples; from there the phase runs
    straight between events, as it does in the examples, so that a step played as recorded keeps its pace exactly.
    """
    times = clocks.knot_times[segment]
    shares = clocks.knot_shares[segment]
    slopes = clocks.knot_slopes[segment]
    now = wp.clamp(time, times[0], times[3])
    k = wp.where(now >= times[1], 1, 0) + wp.where(now >= times[2], 1, 0)
    length = times[k + 1] - times[k]
    share = hermite((now - times[k]) / length, length, shares[k], shares[k + 1], slopes[k], slopes[k + 1])
    zero, one = wp.float64(0.0), wp.float64(1.0)
    piece = wp.where(share >= shares[1], 1, 0) + wp.where(share >= shares[2], 1, 0)
    start = wp.where(piece == 0, zero, wp.where(piece == 1, FIRST_PHASE, SECOND_PHASE))
    end = wp.where(piece == 0, FIRST_PHASE, wp.where(piece == 1, SECOND_PHASE, one))
    part = (share - shares[piece]) / (shares[piece + 1] - shares[piece])
    return start + (end - start) * wp.clamp(part, zero, one)


@wp.func
def fall_arc(flight: wp.vec3d, time: wp.float64, earliest: wp.float64, latest: wp.float64) -> wp.float64:
    """Parabola over a flight with smooth feet on either side [m], C1, zero from `earliest` back and `latest` on.

    What gravity lacks in a flight that the time warp has drawn out is added as a parabola, whose velocity the legs take
    up before and after: a longer flight is prepared by a deeper crouch.
    """
    half, zero, one = wp.float64(0.5), wp.float64(0.0), wp.float64(1.0)
    duration, missing = flight[1], flight[2]
    if missing == zero:
        return zero
    after = time - flight[0]
    slope = half * missing * duration
    least, most = wp.float64(1.0e-6), wp.float64(2.0) * PUSH_TIME
    if after < zero:
        rest = wp.max(one + after / (half * wp.clamp(flight[0] - earliest, least, most)), zero)
        return slope * after * rest * rest
    if after > duration:
        behind = after - duration
        rest = wp.max(one - behind / (half * wp.clamp(latest - flight[0] - duration, least, most)), zero)
        return -slope * behind * rest * rest
    return half * missing * after * (duration - after)


@wp.func
def seam_value(time: wp.float64, length: wp.float64) -> wp.float64:
    """How much of a seam's half jump is left at a time from it."""
    return wp.float64(1.0) - rising(time / wp.max(length, wp.float64(1.0e-6)))


@wp.func
def seam_rate(time: wp.float64, length: wp.float64) -> wp.float64:
    """The same for the jump of the rate [s]."""
    one = wp.float64(1.0)
    longest = wp.max(length, wp.float64(1.0e-6))
    x = wp.clamp(time / longest, wp.float64(0.0), one)
    rest = one - x
    return -longest * x * rest * rest * rest * (one + wp.float64(3.0) * x)


@wp.func
def seam_window(
    kind: int,
    after: wp.float64,
    before: wp.float64,
    begin_value: wp.float64,
    end_value: wp.float64,
    begin_rate: wp.float64,
    end_rate: wp.float64,
) -> wp.vec4f:
    """Factors of the seams' half jumps and rates: begin value, begin rate [s], end value, end rate [s].

    `inertialise` meets in the middle of the jump, in value and velocity: half decays before the seam, half after
    (Bollo 2018, made symmetric since the plan is known). `crossfade` fades from the old pose linearly ([B] 7).

    Args:
        kind: Of the seams.
        after: Time since the segment's begin [s].
        before: Time to its end [s].
        begin_value: Length over which the jump at the begin decays [s].
        end_value: The same at the end.
        begin_rate: Length over which its rate decays [s].
        end_rate: The same at the end.
    """
    if kind == INERTIALISE:
        return wp.vec4f(
            float(-seam_value(after, begin_value)),
            float(seam_rate(after, begin_rate)),
            float(seam_value(before, end_value)),
            float(seam_rate(before, end_rate)),
        )
    if kind == CROSSFADE:
        left = wp.clamp(wp.float64(1.0) - after / begin_value, wp.float64(0.0), wp.float64(1.0))
        return wp.vec4f(float(wp.float64(-2.0) * left), 0.0, 0.0, 0.0)
    return wp.vec4f(0.0, 0.0, 0.0, 0.0)


@wp.struct
class Clock:
    """What a time means in a segment."""

    sample: wp.float32  # of the examples
    yaw: wp.float32  # heading [rad]
    ground: wp.float32  # the pelvis's [m]
    joint_window: wp.vec4f  # of the seams
    position_window: wp.vec4f


@wp.func
def clock_at(clocks: ClockArrays, segment: int, time: wp.float64, last_sample: float) -> Clock:
    """What a time means in a segment; `last_sample` is that of the examples."""
    now = Clock()
    begin, end = clocks.begins[segment], clocks.ends[segment]
    after, before = time - begin, end - time
    length = wp.max(end - begin, wp.float64(1.0e-6))
    share = wp.clamp(after / length, wp.float64(0.0), wp.float64(1.0))
    now.sample = float(phase_at(clocks, segment, time)) * last_sample
    now.yaw = float(clocks.headings[segment] + clocks.twists[segment] * rising(share))
    level = clocks.grounds[segment]
    ground = hermite(share, length, level[0], level[1], level[2], level[3])
    ground += fall_arc(clocks.flights[segment], time, begin, ENDLESS)
    ground += fall_arc(clocks.landed_flights[segment], time, -ENDLESS, clocks.releases[segment])
    now.ground = float(ground)
    seams = clocks.seam_lengths[segment]
    kind = clocks.seam_kind
    now.joint_window = seam_window(kind, after, before, seams[0], seams[1], seams[0], seams[1])
    whole = seams[2]
    now.position_window = seam_window(
        kind, after, before, whole, whole, wp.min(whole, seams[0]), wp.min(whole, seams[1])
    )
    return now


@wp.kernel(enable_backward=False)
def read_samples(
    clocks: ClockArrays,
    frame_segments: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
    last_sample: float,
    samples: wp.array(dtype=wp.float32),
) -> None:
    """Sample of the examples at each frame."""
    frame = wp.tid()
    samples[frame] = clock_at(clocks, frame_segments[frame], times[frame], last_sample).sample
