"""Roster: which numbers agents have who are there."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray, IntArray
from usdfoot.model.report import Problem

__all__ = ["Roster", "problem_of_agent"]


class Roster:
    """Who is there. A number stays an agent's until it is removed, and is then given again."""

    def __init__(self) -> None:
        self.there = np.zeros(0, dtype=bool)
        """By number, shape (N,)."""

    def __len__(self) -> int:
        return len(self.there)

    @property
    def numbers(self) -> IntArray:
        """Of those who are there, increasing."""
        return np.flatnonzero(self.there)

    def enter(self, count: int) -> IntArray:
        """Numbers of more agents, shape (count,)."""
        free = np.flatnonzero(~self.there)[:count]
        fresh = np.arange(len(self), len(self) + count - len(free))
        self.there = np.append(self.there, np.ones(len(fresh), dtype=bool))
        self.there[free] = True
        return np.concatenate([free, fresh])

    def leave(self, agents: IntArray) -> None:
        """Takes away agents who are there."""
        self.there[agents] = False

    def knows(self, agents: IntArray) -> BoolArray:
        """Which of agents (M,) are there."""
        known = (agents >= 0) & (agents < len(self))
        known[known] = self.there[agents[known]]
        return known

    def absence(self, agent: int) -> str:
        """What to say of one who is not there."""
        there = self.numbers
        return f"is not there; {len(there)} are" + (f", from {there[0]} to {there[-1]}" if len(there) else "")


def problem_of_agent(severity: str, agent: int, message: str) -> Problem:
    """A problem of one agent."""
    return Problem(severity=severity, where=f"agent {agent}", message=f"agent {agent}: {message}")
