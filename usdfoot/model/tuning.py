"""Tuning: what an animator turns of a character that physics moves or carries ([P] 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from usdfoot.errors import UsdfootError

__all__ = ["BodyTuning"]

RANGES = {"hip_spacing": (0.1, 10.0), "crouch": (-0.2, 0.6)}
POSITIVE = ("gravity", "comfort")


@dataclass(frozen=True, kw_only=True)
class BodyTuning:
    """Values that were given; None = nothing was said.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    hip_spacing: float | None = None
    """Factor on the distance between the hip joints. The body itself changes, so that it is applied when a character
    is read."""
    crouch: float | None = None
    """Part of the nominal leg length by which the legs stay bent; negative stretches them."""
    com_left: float | None = None
    com_up: float | None = None
    com_ahead: float | None = None
    """Shift of the centre of mass in the body [m]."""
    pitch: float | None = None
    """Factor on the body's nodding."""
    sway: float | None = None
    """Factor on its roll and turn."""
    gravity: float | None = None
    """[m/s^2]."""
    comfort: float | None = None
    """[P]'s k: weight of comfort against physics, for a leg of 0.86 m [1/(m s^2)]."""

    def __post_init__(self) -> None:
        for name, value in self.given.items():
            low, high = RANGES.get(name, (-math.inf, math.inf))
            if not (math.isfinite(value) and low <= value <= high):
                raise UsdfootError(
                    name, f"is {value:g}", f"{low:g} to {high:g} is possible" if name in RANGES else "give a number"
                )
            if name in POSITIVE and value <= 0.0:
                raise UsdfootError(name, f"is {value:g}", "a positive number is possible")

    @property
    def given(self) -> dict[str, float]:
        """What was said, by field."""
        return {name: value for name, value in vars(self).items() if value is not None}

    def over(self, base: BodyTuning) -> BodyTuning:
        """These values, and those of `base` where nothing is said."""
        given = self.given
        return BodyTuning(**{**base.given, **given}) if given else base
