"""Landings and root velocities of a library's examples, both sides as one: right steps as if the left foot swung."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import RIGHT
from usdfoot.model.examples import Examples

__all__ = ["end_landings", "left_landings", "root_starts", "root_velocities"]


def end_landings(examples: Examples, *, frame: str = "support") -> FloatArray:
    """Landings in the heading at the step's end, (x, z) [m], shape (E, 2).

    They are [B] 4.1's p_i, but from the support ball, not from the root, whose errors would go into every step; with
    `frame` = root from there all the same. A blended step is turned about the support ball until it ends in the planned
    heading. Seen from there a landing does not depend on how much its own clip turned, so the barycentric weights stay
    exact whatever the turn.
    """
    origins = root_starts(examples.departures) if frame == "root" else 0.0
    return planar.rotate(-examples.turns, examples.landings - origins)


def root_starts(departures: FloatArray) -> FloatArray:
    """Root as steps start, from the support ball, midway to where the swing foot stood ([B] 4.2) [m], shape (N, 2)."""
    return 0.5 * np.asarray(departures, dtype=float)


def root_velocities(examples: Examples) -> FloatArray:
    """Mean velocity of the root over each step in the heading at its end, (x, z) [m/s], shape (E, 2).

    The root is midway between consecutive footsteps ([B] 4.2): it moves by half of what the swing foot does.
    """
    strides = 0.5 * (examples.landings - examples.departures)
    return planar.rotate(-examples.turns, strides) / np.asarray(examples.durations, dtype=float)[:, None]


def left_landings(landings: FloatArray, swing_sides: IntArray) -> FloatArray:
    """Landings (N, 2) as if the left foot swung: x negated where the right one does. Its own inverse."""
    signs = np.where(np.asarray(swing_sides) == RIGHT, -1.0, 1.0)
    return np.asarray(landings, dtype=float) * np.stack([signs, np.ones_like(signs)], axis=-1)
