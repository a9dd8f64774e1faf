"""Pedestrian data: tracks of people from text files (ETH and UCY, Juelich, PedPy, JuPedSim, CSV) and JuPedSim's SQLite.

Ground coordinates (x, y) are a map's: y north, seen from above. Canonical they become (x, -y): x stays, north is -z.
"""

from __future__ import annotations

import logging
import os
import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot.errors import TrackError
from usdfoot.importers.track_tables import TrackTable, read_track_table
from usdfoot.importers.units import metres_in
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import FASTEST, RootTrajectory, find_breaks

__all__ = ["import_pedestrians"]

_logger = logging.getLogger(__name__)

SQLITE_MAGIC = b"SQLite format 3\x00"

BODY = 0.3
"""No two people are always within this of each other, wherever they go [m]."""
FASTEST_RUN = 12.5
"""Sprinters are no faster [m/s]; a file in which most are is read wrongly."""


@dataclass(frozen=True, kw_only=True)
class _Scale:
    """What the numbers of a file mean."""

    metres: float
    """In a unit of length."""
    rate: float
    """Frames, or units of time, in a second."""


def import_pedestrians(
    file: str | os.PathLike[str], *, unit: str = "", rate: float = 0.0, layout: str = "auto"
) -> tuple[tuple[RootTrajectory, ...], tuple[Problem, ...]]:
    """Trajectories of all people of a file, in the canonical world, and what was left out.

    Args:
        file: Text or SQLite file.
        unit: Of the positions: m, cm, mm, ft, in, or a number of metres a unit (for pixels). Needed unless the file
            says it.
        rate: Frames a second that the frame numbers count. Needed unless the file says it; of a file with
            times instead of frames how many of them are a second, 1 unless it says so itself.
        layout: auto, or one of `track_tables.LAYOUTS`: what the columns are.

    Raises:
        TrackError: If the file cannot be read, a line is malformed, neither file nor options tell unit and rate, or
            these and the layout have most people move faster than anybody runs.
    """
    path = Path(file)
    table = _read_sqlite(path) if _is_sqlite(path) else read_track_table(path, layout=layout)
    scale = _scale(path, table, unit, rate)
    order, repeated = _in_order(path, table)
    people, frames, lines = table.people[order], table.frames[order], table.lines[order]
    times = frames / scale.rate
    same = np.diff(people) == 0
    places = table.positions[order] * scale.metres * (1.0, -1.0)
    jumps, gaps = find_breaks(times, places)
    jumps &= same
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    _check_speeds(path, table, order, lengths=np.where(same & ~gaps, lengths, 0.0), spans=np.abs(np.diff(times)))
    splits = np.flatnonzero(~same | jumps | gaps) + 1
    parts = np.split(np.arange(len(order)), splits)
    found, problems = [], repeated
    for jump in np.flatnonzero(jumps):
        where, who = f"{path}:{lines[jump + 1]}", table.name_of(people[jump])
        message = f"{where}: person {who} jumps here, faster than {FASTEST:g} m/s; the track was cut in two"
        problems.append(Problem(severity="warning", where=str(path), message=message))
    seen: dict[float, int] = {}
    for part in parts:
        person = float(people[part[0]])
        seen[person] = seen.get(person, 0) + 1
        called = table.name_of(person)
        name = f"{path.name} {called}" + (f" {seen[person]}" if seen[person] > 1 else "")
        if len(part) < 2:
            message = f"{path}:{lines[part[0]]}: person {called} is seen only once here and was left out"
            problems.append(Problem(severity="warning", where=str(path), message=message))
            continue
        positions = np.insert(places[part], 1, 0.0, axis=1)
        found.append(RootTrajectory(name=name, times=times[part], positions=positions))
    return tuple(found), (*problems, *_crowded_in(path, found))


def _in_order(path: Path, table: TrackTable) -> tuple[IntArray, list[Problem]]:
    """Rows of the table by person and frame, each once, shape (K,), and a warning of lines that repeat others.

    Raises:
        TrackError: If a person is in two places in one frame.
    """
    order = np.lexsort((table.lines, table.frames, table.people))
    people, frames, lines, places = (
        array[order] for array in (table.people, table.frames, table.lines, table.positions)
    )
    again = (np.diff(people) == 0) & (np.diff(frames) == 0.0)
    for row in np.flatnonzero(again & np.any(np.diff(places, axis=0) != 0.0, axis=1))[:1]:
        raise TrackError(
            f"{path}:{lines[row + 1]}",
            f"person {table.name_of(people[row])} is in frame {frames[row]:.15g} twice, first in line {lines[row]}",
            "keep one of the two",
        )
    if not again.any():
        return order, []
    first = lines[1:][again].min()
    message = f"{path}: {again.sum()} line(s) say again where somebody is, first line {first}. they are left out"
    return order[np.insert(~again, 0, True)], [Problem(severity="warning", where=str(path), message=message)]


def _check_speeds(path: Path, table: TrackTable, order: IntArray, *, lengths: FloatArray, spans: FloatArray) -> None:
    """Raises TrackError where most moves are faster than anybody runs, naming the first one.

    Args:
        path: Of the file.
        table: What is in it.
        order: Rows of the table, shape (K,).
        lengths: Of the moves from each of these to the next [m], 0 where it is somebody else's, shape (K - 1,).
        spans: How long they take [s], shape (K - 1,).
    """
    fast, moves = np.flatnonzero(lengths > FASTEST_RUN * spans), int(np.count_nonzero(lengths))
    if 2 * fast.size <= moves:
        return
    first = int(fast[0])
    before, row = order[first], order[first + 1]
    who = table.name_of(table.people[row])
    raise TrackError(
        f"{path}:{table.lines[row]}",
        f"with columns as {table.layout} person {who} goes {lengths[first]:.3g} m from line "
        f"{table.lines[before]} in {spans[first]:.3g} s, and {fast.size} of {moves} moves are faster than people run",
        "correct the unit, the rate, or the layout",
    )


def _crowded_in(path: Path, found: Sequence[RootTrajectory]) -> list[Problem]:
    """A warning where several people have less room together than one takes."""
    if len(found) < 2:
        return []
    everywhere = np.concatenate([trajectory.positions for trajectory in found])
    size = float(np.ptp(everywhere, axis=0).max())
    if size >= BODY:
        return []
    message = f"{path}: {len(found)} people are within {size:.2g} m of each other all the time. is the unit right?"
    return [Problem(severity="warning", where=str(path), message=message)]


def _scale(path: Path, table: TrackTable, unit: str, rate: float) -> _Scale:
    """Unit and rate, of the file or as asked for; raises TrackError where they are unknown or differ."""
    metres = metres_in(unit, "unit", error=TrackError) if unit else 0.0
    if table.unit:
        stated = metres_in(table.unit, path, error=TrackError)
        if metres and not np.isclose(metres, stated):
            raise TrackError(path, f"says its positions are in {table.unit}, not {unit}", "leave the unit out")
        metres = stated
    if not metres:
        raise TrackError(
            path, "does not say in which unit its positions are", "give --unit: m, cm, mm, or metres a unit, like 0.02"
        )
    if not (np.isfinite(rate) and rate >= 0.0):
        raise TrackError("rate", f"is {rate:g}", "give frames a second, like 25")
    if table.rate and rate and not np.isclose(table.rate, rate):
        raise TrackError(path, f"says it has {table.rate:g} frames a second, not {rate:g}", "leave the rate out")
    if table.has_times and not (table.rate or rate):
        _logger.warning("%s: its times are taken for seconds; give the rate, like 1000 for milliseconds, if not", path)
        rate = 1.0
    if not (table.rate or rate):
        raise TrackError(path, "does not say how many frames a second it has", "give --rate, like 25")
    _logger.info("%s: %g m a unit, %g frames a second, columns as %s", path, metres, table.rate or rate, table.layout)
    return _Scale(metres=metres, rate=table.rate or rate)


def _is_sqlite(path: Path) -> bool:
    try:
        with path.open("rb") as stream:
            return stream.read(len(SQLITE_MAGIC)) == SQLITE_MAGIC
    except OSError as error:
        raise TrackError(path, f"cannot be read ({error.strerror})", "name a file of tracks") from error


def _read_sqlite(path: Path) -> TrackTable:
    """JuPedSim's trajectory file: metres, and its rate in the metadata."""
    try:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
        try:
            rows = connection.execute("SELECT frame, id, pos_x, pos_y FROM trajectory_data").fetchall()
            found = connection.execute("SELECT value FROM metadata WHERE key = 'fps'").fetchone()
        finally:
            connection.close()
        rate = float(found[0]) if found else 0.0
        values: FloatArray = np.array(rows, dtype=float).reshape(-1, 4)
    except (sqlite3.Error, TypeError, ValueError) as error:
        raise TrackError(path, f"is no JuPedSim trajectory file ({error})", "write it with JuPedSim") from error
    if not np.isfinite(values).all():
        raise TrackError(path, "has positions that are not finite", "write it again")
    return TrackTable(
        layout="jupedsim",
        people=values[:, 1],
        frames=values[:, 0],
        positions=values[:, 2:],
        lines=np.arange(1, len(values) + 1),
        unit="m",
        rate=rate,
    )
