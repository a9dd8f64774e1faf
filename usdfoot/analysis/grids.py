"""Grids of times finer than a clip's samples, and durations counted in samples."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["ROUNDING", "fine_times", "samples_within"]

ROUNDING = 1e-6
"""Part of a sample that does not count: rates and times come from time codes with rounding errors."""


def fine_times(start_time: float, frames: int, rate: float, *, fine_rate: float) -> FloatArray:
    """Times that divide every sample interval evenly, at least `fine_rate` a second [s], shape (N,)."""
    parts = max(1, int(np.ceil(fine_rate / rate - ROUNDING)))
    return start_time + np.arange((frames - 1) * parts + 1) / (rate * parts)


def samples_within(duration: float, step: FloatArray | float) -> IntArray:
    """Whole samples `step` [s] apart that fit into a duration [s], whatever the last digits of the two."""
    return np.asarray(duration / np.asarray(step) + ROUNDING).astype(int)
