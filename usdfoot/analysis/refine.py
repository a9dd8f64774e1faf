"""Instants: where exactly a point comes to rest and starts to move, between coarse samples.

A foot that starts to move does so like a power of time, so the instants at which its speed passes a threshold, half
and a quarter of it converge geometrically to the true onset, and Aitken's extrapolation finds their limit whatever the
power. Recorded feet never stand quite still and leave gradually; the less still they are, the closer the instant is
kept to the crossing of the threshold.
"""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.signals import PointSignal
from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["still_end", "still_start"]

LEVELS = np.array([1.0, 0.5, 0.25])
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


def still_end(
    grid: FloatArray, signal: PointSignal, start: int, end: int, limit: int, highest: float = np.inf
) -> float:
    """Time at which a point that is still from index start to end begins to move [s].

    Args:
        grid: Times [s], shape (N,).
        signal: The point.
        start: First index of the coarse interval.
        end: Last index of the coarse interval.
        limit: Index of the next interval's start, not to be reached.
        highest: Height above which the point has left the ground whatever its speed [m].
    """
    threshold = float(signal.thresholds[end])
    middle = (start + end) // 2
    last = min(limit, len(grid) - 1)
    speeds = signal.speeds[middle : last + 1]
    fast = _lasting(speeds >= threshold, end - middle)
    raised = np.flatnonzero(signal.positions[middle : last + 1, 1] >= highest)
    time = _onset(grid[middle : last + 1], speeds, fast, threshold, SMEAR / signal.rate)
    return min(time, float(grid[middle + raised[0]])) if raised.size else time


def still_start(grid: FloatArray, signal: PointSignal, start: int, end: int, limit: int) -> float:
    """Time at which a point that is still from index start to end came to rest [s].

    Args:
        grid: Times [s], shape (N,).
        signal: The point.
        start: First index of the coarse interval.
        end: Last index of the coarse interval.
        limit: Index of the previous interval's end, not to be reached.
    """
    threshold = float(signal.thresholds[start])
    middle = (start + end + 1) // 2
    first = max(limit, 0)
    speeds = signal.speeds[first : middle + 1][::-1]
    fast = _lasting(speeds >= threshold, middle - start)
    return -_onset(-grid[first : middle + 1][::-1], speeds, fast, threshold, SMEAR / signal.rate)


def _lasting(fast: BoolArray, coarse: int) -> int:
    """Index of the crossing: the start of the run of fast samples that the coarse interval ends in."""
    slow = np.flatnonzero(~fast[: coarse + 1])
    return int(slow[-1]) + 1 if slow.size else 0


def _onset(times: FloatArray, speeds: FloatArray, fast: int, threshold: float, smear: float) -> float:
    """Onset of motion [s] before the sample `fast`, the first at or above the threshold; `smear` [s] later."""
    if fast == 0 or fast >= len(times):
        return float(times[min(fast, len(times) - 1)])
    crossings = _crossings(times, speeds[: fast + 1], threshold * LEVELS)
    late, early = crossings[0] - crossings[1], crossings[1] - crossings[2]
    limit = crossings[0] - late**2 / (late - early) if late > early else -np.inf
    limit = max(limit, crossings[2] - STEEPEST * (late + early))
    beside = speeds[(times > limit - REST[1]) & (times < limit - REST[0])]
    restless = min(float(beside.mean()) / (RESTLESS * threshold), 1.0) if beside.size else 1.0
    limit = max(limit, crossings[0] - REACH[1] + restless * (REACH[1] - REACH[0]))
    return min(limit + smear, crossings[0])


def _crossings(times: FloatArray, speeds: FloatArray, levels: FloatArray) -> list[float]:
    """Last times before the last speed at which the speed rises through the levels [s]; the first time if never."""
    below = speeds[-2::-1] < levels[:, None]  # backward in time
    last = len(speeds) - 2 - np.argmax(below, axis=1)
    rises = np.maximum(speeds[last + 1] - speeds[last], 1e-12)
    fractions = np.minimum((levels - speeds[last]) / rises, 1.0)
    found = times[last] + fractions * (times[last + 1] - times[last])
    return np.where(below.any(axis=1), found, times[0]).tolist()
