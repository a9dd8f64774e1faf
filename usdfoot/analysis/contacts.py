"""Contacts: when and where the feet of a clip stand (design.md section 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.motion import FootMotion
from usdfoot.analysis.refine import still_end, still_start
from usdfoot.analysis.signals import PointSignal, fine_times, point_signals, samples_within
from usdfoot.analysis.stillness import intervals_of, still_flags, without_pauses, without_raised, without_rolls
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.contacts import Contacts, FootContacts

__all__ = ["contacts_of", "flat_times"]

BALL_FIRST_MARGIN = 0.008
"""The ball counts as down first unless the heel is down so much earlier [s]."""


def contacts_of(
    motion: FootMotion, *, ball_heights: FloatArray, leg_length: float, options: ContactOptions
) -> Contacts:
    """Contacts of both feet of a motion that travels.

    Args:
        motion: World trajectories of the feet.
        ball_heights: Ball joints above the sole [m], shape (2,).
        leg_length: Hip to ankle with the knee straight [m], the measure of all thresholds.
        options: Thresholds.
    """
    options = options.for_leg(leg_length)
    rate = (len(motion.times) - 1) / (motion.times[-1] - motion.times[0])
    grid = fine_times(motion.times[0], len(motion.times), rate, options.fine_rate)
    signals = _signals(motion, grid, options)
    balls, heels = signals[:2], signals[2:]
    heels_still = np.stack([still_flags(heel, grid, options) for heel in heels])  # (2, N)
    still = np.stack([still_flags(ball, grid, options) for ball in balls])
    for side in range(2):
        reach = samples_within(options.shortest_swing, grid[1] - grid[0])
        still[side] = without_pauses(still[side], balls[side], options.lift, reach)
        still[side] = without_rolls(still[side], heels_still[side], balls[side], options.lift)
    still = without_raised(still, balls, options.raised)
    feet = []
    for side in range(2):
        feet_forward = (motion.balls - motion.ankles)[:, side]
        forward = np.stack([np.interp(grid, motion.times, feet_forward[:, i]) for i in (0, 2)], axis=-1)
        foot = _Foot(grid=grid, ball=balls[side], heel=heels[side], heel_still=heels_still[side], forward=forward)
        feet.append(_foot_contacts(foot, still[side], ball_heights[side], options))
    return Contacts(left=feet[0], right=feet[1])


def _signals(motion: FootMotion, grid: FloatArray, options: ContactOptions) -> list[PointSignal]:
    """Left and right ball, left and right heel."""
    return point_signals(
        motion.times,
        np.concatenate([motion.balls, motion.heels], axis=1),
        grid,
        smoothing=options.smoothing,
        calming=options.calming,
        still_fraction=options.still_fraction,
        still_limits=options.still_limits,
        neighbourhood=options.neighbourhood,
    )


@dataclass(frozen=True, kw_only=True)
class _Foot:
    """What the contacts of one foot are found from, on the fine grid."""

    grid: FloatArray
    """Times [s], shape (N,)."""
    ball: PointSignal
    heel: PointSignal
    heel_still: BoolArray
    """Where the heel stands still, shape (N,)."""
    forward: FloatArray
    """From ankle to ball, (x, z) [m], shape (N, 2)."""


def _foot_contacts(foot: _Foot, still: BoolArray, ball_height: float, options: ContactOptions) -> FootContacts:
    """Events and places of one foot's contacts from the coarse intervals in which its ball is still."""
    starts, ends = intervals_of(still)
    before, after = np.append(-1, ends)[:-1], np.append(starts, len(foot.grid))[1:]
    limits = zip(before, starts, ends, after, strict=True)
    events = np.array([_events(foot, *indices, options) for indices in limits]).reshape(-1, 3)
    quarters = (ends - starts) // 4
    cores = [slice(start, end + 1) for start, end in zip(starts + quarters, ends - quarters, strict=True)]
    balls = np.array([foot.ball.positions[core].mean(axis=0) for core in cores]).reshape(-1, 3)
    yaws = [planar.circular_mean(planar.yaw_of(foot.forward[core])) for core in cores]
    strikes, downs, liftoffs = events.T
    return FootContacts(
        strike_times=strikes,
        flat_times=flat_times(strikes, downs, liftoffs, options=options),
        liftoff_times=liftoffs,
        positions=balls - np.array([0.0, ball_height, 0.0]),
        yaws=np.array(yaws, dtype=float),
        ball_first=strikes >= downs - BALL_FIRST_MARGIN,
    )


def _events(
    foot: _Foot, previous: int, start: int, end: int, following: int, options: ContactOptions
) -> tuple[float, float, float]:
    """Strike, ball down and liftoff [s] of the contact whose ball is still from index start to end.

    The contacts before and after it end at `previous` and start at `following`.
    """
    heights = foot.ball.positions[:, 1]
    highest = np.median(heights[start : end + 1]) + options.lift
    landed = start + int(np.argmax(heights[start : end + 1] <= highest))  # slow it may be, but not down yet
    ball_down = still_start(foot.grid, foot.ball, landed, end, previous)
    liftoff = still_end(foot.grid, foot.ball, landed, end, following, highest)
    first = _heel_down(foot.heel, foot.heel_still, landed, end, previous, options.heel_lift)
    heel_down = still_start(foot.grid, foot.heel, first, end, previous) if first < landed else ball_down
    if liftoff - ball_down < options.shortest_contact:
        ball_down, liftoff = float(foot.grid[start]), float(foot.grid[end])
    if start == 0 or (first == 0 and heel_down < ball_down):
        ball_down = heel_down = -np.inf
    return min(heel_down, ball_down), ball_down, liftoff if end < len(foot.grid) - 1 else np.inf


def _heel_down(heel: PointSignal, still: BoolArray, start: int, end: int, previous: int, lift: float) -> int:
    """First index at which the heel stands before the ball comes down, or `start` if the ball is first."""
    lowest = heel.positions[start : end + 1, 1].min()
    down = still & (heel.positions[:, 1] < lowest + lift)
    up = np.flatnonzero(~down[previous + 1 : start + 1])
    return previous + 1 + (int(up[-1]) + 1 if up.size else 0) if down[start] else start


def flat_times(
    strikes: FloatArray, balls_down: FloatArray, liftoffs: FloatArray, *, options: ContactOptions
) -> FloatArray:
    """Times from which the foot counts as planted (design.md section 2) [s], shape (K,)."""
    with np.errstate(invalid="ignore"):
        rolls = np.minimum(options.longest_roll, options.roll_fraction * (liftoffs - strikes))
        return np.where(np.isfinite(strikes), np.clip(balls_down, strikes, strikes + rolls), strikes)
