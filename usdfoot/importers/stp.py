"""STP: footsteps of 3ds Max's Biped (Character Studio), text files of version 54.

Autodesk's description of the format came with the program only. Its layout is known from the free program SteerSuite,
which writes such files for Biped: after STEPS their number and for each footstep the rows of its matrix (three axes and
the position, +Z up, +X ahead); after SCORE, for RLEG and LLEG, their number and for each of the leg's footsteps a
title, its start, its duration and its index. Times are in 3ds Max's ticks. What follows (SCALE, KEYFF) is not read.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.importers.text_lines import TextLine, number_in, number_rows, read_text_lines
from usdfoot.importers.units import metres_in
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.plan import FootstepPlan

__all__ = ["TICKS", "import_stp"]

TICKS = 4800.0
"""Of 3ds Max in a second."""
SIDES = {"LLEG": 0, "RLEG": 1}
SQUARE = 0.02
"""How far the axes of a footstep may be from unit length and right angles."""


@dataclass(kw_only=True)
class _Reader:
    """Lines still to be read."""

    path: Path
    lines: deque[TextLine]

    def take(self, what: str) -> TextLine:
        """The next line."""
        if not self.lines:
            raise PlanError(self.path, f"ends where {what} was expected", "the file is cut off")
        return self.lines.popleft()

    def keyword(self, *words: str) -> str:
        """The next line, which has to be one of some words."""
        line = self.take(" or ".join(words))
        if line.words[0].upper() not in words:
            raise line.error(
                f"{line.words[0]!r} stands where {' or '.join(words)} was expected", "export the file again"
            )
        return line.words[0].upper()

    def whole(self, what: str, most: float) -> int:
        """The next line as a whole number."""
        line = self.take(what)
        value = number_in(line, line.words[0])
        if len(line.words) != 1 or value != int(value) or not 0 <= value <= most:
            raise line.error(f"{' '.join(line.words)!r} is no {what}", f"a whole number from 0 to {most:g} is")
        return int(value)


def import_stp(
    file: str | os.PathLike[str], *, unit: str = "", ticks: float = 0.0, limits: Limits = DEFAULT_LIMITS
) -> FootstepPlan:
    """The footsteps of a file as a plan in the canonical world.

    Args:
        file: STP file.
        unit: Of its lengths, which it does not say: 3ds Max's system unit, as a rule inches.
        ticks: Units of time in a second, if they are not 3ds Max's; SteerSuite writes 2000.
        limits: How many frames there may be; no file has more footsteps.

    Raises:
        PlanError: If the unit is missing, the file malformed (the line is named) or the plan inconsistent.
    """
    path = Path(file)
    if not unit:
        raise PlanError(path, "does not say in which unit its lengths are", "give --unit, as a rule in for 3ds Max")
    metres = metres_in(unit, "unit", error=PlanError)
    reader = _Reader(path=path, lines=deque(read_text_lines(path, comments=(), error_type=PlanError)))
    reader.keyword("VERSION")
    version = reader.take("the version")
    if version.words[0] != "54":
        raise version.error(f"is version {version.words[0]}", "version 54 is known")
    reader.keyword("STEPS")
    count = reader.whole("number of footsteps", 1e9)
    check_limit(path, "footsteps", count, limit=limits.footsteps)
    if len(reader.lines) < 4 * count:
        raise PlanError(path, f"is cut off: {count} footsteps need {4 * count} rows of matrices", "export it again")
    rows = [reader.lines.popleft() for _ in range(4 * count)]
    matrices = number_rows(rows, 3, "numbers of a row").reshape(count, 4, 3)
    _check_axes(rows, matrices)
    reader.keyword("SCORE")
    sides, times = _read_legs(reader, count)
    matrices = matrices[..., [0, 2, 1]] * (1.0, 1.0, -1.0)
    order = np.argsort(times[:, 0], kind="stable")
    starts, lengths = (times[order] / (ticks or TICKS)).T
    return FootstepPlan(
        name=str(path),
        sides=sides[order],
        positions=metres * matrices[order, 3],
        orientations=quaternion.facing(matrices[order, 0], matrices[order, 2]),
        strike_times=starts,
        liftoff_times=starts + lengths,
        root_weights=np.zeros(count),
    )


def _check_axes(rows: Sequence[TextLine], matrices: FloatArray) -> None:
    axes = matrices[:, :3]
    errors = np.abs(axes @ axes.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2))
    crooked = np.flatnonzero((errors > SQUARE) | (np.linalg.det(axes) < 0.0))
    if crooked.size:
        raise rows[4 * int(crooked[0])].error(
            f"begins the matrix of footstep {crooked[0]}, whose axes are no rotation", "unit axes at right angles are"
        )


def _read_legs(reader: _Reader, count: int) -> tuple[np.ndarray, FloatArray]:
    """Side (N,) and start and duration (N, 2) of every footstep, in the file's unit of time."""
    sides, times = np.full(count, -1), np.zeros((count, 2))
    for _ in SIDES:
        leg = reader.keyword(*SIDES)
        for _ in range(reader.whole("number of footsteps of a leg", count)):
            title = reader.take("the title of a footstep")
            start, length = (reader.take(f"the {word} of a footstep") for word in ("start", "duration"))
            index = reader.whole("index of a footstep", count - 1)
            if sides[index] >= 0:
                raise title.error(f"footstep {index} is timed twice", "every footstep belongs to one leg")
            sides[index] = SIDES[leg]
            times[index] = number_in(start, start.words[0]), number_in(length, length.words[0])
    loose = np.flatnonzero(sides < 0)
    if loose.size:
        raise PlanError(reader.path, f"footstep {loose[0]} belongs to no leg", "export the file again")
    return sides, times
