"""Collisions: feet of different people in one place at one time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.near_feet import find_near_feet, find_pairs_of

__all__ = ["Collisions", "find_collisions"]


@dataclass(frozen=True, kw_only=True)
class Collisions:
    """Feet of two people that overlap, the deepest instant of each pair of footsteps, C of them."""

    steps: IntArray
    """Rows of the foot table, shape (C, 2)."""
    times: FloatArray
    """[s], shape (C,)."""
    depths: FloatArray
    """How far they overlap [m], shape (C,)."""


def find_collisions(feet: FootTable, *, among: BoolArray | None = None) -> Collisions:
    """Overlaps of soles, each a capsule from heel to toe, standing or swinging straight to its next footstep.

    Args:
        feet: Of all people.
        among: Only those of feet on, or on the way from or to, these footsteps, shape (S,); None = of all.
    """
    near = find_near_feet(feet, slack=0.0) if among is None else find_pairs_of(feet, among, slack=0.0)
    first, second, depths = near.first, near.second, near.depths
    deep = np.flatnonzero(depths > 1e-6)
    deep = deep[np.argsort(-depths[deep], kind="stable")]
    pairs = np.sort(np.stack([first.steps[deep], second.steps[deep]], axis=1), axis=1)
    _, rows = np.unique(pairs, axis=0, return_index=True)
    rows = np.sort(rows)
    return Collisions(steps=pairs[rows], times=first.times[deep][rows], depths=depths[deep][rows])
