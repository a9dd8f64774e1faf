"""Ways: paths on the terrain at even spacing, with where they head and how long a step is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.gait import Gait

__all__ = ["Ways", "lay_ways"]

SPACING = 0.035
"""Between the samples of a way, over the step length."""
LARGEST_TURN = 0.5
"""Largest change of heading in a step [rad]."""
ACCELERATION = 1.5
"""How quickly the body starts, stops, and slows down before what it goes over slowly [m/s^2]."""
SHORTEST = 0.3
"""Shortest step over the gait's own."""
GAP = 1e3
"""Between ways on the axis on which all lie one after the other [m]."""


@dataclass(frozen=True, kw_only=True)
class Ways:
    """P ways of M samples in all, one after the other."""

    first: IntArray
    """Index of each way's first sample, shape (P + 1,); the last entry is M."""
    arcs: FloatArray
    """Distance from the way's start, seen from above [m], shape (M,)."""
    points: FloatArray
    """(x, z) [m], shape (M, 2)."""
    heights: FloatArray
    """Of the ground of the level followed [m], shape (M,)."""
    headings: FloatArray
    """Smoothed over a step, continuous [rad], shape (M,)."""
    shares: FloatArray
    """Step length there over the gait's own, shape (M,)."""

    @property
    def rows(self) -> IntArray:
        """Way of each sample, shape (M,)."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))

    @property
    def lengths(self) -> FloatArray:
        """Of each way [m], shape (P,)."""
        return self.arcs[self.first[1:] - 1]

    def only(self, kept: IntArray) -> Ways:
        """The ways that are kept (K,)."""
        samples = np.flatnonzero(np.isin(self.rows, kept))
        columns = {name: getattr(self, name)[samples] for name in ("arcs", "points", "heights", "headings", "shares")}
        return Ways(first=np.concatenate([[0], np.cumsum(np.diff(self.first)[kept])]), **columns)

    def at(self, rows: IntArray, arcs: FloatArray, values: FloatArray) -> FloatArray:
        """`values` (M,) of the samples between them: on ways `rows` (N,) at distances `arcs` [m] (N,), shape (N,)."""
        offsets = _offsets(self.lengths)
        axis = self.arcs + offsets[self.rows]
        return np.interp(np.clip(arcs, 0.0, self.lengths[rows]) + offsets[rows], axis, values)


def lay_ways(paths: Sequence[WalkingPath], gaits: Sequence[Gait], ground: Ground) -> Ways:
    """Ways of paths on the terrain.

    Steps become shorter uphill and downhill as walkers become slower (Tobler's hiking function, with the walk ratio),
    where the way turns, and where it begins and ends. There, and where a run is as slow as a walk, they are
    no longer than legs span.
    """
    ways = _even(paths, np.array([SPACING * gait.step_length for gait in gaits]))
    rows, starts = ways.rows, np.zeros(len(ways.arcs), dtype=bool)
    starts[ways.first[:-1]] = True
    heights = ground.follow(ways.points, ways.heights, first=ways.first).heights
    steps = np.array([gait.step_length for gait in gaits])[rows]
    legs = np.array([gait.rule.leg_length for gait in gaits])[rows]
    headings = _smooth(ways, _tangents(ways, starts), 0.5 * steps)
    curvatures = np.abs(_ramps(ways, headings, 0.25 * steps))
    grades = _ramps(ways, heights, 0.75 * steps)
    slower = np.exp(-1.75 * np.maximum(np.abs(grades + 0.05) - 0.05, 0.0))
    turning = np.minimum(1.0 / (1.0 + 0.5 * curvatures * legs), LARGEST_TURN / np.maximum(curvatures * steps, 1e-9))
    speeds = np.array([gait.speed for gait in gaits])[rows]
    edge = np.minimum(ways.arcs, ways.lengths[rows] - ways.arcs)
    starting = np.sqrt(np.sqrt(2.0 * ACCELERATION * (edge + 0.25 * steps)) / speeds)
    shares = np.clip(np.minimum.reduce([slower * turning, starting, np.ones(len(rows))]), SHORTEST, 1.0)
    shares = _eased(ways, shares, speeds)
    fastest, walked = (np.array(v)[rows] for v in zip(*((g.fastest_walk, g.walked_length) for g in gaits), strict=True))
    slow = (speeds > fastest) & ((speeds * shares**2 <= fastest) | (edge < walked))
    shares = np.where(slow, np.minimum(shares, np.maximum(walked / steps, SHORTEST)), shares)
    return Ways(first=ways.first, arcs=ways.arcs, points=ways.points, heights=heights, headings=headings, shares=shares)


def _eased(ways: Ways, shares: FloatArray, speeds: FloatArray) -> FloatArray:
    """Shares (M,) such that no body of a speed [m/s] (M,) brakes or speeds up by more than `ACCELERATION`, (M,).

    Steps are as much shorter as they are slower, so speeds go by the square of the shares; and the square of a speed
    changes by twice the acceleration a metre.
    """
    rates = 2.0 * ACCELERATION / speeds[ways.first[:-1]] ** 2
    lengths = rates * ways.lengths
    axis = rates[ways.rows] * ways.arcs + (np.cumsum(lengths + 1.0) - lengths)[ways.rows]  # no way limits another
    energies = shares**4
    sped = np.minimum.accumulate(energies - axis) + axis
    braked = np.minimum.accumulate((energies + axis)[::-1])[::-1] - axis
    return np.clip(np.minimum(sped, braked), 0.0, 1.0) ** 0.25


def _offsets(lengths: FloatArray) -> FloatArray:
    """Where each way begins on the common axis [m], shape (P,)."""
    return np.concatenate([[0.0], np.cumsum(lengths + GAP)[:-1]])


def _even(paths: Sequence[WalkingPath], spacings: FloatArray) -> Ways:
    """Samples at even spacings [m] (P,); heights are those the paths are drawn at."""
    points = np.concatenate([path.points for path in paths])
    first = np.cumsum([0, *(len(path.points) for path in paths)])
    pieces = np.linalg.norm(np.diff(points[:, [0, 2]], axis=0, prepend=points[:1, [0, 2]]), axis=1)
    pieces[first[:-1]] = 0.0
    arcs = np.cumsum(pieces)
    arcs -= np.repeat(arcs[first[:-1]], np.diff(first))
    lengths = arcs[first[1:] - 1]
    offsets = _offsets(lengths)
    counts = np.maximum(np.ceil(lengths / spacings).astype(int), 2) + 1
    rows = np.repeat(np.arange(len(paths)), counts)
    starts = np.cumsum(counts) - counts
    even = (np.arange(counts.sum()) - starts[rows]) / (counts[rows] - 1.0) * lengths[rows]
    axis, known = even + offsets[rows], arcs + np.repeat(offsets, np.diff(first))
    placed = np.stack([np.interp(axis, known, points[:, i]) for i in range(3)], axis=-1)
    blank = np.zeros(len(rows))
    return Ways(
        first=np.append(starts, len(rows)),
        arcs=even,
        points=placed[:, [0, 2]],
        heights=placed[:, 1],
        headings=blank,
        shares=blank,
    )


def _tangents(ways: Ways, starts: BoolArray) -> FloatArray:
    """Direction of the way from the sample before, continuous [rad], shape (M,)."""
    steps = np.diff(ways.points, axis=0, prepend=ways.points[:1])
    steps[starts] = np.roll(steps, -1, axis=0)[starts]
    angles = np.arctan2(steps[:, 0], steps[:, 1])
    jumps = np.diff(angles, prepend=angles[0])
    jumps = np.remainder(jumps + np.pi, 2.0 * np.pi) - np.pi
    return angles[0] + np.cumsum(jumps)


def _smooth(ways: Ways, values: FloatArray, reach: FloatArray) -> FloatArray:
    """Means of values (M,) over `reach` [m] (M,) to either side; beyond the ends the end values go on."""
    spacing = np.diff(ways.arcs, append=0.0)
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.maximum(spacing[:-1], 0.0))])
    rows, lengths = ways.rows, ways.lengths[ways.rows]
    low, high = ways.arcs - reach, ways.arcs + reach
    before = np.minimum(low, 0.0) * values[ways.first[:-1]][rows]
    after = np.maximum(high - lengths, 0.0) * values[ways.first[1:] - 1][rows]
    return (ways.at(rows, high, sums) - ways.at(rows, low, sums) + after - before) / (2.0 * reach)


def _ramps(ways: Ways, values: FloatArray, reach: FloatArray) -> FloatArray:
    """Slopes of values (M,) over `reach` [m] (M,) to either side, less at the ends [1/m]."""
    rows, lengths = ways.rows, ways.lengths[ways.rows]
    low, high = np.maximum(ways.arcs - reach, 0.0), np.minimum(ways.arcs + reach, lengths)
    return (ways.at(rows, high, values) - ways.at(rows, low, values)) / np.maximum(high - low, 1e-9)
