"""Route searches: how long the ways to ends are from spots of a grid, many ends at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.route_grid import RouteGrid
from usdfoot.planning.route_kernel import STRAIGHT, UNKNOWN, Known, Targets, find_spots, look_ahead, search

__all__ = ["Ends", "Looks", "Searched", "Targeted", "aim_at", "find_starts", "look_from", "search_ways"]


@dataclass(frozen=True, kw_only=True)
class Ends:
    """Where M ways end, and over what they may lead."""

    places: FloatArray
    """(x, y, z) [m], shape (M, 3)."""
    anchors: FloatArray
    """Which move the lattice by less than a cell, so that each is a cell's centre (x, z) [m], shape (M, 2)."""
    cells: IntArray
    """Of which cell, shape (M, 2)."""
    lowest: IntArray
    """First cells over which ways may lead, shape (M, 2)."""
    highest: IntArray
    """Last cells, shape (M, 2)."""

    def of(self, rows: IntArray | BoolArray) -> Ends:
        """Those of some rows."""
        return Ends(**{name: values[rows] for name, values in vars(self).items()})


@dataclass(frozen=True, kw_only=True)
class Targeted:
    """Ends on a grid."""

    grid: RouteGrid
    outlines: Any
    """Of the world, for kernels."""
    targets: Any
    """For kernels."""

    @property
    def tables(self) -> list[Any]:
        """What kernels begin with."""
        return [self.grid.table, self.outlines, self.targets]

    def places_of(self, row: int, spots: IntArray) -> FloatArray:
        """The centres of spots (K,) as an end moves the lattice (x, y, z) [m], shape (K, 3)."""
        grid, anchor, cell = self.grid.spots, self.targets.anchors.numpy()[row], self.targets.cells.numpy()[row]
        cells = np.stack(np.divmod(grid.columns[spots], grid.shape[1]), axis=1)
        return np.insert(anchor + grid.cell * (cells - cell), 1, grid.heights[spots], axis=1)


@dataclass(frozen=True, kw_only=True)
class Searched(Targeted):
    """What M searches over one grid have found."""

    known: Any
    """For kernels."""

    def known_spots(self, row: int) -> IntArray:
        """The spots with a known way to the end of a search, ascending, shape (K,)."""
        own, lengths = self.known.spots.numpy()[row], self.known.lengths.numpy()[row]
        return np.sort(own[(own >= 0) & (lengths != int(UNKNOWN))])


@dataclass(frozen=True, kw_only=True)
class Looks:
    """What is known of the ways from N places."""

    led: IntArray
    """`NOWHERE`, `STRAYED` or `LED`, shape (N,)."""
    lengths: FloatArray
    """Of the ways [m], infinite where none is known, shape (N,)."""
    aims: FloatArray
    """The farthest points in plain view on them (x, z) [m], shape (N, 2)."""

    def of(self, rows: IntArray) -> Looks:
        """From some of the places."""
        return Looks(led=self.led[rows], lengths=self.lengths[rows], aims=self.aims[rows])

    def with_rows(self, rows: IntArray, looks: Looks) -> Looks:
        """The same with others from some of the places."""
        columns = {name: values.copy() for name, values in vars(self).items()}
        for name, values in columns.items():
            values[rows] = vars(looks)[name]
        return Looks(**columns)


def aim_at(grid: RouteGrid, outlines: Any, ends: Ends, *, radius: float, within: float) -> Targeted:
    """Ends on a grid, for a body of a radius [m] whose spots are at most so far above or below it [m]."""
    cells = ends.cells - grid.lowest
    shifts = ends.anchors - (grid.spots.corner + grid.spots.cell * cells)
    spots = grid.spots.at(ends.places[:, [0, 2]] - shifts, ends.places[:, 1], within=within)
    targets: Any = Targets()
    for name, values, dtype in (
        ("places", ends.places[:, [0, 2]], wp.vec2d),
        ("anchors", ends.anchors, wp.vec2d),
        ("cells", cells.astype(np.int32), wp.vec2i),
        ("spots", spots.astype(np.int32), wp.int32),
        ("shifts", np.hypot(shifts[:, 0], shifts[:, 1]), wp.float64),
        ("lowest", (ends.lowest - grid.lowest).astype(np.int32), wp.vec2i),
        ("highest", (ends.highest - grid.lowest).astype(np.int32), wp.vec2i),
    ):
        setattr(targets, name, wp.array(np.ascontiguousarray(values), dtype=dtype, device="cpu"))
    targets.radius, targets.within = radius, within
    return Targeted(grid=grid, outlines=outlines, targets=targets)


def find_starts(targeted: Targeted, rows: IntArray, places: FloatArray) -> IntArray:
    """The free spots at or beside places (N, 3) for ends (N,) of the M, -1 = none, shape (N,)."""
    spots = wp.empty(len(rows), dtype=wp.int32, device="cpu")
    wp.launch(find_spots, dim=len(rows), inputs=[*targeted.tables, *_asked(rows, places), spots], device="cpu")
    return np.asarray(spots.numpy())


def search_ways(targeted: Targeted, rows: IntArray, starts: IntArray, *, slots: int) -> tuple[Searched, IntArray]:
    """The ways from spots (N,) to ends (N,) of the M, and why some failed, shape (M,): `FULL`, `TOO_SMALL` or 0.

    Args:
        targeted: The ends.
        rows: Of the end to which each way leads, shape (N,).
        starts: Spots, -1 = whatever leads to the end is asked for, shape (N,).
        slots: Room for so many spots, half of which may be used; a power of two.
    """
    count = len(targeted.targets.spots)
    order = np.argsort(rows, kind="stable")
    first = np.searchsorted(rows[order], np.arange(count + 1)).astype(np.int32)
    known: Any = Known()
    known.spots = wp.full((count, slots), -1, dtype=wp.int32, device="cpu")
    known.lengths = wp.empty((count, slots), dtype=wp.int32, device="cpu")
    known.complete = wp.empty(count, dtype=wp.bool, device="cpu")
    room = [wp.empty((count, slots), dtype=dtype, device="cpu") for dtype in (wp.float64, wp.int32, wp.int32)]
    asked = [
        wp.array(values, dtype=dtype, device="cpu")
        for values, dtype in (
            (_boxes(targeted.grid, rows, starts, count), wp.vec4i),
            (first, wp.int32),
            (starts[order].astype(np.int32), wp.int32),
        )
    ]
    failures = wp.empty(count, dtype=wp.int32, device="cpu")
    wp.launch(search, dim=count, inputs=[*targeted.tables, *asked, known, *room, failures], device="cpu")
    return Searched(**vars(targeted), known=known), failures.numpy()


def look_from(searched: Searched, rows: IntArray, places: FloatArray, *, ahead: float) -> Looks:
    """What searches (N,) know of the ways from places (N, 3), looking at most `ahead` [m] on."""
    count, grid = len(rows), searched.grid.spots
    ways = wp.empty((count, max(int(np.ceil(ahead / grid.cell)), 1)), dtype=wp.int32, device="cpu")
    led, lengths = (wp.zeros(count, dtype=wp.int32, device="cpu") for _ in range(2))
    aims = wp.zeros(count, dtype=wp.vec2d, device="cpu")
    inputs = [*searched.tables, searched.known, *_asked(rows, places), ways, led, lengths, aims]
    wp.launch(look_ahead, dim=count, inputs=inputs, device="cpu")
    metres = lengths.numpy() * (grid.cell / STRAIGHT)
    return Looks(led=led.numpy(), lengths=np.where(led.numpy() > 0, metres, np.inf), aims=aims.numpy())


def _boxes(grid: RouteGrid, rows: IntArray, starts: IntArray, count: int) -> IntArray:
    """The cells (lowest x and z, highest x and z) around the starts (N,) of each end, the whole grid for -1, (M, 4)."""
    cells = np.stack(np.divmod(grid.spots.columns[starts], grid.spots.shape[1]), axis=1)
    last = np.array(grid.spots.shape) - 1
    lowest, highest = np.tile(last, (count, 1)), np.zeros((count, 2), dtype=np.int64)
    np.minimum.at(lowest, rows, np.where(starts[:, None] < 0, 0, cells))
    np.maximum.at(highest, rows, np.where(starts[:, None] < 0, last, cells))
    return np.concatenate([lowest, highest], axis=1).astype(np.int32)


def _asked(rows: IntArray, places: FloatArray) -> list[Any]:
    """Searches (N,) and the places (N, 3) that are asked for, for kernels."""
    return [
        wp.array(np.ascontiguousarray(values), dtype=dtype, device="cpu")
        for values, dtype in (
            (rows.astype(np.int32), wp.int32),
            (places[:, [0, 2]], wp.vec2d),
            (places[:, 1], wp.float64),
        )
    ]
