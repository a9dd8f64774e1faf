"""Elbow room: roots that come too near each other are moved apart, smoothly in time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.root_curves import SPACING, CurveBatches, RootCurves

__all__ = ["ElbowRoom", "make_room"]

CLOCK = 0.2
"""Between the instants at which roots are compared [s]."""
SMOOTHING = 0.5
"""Standard deviation in time of how roots are moved [s]."""
ROUNDS = 40
STOREY = 1.0
"""Roots this far above one another are on different levels [m]."""
FARTHEST = 0.5
"""A root is moved this far at most [m]."""
WATCH = 0.2
"""Roots this much farther apart are watched while others move [m]."""
APART = 100.0
"""Between instants on the time axis of the search tree [m]: more than any distance looked for."""


@dataclass(frozen=True, kw_only=True)
class ElbowRoom:
    """How far A roots move aside."""

    start: float
    """Of the clock [s]."""
    offsets: FloatArray
    """(x, z) every `CLOCK` [m], shape (A, T, 2)."""

    def moved(self, curves: RootCurves, agents: IntArray) -> RootCurves:
        """The curves of some agents (N,) with what these move aside."""
        frames = np.arange(curves.yaws.shape[1])
        times = np.minimum(curves.starts[:, None] + SPACING * frames, curves.ends[:, None])
        where = np.clip((times - self.start) / CLOCK, 0.0, self.offsets.shape[1] - 1.001)
        before = where.astype(np.intp)
        share = (where - before)[..., None]
        owner = agents[:, None]
        added = (1.0 - share) * self.offsets[owner, before] + share * self.offsets[owner, before + 1]
        positions = curves.positions.copy()
        positions[..., [0, 2]] += added
        return replace(curves, positions=positions)


def make_room(curves: CurveBatches, *, distance: float) -> ElbowRoom:
    """How roots move aside so that they are at least `distance` [m] from each other wherever they can be.

    Two that are too near are both moved away by half of what lacks; what is moved is smoothed over time and the rest
    is moved again. Tracked people walk shoulder to shoulder, and trackers err by as much as a foot is wide.
    """
    instants, first, present = _clock(curves.starts, curves.ends)
    rows, columns = np.nonzero(present)
    spots = np.empty((len(rows), 3))
    for agents, some in curves.of(np.arange(len(present))):
        asked = slice(*np.searchsorted(rows, [agents[0], agents[-1] + 1]))
        spots[asked] = some.at(rows[asked] - agents[0], instants[columns[asked]])[0]
    places, heights = spots[:, [0, 2]], spots[:, 1]
    offsets = np.zeros((*present.shape, 2))
    weight = np.maximum(gaussian_filter1d(present.astype(float), SMOOTHING / CLOCK, axis=1, mode="constant"), 1e-3)
    moved, near, farthest = places.copy(), _near(places, heights, columns, distance), 0.0
    for _ in range(ROUNDS):
        if farthest > 0.5 * WATCH:
            near, places = _near(moved, heights, columns, distance), moved.copy()
        pushes = _pushes(moved, heights, near, distance)
        if pushes is None:
            break
        pushed = np.bincount(rows, weights=np.any(pushes != 0.0, axis=1), minlength=len(offsets)) > 0.0
        own, line = np.flatnonzero(pushed[rows]), np.cumsum(pushed) - 1
        field = np.zeros((int(pushed.sum()), *offsets.shape[1:]))
        field[line[rows[own]], columns[own]] = pushes[own]
        peak = np.abs(pushes).max()
        field = gaussian_filter1d(field, SMOOTHING / CLOCK, axis=1, mode="constant") / weight[pushed, :, None]
        field *= peak / max(float(np.abs(field[line[rows[own]], columns[own]]).max()), 1e-9)
        field += offsets[pushed]
        lengths = np.maximum(np.linalg.norm(field, axis=2, keepdims=True), 1e-9)
        offsets[pushed] = field * np.minimum(1.0, FARTHEST / lengths)
        moved[own] = spots[own][:, [0, 2]] + offsets[rows[own], columns[own]]
        farthest = float(np.linalg.norm(moved - places, axis=1).max())
    return ElbowRoom(start=first, offsets=offsets)


def _clock(starts: FloatArray, ends: FloatArray) -> tuple[FloatArray, float, BoolArray]:
    """Instants (T,), the first of them, and who of those (A,) is there at each, shape (A, T)."""
    first = float(np.floor(starts.min() / CLOCK)) * CLOCK
    instants = first + CLOCK * np.arange(int(np.ceil((ends.max() - first) / CLOCK)) + 2)
    present = (instants >= starts[:, None] - CLOCK) & (instants <= ends[:, None] + CLOCK)
    return instants, first, present


def _near(places: FloatArray, heights: FloatArray, instants: IntArray, distance: float) -> IntArray:
    """Roots at (x, z) (N, 2) and heights (N,) [m] that are too near each other or soon may be, shape (K, 2)."""
    points = np.column_stack([places, heights * (distance / STOREY), instants * APART])
    tree = cKDTree(points, compact_nodes=False, balanced_tree=False)
    pairs = tree.query_pairs(distance + WATCH, output_type="ndarray")
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _pushes(places: FloatArray, heights: FloatArray, near: IntArray, distance: float) -> FloatArray | None:
    """How each of N roots (x, z) at heights (N,) [m] is to move, shape (N, 2); None if nobody is too near.

    Args:
        places: (x, z) [m], shape (N, 2).
        heights: [m], shape (N,).
        near: Those who may be too near each other, shape (K, 2).
        distance: What is near enough [m].
    """
    rises = (heights[near[:, 0]] - heights[near[:, 1]]) * (distance / STOREY)
    gaps = places[near[:, 0]] - places[near[:, 1]]
    close = np.flatnonzero(np.sum(gaps**2, axis=1) + rises**2 <= distance**2)
    pairs, gaps = near[close], gaps[close]
    lengths = np.linalg.norm(gaps, axis=1)
    if not np.any(lengths < 0.98 * distance):
        return None
    aside = np.where((lengths < 1e-6)[:, None], np.array([1.0, 0.0]), gaps / np.maximum(lengths, 1e-6)[:, None])
    push = 0.5 * (distance - lengths)[:, None] * aside
    moves = np.zeros_like(places)
    np.add.at(moves, pairs[:, 0], push)
    np.add.at(moves, pairs[:, 1], -push)
    return moves
