"""Lines of a text file of another program, without comments and blank lines, that know their number."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from usdfoot.errors import ClipError, UsdfootError
from usdfoot.maths.types import FloatArray

__all__ = ["LARGEST", "TextLine", "number_in", "number_rows", "read_text_lines"]

LARGEST = 1e12
"""Numbers beyond have no meaning in any unit, and overflow where they are multiplied."""


@dataclass(frozen=True, kw_only=True)
class TextLine:
    """One line."""

    file: str
    number: int
    """From 1."""
    words: tuple[str, ...]
    error_type: type[UsdfootError]
    """What goes wrong with files of this kind."""

    def with_words(self, words: Sequence[str]) -> TextLine:
        """A part of the line."""
        return replace(self, words=tuple(words))

    def error(self, what: str, remedy: str = "") -> UsdfootError:
        """An error that names the line."""
        return self.error_type(f"{self.file}:{self.number}", what, remedy)


def read_text_lines(
    file: str | os.PathLike[str],
    *,
    comments: Sequence[str] = ("#",),
    split: Callable[[str], list[str]] = str.split,
    error_type: type[UsdfootError] = ClipError,
) -> list[TextLine]:
    """Lines that hold words.

    Args:
        file: Text file, UTF-8 or else Latin-1, any line ends.
        comments: What begins a comment, at the start of a line or after a blank.
        split: Words of a line.
        error_type: What to raise.

    Raises:
        UsdfootError: If the file cannot be read or is no text.
    """
    name = os.fspath(file)
    try:
        data = Path(file).read_bytes()
    except OSError as error:
        raise error_type(name, f"cannot be read ({error.strerror})", "name a file") from error
    if b"\0" in data[:4096]:
        raise error_type(name, "is no text file", "it may be of another kind than its name says")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    lines = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = split(_without_comment(line, comments))
        if words:
            lines.append(TextLine(file=name, number=number, words=tuple(words), error_type=error_type))
    return lines


def _without_comment(line: str, comments: Sequence[str]) -> str:
    for mark in comments:
        at = line.find(mark)
        while at > 0 and not line[at - 1].isspace():
            at = line.find(mark, at + 1)
        line = line[:at] if at >= 0 else line
    return line


def number_in(line: TextLine, word: str) -> float:
    """A word of a line as a finite number.

    Raises:
        UsdfootError: If it is none.
    """
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise line.error(f"{word!r} is no finite number", "a number is needed here")
    if abs(value) > LARGEST:
        raise line.error(f"{word!r} is too large", f"numbers go up to {LARGEST:g}")
    return value


def number_rows(lines: Sequence[TextLine], count: int, what: str) -> FloatArray:
    """All words of all lines as finite numbers, shape (N, count).

    Args:
        lines: N of them.
        count: How many each has to have.
        what: What the numbers are, for messages.

    Raises:
        UsdfootError: If a line has another number of words or one is no number; the line is named.
    """
    for line in lines:
        if len(line.words) != count:
            raise line.error(f"has {len(line.words)} numbers where there are {count} {what}", f"give {count} numbers")
    try:
        values: FloatArray = np.array([line.words for line in lines], dtype=float).reshape(len(lines), count)
        finite = (np.abs(values) <= LARGEST).all(axis=1)
    except ValueError:
        finite = np.zeros(len(lines), dtype=bool)
    for index in np.flatnonzero(~finite).tolist():
        for word in lines[index].words:
            number_in(lines[index], word)
    return values
