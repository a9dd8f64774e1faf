"""Stillness: the coarse intervals in which a point of a foot stands still."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.signals import PointSignal, samples_within
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["flags_of", "intervals_of", "still_flags", "without_pauses", "without_raised", "without_rolls"]


def intervals_of(flags: BoolArray) -> tuple[IntArray, IntArray]:
    """First and last index of every run of True in flags (N,)."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1


def flags_of(starts: IntArray, ends: IntArray, size: int) -> BoolArray:
    """Flags (N,) that are True from each start to its end, both included."""
    edges = np.zeros(size + 1, dtype=int)
    np.add.at(edges, starts, 1)
    np.add.at(edges, ends + 1, -1)
    return np.cumsum(edges[:-1]) > 0


def still_flags(signal: PointSignal, grid: FloatArray, options: ContactOptions) -> BoolArray:
    """Where a point stands still: hysteresis, median filter, shortest gap and duration; shape (N,)."""
    step = grid[1] - grid[0]
    slow = signal.calm_speeds < signal.thresholds
    loose = signal.calm_speeds < options.hysteresis * signal.thresholds
    flags = _containing(loose, slow)
    width = 2 * samples_within(0.5 * options.median_width, step) + 1
    flags = median_filter(flags.astype(np.uint8), size=width, mode="nearest").astype(bool)
    flags = _without_gaps(flags, signal, samples_within(options.shortest_swing, step), options.lift)
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
    size = 2 * samples_within(options.touch_spacing, step) + 1
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


def _without_gaps(flags: BoolArray, signal: PointSignal, shortest: int, lift: float) -> BoolArray:
    """Flags (N,) with gaps closed that are shorter than `shortest` samples and lead nowhere, not even down."""
    starts, ends = intervals_of(flags)
    gap_starts, gap_ends = ends[:-1] + 1, starts[1:] - 1
    moves = signal.positions[gap_ends] - signal.positions[gap_starts]
    close = (np.linalg.norm(moves, axis=-1) < 3.0 * lift) & (moves[:, 1] > -lift)
    close &= gap_ends - gap_starts < shortest
    return flags | flags_of(gap_starts[close], gap_ends[close], len(flags))


def without_raised(still: BoolArray, balls: list[PointSignal], raised: float) -> BoolArray:
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


def without_pauses(still: BoolArray, ball: PointSignal, lift: float, reach: int) -> BoolArray:
    """Flags (N,) without those intervals in which the foot only pauses in the air.

    It came up into such an interval from well below, or from a little below and goes down again: a foot comes down to
    where it stands and leaves it upward.

    Args:
        still: Where the ball stands still, shape (N,).
        ball: The ball.
        lift: A little [m]; well is twice as much.
        reach: How far before and after to look [samples].
    """
    result = still.copy()
    heights = ball.positions[:, 1]
    starts, ends = intervals_of(still)
    for start, end in zip(starts, ends, strict=True):
        rise = heights[start] - heights[max(start - reach, 0) : start + 1].min()
        fall = heights[end] - heights[end : end + reach + 1].min()
        if rise > 2.0 * lift or (rise > lift and fall > lift):
            result[start : end + 1] = False
    return result


def without_rolls(still: BoolArray, heel_still: BoolArray, ball: PointSignal, lift: float) -> BoolArray:
    """Flags (N,) without those instants at which the ball pauses in the air on its way from heel strike to flat."""
    result = still.copy()
    starts, ends = intervals_of(still)
    for start, end, following in zip(starts[:-1], ends[:-1], starts[1:], strict=True):
        lowered = ball.positions[start, 1] - ball.positions[following, 1] > lift
        if lowered and heel_still[end:following].all():
            result[start : end + 1] = False
    return result
