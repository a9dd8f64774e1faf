"""Contacts: when and where the feet of clips stand (design.md section 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from usdfoot.analysis.contact_options import LEG_LENGTH, ContactOptions
from usdfoot.analysis.motion import FootMotion
from usdfoot.analysis.refine import Speeds, still_ends, still_starts
from usdfoot.analysis.signals import PointSignals, point_signals
from usdfoot.analysis.stillness import still_balls, still_points
from usdfoot.maths import planar
from usdfoot.maths.runs import Runs, expand, first_where, last_where, means_of, medians_of
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contacts import Contacts, FootContacts

__all__ = ["contacts_of", "flat_times", "select_contacts"]

BALL_FIRST_MARGIN = 0.008
"""The ball counts as down first unless the heel is down so much earlier [s]."""


def contacts_of(
    motions: Sequence[FootMotion], *, ball_heights: FloatArray, leg_lengths: FloatArray, options: ContactOptions
) -> list[Contacts]:
    """Contacts of both feet of C motions that travel.

    Args:
        motions: World trajectories of the feet.
        ball_heights: Ball joints above the sole [m], shape (C, 2).
        leg_lengths: Hip to ankle with the knee straight [m], the measure of all thresholds, shape (C,).
        options: Thresholds.
    """
    scales = leg_lengths / LEG_LENGTH
    signals = point_signals(motions, scales, options)
    still = still_points(signals, scales, options)
    feet = _Feet(
        runs=signals.clips.repeated(2),
        clips=np.tile(np.arange(len(motions)), 2),
        times=np.tile(signals.times, 2),
        balls=_speeds(signals, 0),
        heels=_speeds(signals, 2),
        ball_positions=signals.positions[:2].reshape(-1, 3),
        heel_heights=signals.positions[2:, :, 1].ravel(),
        heels_still=still[2:].ravel(),
    )
    starts, ends = feet.runs.intervals(still_balls(signals, still, scales, options=options).ravel())
    strikes, downs, liftoffs = _events(feet, starts, ends, scales, options)
    quarters = (ends - starts) // 4
    first, last = starts + quarters, ends - quarters
    owners = feet.runs.owners_of(starts)
    positions = means_of(feet.ball_positions, first, last)
    positions[:, 1] -= ball_heights.T.ravel()[owners]
    directions = planar.yaw_of(_directions(motions, signals))
    sines, cosines = (means_of(wave(directions), first, last) for wave in (np.sin, np.cos))
    every = FootContacts(
        strike_times=strikes,
        flat_times=flat_times(strikes, downs, liftoffs, options=options),
        liftoff_times=liftoffs,
        positions=positions,
        yaws=np.arctan2(sines, cosines),
        ball_first=strikes >= downs - BALL_FIRST_MARGIN,
    )
    bounds = np.searchsorted(owners, np.arange(2 * len(motions) + 1))
    parts = [select_contacts(every, slice(*pair)) for pair in pairwise(bounds.tolist())]
    return [
        Contacts(left=left, right=right)
        for left, right in zip(parts[: len(motions)], parts[len(motions) :], strict=True)
    ]


def select_contacts(foot: FootContacts, keep: BoolArray | slice) -> FootContacts:
    """Contacts of K that `keep`, an index of arrays, chooses."""
    return FootContacts(
        strike_times=foot.strike_times[keep],
        flat_times=foot.flat_times[keep],
        liftoff_times=foot.liftoff_times[keep],
        positions=foot.positions[keep],
        yaws=foot.yaws[keep],
        ball_first=foot.ball_first[keep],
    )


@dataclass(frozen=True, kw_only=True)
class _Feet:
    """What contacts are found from: left feet of all clips, then right feet, N samples on the fine grid."""

    runs: Runs
    clips: IntArray
    """Clip of each run, shape (2 C,)."""
    times: FloatArray
    """[s], shape (N,)."""
    balls: Speeds
    heels: Speeds
    ball_positions: FloatArray
    """World [m], shape (N, 3)."""
    heel_heights: FloatArray
    """[m], shape (N,)."""
    heels_still: BoolArray
    """Where the heel stands still, shape (N,)."""


def _speeds(signals: PointSignals, first: int) -> Speeds:
    """Speeds of the point `first` and the next one, those of the left and the right foot."""
    own = slice(first, first + 2)
    return Speeds(
        times=np.tile(signals.times, 2),
        speeds=signals.speeds[own].ravel(),
        thresholds=signals.thresholds[own].ravel(),
        rates=np.tile(signals.rates[signals.clips.owners], 2),
    )


def _directions(motions: Sequence[FootMotion], signals: PointSignals) -> FloatArray:
    """From ankle to ball, (x, z) [m], of the left feet, then the right feet, on the grid, shape (N, 2)."""
    parts = []
    for side in range(2):
        for motion, grid in zip(motions, np.split(signals.times, signals.clips.first[1:-1]), strict=True):
            forward = (motion.balls - motion.ankles)[:, side]
            parts.append(np.stack([np.interp(grid, motion.times, forward[:, axis]) for axis in (0, 2)], axis=-1))
    return np.concatenate(parts)


def _events(
    feet: _Feet, starts: IntArray, ends: IntArray, scales: FloatArray, options: ContactOptions
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Strikes, balls down and liftoffs [s] of contacts whose ball is still from index start to end, shapes (K,)."""
    owners = feet.runs.owners_of(starts)
    scale, times = scales[feet.clips[owners]], feet.times
    heads, tails = feet.runs.first[:-1][owners], feet.runs.first[1:][owners] - 1
    previous = np.maximum(np.append(-1, ends)[:-1], heads - 1)  # end of the contact before, of the same foot
    following = np.minimum(np.append(starts, len(times))[1:], tails)  # start of the next
    heights = feet.ball_positions[:, 1]
    highest = medians_of(heights, starts, ends) + scale * options.lift
    indices, own = expand(starts, ends)
    # The ball may be slow before it is down.
    landed = first_where(heights[indices] <= highest[own], indices, own, missing=starts)
    limits = np.maximum(previous, heads)
    balls_down = still_starts(feet.balls, landed, ends, limits=limits)
    liftoffs = np.minimum(
        still_ends(feet.balls, landed, ends, limits=following), _raised(feet, landed, ends, following, highest)
    )
    first = _heels_down(feet, landed, ends, previous + 1, scale * options.heel_lift)
    heels_down = balls_down.copy()
    early = np.flatnonzero(first < landed)
    heels_down[early] = still_starts(feet.heels, first[early], ends[early], limits=limits[early])
    brief = liftoffs - balls_down < options.shortest_contact
    balls_down, liftoffs = np.where(brief, times[starts], balls_down), np.where(brief, times[ends], liftoffs)
    cut = (starts == heads) | ((first == heads) & (heels_down < balls_down))
    balls_down = np.where(cut, -np.inf, balls_down)
    strikes = np.where(cut, -np.inf, np.minimum(heels_down, balls_down))
    return strikes, balls_down, np.where(ends < tails, liftoffs, np.inf)


def _raised(feet: _Feet, starts: IntArray, ends: IntArray, limits: IntArray, highest: FloatArray) -> FloatArray:
    """First times in the second half of contacts or after them at which the ball is up [s], infinite if never, (K,)."""
    indices, own = expand((starts + ends) // 2, limits)
    found = first_where(feet.ball_positions[indices, 1] >= highest[own], indices, own, missing=limits + 1)
    return np.where(found <= limits, feet.times[np.minimum(found, limits)], np.inf)


def _heels_down(feet: _Feet, starts: IntArray, ends: IntArray, limits: IntArray, lifts: FloatArray) -> IntArray:
    """First indices at which the heel stands before the ball comes down, or the start if the ball is first, (K,)."""
    indices, own = expand(starts, ends)
    lowest = np.full(len(starts), np.inf)
    np.minimum.at(lowest, own, feet.heel_heights[indices])
    highest = lowest + lifts
    indices, own = expand(limits, starts)
    up = ~(feet.heels_still[indices] & (feet.heel_heights[indices] < highest[own]))
    return np.minimum(last_where(up, indices, own, missing=limits - 1) + 1, starts)


def flat_times(
    strikes: FloatArray, balls_down: FloatArray, liftoffs: FloatArray, *, options: ContactOptions
) -> FloatArray:
    """Times from which the foot counts as planted (design.md section 2) [s], shape (K,)."""
    with np.errstate(invalid="ignore"):
        rolls = np.minimum(options.longest_roll, options.roll_fraction * (liftoffs - strikes))
        return np.where(np.isfinite(strikes), np.clip(balls_down, strikes, strikes + rolls), strikes)
