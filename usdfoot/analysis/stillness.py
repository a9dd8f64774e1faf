"""Stillness: the coarse intervals in which the points of feet stand still."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.grids import samples_within
from usdfoot.analysis.signals import PointSignals
from usdfoot.maths.runs import Runs, flags_of
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["still_balls", "still_points"]


def still_points(signals: PointSignals, scales: FloatArray, options: ContactOptions) -> BoolArray:
    """Where points stand still: hysteresis, median filter, shortest gap and duration; shape (P, N).

    Args:
        signals: Of P points of C clips.
        scales: What lengths of the options are multiplied with for each clip, shape (C,).
        options: Thresholds.
    """
    points = len(signals.positions)
    runs, steps = signals.clips.repeated(points), np.tile(signals.steps, points)
    places, speeds = signals.positions.reshape(-1, 3), signals.calm_speeds.ravel()
    thresholds, lifts = signals.thresholds.ravel(), np.tile(scales, points) * options.lift
    loose = speeds < options.hysteresis * thresholds
    flags = _containing(runs, loose, speeds < thresholds)
    reach = samples_within(0.5 * options.median_width, steps)
    flags = runs.counts_near(flags, reach) > reach[runs.owners]
    flags = _without_gaps(runs, flags, places, samples_within(options.shortest_swing, steps), lifts)
    starts, ends = runs.intervals(flags)
    owners = runs.owners_of(starts)
    at_end = (starts == runs.first[:-1][owners]) | (ends == runs.first[1:][owners] - 1)
    long = (ends - starts) * steps[owners] >= np.where(at_end, 0.4, 1.0) * options.shortest_contact
    flags = flags_of(starts[long], ends[long], len(flags))
    near = runs.counts_near(flags, samples_within(options.touch_spacing, steps))
    flags |= _touches(runs, places[:, 1], loose & (near == 0), lifts)
    return flags.reshape(points, -1)


def _touches(runs: Runs, heights: FloatArray, slow_apart: BoolArray, lifts: FloatArray) -> BoolArray:
    """Contacts of runs keyed or sampled so coarsely that the foot hardly stands still, shape (N,).

    The point is slow for an instant, about as low as it ever comes, and stands nowhere near that time.
    """
    lowest = np.array([np.quantile(part, 0.02) for part in np.split(heights, runs.first[1:-1])])
    low = heights < (lowest + lifts)[runs.owners]
    return _containing(runs, low, slow_apart)


def _containing(runs: Runs, flags: BoolArray, needed: BoolArray) -> BoolArray:
    """The intervals of flags (N,) in which `needed` (N,) is True somewhere."""
    starts, ends = runs.intervals(flags)
    counts = np.concatenate([[0], np.cumsum(needed & flags)])
    keep = counts[ends + 1] > counts[starts]
    return flags_of(starts[keep], ends[keep], len(flags))


def _without_gaps(
    runs: Runs, flags: BoolArray, positions: FloatArray, shortest: IntArray, lifts: FloatArray
) -> BoolArray:
    """Flags (N,) with gaps closed that are shorter than `shortest` samples (R,) and lead nowhere, not even down."""
    starts, ends = runs.intervals(flags)
    owners = runs.owners_of(starts)
    within = owners[1:] == owners[:-1]
    gap_starts, gap_ends, owners = ends[:-1][within] + 1, starts[1:][within] - 1, owners[1:][within]
    moves = positions[gap_ends] - positions[gap_starts]
    close = (np.linalg.norm(moves, axis=-1) < 3.0 * lifts[owners]) & (moves[:, 1] > -lifts[owners])
    close &= gap_ends - gap_starts < shortest[owners]
    return flags | flags_of(gap_starts[close], gap_ends[close], len(flags))


def still_balls(signals: PointSignals, still: BoolArray, scales: FloatArray, *, options: ContactOptions) -> BoolArray:
    """Where both balls stand on the ground, shape (2, N): still, and neither on their way nor held up.

    Args:
        signals: Of both balls and both heels.
        still: From `still_points`, shape (4, N).
        scales: What lengths of the options are multiplied with for each clip, shape (C,).
        options: Thresholds.
    """
    runs = signals.clips.repeated(2)
    heights = signals.positions[:2, :, 1].ravel()
    lifts, reach = np.tile(scales, 2) * options.lift, np.tile(samples_within(options.shortest_swing, signals.steps), 2)
    balls = _without_pauses(runs, still[:2].ravel(), heights, lifts, reach)
    balls = _without_rolls(runs, balls, still[2:].ravel(), heights, lifts)
    return _without_raised(signals.clips, balls.reshape(2, -1), heights.reshape(2, -1), scales * options.raised)


def _without_pauses(runs: Runs, still: BoolArray, heights: FloatArray, lifts: FloatArray, reach: IntArray) -> BoolArray:
    """Flags (N,) without those intervals in which the foot only pauses in the air.

    It came up into such an interval from well below, or from a little below and goes down again: a foot comes down to
    where it stands and leaves it upward. Looked at are `reach` (R,) samples before and after; a little is `lifts` (R,)
    [m], well is twice as much.
    """
    starts, ends = runs.intervals(still)
    owners = runs.owners_of(starts)
    back, lift = np.arange(reach.max(initial=0) + 1), lifts[owners]
    first = np.maximum(starts - reach[owners], runs.first[:-1][owners])
    last = np.minimum(ends + reach[owners], runs.first[1:][owners] - 1)
    rises = heights[starts] - heights[np.maximum(starts[:, None] - back, first[:, None])].min(axis=1)
    falls = heights[ends] - heights[np.minimum(ends[:, None] + back, last[:, None])].min(axis=1)
    keep = (rises <= 2.0 * lift) & ((rises <= lift) | (falls <= lift))
    return flags_of(starts[keep], ends[keep], len(still))


def _without_rolls(
    runs: Runs, still: BoolArray, heel_still: BoolArray, heights: FloatArray, lifts: FloatArray
) -> BoolArray:
    """Flags (N,) without those instants at which the ball pauses in the air on its way from heel strike to flat."""
    starts, ends = runs.intervals(still)
    if not len(starts):
        return still
    owners = runs.owners_of(starts)
    following = np.append(starts[1:], starts[-1])
    is_followed = np.append(owners[1:] == owners[:-1], False)
    moving = np.concatenate([[0], np.cumsum(~heel_still)])
    lowered = heights[starts] - heights[following] > lifts[owners]
    rolls = is_followed & lowered & (moving[following] == moving[ends])
    return flags_of(starts[~rolls], ends[~rolls], len(still))


def _without_raised(clips: Runs, still: BoolArray, heights: FloatArray, raised: FloatArray) -> BoolArray:
    """Flags (2, N) without those intervals in which a foot is held still in the air.

    Such a foot is well above the other one, by `raised` (C,) [m], which stands all the time: it never carries the body
    alone. A foot on a stair does, when the other one follows.
    """
    result = still.copy()
    for side in range(2):
        starts, ends = clips.intervals(still[side])
        others = np.concatenate([[0], np.cumsum(still[1 - side])])
        doubtful = np.flatnonzero(others[ends + 1] - others[starts] > 0.95 * (ends - starts + 1))
        limits = raised[clips.owners_of(starts)]
        for interval in doubtful:
            own = slice(starts[interval], ends[interval] + 1)
            if np.median(heights[side, own] - heights[1 - side, own]) > limits[interval]:
                result[side, own] = False
    return result
