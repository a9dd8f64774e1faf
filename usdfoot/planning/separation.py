"""Separation: feet of different people that would be in one place at one time are set apart."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.track_steps import TrackSteps, uncross

__all__ = ["Conflicts", "find_conflicts", "separate_feet"]

SAMPLE_STEP = 0.05
"""Between the instants at which feet are compared [s]."""
CLEARANCE = 0.02
"""Wanted between soles [m]."""
FARTHEST = 0.2
"""A footstep is moved this far at most [m]."""
LOOKS, ROUNDS = 6, 12
"""How often all feet that could meet are looked at, and how often those that are close are moved in between."""
CLOSE = 0.1
"""Feet this far apart are watched [m]."""
APART = 10.0
"""Between instants on the time axis of the search tree [m]: more than any distance looked for."""


@dataclass(frozen=True, kw_only=True)
class Conflicts:
    """Instants at which feet of two people overlap, C of them, the deepest first."""

    people: IntArray
    """Who, shape (C, 2)."""
    times: FloatArray
    """[s], shape (C,)."""
    depths: FloatArray
    """How far the soles overlap [m], shape (C,)."""


def find_conflicts(steps: TrackSteps, body: Proportions) -> Conflicts:
    """Overlaps of feet, each a capsule from heel to toe, standing or swinging straight to its next footstep."""
    pairs = _near_pairs(steps, body, 0.0)
    depths, _ = _overlaps(steps, pairs, body)
    deep = np.flatnonzero(depths > 0.0)
    deep = deep[np.argsort(-depths[deep], kind="stable")]
    owners = steps.owners
    people = np.stack([owners[pairs.first.steps[deep]], owners[pairs.second.steps[deep]]], axis=1)
    return Conflicts(people=people, times=pairs.times[deep], depths=depths[deep])


def separate_feet(steps: TrackSteps, body: Proportions) -> TrackSteps:
    """The steps with footsteps moved apart sideways or along until no feet overlap, or as far as they may be moved.

    Each overlap pushes both feet away by half of it; a swinging foot passes that on to the footsteps it swings between.
    """
    start = steps.points
    pairs = _near_pairs(steps, body, 2.0 * FARTHEST)
    for _ in range(LOOKS):
        depths, _ = _overlaps(steps, pairs, body)
        if not np.any(depths > 0.0):
            break
        watched = pairs.at(np.flatnonzero(depths > -CLOSE))
        for _ in range(ROUNDS):
            depths, directions = _overlaps(steps, watched, body)
            if not np.any(depths > -0.5 * CLEARANCE):
                break
            offsets = steps.points + _pushes(steps, watched, depths + CLEARANCE, directions) - start
            lengths = np.maximum(np.linalg.norm(offsets, axis=1, keepdims=True), 1e-12)
            steps = uncross(replace(steps, points=start + offsets * np.minimum(1.0, FARTHEST / lengths)))
    return steps


@dataclass(frozen=True, kw_only=True)
class _Feet:
    """Feet at instants: on the way from a footstep to the next of the same foot."""

    steps: IntArray
    """Footstep left last, shape (K,)."""
    shares: FloatArray
    """How far it is on the way to the footstep after next, 0 = planted, shape (K,)."""

    def at(self, rows: IntArray) -> _Feet:
        """Some of them."""
        return _Feet(steps=self.steps[rows], shares=self.shares[rows])

    def placed(self, steps: TrackSteps, body: Proportions) -> FloatArray:
        """Ends of their axes (x, z) [m], heel and toe, shape (K, 2, 2)."""
        following = np.minimum(self.steps + 2, len(steps.sides) - 1)
        share = self.shares[:, None]
        points = (1.0 - share) * steps.points[self.steps] + share * steps.points[following]
        turns = planar.wrap_angle(steps.yaws[following] - steps.yaws[self.steps])
        forward = planar.direction(steps.yaws[self.steps] + self.shares * turns)
        heel, toe = body.heel - body.half_width, body.toe - body.half_width
        return np.stack([points - heel * forward, points + toe * forward], axis=1)


@dataclass(frozen=True, kw_only=True)
class _Pairs:
    """Feet of different people near each other at one instant."""

    first: _Feet
    second: _Feet
    times: FloatArray
    """[s]"""

    def at(self, rows: IntArray) -> _Pairs:
        """Some of them."""
        return _Pairs(first=self.first.at(rows), second=self.second.at(rows), times=self.times[rows])


def _feet_over_time(steps: TrackSteps) -> tuple[_Feet, FloatArray]:
    """Every foot at every instant at which its owner's plan runs or is over, and the instants."""
    count = int(np.ceil(steps.liftoff_times.max() / SAMPLE_STEP)) + 1
    instants = SAMPLE_STEP * np.arange(count)
    people = len(steps.first) - 1
    key = steps.owners * 2 + steps.sides
    order = np.lexsort((steps.strike_times, key))
    span = instants[-1] + 1.0
    axis = key[order] * span + steps.strike_times[order]
    wanted = (np.arange(2 * people)[:, None] * span + instants).ravel()
    feet = order[np.maximum(np.searchsorted(axis, wanted + 1e-9, side="right") - 1, 0)]
    times = np.tile(instants, 2 * people)
    last = feet + 2 >= steps.first[1:][steps.owners[feet]]
    following = np.minimum(feet + 2, len(steps.sides) - 1)
    leave = steps.liftoff_times[feet]
    swing = np.maximum(steps.strike_times[following] - leave, 1e-9)
    phase = np.where(last, 0.0, np.clip((times - leave) / swing, 0.0, 1.0))
    return _Feet(steps=feet, shares=phase * phase * (3.0 - 2.0 * phase)), times


def _near_pairs(steps: TrackSteps, body: Proportions, slack: float) -> _Pairs:
    """Pairs of feet of different people that could touch if they moved by the slack in all [m]."""
    feet, times = _feet_over_time(steps)
    middles = feet.placed(steps, body).mean(axis=1)
    where = np.column_stack([middles, times * (APART / SAMPLE_STEP)])
    reach = body.heel + body.toe + CLEARANCE + slack
    pairs = cKDTree(where, compact_nodes=False, balanced_tree=False).query_pairs(reach, output_type="ndarray")
    owners = steps.owners[feet.steps]
    pairs = pairs[owners[pairs[:, 0]] != owners[pairs[:, 1]]]
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return _Pairs(first=feet.at(pairs[:, 0]), second=feet.at(pairs[:, 1]), times=times[pairs[:, 0]])


def _overlaps(steps: TrackSteps, pairs: _Pairs, body: Proportions) -> tuple[FloatArray, FloatArray]:
    """How far the feet of pairs overlap [m], shape (K,), and the direction from the second to the first, (K, 2)."""
    a, b = pairs.first.placed(steps, body), pairs.second.placed(steps, body)
    gaps = np.concatenate([_to_segments(a, b), -_to_segments(b, a)], axis=1)  # (K, 4, 2), from b to a
    distances = np.linalg.norm(gaps, axis=2)
    nearest = np.argmin(distances, axis=1)
    rows = np.arange(len(gaps))
    distance, gap = distances[rows, nearest], gaps[rows, nearest]
    crossing = _cross(a, b)
    between = a.mean(axis=1) - b.mean(axis=1)
    direction = np.where((crossing | (distance < 1e-6))[:, None], between, gap)
    direction = direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9)
    distance = np.where(crossing, -distance, distance)
    return 2.0 * body.half_width - distance, direction


def _to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Vectors from the nearest points of segments (K, 2, 2) to points (K, P, 2), shape (K, P, 2)."""
    along = segments[:, 1] - segments[:, 0]
    offsets = points - segments[:, :1]
    share = np.sum(offsets * along[:, None], axis=2) / np.maximum(np.sum(along**2, axis=1), 1e-12)[:, None]
    return offsets - np.clip(share, 0.0, 1.0)[..., None] * along[:, None]


def _cross(a: FloatArray, b: FloatArray) -> np.ndarray:
    """Whether segments a and b (K, 2, 2) cross, shape (K,)."""

    def side(segment: FloatArray, point: FloatArray) -> FloatArray:
        along, offset = segment[:, 1] - segment[:, 0], point - segment[:, 0]
        return along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]

    return (side(a, b[:, 0]) * side(a, b[:, 1]) < 0.0) & (side(b, a[:, 0]) * side(b, a[:, 1]) < 0.0)


def _pushes(steps: TrackSteps, pairs: _Pairs, depths: FloatArray, directions: FloatArray) -> FloatArray:
    """Where to move every footstep [m]: the mean of what its overlaps ask for, shape (S, 2)."""
    deep = np.flatnonzero(depths > 0.0)
    push = 0.5 * depths[deep, None] * directions[deep]
    sums, counts = np.zeros((len(steps.sides), 2)), np.zeros(len(steps.sides))
    for feet, sign in ((pairs.first.at(deep), 1.0), (pairs.second.at(deep), -1.0)):
        norm = (1.0 - feet.shares) ** 2 + feet.shares**2
        for index, share in ((feet.steps, 1.0 - feet.shares), (feet.steps + 2, feet.shares)):
            used = share > 0.0
            np.add.at(sums, index[used], sign * (share / norm)[used, None] * push[used])
            np.add.at(counts, index[used], share[used])
    return sums / np.maximum(counts, 1e-9)[:, None]
