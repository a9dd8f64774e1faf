"""Near feet: which feet of different people are close to each other at one time, and how far they overlap."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable, Instants, between, foot_axes, joined_instants
from usdfoot.planning.presences import INSTANT, Presences, find_presences, pair_presences

__all__ = ["NearFeet", "Pairs", "find_near_feet", "find_pairs_of", "overlaps"]

STOREY = 0.5
"""Feet this far above one another do not touch [m]."""


@dataclass(frozen=True, kw_only=True)
class Pairs:
    """Feet of different people that are near each other, K pairs."""

    first: Instants
    """Of each pair the one with the lower footstep, shape (K,)."""
    second: Instants
    """The other, shape (K,)."""
    depths: FloatArray
    """How far the soles overlap, negative = how far they are apart [m], shape (K,)."""
    directions: FloatArray
    """From the second to the first (x, z), shape (K, 2)."""

    def __getitem__(self, rows: IntArray | BoolArray) -> Pairs:
        return Pairs(
            first=self.first[rows],
            second=self.second[rows],
            depths=self.depths[rows],
            directions=self.directions[rows],
        )

    def touch(self, moved: BoolArray) -> BoolArray:
        """Whether a foot of each pair is on, or on its way from or to, a footstep that moved (S,), shape (K,)."""
        return _touch(self.first, moved) | _touch(self.second, moved)


@dataclass(frozen=True, kw_only=True)
class NearFeet(Pairs):
    """Feet of different people that could touch if they moved by the slack in all, K pairs.

    Of two that both stand it is the first instant at which they do, of others every instant.
    """

    slack: float
    """[m]"""
    presences: Presences
    """Of all feet, shape (P,)."""
    points: FloatArray
    """Where these are: (x, z), and the height so that a storey is as far as feet reach [m], shape (P, 3)."""

    def moved(self, feet: FootTable, moved: BoolArray) -> NearFeet:
        """The same pairs after some footsteps (S,) have moved."""
        rows = np.flatnonzero(self.touch(moved))
        depths, directions = self.depths.copy(), self.directions.copy()
        depths[rows], directions[rows] = overlaps(feet, self.first[rows], self.second[rows])
        return replace(self, depths=depths, directions=directions)

    def after(self, feet: FootTable, moved: BoolArray) -> NearFeet:
        """The pairs after some footsteps (S,) have moved; only feet on these, or on the way from or to one, are new."""
        touched = _touch(self.presences.at_first, moved)
        points = self.points.copy()
        points[touched] = _points(feet, self.presences[touched].at_first, _reach(feet, self.slack))
        new = _near(feet, self.presences, points, touched, self.slack)
        kept = ~self.touch(moved)
        return replace(
            self,
            first=joined_instants(self.first[kept], new.first),
            second=joined_instants(self.second[kept], new.second),
            depths=np.concatenate([self.depths[kept], new.depths]),
            directions=np.concatenate([self.directions[kept], new.directions]),
            points=points,
        )


def find_near_feet(feet: FootTable, *, slack: float) -> NearFeet:
    """Which feet of different people are near each other.

    Args:
        feet: Of all people.
        slack: How far they may move in all [m].
    """
    presences = find_presences(feet)
    points = _points(feet, presences.at_first, _reach(feet, slack))
    pairs = _near(feet, presences, points, np.ones(len(points), dtype=bool), slack)
    return NearFeet(slack=slack, presences=presences, points=points, **vars(pairs))


def find_pairs_of(feet: FootTable, steps: BoolArray, *, slack: float) -> Pairs:
    """Pairs of near feet of which one is on, or on its way from or to, one of some footsteps.

    Args:
        feet: Of all people.
        steps: Which footsteps, shape (S,).
        slack: How far feet may move in all [m].
    """
    presences = find_presences(feet)
    instants = presences.at_first
    return _near(feet, presences, _points(feet, instants, _reach(feet, slack)), _touch(instants, steps), slack)


def _reach(feet: FootTable, slack: float) -> float:
    """Farthest apart are the middles of two feet that could touch [m]."""
    return float((feet.heels + feet.toes).max()) + slack


def _points(feet: FootTable, instants: Instants, reach: float) -> FloatArray:
    """Where feet are at instants: middles (x, z), and heights of which a storey is a reach [m], shape (K, 3)."""
    heights, axes = between(feet, instants, feet.positions[:, 1]), foot_axes(feet, instants)
    return np.column_stack([0.5 * (axes[:, 0] + axes[:, 1]), heights * (reach / STOREY)])


def _touch(instants: Instants, moved: BoolArray) -> BoolArray:
    """Whether each foot is on, or on its way from or to, a footstep that moved (S,), shape (K,)."""
    following = np.minimum(instants.steps + 2, len(moved) - 1)
    return np.asarray(moved[instants.steps] | (moved[following] & (instants.shares > 0.0)))


def _near(feet: FootTable, presences: Presences, points: FloatArray, touched: BoolArray, slack: float) -> Pairs:
    """Pairs of feet that are near, of which at least one is touched (P,)."""
    pairs = pair_presences(presences, points, feet.owners[presences.steps], touched=touched, reach=_reach(feet, slack))
    first, second = presences[pairs[:, 0]], presences[pairs[:, 1]]
    times = INSTANT * np.maximum(first.begins, second.begins)
    order = np.lexsort((second.steps, times, first.steps))
    one, other = (
        Instants(steps=part.steps[order], shares=part.shares[order], times=times[order]) for part in (first, second)
    )
    depths, directions = overlaps(feet, one, other)
    near = depths > -slack - 1e-9
    return Pairs(first=one[near], second=other[near], depths=depths[near], directions=directions[near])


def overlaps(feet: FootTable, first: Instants, second: Instants) -> tuple[FloatArray, FloatArray]:
    """How far the soles of pairs overlap [m], shape (K,), and the direction from the second to the first, (K, 2)."""
    a, b = foot_axes(feet, first), foot_axes(feet, second)
    gaps = np.concatenate([_to_segments(a, b), -_to_segments(b, a)], axis=1)  # (K, 4, 2), from b to a
    distances = np.linalg.norm(gaps, axis=2)
    rows, nearest = np.arange(len(gaps)), np.argmin(distances, axis=1)
    distance, gap = distances[rows, nearest], gaps[rows, nearest]
    crossing = _cross(a, b)
    direction = np.where((crossing | (distance < 1e-6))[:, None], a.mean(axis=1) - b.mean(axis=1), gap)
    lengths = np.linalg.norm(direction, axis=1, keepdims=True)
    direction = np.where(lengths < 1e-9, np.array([1.0, 0.0]), direction / np.maximum(lengths, 1e-9))
    widths = feet.half_widths[first.steps] + feet.half_widths[second.steps]
    return widths - np.where(crossing, -distance, distance), direction


def _to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Vectors from the nearest points of segments (K, 2, 2) to points (K, P, 2), shape (K, P, 2)."""
    along = segments[:, 1] - segments[:, 0]
    offsets = points - segments[:, :1]
    share = np.sum(offsets * along[:, None], axis=2) / np.maximum(np.sum(along**2, axis=1), 1e-12)[:, None]
    return offsets - np.clip(share, 0.0, 1.0)[..., None] * along[:, None]


def _cross(a: FloatArray, b: FloatArray) -> BoolArray:
    """Whether segments a and b (K, 2, 2) cross, shape (K,)."""

    def side(segment: FloatArray, point: FloatArray) -> FloatArray:
        along, offset = segment[:, 1] - segment[:, 0], point - segment[:, 0]
        return along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]

    apart = (side(a, b[:, 0]) * side(a, b[:, 1]) < 0.0) & (side(b, a[:, 0]) * side(b, a[:, 1]) < 0.0)
    return np.asarray(apart)
