"""Root trajectories given with plans: they say where the agent prim goes, faces, and how fast the root is ([B] 4.2, 5).

At lambda4 = 0 the feet stand on their footsteps all the same; the body turns about the support ball into the heading
given. With a root weight the velocity wanted is the trajectory's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent
from usdfoot.model.contact_table import ContactTable, with_headings
from usdfoot.model.trajectory import RootTrajectory, sample_trajectories

__all__ = ["GivenRoots", "given_roots", "guide_headings"]


@dataclass(frozen=True, kw_only=True)
class GivenRoots:
    """The trajectories of those of A agents that have one."""

    numbers: IntArray
    """Index of each agent's trajectory, -1 where it has none, shape (A,)."""
    trajectories: tuple[RootTrajectory, ...]

    def positions(self, agents: IntArray, times: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Whose roots are given, shape (N,), and their positions at times (N,) [s], shape (given, 3) [m]."""
        given = self.numbers[agents] >= 0
        if not self.trajectories:
            return given, np.zeros((0, 3))
        values = np.concatenate([trajectory.positions for trajectory in self.trajectories])
        return given, sample_trajectories(self.trajectories, self.numbers[agents[given]], times[given], values=values)

    def yaws(self, agents: IntArray, times: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Whose headings are given, shape (N,), and these at times (N,) [s], shape (given,) [rad]."""
        heads = np.array([trajectory.yaws is not None for trajectory in self.trajectories], dtype=bool)
        given = self.numbers[agents] >= 0
        given[given] = heads[self.numbers[agents[given]]]
        if not given.any():
            return given, np.zeros(0)
        values = np.concatenate([np.zeros(len(t.times)) if t.yaws is None else t.yaws for t in self.trajectories])
        own = self.numbers[agents[given]]
        return given, sample_trajectories(self.trajectories, own, times[given], values=values[:, None])[:, 0]


def given_roots(agents: Sequence[Agent]) -> GivenRoots:
    """The root trajectories of agents."""
    given = np.array([agent.root_trajectory is not None for agent in agents], dtype=bool)
    return GivenRoots(
        numbers=np.where(given, np.cumsum(given) - 1, -1),
        trajectories=tuple(agent.root_trajectory for agent in agents if agent.root_trajectory is not None),
    )


def guide_headings(contacts: ContactTable, agents: Sequence[Agent]) -> ContactTable:
    """The table with the headings that trajectories give at the strikes in place of the feet's."""
    given, yaws = given_roots(agents).yaws(contacts.agents, contacts.strikes)
    if not given.any():
        return contacts
    wanted = np.full(len(given), np.nan)
    wanted[given] = yaws
    return with_headings(replace(contacts, given_headings=wanted))
