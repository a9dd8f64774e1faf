"""Track lines: what stands in the lines of a text file of tracks, whatever separates it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot.errors import TrackError
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["TrackLines", "is_number", "split_lines"]

WORDS = {
    "id": ("id", "persid", "ped", "pedid", "pedestrian", "person", "agent", "agentid", "trackid", "track", "personid"),
    "frame": ("frame", "fr", "frameid", "framenumber"),
    "time": ("t", "time", "timestamp", "seconds"),
    "x": ("x", "posx", "xpos", "pos_x", "positionx", "xcenter"),
    "y": ("y", "posy", "ypos", "pos_y", "positiony", "ycenter"),
}
"""What columns are called in headers, in small letters without the unit."""
DECIMAL = re.compile(r"[+-]?\d+(,\d+)?(e[+-]?\d+)?", re.IGNORECASE)
"""A number with a comma for a point."""


@dataclass(frozen=True, kw_only=True)
class TrackLines:
    """A file's lines that hold numbers."""

    comments: str
    names: tuple[str, ...]
    """Of the columns, if a header tells them."""
    numbers: IntArray
    """Line numbers, shape (N,)."""
    values: FloatArray
    """Shape (N, C); NaN where another column than person, time and place holds no number."""
    people: tuple[str, ...]
    """Whom a number of a person stands for, where people are words; empty if they are numbers."""


def split_lines(path: Path, rows: Sequence[str]) -> TrackLines:
    """All lines of numbers; a first line of words names the columns, or a comment.

    Of named columns only those that tell who is where when need be numbers, and people may be words.

    Raises:
        TrackError: If a line is malformed (named), or there is none.
    """
    comments: list[str] = []
    names: tuple[str, ...] = ()
    lines: list[tuple[int, list[str]]] = []
    for number, row in enumerate(rows, start=1):
        content, *comment = row.split("#", 1)
        words = _split(content)
        is_text = bool(words) and not (lines or is_number(words[0])) and (not names or bool(_column_names(row)))
        for text in (*comment, *([row] if is_text else [])):
            comments.append(text)
            names = _column_names(text) or names
        if words and not is_text:
            lines.append((number, words))
    if not lines:
        raise TrackError(path, "has no line of numbers", "a line is a position of a person")
    values, people = _values(path, lines, names)
    return TrackLines(
        comments="\n".join(comments),
        names=names,
        numbers=np.array([number for number, _ in lines], dtype=int),
        values=values,
        people=people,
    )


def is_number(word: str) -> bool:
    """Whether a word is a number; digits that _ groups, as Python has them, are somebody's name."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


def _values(
    path: Path, lines: Sequence[tuple[int, list[str]]], names: Sequence[str]
) -> tuple[FloatArray, tuple[str, ...]]:
    """Numbers of all lines, shape (N, C), and whom those of people stand for."""
    count = len(lines[0][1])
    named = {names.index(name) for name in WORDS if name in names}
    needed = named or set(range(count))
    person = names.index("id") if names else -1
    is_text = 0 <= person < count and not all(is_number(words[person]) for _, words in lines if person < len(words))
    people: dict[str, int] = {}
    values = []
    for number, words in lines:
        if len(words) != count:
            what = f"has {len(words)} numbers, the lines before have {count}"
            raise TrackError(f"{path}:{number}", what, "every line needs the same columns")
        if is_text:
            if not words[person]:
                raise TrackError(f"{path}:{number}", "names nobody", "every line needs a person")
            words = [*words[:person], str(people.setdefault(words[person], len(people))), *words[person + 1 :]]
        values.append([_value(path, number, word, column in needed) for column, word in enumerate(words)])
    return np.array(values), tuple(people)


def _value(path: Path, number: int, word: str, is_needed: bool) -> float:
    """A word as a number; NaN of one that need not be."""
    try:
        value = float(word)
    except ValueError:
        if not is_needed:
            return np.nan
        what, remedy = (f"{word!r} is no number", "a line is numbers only") if word else ("lacks a number", "add it")
        more = ", people too, unless a header names the columns" if word else ""
        raise TrackError(f"{path}:{number}", what, remedy + more) from None
    if is_needed and not np.isfinite(value):
        raise TrackError(f"{path}:{number}", "has a number that is not finite", "leave the line out")
    return value


def _split(row: str) -> list[str]:
    """What separators part; commas beside semicolons, tabs or spaces are decimal ones."""
    row = row.replace("|", " ").replace('"', " ").strip()
    if ";" in row:
        return _between(row.replace(",", "."), ";")
    words = row.split()
    if "," in row and len(words) > 1 and all(DECIMAL.fullmatch(word) for word in words):
        return [word.replace(",", ".") for word in words]
    return _between(row, ",") if "," in row else words


def _between(row: str, separator: str) -> list[str]:
    """Words between separators, of which a last one ends the line; those parted by spaces too are several."""
    words = [word.split() for word in row.removesuffix(separator).split(separator)]
    return [part for parts in words for part in (parts if parts and is_number(parts[0]) else [" ".join(parts)])]


def _column_names(header: str) -> tuple[str, ...]:
    """Our names of the columns a line names, unknown ones as they stand; empty if it names no table."""
    header = re.sub(r"\s*([/\[(])\s*", r"\1", header.replace("|", ",").strip())  # a unit belongs to the word before it
    words = [re.split(r"[/\[(]", word)[0].strip("\"' ").lower() for word in re.split(r"[\s,;]+", header)]
    known = {alias: name for name, aliases in WORDS.items() for alias in aliases}
    names = tuple(known.get(word.replace("_", "") if word not in known else word, word) for word in words)
    needed = {"id", "x", "y"} <= set(names) and ("frame" in names or "time" in names)
    return names if needed else ()
