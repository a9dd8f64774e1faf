"""Contacts: when and where the feet of a clip stand (design.md section 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from usdfoot.analysis.motion import FootMotion
from usdfoot.analysis.refine import still_end, still_start
from usdfoot.analysis.signals import PointSignal, fine_times, point_signal
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.contacts import Contacts, FootContacts

__all__ = ["ContactOptions", "contacts_of"]


@dataclass(frozen=True, kw_only=True)
class ContactOptions:
    """Thresholds of contact detection; lengths and speeds are for a leg of 0.8 m and scale with the leg."""

    fine_rate: float = 240.0
    """Least number of samples a second the events are looked for in [Hz]."""
    smoothing: float = 0.003
    """Standard deviation of the smoothing of positions [s]."""
    still_fraction: float = 0.08
    """A point is still below this fraction of the fastest it moves nearby."""
    still_limits: tuple[float, float] = (0.1, 0.8)
    """Least and greatest speed below which a point is still [m/s]."""
    neighbourhood: float = 0.5
    """How far to look for the fastest motion [s]."""
    hysteresis: float = 1.6
    """A contact goes on until the speed exceeds this multiple of the threshold."""
    shortest_contact: float = 0.05
    """Shorter contacts are dropped [s]."""
    touch_spacing: float = 0.15
    """A shorter stillness of a foot at its lowest counts too where no contact is this near [s]."""
    shortest_swing: float = 0.07
    """Shorter gaps between contacts are closed [s]."""
    median_width: float = 0.03
    """Width of the median filter [s]."""
    lift: float = 0.015
    """The ball has left the ground when it is this much above its height in the contact [m]."""
    heel_lift: float = 0.03
    """The heel is down when it is no more than this above its lowest in the contact [m]."""
    raised: float = 0.05
    """A still foot so much above the other standing one must carry the body alone at some time [m]."""
    longest_roll: float = 0.12
    """Flat is at most this long after the strike [s] (design.md section 2)."""
    roll_fraction: float = 0.25
    """Flat is at most this part of the contact after the strike (design.md section 2)."""


def contacts_of(motion: FootMotion, *, ball_heights: FloatArray, leg_length: float, options: ContactOptions) -> Contacts:
    """Contacts of both feet of a motion that travels.

    Args:
        motion: World trajectories of the feet.
        ball_heights: Ball joints above the sole [m], shape (2,).
        leg_length: Hip to ankle with the knee straight [m], the measure of all thresholds.
        options: Thresholds.
    """
    scale = leg_length / 0.8
    rate = (len(motion.times) - 1) / (motion.times[-1] - motion.times[0])
    grid = fine_times(motion.times[0], len(motion.times), rate, options.fine_rate)
    balls = [_signal(motion, motion.balls[:, side], grid, scale, options) for side in range(2)]
    heels = [_signal(motion, motion.heels[:, side], grid, scale, options) for side in range(2)]
    still = np.stack([_still_intervals(ball, grid, options) for ball in balls])  # (2, N)
    still = _without_raised(still, balls, scale * options.raised)
    feet = []
    for side in range(2):
        forward = np.stack([np.interp(grid, motion.times, (motion.balls - motion.ankles)[:, side, i]) for i in (0, 2)], -1)
        feet.append(
            _foot_contacts(grid, still[side], balls[side], heels[side], forward, ball_heights[side], scale, options)
        )
    return Contacts(left=feet[0], right=feet[1])


def _signal(
    motion: FootMotion, positions: FloatArray, grid: FloatArray, scale: float, options: ContactOptions
) -> PointSignal:
    low, high = options.still_limits
    return point_signal(
        motion.times,
        positions,
        grid,
        smoothing=options.smoothing,
        still_fraction=options.still_fraction,
        still_limits=(scale * low, scale * high),
        neighbourhood=options.neighbourhood,
    )


def intervals_of(flags: BoolArray) -> tuple[FloatArray, FloatArray]:
    """First and last index of every run of True in flags (N,)."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1


def flags_of(starts: FloatArray, ends: FloatArray, size: int) -> BoolArray:
    """Flags (N,) that are True from each start to its end, both included."""
    edges = np.zeros(size + 1, dtype=int)
    np.add.at(edges, starts, 1)
    np.add.at(edges, ends + 1, -1)
    return np.cumsum(edges[:-1]) > 0


def _still_intervals(signal: PointSignal, grid: FloatArray, options: ContactOptions) -> BoolArray:
    """Where a point stands still: hysteresis, median filter, shortest gap and duration; shape (N,)."""
    step = grid[1] - grid[0]
    slow = signal.speeds < signal.thresholds
    loose = signal.speeds < options.hysteresis * signal.thresholds
    flags = _containing(loose, slow)
    width = 2 * int(0.5 * options.median_width / step) + 1
    flags = median_filter(flags.astype(np.uint8), size=width, mode="nearest").astype(bool)
    flags = _without_gaps(flags, signal, int(options.shortest_swing / step))
    starts, ends = intervals_of(flags)
    at_end = (starts == 0) | (ends == len(grid) - 1)
    long = (ends - starts) * step >= np.where(at_end, 0.4, 1.0) * options.shortest_contact
    flags = flags_of(starts[long], ends[long], len(grid))
    return flags | _touches(signal, loose, flags, step, options)


def _touches(
    signal: PointSignal, loose: BoolArray, flags: BoolArray, step: float, options: ContactOptions
) -> BoolArray:
    """Contacts of runs keyed or sampled so coarsely that the foot hardly stands still, shape (N,).

    The point is slow for an instant, about as low as it ever comes, and stands nowhere near that time.
    """
    size = 2 * int(options.touch_spacing / step) + 1
    apart = ~maximum_filter1d(flags.astype(np.uint8), size, mode="nearest").astype(bool)
    heights = signal.positions[:, 1]
    low = heights < np.quantile(heights, 0.02) + options.lift
    return _containing(low, loose & apart)


def _containing(flags: BoolArray, needed: BoolArray) -> BoolArray:
    """The runs of flags (N,) in which `needed` (N,) is True somewhere."""
    starts, ends = intervals_of(flags)
    counts = np.concatenate([[0], np.cumsum(needed & flags)])
    keep = counts[ends + 1] > counts[starts]
    return flags_of(starts[keep], ends[keep], len(flags))


def _without_gaps(flags: BoolArray, signal: PointSignal, shortest: int) -> BoolArray:
    """Flags with gaps closed that are shorter than `shortest` samples and lead nowhere."""
    starts, ends = intervals_of(flags)
    gap_starts, gap_ends = ends[:-1] + 1, starts[1:] - 1
    jump = np.linalg.norm(signal.positions[gap_ends] - signal.positions[gap_starts], axis=-1)
    close = (gap_ends - gap_starts < shortest) & (jump < 0.05)
    return flags | flags_of(gap_starts[close], gap_ends[close], len(flags))


def _without_raised(still: BoolArray, balls: list[PointSignal], raised: float) -> BoolArray:
    """Flags (2, N) without those intervals in which a foot is held still in the air.

    Such a foot is well above the other one, which stands all the time: it never carries the body alone. A foot on a
    stair does, when the other one follows.
    """
    result = still.copy()
    for side in range(2):
        for start, end in zip(*intervals_of(still[side]), strict=True):
            other = still[1 - side, start : end + 1]
            height = balls[side].positions[start : end + 1, 1] - balls[1 - side].positions[start : end + 1, 1]
            if other.mean() > 0.95 and np.median(height) > raised:
                result[side, start : end + 1] = False
    return result


def _foot_contacts(
    grid: FloatArray,
    still: BoolArray,
    ball: PointSignal,
    heel: PointSignal,
    forward: FloatArray,
    ball_height: float,
    scale: float,
    options: ContactOptions,
) -> FootContacts:
    """Events and places of one foot's contacts from its coarse intervals."""
    heel_still = _still_intervals(heel, grid, options)
    count = len(grid)
    rows = []
    positions, yaws = [], []
    starts, ends = intervals_of(still)
    for k, (start, end) in enumerate(zip(starts, ends, strict=True)):
        previous = ends[k - 1] if k else -1
        following = starts[k + 1] if k + 1 < len(starts) else count
        floor = np.median(ball.positions[start : end + 1, 1])
        ball_down = still_start(grid, ball, start, end, previous)
        liftoff = still_end(grid, ball, start, end, following, floor + scale * options.lift)
        first = _heel_down(heel, heel_still, start, end, previous, scale * options.heel_lift)
        heel_down = still_start(grid, heel, first, end, previous) if first < start else ball_down
        if liftoff - ball_down < options.shortest_contact:
            ball_down, liftoff = float(grid[start]), float(grid[end])
        if start == 0 or (first == 0 and heel_down < ball_down):
            ball_down = heel_down = -np.inf
        ball_first = heel_down >= ball_down - 0.008
        rows.append((min(heel_down, ball_down), ball_down, liftoff if end < count - 1 else np.inf, ball_first))
        core = slice(start + (end - start) // 4, end - (end - start) // 4 + 1)
        positions.append(ball.positions[core].mean(axis=0) - np.array([0.0, ball_height, 0.0]))
        yaws.append(planar.circular_mean(planar.yaw_of(forward[core])))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    strikes, downs, liftoffs = table[:, 0], table[:, 1], table[:, 2]
    return FootContacts(
        strike_times=strikes,
        flat_times=flat_times(strikes, downs, liftoffs, options=options),
        liftoff_times=liftoffs,
        positions=np.array(positions).reshape(-1, 3),
        yaws=np.array(yaws),
        ball_first=table[:, 3].astype(bool),
    )


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
