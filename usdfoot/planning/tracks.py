"""Tracks: the contacts of many agents as they are planned, and the footstep plans cut from them."""

from __future__ import annotations

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.prints import print_orientations

__all__ = ["Tracks"]


class Tracks:
    """Contacts of A agents in rounds of one each; an agent that is done takes no part in later rounds.

    Args:
        count: Number of agents.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._sides: list[IntArray] = []
        self._positions: list[FloatArray] = []
        self._yaws: list[FloatArray] = []
        self._strikes: list[FloatArray] = []
        self._liftoffs: list[FloatArray] = []

    def add(
        self, agents: IntArray, sides: IntArray, *, positions: FloatArray, yaws: FloatArray, strikes: FloatArray
    ) -> None:
        """One more contact of each of the agents; a strike that is not a number marks one that is no footstep."""
        for rows, values, missing in (
            (self._sides, sides, -1),
            (self._positions, positions, np.nan),
            (self._yaws, yaws, np.nan),
            (self._strikes, strikes, np.nan),
            (self._liftoffs, np.full(len(agents), np.nan), np.nan),
        ):
            row = np.full((self._count, *values.shape[1:]), missing, dtype=values.dtype)
            row[agents] = values
            rows.append(row)

    def release(self, agents: IntArray, times: FloatArray, *, back: int) -> None:
        """Lets the contact `back` rounds before the last one lift off at times (N,) [s]."""
        self._liftoffs[-1 - back][agents] = times

    @property
    def strikes(self) -> FloatArray:
        """[s], shape (S, A); not a number where there is no footstep."""
        return np.stack(self._strikes)

    @property
    def positions(self) -> FloatArray:
        """[m], shape (S, A, 3)."""
        return np.stack(self._positions)

    def plan(self, agent: int, end: float, ground: Ground, *, name: str) -> tuple[FootstepPlan, IntArray]:
        """The footsteps of one agent that strike before the `end` [s], and the rounds they are from.

        Who walks on at the end finishes the last contacts: cut off, a foot would have to roll and leave in no time.

        Raises:
            PlanError: If fewer than two footsteps strike before the end.
        """
        strikes = np.array([row[agent] for row in self._strikes])
        liftoffs = np.array([row[agent] for row in self._liftoffs])
        rounds = np.flatnonzero(strikes < end)
        if len(rounds) < 2:
            first = float(strikes[rounds[0]]) if len(rounds) else end
            raise PlanError(name, f"lasts {end - first:.3g} s, less than a step", "give it at least a second")
        positions = np.stack([row[agent] for row in self._positions])[rounds]
        yaws = np.array([row[agent] for row in self._yaws])[rounds]
        plan = FootstepPlan(
            name=name,
            sides=np.array([row[agent] for row in self._sides])[rounds],
            positions=positions,
            orientations=print_orientations(yaws, _normals(ground, positions)),
            strike_times=strikes[rounds],
            liftoff_times=np.where(np.isfinite(liftoffs[rounds]), liftoffs[rounds], end),
            root_weights=np.zeros(len(rounds)),
        )
        return plan, rounds


def _normals(ground: Ground, positions: FloatArray) -> FloatArray:
    return ground.heights(positions[:, [0, 2]], positions[:, 1], step_up=0.05).normals
