"""Slots: arrays with a row for each agent, into which agents that come later are put."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import IntArray

__all__ = ["Slots", "with_rows"]


class Slots:
    """What agents have in arrays (N, ...), all of which are attributes."""

    def put(self, agents: IntArray, others: Slots) -> None:
        """Gives agents (M,), new ones or those whose rows are free, the rows of M others, in their order."""
        for name, values in vars(self).items():
            if isinstance(values, np.ndarray):
                setattr(self, name, with_rows(values, agents, getattr(others, name)))


def with_rows(values: np.ndarray, rows: IntArray, others: np.ndarray) -> np.ndarray:
    """Values (N, ...) with others (M, ...) in `rows` (M,), and as many rows as these need."""
    count = max(len(values), int(rows.max(initial=-1)) + 1)
    new = np.zeros((count, *values.shape[1:]), dtype=values.dtype)
    new[: len(values)] = values
    new[rows] = others
    return new
