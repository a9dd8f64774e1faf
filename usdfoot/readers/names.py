"""Names of prims to be written."""

from __future__ import annotations

__all__ = ["unique_name"]


def unique_name(name: str, taken: set[str]) -> str:
    """The name, with a number added if it is taken; from now on it is."""
    candidate, count = name, 0
    while candidate in taken:
        count += 1
        candidate = f"{name}_{count}"
    taken.add(candidate)
    return candidate
