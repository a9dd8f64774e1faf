"""Instants: where exactly a point comes to rest and starts to move, between coarse samples.

A foot that starts to move does so like a power of time, so the instants at which its speed passes a threshold, half
and a quarter of it converge geometrically to the true onset, and Aitken's extrapolation finds their limit whatever the
power. Recorded feet never stand quite still and leave gradually; the less still they are, the closer the instant is
kept to the crossing of the threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.runs import expand, last_where
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["Speeds", "still_ends", "still_starts"]

LEVELS = (1.0, 0.5, 0.25)
"""Speeds whose crossings are taken, relative to the threshold."""
STEEPEST = 0.8
"""How far the onset may lie before the crossing of a quarter, relative to the way from there: 1 for
a square law."""
REACH = (0.008, 0.036)
"""How far the onset may lie from the crossing of the threshold, of a restless and of a still foot [s]."""
SMEAR = 0.15
"""How much earlier a spline starts to move than the foot it was sampled from [samples]."""
RESTLESS = 0.1
"""Mean speed beside the onset at which a foot counts as restless, relative to the threshold."""
REST = (0.015, 0.075)
"""How far beside the onset that speed is taken [s]."""


@dataclass(frozen=True, kw_only=True)
class Speeds:
    """Speed of points over time, N samples of many sequences end to end."""

    times: FloatArray
    """[s], shape (N,)."""
    speeds: FloatArray
    """[m/s], shape (N,)."""
    thresholds: FloatArray
    """Speeds below which the points count as still [m/s], shape (N,)."""
    rates: FloatArray
    """Samples a second of the clips they come from [Hz], shape (N,)."""

    def backward(self) -> Speeds:
        """The same in reverse order of time, on a clock that runs backward."""
        return Speeds(
            times=-self.times[::-1],
            speeds=self.speeds[::-1],
            thresholds=self.thresholds[::-1],
            rates=self.rates[::-1],
        )


def still_ends(signal: Speeds, starts: IntArray, ends: IntArray, *, limits: IntArray) -> FloatArray:
    """Times at which points that are still from index start to end begin to move [s], shape (K,).

    Args:
        signal: The points.
        starts: First index of each coarse interval, shape (K,).
        ends: Last index of each, shape (K,).
        limits: Last index to look at, at least the end, shape (K,).
    """
    begins = (starts + ends) // 2
    thresholds = signal.thresholds[ends]
    indices, owners = expand(begins, limits)
    slow = (signal.speeds[indices] < thresholds[owners]) & (indices <= ends[owners])
    # The coarse interval ends in the samples from here on.
    fast = last_where(slow, indices, owners, missing=begins - 1) + 1
    found = np.flatnonzero((fast > begins) & (fast <= limits))
    times = signal.times[np.minimum(fast, limits)]
    times[found] = _onsets(signal, begins[found], fast[found], limits[found], thresholds[found])
    return times


def still_starts(signal: Speeds, starts: IntArray, ends: IntArray, *, limits: IntArray) -> FloatArray:
    """Times at which points that are still from index start to end came to rest [s], shape (K,).

    Args:
        signal: The points.
        starts: First index of each coarse interval, shape (K,).
        ends: Last index of each, shape (K,).
        limits: First index to look at, at most the start, shape (K,).
    """
    last = len(signal.times) - 1
    return -still_ends(signal.backward(), last - ends, last - starts, limits=last - limits)


def _onsets(signal: Speeds, begins: IntArray, fast: IntArray, limits: IntArray, thresholds: FloatArray) -> FloatArray:
    """Onsets of motion [s] before the samples `fast`, the first at or above the thresholds, all shapes (K,)."""
    crossings = [_crossings(signal, begins, fast, level * thresholds) for level in LEVELS]
    late, early = crossings[0] - crossings[1], crossings[1] - crossings[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        limit = np.where(late > early, crossings[0] - late**2 / (late - early), -np.inf)
    limit = np.maximum(limit, crossings[2] - STEEPEST * (late + early))
    restless = np.minimum(_speeds_beside(signal, begins, limits, limit) / (RESTLESS * thresholds), 1.0)
    limit = np.maximum(limit, crossings[0] - REACH[1] + restless * (REACH[1] - REACH[0]))
    return np.minimum(limit + SMEAR / signal.rates[begins], crossings[0])


def _speeds_beside(signal: Speeds, begins: IntArray, limits: IntArray, onsets: FloatArray) -> FloatArray:
    """Mean speed shortly before each onset [m/s], infinite where nothing is known of it, shape (K,)."""
    indices, owners = expand(begins, limits)
    times = signal.times[indices] - onsets[owners]
    beside = (times > -REST[1]) & (times < -REST[0])
    counts = np.bincount(owners[beside], minlength=len(begins))
    sums = np.bincount(owners[beside], signal.speeds[indices[beside]], minlength=len(begins))
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.inf)


def _crossings(signal: Speeds, begins: IntArray, fast: IntArray, levels: FloatArray) -> FloatArray:
    """Last times before the samples `fast` at which the speed rises through levels [s]; at the begin if never."""
    indices, owners = expand(begins, fast - 1)
    below = signal.speeds[indices] < levels[owners]
    last = last_where(below, indices, owners, missing=begins - 1)
    known = last >= begins
    last = np.maximum(last, begins)
    rises = np.maximum(signal.speeds[last + 1] - signal.speeds[last], 1e-12)
    fractions = np.minimum((levels - signal.speeds[last]) / rises, 1.0)
    found = signal.times[last] + fractions * (signal.times[last + 1] - signal.times[last])
    return np.where(known, found, signal.times[begins])
