"""Units of length that files and people name."""

from __future__ import annotations

import math
from collections.abc import Mapping

from usdfoot.errors import UsdfootError

__all__ = ["UNITS", "metres_in"]

UNITS: Mapping[str, float] = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
"""Metres in a unit."""
ALIASES: Mapping[str, str] = {
    "inch": "in", "inches": "in", "foot": "ft", "feet": "ft", "metre": "m", "metres": "m", "meter": "m", "meters": "m",
    "centimetre": "cm", "centimetres": "cm", "centimeter": "cm", "centimeters": "cm", "millimetre": "mm",
    "millimetres": "mm", "millimeter": "mm", "millimeters": "mm",
}  # fmt: skip
"""Other words for them."""

LEAST, MOST = 1e-9, 1e9
"""Metres in the smallest and the largest unit that a number may stand for."""


def metres_in(unit: str, where: object, *, error: type[UsdfootError] = UsdfootError) -> float:
    """Metres in a unit: one of `UNITS` or `ALIASES`, or a number of metres.

    Args:
        unit: The word or number.
        where: File or argument it stands in, for messages.
        error: What to raise.

    Raises:
        UsdfootError: If it is no unit.
    """
    name = ALIASES.get(unit.lower(), unit.lower())
    if name in UNITS:
        return UNITS[name]
    try:
        value = float(unit)
    except ValueError:
        value = math.nan
    if not LEAST <= value <= MOST:
        raise error(where, f"{unit!r} is no known unit", f"{', '.join(UNITS)} or metres a unit, like 0.02")
    return value
