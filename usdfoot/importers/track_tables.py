"""Track tables: text files with one position of one person a line, whatever the order of their columns."""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot.errors import TrackError
from usdfoot.importers.track_lines import TrackLines, is_number, split_lines
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["LAYOUTS", "TrackTable", "read_track_table"]

_logger = logging.getLogger(__name__)

LAYOUTS = {
    "eth": ("frame", "id", "x", "y"),
    "obsmat": ("frame", "id", "x", "z", "y", "vx", "vz", "vy"),
    "juelich": ("id", "frame", "x", "y", "z"),
    "vsp": (),
}
"""Columns by layout; more at the end are ignored. vsp are UCY's splines, which tell their columns themselves."""
CLEARLY = 3.0
"""One reading of unnamed columns is right if people move this much less from sample to sample than in the other."""
RATE = re.compile(r"(?:framerate|frame rate|fps)\s*[:=]?\s*([0-9.]+)", re.IGNORECASE)
COLUMN_UNIT = re.compile(r"(?<![a-z])[xy]\s*[/\[(]\s*(mm|cm|m|ft|in)\b", re.IGNORECASE)
UNIT = re.compile(r"\bunits?\s*[:=]\s*(mm|cm|m|ft|in)\b", re.IGNORECASE)
TIME_UNIT = re.compile(r"(?<![a-z])(?:t|time|timestamp)\s*[/\[(]\s*(ms|sec|s)\b|\b(seconds)\b", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class TrackTable:
    """N positions as they stand in a file."""

    layout: str
    """How the columns were read, for messages."""
    people: FloatArray
    """Number of the person, shape (N,)."""
    frames: FloatArray
    """Frame, or time, shape (N,)."""
    positions: FloatArray
    """Map x and y in the file's unit, shape (N, 2)."""
    lines: IntArray
    """Line of the file, from 1, shape (N,)."""
    unit: str
    """As the file says, empty if it does not."""
    rate: float
    """Frames, or units of time, a second as the file says, 0 if it does not."""
    has_times: bool = False
    """Whether it has times instead of frames."""
    names: tuple[str, ...] = ()
    """Of people, whose numbers are places in it; empty if the file has numbers itself."""

    def name_of(self, person: float) -> str:
        """What the file calls a person."""
        return self.names[int(person)] if self.names else f"{person:.15g}"


def read_track_table(path: Path, *, layout: str = "auto") -> TrackTable:
    """The table in a text file.

    Columns are those of the layout, or those a header names, or those of the only layout in which people do not jump.

    Raises:
        TrackError: If the file is no text, a line is malformed (named), or its columns are unknown.
    """
    if layout != "auto" and layout not in LAYOUTS:
        raise TrackError("layout", f"{layout!r} is unknown", f"auto, {', '.join(LAYOUTS)} are known")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise TrackError(path, f"cannot be read ({error.strerror})", "name a file of tracks") from error
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise TrackError(path, f"is not UTF-8: line {line}", "save it as UTF-8, or HDF5 as CSV") from error
    rows = text.splitlines()
    if layout == "vsp" or (layout == "auto" and "number of splines" in text[:200].lower()):
        return _read_splines(path, rows)
    lines = split_lines(path, rows)
    if layout == "auto" and lines.names:
        if lines.values.shape[1] > len(lines.names):
            what = f"has {lines.values.shape[1]} numbers, the header names {len(lines.names)} columns"
            raise TrackError(f"{path}:{lines.numbers[0]}", what, "name every column, or give the layout")
        return _named(path, lines, lines.names, "its header")
    if layout == "auto":
        layout = _likely_layout(path, lines)
    columns = LAYOUTS[layout]
    if lines.values.shape[1] < 4 or (layout == "obsmat" and lines.values.shape[1] < 5):
        what = f"has {lines.values.shape[1]} columns"
        raise TrackError(f"{path}:{lines.numbers[0]}", what, f"{layout} files have {' '.join(columns)}")
    return _named(path, lines, columns, layout)


def _named(path: Path, lines: TrackLines, columns: Sequence[str], layout: str) -> TrackTable:
    """The table with columns of these names."""
    count = lines.values.shape[1]
    at = {name: columns.index(name) for name in ("id", "frame", "time", "x", "y") if name in columns}
    if max(at.values()) >= count:
        raise TrackError(f"{path}:{lines.numbers[0]}", f"has {count} columns", f"needed are {' '.join(columns)}")
    clock = at.get("frame", at.get("time", 0))
    rate = RATE.search(lines.comments)
    unit = COLUMN_UNIT.search(lines.comments) or UNIT.search(lines.comments)
    try:
        frames_per_second = float(rate[1]) if rate and "frame" in at else 0.0
    except ValueError:
        raise TrackError(path, f"says its frame rate is {rate[1]!r}" if rate else "", "it is a number") from None
    time_unit = TIME_UNIT.search(lines.comments)
    if "frame" not in at and time_unit:
        frames_per_second = 1000.0 if time_unit[1] and time_unit[1].lower() == "ms" else 1.0
    return TrackTable(
        layout=layout,
        people=lines.values[:, at["id"]],
        frames=lines.values[:, clock],
        positions=lines.values[:, [at["x"], at["y"]]],
        lines=lines.numbers,
        unit=unit[1].lower() if unit else "",
        rate=frames_per_second,
        has_times="frame" not in at,
        names=lines.people,
    )


def _likely_layout(path: Path, lines: TrackLines) -> str:
    """The layout of columns nobody named: that in which people jump least, or else the usual one, with a warning."""
    if lines.values.shape[1] < 4:
        raise TrackError(
            f"{path}:{lines.numbers[0]}",
            f"has {lines.values.shape[1]} numbers",
            "needed are frame, person, x and y, or a header that names the columns",
        )
    if lines.values.shape[1] == 8:
        return "obsmat"
    jumps = {layout: _jumps(_named(path, lines, LAYOUTS[layout][:4], layout)) for layout in ("eth", "juelich")}
    best, other = sorted(jumps, key=lambda layout: jumps[layout])
    if not jumps[best] * CLEARLY < jumps[other]:
        best = "eth" if lines.values.shape[1] == 4 else "juelich"
        _logger.warning(
            "%s: people move alike whichever column is the person; as usual with %d columns it is read as %s. "
            "name the layout if that is wrong",
            path,
            lines.values.shape[1],
            " ".join(LAYOUTS[best]),
        )
    return best


def _jumps(table: TrackTable) -> float:
    """Median distance between samples of a person that follow each other, infinite if there are none."""
    order = np.lexsort((table.frames, table.people))
    same = np.diff(table.people[order]) == 0
    distances = np.linalg.norm(np.diff(table.positions[order], axis=0), axis=1)[same]
    return float(np.median(distances)) if distances.size else np.inf


def _read_splines(path: Path, rows: Sequence[str]) -> TrackTable:
    """UCY's .vsp: for each person a number of control points, then a line x, y, frame, gaze for each."""
    found: list[tuple[float, float, float, float, int]] = []
    expected, person = 0, -1
    for number, row in enumerate(rows, start=1):
        words = row.replace(",", " ").split()
        if not words:
            continue
        heading = re.match(r"\s*(\d+)\s*-", row)
        if heading and expected == 0:
            if person >= 0 or "control" in row.lower():
                person, expected = person + 1, int(heading[1])
            continue
        if person < 0 or expected == 0:
            if is_number(words[0]) and person >= 0:
                raise TrackError(f"{path}:{number}", "is a control point too many", "correct the number before them")
            continue
        if len(words) < 3 or not all(is_number(word) and np.isfinite(float(word)) for word in words[:3]):
            raise TrackError(f"{path}:{number}", "is no control point", "needed are x, y and frame")
        x, y, frame = (float(word) for word in words[:3])
        found.append((frame, person, x, y, number))
        expected -= 1
    if expected:
        raise TrackError(f"{path}:{len(rows)}", f"ends {expected} control points early", "the file is cut off")
    if not found:
        raise TrackError(path, "has no control points", "a .vsp file lists splines")
    values = np.array(found)
    return TrackTable(
        layout="vsp",
        people=values[:, 1],
        frames=values[:, 0],
        positions=values[:, 2:4],
        lines=values[:, 4].astype(int),
        unit="",
        rate=0.0,
    )
