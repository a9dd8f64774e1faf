"""Slipping: who is held up by people who stand turns its shoulders and slips through between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.scenario import Seeker

__all__ = ["HELD_UP", "Slips"]

HELD_UP, HARDLY = 1.5, 0.2
"""Who has for so long [s] hardly moved, by less than this [m], is held up."""
REACH = 0.5
"""By those whose bodies are so near [m]."""
LASTS = 4.0
"""It slips for so long [s], and until its body has room again."""
THIN = 0.3
"""Radius of who has turned, over its own: half, less what JuPedSim keeps between people."""
TURN = 0.67
"""How far shoulders turn: then a body needs two thirds of its width."""
APART = 1e3
"""Between levels in the search tree [m]: more than any distance looked for."""


class Slips:
    """Who of N people slips past whom.

    Seen from above a body is half as deep as broad. Those who stand lean out of the way.

    Args:
        seekers: The people.
    """

    def __init__(self, seekers: Sequence[Seeker]) -> None:
        self._radii = np.array([seeker.radius for seeker in seekers])
        self._narrowest = THIN * self._radii
        self._until = np.full(len(seekers), -np.inf)
        self.active: BoolArray = np.zeros(len(seekers), dtype=bool)
        """Who slips through, shape (N,)."""
        self._gives_way: BoolArray = self.active.copy()

    @property
    def turned(self) -> FloatArray:
        """How far each has to turn its shoulders: 0 = not, 1 = sideways, shape (N,)."""
        return TURN * self.active

    @property
    def thin(self) -> FloatArray:
        """Radii of the bodies in the simulation [m], shape (N,)."""
        return np.where(self.active | self._gives_way, self._narrowest, self._radii)

    def advance(
        self,
        points: FloatArray,
        moved: FloatArray,
        levels: IntArray,
        *,
        standing: BoolArray,
        waits: BoolArray,
        now: float,
    ) -> None:
        """Let people slip from now on, or no longer.

        Args:
            points: Where they are (x, z) [m], shape (N, 2).
            moved: How far they got in `HELD_UP` [m], shape (N,).
            levels: On which they are, shape (N,).
            standing: Who has arrived, shape (N,).
            waits: Who waits before a passage, or goes through one, shape (N,).
            now: [s]
        """
        places = np.column_stack([points, APART * levels])
        pairs = cKDTree(places).query_pairs(2.0 * float(self._radii.max()) + REACH, output_type="ndarray")
        one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
        gaps = np.linalg.norm(points[one] - points[other], axis=1) - self._radii[one] - self._radii[other]
        beside = self._any(one, standing[other] & (gaps <= REACH))
        free = ~(standing | waits)
        self._until[free & beside & (moved < HARDLY)] = now + LASTS
        tight = self._any(one, gaps < 0.0)
        self.active = free & ((now < self._until) | (self.active & tight))
        self._gives_way = standing & (self._any(one, self.active[other]) | (self._gives_way & tight))

    def _any(self, people: IntArray, holds: BoolArray) -> BoolArray:
        """Whether something holds for any pair of each of N people."""
        return np.bincount(people, weights=holds, minlength=len(self._radii)) > 0.0
