"""Elbow room: roots that come too near each other are moved apart, smoothly in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.root_curves import SPACING, RootCurves

__all__ = ["keep_apart"]

CLOCK = 0.2
"""Between the instants at which roots are compared [s]."""
SMOOTHING = 0.5
"""Standard deviation in time of how roots are moved [s]."""
ROUNDS = 40
STOREY = 1.0
"""Roots this far above one another are on different levels [m]."""
FARTHEST = 0.5
"""A root is moved this far at most [m]."""
APART = 100.0
"""Between instants on the time axis of the search tree [m]: more than any distance looked for."""


def keep_apart(curves: RootCurves, *, distance: float) -> RootCurves:
    """The curves with roots at least `distance` [m] from each other wherever they can be.

    Two that are too near are both moved away by half of what lacks; what is moved is smoothed over time and the rest
    is moved again. Tracked people walk shoulder to shoulder, and trackers err by as much as a foot is wide.
    """
    instants, first, present = _clock(curves)
    rows, columns = np.nonzero(present)
    if len(rows) < 2:
        return curves
    times = instants[columns]
    spots = curves.at(rows, times)[0]
    places, heights = spots[:, [0, 2]], spots[:, 1]
    offsets = np.zeros((*present.shape, 2))
    weight = np.maximum(gaussian_filter1d(present.astype(float), SMOOTHING / CLOCK, axis=1, mode="constant"), 1e-3)
    for _ in range(ROUNDS):
        pushes = _pushes(places + offsets[rows, columns], heights, columns, distance)
        if pushes is None:
            break
        field = np.zeros_like(offsets)
        field[rows, columns] = pushes
        peak = np.abs(pushes).max()
        field = (
            gaussian_filter1d(field, SMOOTHING / CLOCK, axis=1, mode="constant") / np.maximum(weight, 1e-3)[..., None]
        )
        field *= peak / max(float(np.abs(field[rows, columns]).max()), 1e-9)
        offsets = offsets + field
        lengths = np.maximum(np.linalg.norm(offsets, axis=2, keepdims=True), 1e-9)
        offsets = offsets * np.minimum(1.0, FARTHEST / lengths)
    return _moved(curves, offsets, first)


def _clock(curves: RootCurves) -> tuple[FloatArray, float, BoolArray]:
    """Instants (T,), the first of them, and who is there at each, shape (A, T)."""
    first = float(np.floor(curves.starts.min() / CLOCK)) * CLOCK
    instants = first + CLOCK * np.arange(int(np.ceil((curves.ends.max() - first) / CLOCK)) + 2)
    present = (instants >= curves.starts[:, None] - CLOCK) & (instants <= curves.ends[:, None] + CLOCK)
    return instants, first, present


def _pushes(places: FloatArray, heights: FloatArray, instants: np.ndarray, distance: float) -> FloatArray | None:
    """How each of N roots (x, z) at heights (N,) [m] is to move, shape (N, 2); None if nobody is too near."""
    points = np.column_stack([places, heights * (distance / STOREY), instants * APART])
    pairs = cKDTree(points, compact_nodes=False, balanced_tree=False).query_pairs(distance, output_type="ndarray")
    gaps = places[pairs[:, 0]] - places[pairs[:, 1]]
    lengths = np.linalg.norm(gaps, axis=1)
    if not np.any(lengths < 0.98 * distance):
        return None
    aside = np.where((lengths < 1e-6)[:, None], np.array([1.0, 0.0]), gaps / np.maximum(lengths, 1e-6)[:, None])
    push = 0.5 * (distance - lengths)[:, None] * aside
    moves = np.zeros_like(places)
    np.add.at(moves, pairs[:, 0], push)
    np.add.at(moves, pairs[:, 1], -push)
    return moves


def _moved(curves: RootCurves, offsets: FloatArray, first: float) -> RootCurves:
    """The curves with offsets (A, T, 2) of the clock added."""
    agents, frames = curves.yaws.shape
    times = np.minimum(curves.starts[:, None] + SPACING * np.arange(frames), curves.ends[:, None])
    where = np.clip((times - first) / CLOCK, 0.0, offsets.shape[1] - 1.001)
    before = where.astype(np.intp)
    share = (where - before)[..., None]
    owner = np.arange(agents)[:, None]
    added = (1.0 - share) * offsets[owner, before] + share * offsets[owner, before + 1]
    positions = curves.positions.copy()
    positions[..., [0, 2]] += added
    return replace(curves, positions=positions)
