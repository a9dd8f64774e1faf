"""What arguments may say: each quantity is read from its text, or refused with what would be right."""

from __future__ import annotations

import argparse
import math
import re

__all__ = [
    "above_zero",
    "area",
    "count",
    "distance",
    "duration",
    "frame_range",
    "number",
    "rate",
    "root_weight",
    "seed",
    "several",
    "span",
    "warp_range",
]


def number(text: str) -> float:
    """A finite number."""
    return _between(text, -math.inf, math.inf, "is no number")


def above_zero(text: str) -> float:
    """A number above 0."""
    return _between(text, 0.0, math.inf, "is not a number above 0")


def root_weight(text: str) -> float:
    """A number between 0 and 1."""
    return _between(text, 0.0, 1.0, "is no root weight; give a number between 0 and 1", closed=True)


def distance(text: str) -> float:
    """A distance [m], 0 or more."""
    return _between(text, 0.0, math.inf, "is no distance; give metres, like 0.02", closed=True)


def duration(text: str) -> float:
    """A time [s], 0 or more."""
    return _between(text, 0.0, math.inf, "is no time; give seconds, like 0.25", closed=True)


def span(text: str) -> float:
    """A time above 0 [s]."""
    return _between(text, 0.0, math.inf, "is no time above 0; give seconds, like 0.5")


def rate(text: str) -> float:
    """A rate above 0 [Hz]."""
    return _between(text, 0.0, math.inf, "is no rate; give frames a second, like 25")


def count(text: str) -> int:
    """A whole number, 1 or more."""
    return _at_least(text, 1, "is no number of things; give 1 or more")


def seed(text: str) -> int:
    """A whole number, 0 or more."""
    return _at_least(text, 0, "is no seed; give a whole number of at least 0")


def several(text: str) -> int:
    """A whole number, 2 or more."""
    return _at_least(text, 2, "is not a whole number of at least 2")


def frame_range(text: str) -> tuple[int, int]:
    """First and last frame of "A:B"."""
    match = re.fullmatch(r"(-?\d+):(-?\d+)", text)
    if not match or int(match[1]) > int(match[2]):
        raise argparse.ArgumentTypeError(f"{text!r} is not a range of frames; give first:last, like 1:240")
    return int(match[1]), int(match[2])


def warp_range(text: str) -> tuple[float, float]:
    """Least and most of "A:B", around 1."""
    least, most = (_float(part) for part in text.split(":")) if text.count(":") == 1 else (math.nan, math.nan)
    if not 0.0 < least <= 1.0 <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is no range around 1; give least:most, like 0.5:2")
    return least, most


def area(text: str) -> tuple[float, float, float, float]:
    """Four numbers, the first two below the last two."""
    corners = [_float(part) for part in text.split(",")]
    if len(corners) == 4 and all(map(math.isfinite, corners)) and corners[0] < corners[2] and corners[1] < corners[3]:
        return corners[0], corners[1], corners[2], corners[3]
    raise argparse.ArgumentTypeError(f"{text!r} is no area; give lowest x and z, highest x and z, like -10,-10,10,10")


def _between(text: str, least: float, most: float, fault: str, *, closed: bool = False) -> float:
    """The finite number, between two bounds and on them if closed."""
    value = _float(text)
    if not math.isfinite(value) or not (least < value < most or (closed and value in (least, most))):
        raise argparse.ArgumentTypeError(f"{text!r} {fault}")
    return value


def _at_least(text: str, least: int, fault: str) -> int:
    """The whole number."""
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r} {fault}")
    return int(text)


def _float(text: str) -> float:
    """The number, not finite if the text is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
