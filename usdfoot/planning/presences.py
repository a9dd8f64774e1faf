"""Presences: which foot is where from when to when, and which of different people are near each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.planning.foot_table import FootTable, Instants
from usdfoot.planning.presence_kernel import Stays, find_pairs

__all__ = ["INSTANT", "Presences", "find_presences", "pair_presences"]

INSTANT = 1.0 / 60.0
"""Between the instants at which feet are compared [s]."""
MOST_INSTANTS = 50_000_000
"""Instants of swings that are compared at once, for memory's sake: some gigabytes."""


@dataclass(frozen=True, kw_only=True)
class Presences:
    """Feet in one place for a while: a stand is one, a swing one for each of its instants; P of them."""

    steps: IntArray
    """Footstep left last, shape (P,)."""
    begins: IntArray
    """First instant, shape (P,)."""
    ends: IntArray
    """Last instant, shape (P,)."""
    shares: FloatArray
    """How far it is on the way to the next footstep, 0 = planted, shape (P,)."""

    def __getitem__(self, rows: IntArray | BoolArray) -> Presences:
        return Presences(
            steps=self.steps[rows], begins=self.begins[rows], ends=self.ends[rows], shares=self.shares[rows]
        )

    @property
    def at_first(self) -> Instants:
        """The first instant of each."""
        return Instants(steps=self.steps, shares=self.shares, times=INSTANT * self.begins)


def find_presences(feet: FootTable) -> Presences:
    """Where every foot is from its first strike to its last liftoff."""
    following = np.minimum(np.arange(len(feet.owners)) + 2, len(feet.owners) - 1)
    ends = np.where(feet.last, feet.liftoffs, feet.strikes[following] - 1e-9)
    begins = np.ceil(feet.strikes / INSTANT - 1e-9).astype(np.int64)
    ends = np.floor(ends / INSTANT).astype(np.int64)
    left = np.where(feet.last, ends, np.clip(np.floor(feet.liftoffs / INSTANT).astype(np.int64), begins - 1, ends))
    stands = np.flatnonzero(left >= begins)
    counts = np.maximum(ends - left, 0)
    if counts.sum() > MOST_INSTANTS:
        longest = int(np.argmax(counts))
        raise PlanError(
            "plans",
            f"have {counts.sum()} instants of swings to compare, more than {MOST_INSTANTS}; the longest swing is after "
            f"footstep {feet.numbers[longest]} of plan {feet.owners[longest]}, until {INSTANT * ends[longest]:.6g} s",
            "correct its times, or take fewer plans at once",
        )
    swings = np.repeat(np.arange(len(counts)), counts)
    instants = left[swings] + 1 + np.arange(len(swings)) - np.repeat(np.cumsum(counts) - counts, counts)
    spans = np.maximum(feet.strikes[following] - feet.liftoffs, 1e-9)[swings]
    phases = np.clip((INSTANT * instants - feet.liftoffs[swings]) / spans, 0.0, 1.0)
    return Presences(
        steps=np.concatenate([stands, swings]),
        begins=np.concatenate([begins[stands], instants]),
        ends=np.concatenate([left[stands], instants]),
        shares=np.concatenate([np.zeros(len(stands)), phases * phases * (3.0 - 2.0 * phases)]),
    )


def pair_presences(
    presences: Presences, points: FloatArray, owners: IntArray, *, touched: BoolArray, reach: float
) -> IntArray:
    """Pairs of presences of different people at one time near each other, shape (K, 2), the lower footstep first.

    Of two the one that begins later does so during the other.

    Args:
        presences: P of them.
        points: Where they are [m], shape (P, 3).
        owners: Whose, shape (P,).
        touched: At least one of a pair is, shape (P,).
        reach: So near are they [m].
    """
    cells = np.floor(points[:, :2] / reach).astype(np.int64)
    cells -= cells.min(axis=0, initial=0) - 1
    width = int(cells[:, 0].max(initial=0)) + 2
    numbers = cells[:, 1] * width + cells[:, 0]
    offsets = np.array([row * width + column for row in (-1, 0, 1) for column in (-1, 0, 1)])
    rows = np.arange(len(numbers))
    if not touched.all():
        rows = np.flatnonzero(np.isin(numbers, np.add.outer(np.unique(numbers[touched]), offsets)))
    if not rows.size:
        return np.zeros((0, 2), dtype=np.intp)
    since = presences.begins[rows] - presences.begins.min()
    rows = rows[np.argsort(numbers[rows] * (int(since.max()) + 1) + since, kind="stable")]
    first = np.flatnonzero(np.diff(numbers[rows], prepend=-1))
    known = numbers[rows[first]]
    wanted = known[:, None] + offsets
    beside = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    beside = np.where(known[beside] == wanted, beside, -1)
    stays = _stays(presences[rows], rows, points[rows], owners=owners[rows], touched=touched[rows])
    pairs = _pairs(stays, np.append(first, len(rows)), beside, reach)
    swapped = presences.steps[pairs[:, 0]] > presences.steps[pairs[:, 1]]
    return np.where(swapped[:, None], pairs[:, ::-1], pairs)


def _stays(presences: Presences, rows: IntArray, points: FloatArray, *, owners: IntArray, touched: BoolArray) -> Any:
    """Presences, P of them and all sorted alike, for the kernel."""
    start_warp()
    stays: Any = Stays()
    tables: dict[str, tuple[Any, Any]] = {
        "rows": (rows.astype(np.int32), wp.int32),
        "begins": (presences.begins, wp.int64),
        "ends": (presences.ends, wp.int64),
        "owners": (owners.astype(np.int32), wp.int32),
        "touched": (touched, wp.bool),
        "points": (points, wp.vec3d),
    }
    for name, (values, dtype) in tables.items():
        setattr(stays, name, wp.array(values, dtype=dtype, device="cpu", copy=False))
    return stays


def _pairs(stays: Any, first: IntArray, beside: IntArray, reach: float) -> IntArray:
    """Rows of stays that are near each other, shape (K, 2): those of each cell are counted, then written."""
    counts, pairs = np.zeros(len(beside), dtype=np.int32), np.zeros((0, 2), dtype=np.int32)
    for _ in range(2):
        tables = (first, beside, np.cumsum(counts) - counts, counts, pairs)
        begins, around, places, counted, written = (
            wp.array(values.astype(np.int32, copy=False), dtype=wp.int32, ndim=values.ndim, device="cpu", copy=False)
            for values in tables
        )
        wp.launch(
            find_pairs,
            dim=len(beside),
            inputs=[stays, begins, around, reach, places],
            outputs=[counted, written],
            device="cpu",
        )
        if pairs.size:
            break
        pairs = np.zeros((int(counts.sum()), 2), dtype=np.int32)
    return pairs.astype(np.intp)
