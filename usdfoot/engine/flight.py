"""Flight: the body falls freely while no foot is on the ground, whatever the time warp made of the clips."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.segments import Segments
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.examples import Examples

__all__ = ["GRAVITY", "flight_lifts", "natural_flights"]

GRAVITY = 9.81
"""[m/s^2]."""

PUSH_TIME = 0.15
"""Time in which the legs take up the change before and after the flight, at most half the contact [s]."""


def natural_flights(examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """Blended duration of the examples' flights before the swing strike [s], shape (M,)."""
    flights = np.maximum(examples.durations - examples.support_liftoffs, 0.0)
    return np.sum(weights * flights[chosen], axis=1)


def flight_lifts(
    contacts: ContactTable, segments: Segments, natural: FloatArray, rows: IntArray, times: FloatArray
) -> FloatArray:
    """Heights to add to the pelvis so that it falls with gravity in flight [m], shape (F,).

    A flight of the clips that lasts `natural` falls with about gravity g; warped to the planned time T it falls with
    g (natural / T)^2. The rest is added as a parabola, whose velocity the legs take up before and after: a longer
    flight is prepared by a deeper crouch.

    Args:
        contacts: Contacts as planned.
        segments: M segments.
        natural: Duration of the blended examples' flights [s], shape (M,).
        rows: Segment of each frame, shape (F,).
        times: [s], shape (F,).
    """
    takeoffs, durations, missing = _flights(contacts, segments, natural)
    lifts = _arc(times, takeoffs[rows], durations[rows], missing[rows], segments.begins[rows], np.inf)
    before = np.maximum(rows - 1, 0)
    joined = segments.joined[rows]
    contact_ends = contacts.liftoffs[segments.supports[rows]]
    tail = _arc(times, takeoffs[before], durations[before], missing[before], -np.inf, contact_ends)
    return lifts + np.where(joined, tail, 0.0)


def _flights(
    contacts: ContactTable, segments: Segments, natural: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Liftoff, duration and missing downward acceleration of the flight that ends each segment; 0 without one."""
    takeoffs = contacts.liftoffs[segments.supports]
    durations = segments.ends - takeoffs
    flies: BoolArray = ~segments.stands & (durations > 0.02)
    ratio = np.where(flies, natural / np.where(flies, durations, 1.0), 1.0)
    return takeoffs, np.where(flies, durations, 0.0), np.where(flies, GRAVITY * (1.0 - np.minimum(ratio**2, 2.0)), 0.0)


def _arc(
    times: FloatArray,
    takeoffs: FloatArray,
    durations: FloatArray,
    accelerations: FloatArray,
    earliest: FloatArray | float,
    latest: FloatArray | float,
) -> FloatArray:
    """Parabola over the flight with smooth feet on either side, C1, zero from `earliest` back and `latest` on."""
    after = times - takeoffs
    inside = 0.5 * accelerations * after * (durations - after)
    slope = 0.5 * accelerations * durations
    before_time = np.clip(takeoffs - earliest, 1e-6, 2.0 * PUSH_TIME) / 2.0
    after_time = np.clip(latest - takeoffs - durations, 1e-6, 2.0 * PUSH_TIME) / 2.0
    ahead, behind = np.maximum(-after, 0.0), np.maximum(after - durations, 0.0)
    crouch = -slope * ahead * np.maximum(1.0 - ahead / before_time, 0.0) ** 2
    absorb = -slope * behind * np.maximum(1.0 - behind / after_time, 0.0) ** 2
    return np.where(after < 0.0, crouch, np.where(after > durations, absorb, inside))
