"""Signals: smooth fine-grained trajectories of a foot's points, and how fast and high they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from usdfoot.maths.types import FloatArray

__all__ = ["PointSignal", "fine_times", "point_signals", "samples_within"]

ROUNDING = 1e-6
"""Part of a sample that does not count: rates and times come from time codes with rounding errors."""


@dataclass(frozen=True, kw_only=True)
class PointSignal:
    """One point of a foot on the fine grid of N times."""

    positions: FloatArray
    """World [m], shape (N, 3)."""
    speeds: FloatArray
    """Length of the velocity [m/s], shape (N,)."""
    calm_speeds: FloatArray
    """The same of a smoother trajectory, for coarse decisions [m/s], shape (N,)."""
    thresholds: FloatArray
    """Speed below which the point counts as still, from the fastest it moves nearby [m/s], shape (N,)."""
    rate: float
    """Samples a second of the clip [Hz]."""


def fine_times(start_time: float, frames: int, rate: float, fine_rate: float) -> FloatArray:
    """Times that divide every sample interval evenly, at least `fine_rate` a second [s], shape (N,)."""
    parts = max(1, int(np.ceil(fine_rate / rate - ROUNDING)))
    return start_time + np.arange((frames - 1) * parts + 1) / (rate * parts)


def samples_within(duration: float, step: float) -> int:
    """Whole samples `step` [s] apart that fit into a duration [s], whatever the last digits of the two."""
    return int(duration / step + ROUNDING)


def point_signals(
    times: FloatArray,
    positions: FloatArray,
    grid: FloatArray,
    *,
    smoothing: float,
    calming: float,
    still_fraction: float,
    still_limits: tuple[float, float],
    neighbourhood: float,
) -> list[PointSignal]:
    """Trajectories of P points on a fine grid, by C2 splines through lightly smoothed samples.

    Args:
        times: Sample times [s], shape (T,).
        positions: Samples [m], shape (T, P, 3).
        grid: Times wanted, within `times` [s], shape (N,).
        smoothing: Standard deviation of the Gaussian that takes noise off [s].
        calming: The same for the coarse decisions [s].
        still_fraction: Still below this fraction of the fastest speed in the neighbourhood.
        still_limits: Least and greatest threshold [m/s].
        neighbourhood: Half width of the neighbourhood [s].
    """
    rate = (len(times) - 1) / (times[-1] - times[0])
    spline = CubicSpline(times, _smoothed(positions, smoothing * rate))
    calm_speeds = _lengths(CubicSpline(times, _smoothed(positions, calming * rate))(grid, 1))
    size = 2 * samples_within(neighbourhood, grid[1] - grid[0]) + 1
    fastest = maximum_filter1d(calm_speeds, size, axis=0, mode="nearest")
    thresholds = np.clip(still_fraction * fastest, *still_limits)
    places, speeds = spline(grid), _lengths(spline(grid, 1))
    return [
        PointSignal(
            positions=np.ascontiguousarray(places[:, point]),
            speeds=speeds[:, point].copy(),
            calm_speeds=calm_speeds[:, point].copy(),
            thresholds=thresholds[:, point].copy(),
            rate=rate,
        )
        for point in range(positions.shape[1])
    ]


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors (N, P, 3), shape (N, P)."""
    return np.sqrt(np.einsum("npi,npi->np", vectors, vectors))


def _smoothed(positions: FloatArray, sigma: float) -> FloatArray:
    """Positions (T, P, 3) after a Gaussian of `sigma` samples that keeps straight motion at the ends straight."""
    if sigma < 0.2:
        return positions
    pad = min(int(4 * sigma) + 1, len(positions) - 1)
    before = 2.0 * positions[0] - positions[pad:0:-1]
    after = 2.0 * positions[-1] - positions[-2 : -pad - 2 : -1]
    return gaussian_filter1d(np.concatenate([before, positions, after]), sigma, axis=0)[pad:-pad]
