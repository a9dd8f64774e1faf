"""Signals: smooth fine-grained trajectories of the feet's points, and how fast and high they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.grids import fine_times, samples_within
from usdfoot.analysis.motion import FootMotion
from usdfoot.maths.runs import Runs
from usdfoot.maths.splines import Splines, build_splines
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["PointSignals", "point_signals"]


@dataclass(frozen=True, kw_only=True)
class PointSignals:
    """P points of the feet of C clips on a fine grid; the N times of all clips are end to end."""

    clips: Runs
    """The clips' stretches of the grid."""
    times: FloatArray
    """The grid [s], shape (N,)."""
    steps: FloatArray
    """Its spacing in each clip [s], shape (C,)."""
    rates: FloatArray
    """Samples a second of each clip [Hz], shape (C,)."""
    positions: FloatArray
    """World [m], shape (P, N, 3)."""
    speeds: FloatArray
    """Length of the velocity [m/s], shape (P, N)."""
    calm_speeds: FloatArray
    """The same of smoother trajectories, for coarse decisions [m/s], shape (P, N)."""
    thresholds: FloatArray
    """Speed below which a point counts as still, from the fastest it moves nearby [m/s], shape (P, N)."""


def point_signals(motions: Sequence[FootMotion], scales: FloatArray, options: ContactOptions) -> PointSignals:
    """Left and right ball, left and right heel of clips, by C2 splines through lightly smoothed samples.

    Args:
        motions: Of the clips' feet.
        scales: What speeds of the options are multiplied with for each clip, shape (C,).
        options: Thresholds.
    """
    rates = np.array([(len(motion.times) - 1) / (motion.times[-1] - motion.times[0]) for motion in motions])
    grids = [
        fine_times(motion.times[0], len(motion.times), rate, fine_rate=options.fine_rate)
        for motion, rate in zip(motions, rates, strict=True)
    ]
    clips, times = Runs.of_lengths(np.array([len(grid) for grid in grids])), np.concatenate(grids)
    points = [np.concatenate([motion.balls, motion.heels], axis=1) for motion in motions]  # (T, P, 3)
    first = Runs.of_lengths(np.array([len(part) for part in points])).first
    starts, owners = np.array([motion.times[0] for motion in motions]), clips.owners

    def splines(smoothing: float) -> Splines:
        smooth = [_smoothed(part, smoothing * rate) for part, rate in zip(points, rates, strict=True)]
        return build_splines(np.concatenate(smooth).reshape(first[-1], -1), first=first, starts=starts, rates=rates)

    def by_point(vectors: FloatArray) -> FloatArray:
        return np.ascontiguousarray(vectors.reshape(len(times), -1, 3).swapaxes(0, 1))

    light = splines(options.smoothing)
    calm_speeds = _lengths(by_point(splines(options.calming).rates_at(owners, times)))
    steps = np.array([grid[1] - grid[0] for grid in grids])
    fastest = _largest_near(calm_speeds, clips, samples_within(options.neighbourhood, steps))
    low, high = (limit * scales[owners] for limit in options.still_limits)
    return PointSignals(
        clips=clips,
        times=times,
        steps=steps,
        rates=rates,
        positions=by_point(light.at(owners, times)),
        speeds=_lengths(by_point(light.rates_at(owners, times))),
        calm_speeds=calm_speeds,
        thresholds=np.clip(options.still_fraction * fastest, low, high),
    )


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors (P, N, 3), shape (P, N)."""
    return np.sqrt(np.einsum("pni,pni->pn", vectors, vectors))


def _largest_near(values: FloatArray, clips: Runs, reach: IntArray) -> FloatArray:
    """Largest of the values (P, N) up to `reach` (C,) samples away in the same clip."""
    bounds = zip(clips.first[:-1], clips.first[1:], reach, strict=True)
    parts = [
        maximum_filter1d(values[:, begin:end], 2 * int(size) + 1, axis=1, mode="nearest") for begin, end, size in bounds
    ]
    return np.concatenate(parts, axis=1)


def _smoothed(positions: FloatArray, sigma: float) -> FloatArray:
    """Positions (T, P, 3) after a Gaussian of `sigma` samples that keeps straight motion at the ends straight."""
    if sigma < 0.2:
        return positions
    pad = min(int(4 * sigma) + 1, len(positions) - 1)
    before = 2.0 * positions[0] - positions[pad:0:-1]
    after = 2.0 * positions[-1] - positions[-2 : -pad - 2 : -1]
    return gaussian_filter1d(np.concatenate([before, positions, after]), sigma, axis=0)[pad:-pad]
