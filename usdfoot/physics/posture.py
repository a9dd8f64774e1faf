"""Posture: what of a body changes from stride to stride only, as moving means over a stride at any time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.runs import sums_within
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["WINDOW", "Posture", "lay_posture"]

SPACING = 0.05
"""Time between the samples of a posture, at most [s]."""
WINDOW = 1.2
"""About a stride: what changes more quickly is physics, what changes more slowly is posture [s]."""


@dataclass(frozen=True, kw_only=True)
class Posture:
    """D values of A agents, stride by stride."""

    first: IntArray
    """Index of each agent's first sample, shape (A + 1,)."""
    starts: FloatArray
    ends: FloatArray
    """Each agent's interval [s], shape (A,)."""
    integrals: FloatArray
    """Of the values over time, from each agent's start, shape (N, D)."""

    def at(self, agents: IntArray, times: FloatArray) -> FloatArray:
        """Means over a stride around each time, shape (F, D)."""
        first, last = self.starts[agents], self.ends[agents]
        times = np.clip(times, first, last)
        begins, ends = np.maximum(times - 0.5 * WINDOW, first), np.minimum(times + 0.5 * WINDOW, last)
        return (self._integral(agents, ends) - self._integral(agents, begins)) / (ends - begins)[:, None]

    def _integral(self, agents: IntArray, times: FloatArray) -> FloatArray:
        count = np.diff(self.first)[agents]
        places = (times - self.starts[agents]) / (self.ends - self.starts)[agents] * (count - 1)
        before = np.clip(places.astype(int), 0, count - 2)
        share, rows = (places - before)[:, None], self.first[agents] + before
        return (1.0 - share) * self.integrals[rows] + share * self.integrals[rows + 1]


def lay_posture(contacts: ContactTable, values_at: Callable[[IntArray, FloatArray], FloatArray]) -> Posture:
    """The posture of all agents over their contacts.

    Args:
        contacts: Whose agents and intervals.
        values_at: Values (F, D) of agents (F,) at times [s] (F,), which come sorted by both.
    """
    lasting = contacts.ends - contacts.starts
    counts = np.ceil(lasting / SPACING).astype(int) + 2
    first = np.concatenate([[0], np.cumsum(counts)])
    agents = np.repeat(np.arange(len(counts)), counts)
    steps = (lasting / (counts - 1))[agents]
    times = contacts.starts[agents] + steps * (np.arange(first[-1]) - first[agents])
    values = values_at(agents, times)
    areas = np.zeros_like(values)
    areas[1:] = 0.5 * steps[1:, None] * (values[1:] + values[:-1])
    areas[first[:-1]] = 0.0
    integrals = sums_within(areas, first)
    return Posture(first=first, starts=contacts.starts, ends=contacts.ends, integrals=integrals)
