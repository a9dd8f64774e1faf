"""Rows of many agents' timelines found by time."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["locate"]

AGENT_SPAN = 1.0e5
"""Longest motion of one agent [s]; keeps the agents apart in one sorted key."""


def locate(
    row_agents: IntArray, row_times: FloatArray, origins: FloatArray, *, agents: IntArray, times: FloatArray
) -> IntArray:
    """Last row of the same agent that has begun at each time, or its first; rows sorted by agent and time.

    Exact: a query at the very time a row begins finds that row, whatever other agents there are.

    Args:
        row_agents: Agent of each row, not decreasing, shape (M,).
        row_times: Begin of each row [s], shape (M,).
        origins: A time on each agent's clock that keeps keys small [s], shape (A,).
        agents: Agent of each query, shape (F,).
        times: [s], shape (F,).
    """
    keys = row_agents * AGENT_SPAN + (row_times - origins[row_agents])
    queries = agents * AGENT_SPAN + (times - origins[agents])
    rows = np.searchsorted(keys, queries, side="right") - 1
    rows = np.maximum(rows, np.searchsorted(row_agents, agents))
    ends = np.searchsorted(row_agents, agents, side="right") - 1
    while (late := (rows < ends) & (row_times[np.minimum(rows + 1, ends)] <= times)).any():  # keys are rounded
        rows = rows + late
    while (early := (row_times[rows] > times) & (row_agents[rows - 1] == agents) & (rows > 0)).any():
        rows = rows - early
    return rows
