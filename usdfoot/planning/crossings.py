"""Crossings: footholds, the stances before and after them, and the footsteps between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.reach import Reach

__all__ = ["Crossing", "Stance", "Stones", "stance_at"]


@dataclass(frozen=True, kw_only=True)
class Stones:
    """Places a foot may stand, N of them.

    Raises:
        PlanError: If there is none, or a position is not finite.
    """

    name: str
    """Prim paths they come from, for messages."""
    positions: FloatArray
    """Point of the ground under the ball [m], shape (N, 3)."""
    normals: FloatArray
    """Of the ground, shape (N, 3)."""
    discomforts: FloatArray | None = None
    """How much worse it is to stand there, in comfortable steps, shape (N,); None = no worse."""

    def __post_init__(self) -> None:
        if not len(self.positions):
            raise PlanError(self.name, "has no footholds", "give points, or meshes with level places for a foot")
        stray = np.flatnonzero(~np.isfinite(np.hstack([self.positions, self.normals])).all(axis=1))
        if stray.size:
            raise PlanError(self.name, f"foothold {stray[0]} is not finite", "repair its position")

    @property
    def costs(self) -> FloatArray:
        """The discomforts, 0 where there are none, shape (N,)."""
        return np.zeros(len(self.positions)) if self.discomforts is None else self.discomforts

    def only(self, kept: IntArray | BoolArray) -> Stones:
        """The footholds that are kept."""
        return Stones(
            name=self.name,
            positions=self.positions[kept],
            normals=self.normals[kept],
            discomforts=self.costs[kept],
        )


@dataclass(frozen=True, kw_only=True)
class Stance:
    """Both feet side by side, where a crossing starts or ends."""

    positions: FloatArray
    """Of the left and right foot [m], shape (2, 3)."""
    yaw: float
    """[rad]"""


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """Footsteps from stance to stance, S of them, the first two and the last two side by side."""

    footholds: IntArray
    """Index of each footstep's foothold, -1 for the stances, shape (S,)."""
    sides: IntArray
    """0 = left, 1 = right, shape (S,)."""
    positions: FloatArray
    """[m], shape (S, 3)."""
    normals: FloatArray
    """Of the ground, shape (S, 3)."""
    yaws: FloatArray
    """Heading at the end of each step [rad], shape (S,)."""
    cost: float
    """Sum over all steps of how uncomfortable they are."""


def stance_at(position: FloatArray, yaw: float, reach: Reach) -> Stance:
    """Feet as far apart as is comfortable, around a point (3,) [m]."""
    across = 0.5 * float(reach.comfortable[0]) * planar.direction(np.array([yaw + 0.5 * np.pi, yaw - 0.5 * np.pi]))
    return Stance(positions=np.asarray(position, dtype=float) + np.insert(across, 1, 0.0, axis=1), yaw=yaw)
