"""What the footstep spaces are asked for each step: where it lands, and in what time, turn and rise it gets there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.engine.poses import Setup
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray, StyleArray
from usdfoot.spaces.features import StepFeatures
from usdfoot.spaces.landings import left_landings, root_starts

__all__ = ["StepQueries", "asked_landings", "step_queries"]


@dataclass(frozen=True, kw_only=True)
class StepQueries:
    """N steps as planned."""

    landings: FloatArray
    """Landing from the support ball in the heading at the step's end, (x, z) [m], shape (N, 2)."""
    headings: FloatArray
    """Heading at the step's start [rad], shape (N,)."""
    turns: FloatArray
    """Planned change of heading [rad], shape (N,)."""
    swing_sides: IntArray
    """0 = left, 1 = right, shape (N,)."""
    flights: BoolArray
    """Whether the step ends in a flight, shape (N,)."""
    styles: StyleArray
    """Shape (N,)."""
    speeds: FloatArray
    """Of the middle of consecutive footsteps over the step [m/s], shape (N,)."""
    features: StepFeatures
    """Timing, turn, rise and departure."""

    def __getitem__(self, rows: IntArray) -> StepQueries:
        return StepQueries(
            landings=self.landings[rows],
            headings=self.headings[rows],
            turns=self.turns[rows],
            swing_sides=self.swing_sides[rows],
            flights=self.flights[rows],
            styles=self.styles[rows],
            speeds=self.speeds[rows],
            features=self.features[rows],
        )


def asked_landings(queries: StepQueries, *, frame: str) -> FloatArray:
    """What the spaces are asked for, from where their `frame` measures, as if the left foot swung, (x, z) [m], (N, 2).

    The root is where the footsteps put it, midway between the feet ([B] 4.2).
    """
    landings = queries.landings
    if frame == "root":
        landings = landings - planar.rotate(-queries.turns, root_starts(queries.features.departures))
    return left_landings(landings, queries.swing_sides)


def step_queries(setup: Setup, steps: IntArray) -> StepQueries:
    """Queries of the segments `steps`, none of them a stand."""
    contacts, segments = setup.contacts, setup.segments
    supports = segments.supports[steps]
    starts = segments.knot_times[steps, 0]
    headings = contacts.headings[supports]
    turns = contacts.headings[supports + 1] - headings
    positions = contacts.positions
    displacements = (positions[supports + 1] - positions[supports])[:, 0::2]
    departures = (positions[supports - 1] - positions[supports])[:, 0::2]
    durations = segments.ends[steps] - starts
    return StepQueries(
        landings=planar.rotate(-(headings + turns), displacements),
        headings=headings,
        turns=turns,
        swing_sides=contacts.sides[supports + 1],
        flights=has_flight(durations, contacts.liftoffs[supports] - starts, displacements, leg_length=setup.leg_length),
        styles=setup.styles[supports + 1],
        speeds=0.5 * np.linalg.norm(displacements - departures, axis=1) / durations,
        features=StepFeatures(
            durations=durations,
            swing_liftoffs=contacts.liftoffs[supports - 1] - starts,
            turns=turns,
            landing_heights=positions[supports + 1, 1] - positions[supports, 1],
            departures=planar.rotate(-headings, departures),
        ),
    )
