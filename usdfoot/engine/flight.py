"""Flight: the body falls freely while no foot is on the ground, whatever the time warp made of the clips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.examples import Examples, event_knots

__all__ = ["centre_flights", "flight_falls", "liftoff_samples", "natural_flights", "natural_overlaps"]

MOST_SHIFT = 0.25
"""How far the body may be behind or ahead of a strike, over the shorter of the steps before and after it."""


def natural_flights(examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """Blended duration of the examples' flights before the swing strike [s], shape (M,)."""
    return np.sum(weights * _flight_times(examples)[chosen], axis=1)


def natural_overlaps(examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """Blended duration of the examples' double supports after the swing strike [s], shape (M,)."""
    return np.sum(weights * np.maximum(examples.support_liftoffs - examples.durations, 0.0)[chosen], axis=1)


def liftoff_samples(examples: Examples) -> FloatArray:
    """Sample at which each example's support foot leaves the ground, shape (E,); the last where it stays.

    Blended as poses are, so that a walk which gets a little of a run leaves the ground at its very end.
    """
    knots, phases = event_knots(examples.durations, examples.swing_liftoffs, examples.support_liftoffs)
    flown = np.minimum(_flight_times(examples) / (knots[:, 3] - knots[:, 2]), 1.0)
    samples: FloatArray = (1.0 - flown * (1.0 - phases[:, 2])) * (examples.rotations.shape[1] - 1)
    return samples


def _flight_times(examples: Examples) -> FloatArray:
    """Duration of the examples' flights before the swing strike [s], shape (E,)."""
    return np.maximum(examples.durations - examples.support_liftoffs, 0.0)


def flight_falls(contacts: ContactTable, segments: Segments, natural: FloatArray, *, warps: FloatArray) -> FloatArray:
    """Takeoff [s], duration [s] and missing downward acceleration [m/s^2] of the flight that ends each segment.

    The body flies about the middle of the planned flight, for T: as long as that, or as the clips as warped if that is
    longer. A flight of the clips that lasts `natural` falls with about gravity g; in T it falls with
    g (natural / T)^2. The rest is missing. Without a planned flight duration and acceleration are 0.

    Args:
        contacts: Contacts as planned.
        segments: M segments.
        natural: Duration of the blended examples' flights [s], shape (M,).
        warps: Planned durations of the steps over those of their examples, shape (M,).

    Returns:
        Shape (M, 3).
    """
    liftoffs = contacts.liftoffs[segments.supports]
    lands = contacts.strikes[np.minimum(segments.supports + 1, len(contacts.strikes) - 1)]
    flies: BoolArray = ~segments.stands & (lands - liftoffs > 0.02)
    durations = np.where(flies, np.maximum(lands - liftoffs, natural * warps), 0.0)
    ratio = np.where(flies, natural / np.where(flies, durations, 1.0), 1.0)
    missing = np.where(flies, EARTH_GRAVITY * (1.0 - np.minimum(ratio**2, 2.0)), 0.0)
    return np.stack([0.5 * (liftoffs + lands - durations), durations, missing], axis=1)


def centre_flights(contacts: ContactTable, segments: Segments, natural: FloatArray) -> Segments:
    """The segments from strike to strike as the body takes them: its flights about the middle of the planned ones.

    People may run the same way with longer or shorter contacts than the clips show. So a foot that is planted for
    longer comes down before the blended one does and leaves after it by as much, and the body is never far from over
    it. Where a stand begins the body keeps the plan's times, and where both feet are on the ground for longer than the
    blended examples fly: a walk may be blended with runs.

    Args:
        contacts: As planned.
        segments: M segments from strike to strike.
        natural: Duration of the blended examples' flights [s], shape (M,).
    """
    durations = segments.ends - segments.begins
    planned = segments.ends - contacts.liftoffs[segments.supports]
    longer = np.where(planned > 0.0, natural - planned, np.maximum(natural + planned, 0.0))
    between, following = segments.joined[1:], np.append(segments.stands[1:], False)
    moves = ~segments.stands & ~(between & following)
    most = MOST_SHIFT * np.where(between, np.minimum(durations, np.append(durations[1:], np.inf)), durations)
    shifts = np.where(moves, np.clip(0.5 * longer, -most, most), 0.0)
    ends = segments.ends + shifts
    begins = segments.begins + np.where(segments.joined[:-1], np.roll(shifts, 1), 0.0)
    liftoffs = (contacts.liftoffs[rows] - begins for rows in (segments.supports - 1, segments.supports))
    events, _ = event_knots(ends - begins, *liftoffs)
    moved = (begins != segments.begins) | (ends != segments.ends)
    whole = moved & (segments.knot_times[:, 0] == segments.begins)
    knot_times = np.where(whole[:, None], begins[:, None] + events, segments.knot_times)
    knot_times[moved, 3] = ends[moved]
    return replace(segments, begins=begins, ends=ends, knot_times=knot_times)
