"""Problems: what could not be used, and why; collected instead of raised so that the crowd goes on."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Outcome", "Problem"]


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One fault that did not stop the crowd."""

    severity: str
    """error: the agent or clip was skipped; warning: it was used all the same."""
    where: str
    """Prim path."""
    message: str
    """What is wrong and what would be right."""

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of a whole job, whatever else it tells."""

    problems: tuple[Problem, ...]
    """What was skipped (errors) and what was used all the same (warnings)."""

    @property
    def skipped(self) -> tuple[Problem, ...]:
        """What could not be used."""
        return tuple(problem for problem in self.problems if problem.severity == "error")
