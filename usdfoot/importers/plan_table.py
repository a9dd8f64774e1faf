"""CSV plans: a row is a footstep, a header names the columns (`bridge/plan_columns.py`)."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from usdfoot.bridge.plan_columns import PlanColumn as Column
from usdfoot.errors import PlanError
from usdfoot.importers.text_lines import TextLine, number_in, read_text_lines
from usdfoot.importers.units import metres_in
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan

__all__ = ["import_plan_table"]

DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+")
"""A number as spreadsheets of many countries write it, with semicolons or tabs between the cells."""
FEET = {"left": 0, "l": 0, "right": 1, "r": 1}


def import_plan_table(file: str | os.PathLike[str], *, unit: str = "", up: str = "Y") -> dict[str, FootstepPlan]:
    """Plans of a file by name, in the canonical world; rows may be in any order.

    Args:
        file: CSV, separated by commas, semicolons or tabs.
        unit: Of lengths, if they are not in metres.
        up: Axis that points up, Y or Z; with Z up, yaw is about +Z from -Y to +X.

    Raises:
        PlanError: If a column is missing, a row malformed (its line is named) or a plan inconsistent.
    """
    path = Path(file)
    metres = metres_in(unit, "unit", error=PlanError) if unit else 1.0
    lines = read_text_lines(path, split=_cells, error_type=PlanError)
    if not lines:
        raise PlanError(path, "is empty", f"a header comes first: {','.join(Column.NEEDED)}")
    header, rows = lines[0], lines[1:]
    names = [word.strip().lower() for word in header.words]
    missing = [name for name in Column.NEEDED if name not in names]
    unknown = [name for name in names if name not in Column.ALL]
    if missing or unknown or len(set(names)) != len(names):
        what = "lacks columns" if missing else "has unknown columns" if unknown else "has a column twice"
        raise PlanError(f"{path}:{header.number}", what, f"known are {','.join(Column.ALL)}", missing or unknown)
    grouped: dict[str, list[TextLine]] = {}
    for row in rows:
        if len(row.words) != len(names):
            raise row.error(f"has {len(row.words)} cells, the header has {len(names)}", "a row has a cell a column")
        name = row.words[names.index(Column.PLAN)].strip() if Column.PLAN in names else path.stem
        grouped.setdefault(name or path.stem, []).append(row)
    if not grouped:
        raise PlanError(path, "has no footsteps", "a row is a footstep")
    return {name: _plan(f"{path} ({name})", names, own, metres, up) for name, own in grouped.items()}


def _cells(line: str) -> list[str]:
    """Cells of a row, decimal commas as points; none if the line is empty."""
    if not line.strip():
        return []
    separator = next((mark for mark in ";\t" if mark in line), ",")
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    if separator == ",":
        return cells
    return [cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]


def _plan(name: str, names: Sequence[str], rows: Sequence[TextLine], metres: float, up: str) -> FootstepPlan:
    """The plan of some rows, in order of strike."""
    rows = sorted(rows, key=lambda row: _number(row, names, Column.STRIKE))
    yaws = np.radians(_numbers(rows, names, Column.YAW))
    places = np.stack([_numbers(rows, names, axis) for axis in Column.POSITION], axis=1)
    level = (0.0, 1.0, 0.0) if up == "Y" else (0.0, 0.0, 1.0)
    normals = np.stack([_numbers(rows, names, *pair) for pair in zip(Column.NORMAL, level, strict=True)], axis=1)
    styles = tuple(_cell(row, names, Column.STYLE) for row in rows)
    for row, normal in zip(rows, normals, strict=True):
        if not normal @ level > 1e-3:
            raise row.error("has a normal that does not point up", "leave nx, ny, nz out on level ground")
    upright = _canonical(normals, up)
    return FootstepPlan(
        name=name,
        sides=np.array([_foot(row, names) for row in rows], dtype=int),
        positions=_canonical(metres * places, up),
        orientations=quaternion.facing(_along_ground(planar.direction(yaws), upright), upright),
        strike_times=_numbers(rows, names, Column.STRIKE),
        liftoff_times=_numbers(rows, names, Column.LIFTOFF),
        root_weights=_numbers(rows, names, Column.ROOT_WEIGHT, 0.0),
        styles=styles if any(styles) else (),
    )


def _along_ground(directions: FloatArray, normals: FloatArray) -> FloatArray:
    """Directions (N, 2) seen from above as they lie on the ground, shape (N, 3)."""
    rise = -np.sum(directions * normals[:, [0, 2]], axis=1) / normals[:, 1]
    return np.stack([directions[:, 0], rise, directions[:, 1]], axis=1)


def _canonical(vectors: FloatArray, up: str) -> FloatArray:
    return vectors if up == "Y" else vectors[:, [0, 2, 1]] * (1.0, 1.0, -1.0)


def _cell(row: TextLine, names: Sequence[str], name: str) -> str:
    return row.words[names.index(name)] if name in names else ""


def _foot(row: TextLine, names: Sequence[str]) -> int:
    word = _cell(row, names, Column.FOOT)
    if word.lower() not in FEET:
        raise row.error(f"{word!r} is no foot", "left or right is")
    return FEET[word.lower()]


def _number(row: TextLine, names: Sequence[str], name: str, default: float | None = None) -> float:
    word = _cell(row, names, name)
    return default if default is not None and not word else number_in(row, word)


def _numbers(rows: Sequence[TextLine], names: Sequence[str], name: str, default: float | None = None) -> FloatArray:
    """A column, shape (N,)."""
    return np.array([_number(row, names, name, default) for row in rows])
