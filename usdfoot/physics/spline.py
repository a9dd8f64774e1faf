"""The path of the centre of mass: cubic Hermite segments that share position and velocity in time ([P] 2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.footing import Footing
from usdfoot.physics.knot_kernel import KnotOptions, count_knots, write_knots
from usdfoot.physics.shared_arrays import shared, shared_record

__all__ = ["ComSpline", "Knots", "controls_of", "hermite_basis", "lay_knots"]


@dataclass(frozen=True, kw_only=True)
class Knots:
    """Knots of A agents, K in all, in order of agent and time; S = K - A segments lie between them."""

    agents: IntArray
    """Agent of each knot, shape (K,)."""
    times: FloatArray
    """[s], shape (K,)."""
    starts: FloatArray
    """First knot of each agent [s], shape (A,)."""
    fixed: BoolArray
    """Whether the knot keeps its position and its velocity, shape (K, 2): motions that begin or end standing begin or
    end at rest."""
    begins: IntArray
    """Knot at the begin of each segment; the next knot is its end, shape (S,)."""

    @property
    def durations(self) -> FloatArray:
        """Of the segments [s], shape (S,)."""
        return self.times[self.begins + 1] - self.times[self.begins]


@dataclass(frozen=True, kw_only=True)
class ComSpline:
    """[P]'s v: 6 (m + 1) values for m segments."""

    knots: Knots
    positions: FloatArray
    """Centre of mass at the knots [m], shape (K, 3)."""
    velocities: FloatArray
    """Its velocity there, in time: C1 whatever the durations [m/s], shape (K, 3)."""

    @property
    def controls(self) -> FloatArray:
        """Begin position, begin velocity, end position, end velocity of each segment, shape (S, 4, 3)."""
        return controls_of(np.concatenate([self.positions, self.velocities], axis=1), self.knots.begins)

    def evaluate(self, agents: IntArray, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration [m, m/s, m/s^2] at F times, shape (F, 3) each.

        Outside an agent's time it rests where it begins or ends.
        """
        knots = self.knots
        rows = locate(knots.agents[knots.begins], knots.times[knots.begins], knots.starts, agents=agents, times=times)
        first = knots.begins[rows]
        length = knots.times[first + 1] - knots.times[first]
        share = (times - knots.times[first]) / length
        outside = (share < 0.0) | (share > 1.0)
        basis = hermite_basis(np.clip(share, 0.0, 1.0), length)  # (3, F, 4)
        basis[1:, outside] = 0.0
        controls = np.stack(
            [self.positions[first], self.velocities[first], self.positions[first + 1], self.velocities[first + 1]],
            axis=1,
        )
        values = np.einsum("dfc,fcx->dfx", basis, controls)
        return values[0], values[1], values[2]


def hermite_basis(shares: FloatArray, durations: FloatArray) -> FloatArray:
    """Weights of begin position, begin velocity, end position and end velocity in a cubic and its derivatives.

    Args:
        shares: Part of the segment passed, 0 to 1, any shape.
        durations: Of the segments [s], the same shape.

    Returns:
        For position, velocity [1/s] and acceleration [1/s^2], shape (3, ..., 4).
    """
    x, length = shares, durations
    rest = 1.0 - x
    one = np.ones_like(x)
    position = [rest**2 * (1.0 + 2.0 * x), length * x * rest**2, x**2 * (3.0 - 2.0 * x), -length * x**2 * rest]
    slope = 6.0 * x * rest / length
    velocity = [-slope, one - 4.0 * x + 3.0 * x**2, slope, 3.0 * x**2 - 2.0 * x]
    bend = (6.0 - 12.0 * x) / length**2
    acceleration = [-bend, (6.0 * x - 4.0) / length, bend, (6.0 * x - 2.0) / length]
    return np.stack([np.stack(row, axis=-1) for row in (position, velocity, acceleration)])


def controls_of(unknowns: FloatArray, begins: IntArray) -> FloatArray:
    """Begin position, begin velocity, end position, end velocity of segments, shape (S, 4, 3).

    Args:
        unknowns: Position and velocity of each knot, shape (K, 6).
        begins: Knot at the begin of each segment, shape (S,).
    """
    pairs = unknowns.reshape(-1, 2, 3)
    return np.concatenate([pairs[begins], pairs[begins + 1]], axis=1)


def lay_knots(contacts: ContactTable, footing: Footing, *, parts: int = 1, longest_segment: float = 1.0) -> Knots:
    """Knots at every strike, at the begin of every flight and at the end ([P] Figure 6).

    A flight is the time before a strike in which neither foot stands. Events closer than 20 ms share a knot. Where feet
    take weight as people's do, a walk's knot is not at the strike but in the middle of the double stance, when half of
    the weight is on either foot: only at a knot can the acceleration jump, and else the force would change feet at the
    strike.

    Args:
        contacts: Of all agents.
        footing: Of the contacts.
        parts: Segments a step on the ground; 1 as in [P].
        longest_segment: Longer ones are divided [s].
    """
    count = len(contacts.starts)
    counts = np.empty(count, dtype=np.int32)
    options = shared_record(KnotOptions, {"parts": parts, "longest": longest_segment})
    wp.launch(
        count_knots, dim=count,
        inputs=[footing.contacts, footing.rows, options, wp.empty(0, dtype=wp.float64, device="cpu")],
        outputs=[shared(counts, wp.int32)], device="cpu",
    )  # fmt: skip
    starts = np.cumsum(counts) - counts
    agents, times = np.repeat(np.arange(count), counts), np.empty(counts.sum())
    wp.launch(
        write_knots, dim=count, inputs=[footing.contacts, footing.rows, options, shared(starts, wp.int32)],
        outputs=[shared(times, wp.float64)], device="cpu",
    )  # fmt: skip
    return Knots(
        agents=agents,
        times=times,
        starts=contacts.starts,
        fixed=_rests(contacts, starts, starts + counts - 1),
        begins=np.flatnonzero(agents[:-1] == agents[1:]),
    )


def _rests(contacts: ContactTable, firsts: IntArray, lasts: IntArray) -> BoolArray:
    """Fixed velocities at the first and last knots (A,) of motions that begin or end standing, shape (K, 2)."""
    fixed = np.zeros((lasts[-1] + 1, 2), dtype=bool)
    first, last = contacts.first[:-1], contacts.first[1:] - 1
    fixed[firsts, 1] = contacts.strikes[first] == contacts.strikes[first + 1]
    fixed[lasts, 1] |= (contacts.steps[last] >= 0) & (contacts.liftoffs[last] == contacts.liftoffs[last - 1])
    return fixed
