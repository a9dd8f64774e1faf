"""The analytic walker: clips of a small biped whose strikes, flats, liftoffs and footsteps are known exactly.

Every foot rests between its events: the heel is exactly still from strike to flat, the ball from flat to liftoff.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from tests.walker_body import (
    ANKLE_HEIGHT,
    BALL_FORWARD,
    BALL_HEIGHT,
    HEEL_BACK,
    HIP_DROP,
    SHIN,
    THIGH,
    FootCurves,
    lowered,
    pose_walker,
    walker_clip,
    walker_rig,
)
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.contacts import Contacts, FootContacts

__all__ = ["Gait", "Walker", "build_walker", "with_clip"]


@dataclass(frozen=True, kw_only=True)
class Gait:
    """How the walker walks; lengths for its leg of 0.82 m."""

    step_time: float = 0.5
    """Strike to strike of the other foot [s]."""
    step_length: float = 0.6
    """Ball to ball along the way [m]; negative walks backward, 0 on the spot."""
    step_width: float = 0.16
    """Distance of the feet across the way [m]."""
    sideways: float = 0.0
    """Shift to the left in each step [m]."""
    turn: float = 0.0
    """Change of heading in each step [rad]."""
    rise: float = 0.0
    """Height gained in each step [m]: stairs."""
    duty: float = 0.62
    """Contact over stride; below 0.5 there is flight."""
    heel_strike: bool = True
    """Heel first; otherwise the whole foot comes down at once."""
    clearance: float = 0.12
    """How high the ball is lifted [m]."""


@dataclass(frozen=True, kw_only=True)
class Walker:
    """A clip of the analytic walker and the truth about it."""

    library: ClipLibrary
    clip: Clip
    contacts: Contacts
    """Every contact that the clip shows, cut off ones with -inf and +inf."""


def build_walker(
    gait: Gait | None = None,
    *,
    rate: float = 30.0,
    footsteps: int = 8,
    start_time: float = 0.0,
    in_place: bool = False,
    loop: bool = False,
    noise: float = 0.0,
    twisted: bool = False,
    size: float = 1.0,
) -> Walker:
    """A clip of the walker, facing +Z at its first footstep, and its contacts.

    Args:
        gait: How it walks.
        rate: Samples a second [Hz].
        footsteps: Strikes the clip shows; the first is the left foot's.
        start_time: Time of the first sample [s].
        in_place: Take the mean travel off.
        loop: One stride whose last sample is its first pose again (if the stride is a whole number of samples).
        noise: Standard deviation of noise on the pelvis and both ankles [m].
        twisted: Joints with rest axes of their own.
        size: Factor on all lengths.
    """
    gait = gait or Gait()
    skeleton, biped = walker_rig(twisted=twisted, size=size)
    lead = 0.4 * gait.step_time
    length = 2.0 * gait.step_time if loop else (footsteps - 1) * gait.step_time + 2.0 * lead
    times = np.arange(round(length * rate) + 1) / rate - lead  # the first strike is at 0
    plan = _plan(gait, footsteps)
    feet = [_foot_curves(gait, plan, side, times) for side in range(2)]
    pelvis, yaws = _pelvis_curve(gait, plan, times)
    generator = np.random.default_rng(3)
    pelvis = pelvis + noise / size * generator.normal(size=pelvis.shape)
    ankles = [foot.ankle + noise / size * generator.normal(size=foot.ankle.shape) for foot in feet]
    pelvis = lowered(pelvis, yaws, ankles)
    arm_swing = 0.4 * np.cos(np.pi * times / gait.step_time)
    rotations_world = pose_walker(pelvis, yaws, ankles, feet=feet, arm_swing=arm_swing)
    travel = np.zeros((len(times), 3))
    velocity = np.array([gait.sideways, gait.rise, gait.step_length]) / gait.step_time
    if in_place:
        travel = times[:, None] * velocity * np.array([1.0, 0.0, 1.0])
    clip = walker_clip(skeleton, rotations_world, size * (pelvis - travel), rate, start_time)
    contacts = Contacts(
        left=_truth(plan, 0, times, start_time + lead, size), right=_truth(plan, 1, times, start_time + lead, size)
    )
    return Walker(library=ClipLibrary(skeleton=skeleton, biped=biped, clips=(clip,)), clip=clip, contacts=contacts)


@dataclass(frozen=True, kw_only=True)
class _Plan:
    """Contacts of the walker, more than the clip shows."""

    sides: FloatArray
    positions: FloatArray
    yaws: FloatArray
    strikes: FloatArray
    flats: FloatArray
    liftoffs: FloatArray


def _plan(gait: Gait, footsteps: int) -> _Plan:
    numbers = np.arange(-4, footsteps + 4)
    yaws = gait.turn * numbers
    middle = np.zeros((len(numbers), 2))
    advance = np.tile([gait.sideways, gait.step_length], (len(numbers) - 1, 1))
    stride = planar.rotate(yaws[:-1] + 0.5 * gait.turn, advance)
    middle[1:] = np.cumsum(stride, axis=0)
    middle -= middle[4]
    sides = numbers % 2
    lateral = np.stack([np.where(sides == 0, 0.5, -0.5) * gait.step_width, np.zeros(len(numbers))], axis=1)
    ground = middle + planar.rotate(yaws, lateral)
    duration = gait.duty * 2.0 * gait.step_time
    strikes = gait.step_time * numbers
    roll = min(0.1, 0.2 * duration) if gait.heel_strike else 0.0
    return _Plan(
        sides=sides,
        positions=np.stack([ground[:, 0], gait.rise * numbers, ground[:, 1]], axis=1),
        yaws=yaws,
        strikes=strikes,
        flats=strikes + roll,
        liftoffs=strikes + duration,
    )


def _ease(fraction: FloatArray) -> FloatArray:
    """0 to 1 with velocity and acceleration 0 at both ends."""
    fraction = np.clip(fraction, 0.0, 1.0)
    return fraction**3 * (10.0 - 15.0 * fraction + 6.0 * fraction**2)


def _hermite(fraction: FloatArray, ends: tuple[float, float], slopes: FloatArray) -> FloatArray:
    """Cubic between two values with slopes (2, ...) there, constant outside."""
    f = np.clip(fraction, 0.0, 1.0)
    first, second = ends
    value = first + (second - first) * f**2 * (3.0 - 2.0 * f)
    return value + slopes[0] * f * (1.0 - f) ** 2 - slopes[1] * f**2 * (1.0 - f)


def _foot_curves(gait: Gait, plan: _Plan, side: int, times: FloatArray) -> FootCurves:
    """Ankle, pitch (toes up) and yaw of one foot.

    The foot turns about the heel until it is flat and about the ball from heel-off on, without a stop at strike and
    liftoff. In the swing the point that is led from ball to heel moves along the foot.
    """
    mine = np.flatnonzero(plan.sides == side)
    current = np.clip(np.searchsorted(plan.strikes[mine], times, side="right") - 1, 0, len(mine) - 2)
    here, there = mine[current], mine[current + 1]
    strikes, flats, liftoffs = plan.strikes[here], plan.flats[here], plan.liftoffs[here]
    heel_offs, swing_time = 0.5 * (flats + liftoffs), plan.strikes[there] - liftoffs
    swing_fraction = np.clip((times - liftoffs) / swing_time, 0.0, 1.0)
    swing = _ease(swing_fraction)
    pitch = _pitch(gait, times, strikes, flats, heel_offs, liftoffs, swing_time)
    yaw = plan.yaws[here] + swing * (plan.yaws[there] - plan.yaws[here])
    bump = gait.clearance * 64.0 * (swing_fraction * (1.0 - swing_fraction)) ** 3
    ball, heel = np.array([BALL_FORWARD, BALL_HEIGHT - ANKLE_HEIGHT]), np.array([-HEEL_BACK, -ANKLE_HEIGHT])
    if not gait.heel_strike:
        heel = ball
    heel_from_ball = heel - np.array([BALL_FORWARD, -ANKLE_HEIGHT])  # to the ground under the ball: forward, up
    about_heel = times < flats
    flat_heel = plan.positions[here] + _along(plan.yaws[here], np.tile(heel_from_ball, (len(times), 1)))
    ball_place = plan.positions[here] + np.array([0.0, BALL_HEIGHT, 0.0])
    next_heel = plan.positions[there] + _along(plan.yaws[there], np.tile(heel_from_ball, (len(times), 1)))
    leading = ball_place + swing[:, None] * (next_heel - ball_place) + bump[:, None] * np.array([0.0, 1.0, 0.0])
    place = np.where(about_heel[:, None], flat_heel, leading)
    pivot = np.where(about_heel[:, None], heel, ball + swing[:, None] * (heel - ball))
    return FootCurves(ankle=place + _along(yaw, -_turned(pivot, pitch)), pitch=pitch, yaw=yaw)


def _pitch(
    gait: Gait,
    times: FloatArray,
    strikes: FloatArray,
    flats: FloatArray,
    heel_offs: FloatArray,
    liftoffs: FloatArray,
    swing_time: FloatArray,
) -> FloatArray:
    """Toes up [rad], with a continuous rate."""
    toes_up, toes_down = (0.35 if gait.heel_strike else 0.0), -0.5
    roll_time, push_time = np.maximum(flats - strikes, 1e-9), liftoffs - heel_offs
    strike_rate = -1.5 * toes_up / roll_time if gait.heel_strike else 0.0 * roll_time
    liftoff_rate = 1.5 * toes_down / push_time
    still = np.zeros(len(times))
    roll = _hermite((times - strikes) / roll_time, (toes_up, 0.0), np.stack([strike_rate * roll_time, still]))
    push = _hermite((times - heel_offs) / push_time, (0.0, toes_down), np.stack([still, liftoff_rate * push_time]))
    swing = _hermite(
        (times - liftoffs) / swing_time, (toes_down, toes_up), np.stack([liftoff_rate, strike_rate]) * swing_time
    )
    return np.where(times < heel_offs, roll, np.where(times < liftoffs, push, swing))


def _turned(vector: FloatArray, pitch: FloatArray) -> FloatArray:
    """(forward, up) vectors (..., 2) with the toes turned up by pitch (N,), shape (N, 2)."""
    cosine, sine = np.cos(pitch), np.sin(pitch)
    forward, up = vector[..., 0], vector[..., 1]
    return np.stack([cosine * forward - sine * up, sine * forward + cosine * up], axis=-1)


def _along(yaw: FloatArray, vectors: FloatArray) -> FloatArray:
    """World vectors of (forward, up) ones (N, 2) in the vertical planes of yaw (N,)."""
    ground = planar.direction(yaw) * vectors[..., :1]
    return np.stack([ground[..., 0], vectors[..., 1], ground[..., 1]], axis=-1)


def _pelvis_curve(gait: Gait, plan: _Plan, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pelvis positions as high as the stretched legs allow for a standing walker, and yaws."""
    middle = plan.strikes + gait.duty * gait.step_time
    side = np.where(plan.sides == 0, 0.5, -0.5) * gait.step_width
    ankle = planar.rotate(plan.yaws, np.stack([-side, np.full(len(side), -0.5 * BALL_FORWARD)], axis=1))
    centre = plan.positions + np.stack([ankle[:, 0], np.zeros(len(side)), ankle[:, 1]], axis=1)
    height = np.array([0.0, THIGH + SHIN + ANKLE_HEIGHT + HIP_DROP, 0.0])
    return CubicSpline(middle, centre)(times) + height, CubicSpline(middle, plan.yaws)(times)


def _truth(plan: _Plan, side: int, times: FloatArray, offset: float, size: float) -> FootContacts:
    shown = (plan.sides == side) & (plan.liftoffs > times[0]) & (plan.strikes < times[-1])
    strikes, liftoffs = plan.strikes[shown], plan.liftoffs[shown]
    cut = strikes < times[0]
    return FootContacts(
        strike_times=np.where(cut, -np.inf, strikes + offset),
        flat_times=np.where(cut, -np.inf, plan.flats[shown] + offset),
        liftoff_times=np.where(liftoffs > times[-1], np.inf, liftoffs + offset),
        positions=size * plan.positions[shown],
        yaws=planar.wrap_angle(plan.yaws[shown]),
        ball_first=plan.flats[shown] <= plan.strikes[shown],
    )


def with_clip(walker: Walker, **changes: object) -> ClipLibrary:
    """The walker's library with fields of its clip replaced."""
    return replace(walker.library, clips=(replace(walker.clip, **changes),))
