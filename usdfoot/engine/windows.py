"""How long the jumps at either end of a segment take to decay (design.md section 7, Seams)."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.options import EngineOptions
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import FloatArray

__all__ = ["seam_lengths"]


def seam_lengths(segments: Segments, options: EngineOptions) -> FloatArray:
    """Times over which seams decay in M segments [s]: joints at the begin and at the end, pelvis's position, 0; (M, 4).

    The position's value decays over the whole segment on either side, so that the body does not dart; its rate as fast
    as the joints'.
    """
    durations = segments.ends - segments.begins
    beside_stand = np.zeros(len(segments) + 1, dtype=bool)
    beside_stand[:-1] |= segments.stands
    beside_stand[1:] |= segments.stands
    wanted = np.where(beside_stand, options.stand_seam_time, options.seam_time)
    whole = np.where(segments.stands, np.minimum(durations, options.stand_seam_time), durations)
    begins, ends = np.minimum(wanted[:-1], durations), np.minimum(wanted[1:], durations)
    return np.stack([begins, ends, whole, np.zeros(len(segments))], axis=1)
