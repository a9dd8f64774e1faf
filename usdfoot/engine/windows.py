"""How much of the jump at either end of a segment each frame carries (design.md section 7, Seams)."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.options import EngineOptions
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["seam_windows"]


def seam_windows(
    segments: Segments, rows: IntArray, times: FloatArray, options: EngineOptions
) -> tuple[FloatArray, FloatArray]:
    """Factors of the seams' half jumps and rates: begin value, begin rate [s], end value, end rate [s].

    `inertialise` meets in the middle of the jump, in value and velocity: half decays before the seam, half after
    (Bollo 2018, made symmetric since the plan is known). `crossfade` fades from the old pose linearly ([B] 7).

    Args:
        segments: M segments.
        rows: Segment of each frame, shape (F,).
        times: [s], shape (F,).
        options: Kind and times of the seams.

    Returns:
        For the joints and for the pelvis's position, float32, shape (F, 4) each. The position's value decays over the
        whole segment on either side, so that the body does not dart; its rate as fast as the joints'.
    """
    durations = segments.ends - segments.begins
    beside_stand = np.zeros(len(segments) + 1, dtype=bool)
    beside_stand[:-1] |= segments.stands
    beside_stand[1:] |= segments.stands
    wanted = np.where(beside_stand, options.stand_seam_time, options.seam_time)
    after = times - segments.begins[rows]
    before = segments.ends[rows] - times
    joint = np.minimum(np.stack([wanted[rows], wanted[rows + 1]]), durations[rows])
    whole = np.stack([durations[rows], durations[rows]])
    whole = np.where(segments.stands[rows], np.minimum(whole, options.stand_seam_time), whole)
    return (
        _factors(after, before, joint, joint, options.seam),
        _factors(after, before, whole, np.minimum(whole, joint), options.seam),
    )


def _factors(
    after: FloatArray, before: FloatArray, lengths: FloatArray, slope_lengths: FloatArray, seam: str
) -> FloatArray:
    """Factors at times `after` the begin and `before` the end; values and rates decay over lengths (2, F) [s]."""
    lengths = np.maximum(lengths, 1e-6)
    slope_lengths = np.maximum(slope_lengths, 1e-6)
    factors = np.zeros((len(after), 4), dtype=np.float32)
    if seam == "inertialise":
        for column, (time, sign) in enumerate(((after, -1.0), (before, 1.0))):
            x = np.clip(time / lengths[column], 0.0, 1.0)
            factors[:, 2 * column] = sign * (1.0 - x * x * x * (10.0 + x * (6.0 * x - 15.0)))
            x = np.clip(time / slope_lengths[column], 0.0, 1.0)
            rest = 1.0 - x
            factors[:, 2 * column + 1] = -slope_lengths[column] * x * rest * rest * rest * (1.0 + 3.0 * x)
    elif seam == "crossfade":
        factors[:, 0] = -2.0 * np.clip(1.0 - after / lengths[0], 0.0, 1.0)
    return factors
