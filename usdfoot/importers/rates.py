"""Rates: frames a second of frame times that were rounded when they were written."""

from __future__ import annotations

from decimal import Decimal, InvalidOperation

from usdfoot.importers.text_lines import TextLine

__all__ = ["written_rate"]

NTSC = 1.001
"""Television's rates are whole numbers over this."""
COARSE = Decimal("0.01")
"""A frame time with so few digits that the last is a larger part of it is taken as it stands."""
SINGLE_PRECISION = Decimal("1e-6")
"""Relative rounding of programs that compute in single precision."""


def written_rate(line: TextLine, word: str) -> float:
    """Frames a second [Hz] for a frame time [s] as written: the whole (or television's) rate it may be the rounding of.

    0.0333333 is 30 frames a second, not 30.00003.

    Raises:
        UsdfootError: If it is no positive number.
    """
    try:
        time = Decimal(word)
    except InvalidOperation:
        time = Decimal(0)
    if not (time.is_finite() and 0 < time < 1_000_000):
        raise line.error(f"{word!r} is no frame time", "seconds above 0, like 0.0333333, are")
    exact = float(1 / time)
    digit = Decimal(1).scaleb(int(time.as_tuple().exponent))
    if digit > COARSE * time:
        return exact
    for rate in (float(round(exact)), round(exact * NTSC) / NTSC):
        if rate > 0.0 and abs(Decimal(1.0 / rate) - time) <= max(digit, SINGLE_PRECISION * time):
            return rate
    return exact
