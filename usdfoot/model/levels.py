"""Levels of detail: which variants of a character stand for it, from near to far."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from usdfoot.errors import UsdfootError

__all__ = ["DetailLevels"]


@dataclass(frozen=True, kw_only=True)
class DetailLevels:
    """Variants of characters and how far away each begins to stand for its character.

    Raises:
        UsdfootError: If there are fewer than two different variants, or the distances do not grow.
    """

    variants: tuple[str, ...]
    """Names in one variant set of each character, nearest first, L of them."""
    distances: tuple[float, ...]
    """From the viewpoint to the agent, at which one gives way to the next [m], shape (L - 1,), increasing."""

    def __post_init__(self) -> None:
        count = len(self.variants)
        if count < 2 or len(set(self.variants)) < count or len(self.distances) != count - 1:
            raise UsdfootError(
                "levels", str(self), "give two or more variants with a distance between, like full:15:low"
            )
        ends = (0.0, *self.distances, float("inf"))
        if not all(near < far for near, far in pairwise(ends)):
            raise UsdfootError("levels", f"distances {list(self.distances)}", "they must be above 0 and grow")

    @staticmethod
    def parse(text: str) -> DetailLevels:
        """Levels as on the command line: variants with the distances between them, ``full:15:low``."""
        parts = text.split(":")
        try:
            distances = tuple(float(part) for part in parts[1::2])
        except ValueError:
            raise UsdfootError("levels", repr(text), "name a variant, a distance [m], a variant ...") from None
        return DetailLevels(variants=tuple(parts[::2]), distances=distances)

    def __str__(self) -> str:
        numbers = [*(f"{distance:g}" for distance in self.distances), ""]
        return ":".join(part for pair in zip(self.variants, numbers, strict=False) for part in pair).rstrip(":")
