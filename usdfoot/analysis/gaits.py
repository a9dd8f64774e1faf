"""What tells a run from a walk: a flight, of a length that depends on the speed."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG
from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["RUNNING_FROUDE", "has_flight"]

FLIGHT_SHARE = 0.2
"""Shortest flight of a run, relative to its step. By ball contacts walks have up to 0.18, slow jogs 0.22 and more."""
FAST_FLIGHT_SHARE = 0.1
"""The same where legs are too short to walk that fast: by ball contacts hurried walks have up to 0.08 there, runs 0.11
and more."""
RUNNING_FROUDE = 0.5
"""Froude number from which people do not walk (design.md section 8)."""


def has_flight(
    durations: FloatArray,
    support_liftoffs: FloatArray,
    landings: FloatArray,
    *,
    leg_length: float | FloatArray = HUMAN_LEG,
) -> BoolArray:
    """Whether both feet are in the air for a good part of the step, shape (N,).

    The ball's contacts are shorter than the foot's, so those of a quick walk may not overlap; that is no flight. Steps
    too fast for a walk need less of one.

    Args:
        durations: Strike of the support foot to strike of the swing foot [s], shape (N,).
        support_liftoffs: Liftoff of the support foot after its strike [s], shape (N,).
        landings: Support ball to swing ball, (x, z) [m], shape (N, 2).
        leg_length: From hip to ankle [m], of all or shape (N,).
    """
    durations = np.asarray(durations)
    fast = np.linalg.norm(landings, axis=1) > durations * np.sqrt(RUNNING_FROUDE * EARTH_GRAVITY * leg_length)
    return durations - support_liftoffs > np.where(fast, FAST_FLIGHT_SHARE, FLIGHT_SHARE) * durations
