"""Ten instants a segment at which physics and comfort are judged ([P] 2.4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.physics.footing import Footing
from usdfoot.physics.heading import OrientationScript, body_orientations
from usdfoot.physics.spline import Knots
from usdfoot.physics.support import Stance, find_stance

__all__ = ["SAMPLES", "Samples", "instant_shares", "lay_samples", "take_segments"]

SAMPLES = 10
"""Instants a segment, in the middle of equal parts."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """What E depends on beside the spline: N instants of each of S segments."""

    times: FloatArray
    """[s], shape (S, N)."""
    intervals: FloatArray
    """Time each instant stands for [s], shape (S,)."""
    stance: Stance
    """Both legs at the instants, a segment's one after the other."""


def lay_samples(
    footing: Footing, knots: Knots, scripts: Sequence[OrientationScript | None] = (), *, window: float
) -> Samples:
    """Samples of all segments; the body's heading is the mean over a window [s]."""
    durations = knots.durations
    times = knots.times[knots.begins][:, None] + durations[:, None] * instant_shares(SAMPLES)
    agents = np.repeat(knots.agents[knots.begins], SAMPLES)
    bodies = body_orientations(footing, scripts, agents=agents, times=times.ravel(), window=window)
    return Samples(
        times=times,
        intervals=durations / SAMPLES,
        stance=find_stance(footing, agents=agents, times=times.ravel(), bodies=bodies),
    )


def instant_shares(count: int) -> FloatArray:
    """Parts of a segment passed at its instants, shape (count,)."""
    return (np.arange(count) + 0.5) / count


def take_segments(samples: Samples, segments: IntArray) -> Samples:
    """The samples of some segments (T,), in their order."""
    instants = samples.times.shape[1]
    rows = (segments[:, None] * instants + np.arange(instants)).ravel()
    return Samples(
        times=samples.times[segments],
        intervals=samples.intervals[segments],
        stance=Stance(**{name: values[rows] for name, values in vars(samples.stance).items()}),
    )
