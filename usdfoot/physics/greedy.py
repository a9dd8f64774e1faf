"""[P]'s own solver: every value is altered in turn, and what lowers E stays (Figure 10)."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.energy import segment_energies
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import Samples, take_segments
from usdfoot.physics.spline import Knots, controls_of

__all__ = ["search_unknowns"]

SCALES = (0.06, 0.02)
"""Alterations of control points and tangents, one scale after the other [m]."""
SWEEPS = 1000
"""Most sweeps over all values at one scale."""


def search_unknowns(samples: Samples, knots: Knots, unknowns: FloatArray, *, options: PhysicsOptions) -> FloatArray:
    """Unknowns (K, 6) at which no single alteration lowers E, from `unknowns`.

    As printed, with its sign slip mended (the second trial is kept as v - delta): each value is tried upward, then
    downward; an alteration that helps is repeated; sweeps end when nothing helps. Only the segments that share the
    knot are evaluated again, and only knots beside which something changed since they were tried. Tangents are altered
    by the scale over the duration of the segments beside them, since they are velocities here. Every other knot comes
    first, then those between: these share no segment, so that all of them, of all agents, are altered at once with the
    same outcome as one after the other.

    Args:
        samples: Of all segments.
        knots: Of all agents.
        unknowns: Position and velocity of each knot, shape (K, 6).
        options: Gravity and comfort.
    """
    state = _Search(samples, knots, unknowns, options)
    places = np.arange(len(knots.times)) - np.searchsorted(knots.agents, knots.agents)
    for scale in SCALES:
        before = np.ones(len(places), dtype=bool)  # what the last sweep altered
        for _ in range(SWEEPS):
            altered = np.zeros(len(places), dtype=bool)
            for parity in (0, 1):
                tried = (places % 2 == parity) & _beside(before | altered)
                for column in range(6):
                    rows = np.flatnonzero(tried & ~knots.fixed[:, column // 3])
                    altered[rows[state.alter(rows, column, scale)]] = True
            if not altered.any():
                break
            before = altered
    return state.unknowns


def _beside(flags: BoolArray) -> BoolArray:
    """Knots that are marked or next to one that is, shape (K,)."""
    marked = flags.copy()
    marked[1:] |= flags[:-1]
    marked[:-1] |= flags[1:]
    return marked


class _Search:
    """The search's state: values as they are, and E of each segment."""

    def __init__(self, samples: Samples, knots: Knots, unknowns: FloatArray, options: PhysicsOptions) -> None:
        self.samples, self.knots, self.options = samples, knots, options
        self.unknowns = unknowns.copy()
        segments = len(knots.begins)
        self.after = np.full(len(knots.times), -1)
        self.after[knots.begins] = np.arange(segments)
        self.before = np.full(len(knots.times), -1)
        self.before[knots.begins + 1] = np.arange(segments)
        lengths = np.append(knots.durations, 0.0)  # for the index -1
        beside = (self.after >= 0).astype(int) + (self.before >= 0)
        self.spans = (lengths[self.after] + lengths[self.before]) / beside

    def alter(self, rows: IntArray, column: int, scale: float) -> BoolArray:
        """Alters one value of each knot of `rows` (R,) up or down as long as E falls; which of them moved, (R,)."""
        deltas = np.full(len(rows), scale) if column < 3 else scale / self.spans[rows]
        moved = np.zeros(len(rows), dtype=bool)
        for sign in (1.0, -1.0):
            going = np.flatnonzero(~moved)
            if not going.size:
                break
            energies = self._energies(rows[going])
            while going.size:
                knots = rows[going]
                self.unknowns[knots, column] += sign * deltas[going]
                trial = self._energies(knots)
                lower = trial < energies
                self.unknowns[knots[~lower], column] -= sign * deltas[going[~lower]]
                going, energies = going[lower], trial[lower]
                moved[going] = True
        return moved

    def _energies(self, rows: IntArray) -> FloatArray:
        """E of the segments that share each knot, shape (rows,)."""
        segments = np.concatenate([self.before[rows], self.after[rows]])
        owners = np.tile(np.arange(len(rows)), 2)[segments >= 0]
        segments = segments[segments >= 0]
        part = take_segments(self.samples, segments)
        energies = segment_energies(
            part, controls_of(self.unknowns, self.knots.begins[segments]),
            gravity=self.options.gravity, comfort=self.options.comfort,
        )  # fmt: skip
        return np.bincount(owners, energies, len(rows)).astype(float)
