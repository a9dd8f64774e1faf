"""Step limits: how near and how far from its other foot a foot comes down."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.planning.foot_table import FootTable

__all__ = ["StepLimits", "limit_steps", "uncross"]

AHEAD = 1.25
"""How far feet come ahead of or behind the other one, over how far across."""


@dataclass(frozen=True, kw_only=True)
class StepLimits:
    """Where each of S footsteps may be, seen from the other foot: an ellipse around it, without what is across it."""

    narrowest: FloatArray
    """Least distance across between a foot and the other one [m], shape (S,)."""
    widest: FloatArray
    """Largest [m], shape (S,)."""
    strained: FloatArray
    """How far out in the ellipse, `widest` across and longer ahead: 1 = on it, shape (S,)."""

    def __getitem__(self, rows: IntArray) -> StepLimits:
        return StepLimits(narrowest=self.narrowest[rows], widest=self.widest[rows], strained=self.strained[rows])

    def relaxed(self, *, narrower: float, wider: float = 1.0) -> StepLimits:
        """The limits with least and largest distances that many times as large."""
        return replace(self, narrowest=narrower * self.narrowest, widest=wider * self.widest)

    def excess(self, feet: FootTable, rows: IntArray) -> FloatArray:
        """How far footsteps (K,), none a plan's first, are outside: across [m], and in the ellipse, shape (K, 2)."""
        apart, along = _offsets(feet, feet.positions[:, [0, 2]], rows)
        own = self[rows]
        across = np.maximum(own.narrowest - apart, 0.0) + np.maximum(apart - own.widest, 0.0)
        return np.stack([across, np.maximum(_strains(apart, along, own.widest) - own.strained, 0.0)], axis=1)


def limit_steps(feet: FootTable, *, narrowest: FloatArray, widest: FloatArray) -> StepLimits:
    """Limits of footsteps, those farther away than people step as far as they are.

    Args:
        feet: Of all people.
        narrowest: Least distance across between a foot and the other one [m], shape (S,).
        widest: Largest [m], shape (S,); infinite = steps may be as long as they like.
    """
    rows = np.flatnonzero(feet.numbers > 0)
    strained = np.ones(len(feet.owners))
    apart, along = _offsets(feet, feet.positions[:, [0, 2]], rows)
    strained[rows] = np.maximum(_strains(apart, along, widest[rows]), 1.0)
    return StepLimits(narrowest=narrowest, widest=widest, strained=strained)


def uncross(feet: FootTable, limits: StepLimits) -> FootTable:
    """The table with every foot on its own side of the other, in reach: it comes down further out, or further in."""
    points = feet.positions[:, [0, 2]]
    first = np.flatnonzero(feet.numbers == 0)
    counts = np.diff(first, append=len(feet.owners))
    for number in range(1, int(counts.max())):
        rows = first[counts > number] + number
        own, (ahead, across) = limits[rows], _axes(feet, rows)
        apart, along = _offsets(feet, points, rows)
        aside = np.clip(apart, own.narrowest, own.widest)
        most = AHEAD * own.widest * np.sqrt(np.maximum(own.strained**2 - (aside / own.widest) ** 2, 0.0))
        points[rows] += (aside - apart)[:, None] * across + (np.clip(along, -most, most) - along)[:, None] * ahead
    positions = feet.positions.copy()
    positions[:, [0, 2]] = points
    return replace(feet, positions=positions)


def _strains(apart: FloatArray, along: FloatArray, widest: FloatArray) -> FloatArray:
    """How far out in the ellipse offsets (K,) [m] are, 1 = on it, shape (K,)."""
    return np.hypot(apart / widest, along / (AHEAD * widest))


def _offsets(feet: FootTable, points: FloatArray, rows: IntArray) -> tuple[FloatArray, FloatArray]:
    """How far feet (K,) at points (S, 2) are from the other one, across to their own side and ahead [m], (K,) each."""
    offsets = points[rows] - points[rows - 1]
    ahead, across = _axes(feet, rows)
    return np.sum(offsets * across, axis=1), np.sum(offsets * ahead, axis=1)


def _axes(feet: FootTable, rows: IntArray) -> tuple[FloatArray, FloatArray]:
    """Directions (x, z) ahead, midway between two consecutive feet, and to the side of the foot, shape (K, 2) each."""
    mean = planar.midway_yaw(feet.yaws[rows - 1], feet.yaws[rows])
    outward = np.where(feet.sides[rows] == LEFT, 1.0, -1.0)[:, None]
    return planar.direction(mean), outward * planar.direction(mean + 0.5 * np.pi)
