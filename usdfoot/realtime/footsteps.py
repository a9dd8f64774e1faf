"""Footsteps as they come: one or more of some agents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.limits import FARTHEST, LATEST
from usdfoot.realtime.arguments import number_array

__all__ = ["Footsteps", "rounds_of"]

BEYOND = (("positions", FARTHEST, "m"), ("strike_times", LATEST, "s"), ("liftoff_times", LATEST, "s"))
"""Where footsteps are not taken."""


@dataclass(frozen=True, kw_only=True)
class Footsteps:
    """M footsteps in the canonical world; those of one agent in order of strike.

    Raises:
        UsdfootError: If the arrays differ in length, or hold no numbers.
    """

    sides: IntArray
    """0 = left, 1 = right, shape (M,)."""
    positions: FloatArray
    """Point of the ground under the ball of the planted foot [m], shape (M, 3)."""
    yaws: FloatArray
    """Direction of the foot [rad], shape (M,)."""
    strike_times: FloatArray
    """First contact [s], shape (M,)."""
    liftoff_times: FloatArray
    """When the ball is to leave the ground [s], shape (M,)."""

    def __post_init__(self) -> None:
        for name, values in vars(self).items():
            object.__setattr__(self, name, number_array(name, values))
        count = self.sides.shape[:1]
        shapes = {name: (*count, 3) if name == "positions" else count for name in vars(self)}
        if self.sides.ndim != 1 or any(values.shape != shapes[name] for name, values in vars(self).items()):
            listing = ", ".join(f"{name} {values.shape}" for name, values in vars(self).items())
            raise PlanError("Footsteps", f"arrays differ in length ({listing})", "give one entry a footstep in each")

    def __len__(self) -> int:
        return len(self.sides)

    def __getitem__(self, rows: IntArray | BoolArray) -> Footsteps:
        return Footsteps(**{name: values[rows] for name, values in vars(self).items()})

    def faults(self) -> dict[int, str]:
        """What is wrong with which footstep: its side, a value that is none or beyond all measure, no time to stand."""
        found: dict[int, str] = {}
        if not len(self):
            return found
        for name, values in vars(self).items():
            bad = ~np.isfinite(values.reshape(len(self), -1)).all(axis=1)
            found |= {int(row): f"{name} is not a finite number" for row in np.flatnonzero(bad)}
        for name, most, unit in BEYOND:
            far = np.abs(getattr(self, name).reshape(len(self), -1)).max(axis=1, initial=0.0) > most
            for row in np.flatnonzero(far):
                found.setdefault(int(row), f"{name} is beyond {most:g} {unit}")
        for row in np.flatnonzero((self.sides != 0) & (self.sides != 1)):
            found.setdefault(int(row), f"side is {self.sides[row]}; 0 = left, 1 = right")
        for row in np.flatnonzero(~(self.liftoff_times > self.strike_times)):
            found.setdefault(int(row), "liftoff_times is not after strike_times")
        return found


def rounds_of(agents: IntArray) -> Sequence[IntArray]:
    """Rows of the agents' first footsteps, of their second ones and so on; `agents` (M,) say whose each is."""
    order = np.argsort(agents, kind="stable")
    fresh = np.diff(agents[order], prepend=-np.inf) != 0
    begins = np.flatnonzero(fresh)
    ranks = np.arange(len(agents)) - np.repeat(begins, np.diff(np.append(begins, len(agents))))
    return [order[ranks == rank] for rank in range(int(ranks.max(initial=-1)) + 1)]
