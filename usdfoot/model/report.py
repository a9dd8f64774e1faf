"""Problem: what could not be used, and why; collected instead of raised so that the crowd goes on."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Problem"]


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
