"""Names of prims to be written."""

from __future__ import annotations

import re

__all__ = ["unique_name", "valid_name"]


def unique_name(name: str, taken: set[str]) -> str:
    """The name, with a number added if it is taken; from now on it is."""
    candidate, count = name, 0
    while candidate in taken:
        count += 1
        candidate = f"{name}_{count}"
    taken.add(candidate)
    return candidate


def valid_name(text: str) -> str:
    """A prim's name for any text: runs of what is no letter, digit or underscore become one underscore."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", text).strip("_") or "prim"
    return f"_{name}" if name[0].isdigit() else name
