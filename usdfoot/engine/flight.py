"""Flight: the body falls freely while no foot is on the ground, whatever the time warp made of the clips."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.examples import Examples

__all__ = ["flight_falls", "flight_times", "natural_flights"]


def flight_times(examples: Examples) -> FloatArray:
    """Duration of the examples' flights before the swing strike [s], shape (E,)."""
    return np.maximum(examples.durations - examples.support_liftoffs, 0.0)


def natural_flights(examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """Blended duration of the examples' flights before the swing strike [s], shape (M,)."""
    return np.sum(weights * flight_times(examples)[chosen], axis=1)


def flight_falls(contacts: ContactTable, segments: Segments, natural: FloatArray) -> FloatArray:
    """Liftoff [s], duration [s] and missing downward acceleration [m/s^2] of the flight that ends each segment.

    A flight of the clips that lasts `natural` falls with about gravity g; warped to the planned time T it falls with
    g (natural / T)^2. The rest is missing. Without a flight duration and acceleration are 0.

    Args:
        contacts: Contacts as planned.
        segments: M segments.
        natural: Duration of the blended examples' flights [s], shape (M,).

    Returns:
        Shape (M, 3).
    """
    takeoffs = contacts.liftoffs[segments.supports]
    durations = segments.ends - takeoffs
    flies: BoolArray = ~segments.stands & (durations > 0.02)
    ratio = np.where(flies, natural / np.where(flies, durations, 1.0), 1.0)
    missing = np.where(flies, EARTH_GRAVITY * (1.0 - np.minimum(ratio**2, 2.0)), 0.0)
    return np.stack([takeoffs, np.where(flies, durations, 0.0), missing], axis=1)
