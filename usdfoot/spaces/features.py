"""What tells two steps to the same spot apart: their timing, turn and rise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import RIGHT
from usdfoot.model.examples import Examples

__all__ = ["DOUBT", "FeatureScales", "StepFeatures", "example_features", "step_coordinates"]

DOUBT = 6
"""Coordinate in which what is wanted and what was recorded is 0: how far off a synthetic step is from what it is of."""


@dataclass(frozen=True, kw_only=True)
class StepFeatures:
    """Features of N steps, examples or wanted ones."""

    durations: FloatArray
    """Strike of the support foot to strike of the swing foot [s], shape (N,)."""
    swing_liftoffs: FloatArray
    """Liftoff of the swing foot after the support strike [s], the double support; negative after a flight, (N,)."""
    turns: FloatArray
    """Change of heading over the step [rad], shape (N,)."""
    landing_heights: FloatArray
    """Height of the landing contact above the support contact [m], shape (N,)."""

    departures: FloatArray
    """Where the swing ball stood before, (x, z) from the support ball in the heading at the step's start [m],
    shape (N, 2)."""

    def __getitem__(self, chosen: IntArray) -> StepFeatures:
        return StepFeatures(
            durations=self.durations[chosen],
            swing_liftoffs=self.swing_liftoffs[chosen],
            turns=self.turns[chosen],
            landing_heights=self.landing_heights[chosen],
            departures=self.departures[chosen],
        )

    def as_left(self, swing_sides: IntArray) -> StepFeatures:
        """The features as if the left foot swung: turns and departures mirrored where the right one does."""
        signs = np.where(np.asarray(swing_sides) == RIGHT, -1.0, 1.0)
        departures = self.departures * np.stack([signs, np.ones_like(signs)], axis=-1)
        return replace(self, turns=signs * self.turns, departures=departures)


@dataclass(frozen=True, kw_only=True)
class FeatureScales:
    """Differences between two steps that count the same."""

    landing: float = 0.1
    """Landing [m]."""
    duration: float = 0.1
    """Duration [s]."""
    swing_liftoff: float = 0.2
    """Double support [s]."""
    turn: float = 0.25
    """Turn [rad]."""
    landing_height: float = 0.1
    """Rise of the ground [m]."""
    departure: float = 0.2
    """Departure [m]."""


def example_features(examples: Examples) -> StepFeatures:
    """The features of a library's examples."""
    return StepFeatures(
        durations=np.asarray(examples.durations, dtype=float),
        swing_liftoffs=np.asarray(examples.swing_liftoffs, dtype=float),
        turns=np.asarray(examples.turns, dtype=float),
        landing_heights=np.asarray(examples.landing_heights, dtype=float),
        departures=np.asarray(examples.departures, dtype=float),
    )


def step_coordinates(landings: FloatArray, features: StepFeatures, scales: FeatureScales) -> FloatArray:
    """Landings and features, each divided by its scale, and no doubt, shape (N, 9): steps' distances are Euclidean."""
    return np.column_stack(
        [
            landings / scales.landing,
            features.durations / scales.duration,
            features.swing_liftoffs / scales.swing_liftoff,
            features.turns / scales.turn,
            features.landing_heights / scales.landing_height,
            np.zeros(len(landings)),
            features.departures / scales.departure,
        ]
    )
