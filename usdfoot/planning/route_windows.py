"""Route windows: searches over as much of the ground of a world as the ways that are asked for lead over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.route_grid import Lattice, RouteGrid, build_grid, outlines_of
from usdfoot.planning.route_kernel import FULL, TOO_SMALL
from usdfoot.planning.route_searches import Ends, Searched, aim_at, find_starts, search_ways
from usdfoot.planning.world import World

__all__ = ["RouteWindows"]

TOGETHER = 1_000_000
"""Cells of a window that several searches share."""
BESIDE = 2.0
"""So far around starts and ends ways are looked for at first [m]."""
TILE = 64
"""Searches that end in the same square of so many cells are neighbours."""
FEWEST_SLOTS, FULLER = 4096, 8
"""Room of a search at first, and how many times as much it gets when that is full."""
MOST_SLOTS = 20_000_000
"""Of all searches at once, for memory's sake."""


class RouteWindows:
    """Searches in one world; all that are asked for at once share what is known of the ground.

    What a search finds depends on the world, its end and what it may lead over, and not on what else is asked for.

    Args:
        world: Bounds, obstacles, terrain.
        step: Highest rise of the ground from cell to cell [m].
        headroom: Free height that the body needs [m].
    """

    def __init__(self, world: World, *, step: float, headroom: float) -> None:
        self.within = step if world.ground is not None and world.ground.has_terrain else np.inf
        self._world, self._step, self._headroom = world, step, headroom
        self._outlines = outlines_of(world)
        self._grids: list[RouteGrid] = []

    def search(self, ends: Ends, starts: FloatArray | None, lattices: Sequence[Lattice]) -> list[tuple[Searched, int]]:
        """What was found by the searches for N ways, and which of them each way's is.

        Args:
            ends: Where the ways end, N of them.
            starts: Where they begin (x, y, z) [m], shape (N, 3); None = everywhere.
            lattices: Over which they lead, N of them.
        """
        owners, firsts = _alike(ends, lattices)
        ways, ends, lattices = ends, ends.of(firsts), [lattices[row] for row in firsts]
        windows = _windows(ways, ways.places if starts is None else starts, lattices, owners)
        slots, left = np.full(len(firsts), FEWEST_SLOTS), np.arange(len(firsts))
        found: dict[int, tuple[Searched, int]] = {}
        while left.size:
            failures = np.zeros(len(firsts), dtype=int)
            for part in _parts(lattices, windows, slots, left):
                grid = self._grid(lattices[part[0]], windows[part, 0].min(axis=0), windows[part, 1].max(axis=0))
                targeted = aim_at(grid, self._outlines, ends.of(part), radius=2.0 * grid.spots.cell, within=self.within)
                asked = np.flatnonzero(np.isin(owners, part))
                rows = np.searchsorted(part, owners[asked])
                spots = np.full(len(asked), -1) if starts is None else find_starts(targeted, rows, starts[asked])
                begun = np.flatnonzero((spots >= 0) | (starts is None))
                searched, failures[part] = search_ways(targeted, rows[begun], spots[begun], slots=int(slots[part[0]]))
                found |= {int(number): (searched, row) for row, number in enumerate(part)}
            slots[failures == FULL] *= FULLER
            windows = _widened(windows, ends, failures == TOO_SMALL)
            left = np.flatnonzero(failures)
        return [found[int(owner)] for owner in owners]

    def _grid(self, lattice: Lattice, lowest: IntArray, highest: IntArray) -> RouteGrid:
        """The grid of cells from the lowest (2,) to the highest (2,), a known one if it has them."""
        for grid in self._grids:
            if grid.lattice == lattice and grid.covers(lowest, highest):
                return grid
        how = {"step": self._step, "headroom": self._headroom}
        grid = build_grid(self._world, lattice, lowest=lowest, highest=highest, **how)
        self._grids.append(grid)
        return grid


def _alike(ends: Ends, lattices: Sequence[Lattice]) -> tuple[IntArray, IntArray]:
    """Which search each of N ways is found by, shape (N,), and the first way of each search (M,)."""
    keys = np.column_stack([ends.places, ends.anchors, ends.lowest, ends.highest])
    numbers: dict[tuple[bytes, Lattice], int] = {}
    pairs = zip(keys, lattices, strict=True)
    owners = np.array([numbers.setdefault((key.tobytes(), lattice), len(numbers)) for key, lattice in pairs], dtype=int)
    return owners, np.unique(owners, return_index=True)[1]


def _windows(ways: Ends, starts: FloatArray, lattices: Sequence[Lattice], owners: IntArray) -> IntArray:
    """The first and last cells around starts (N, 3) and ends of the ways of each search, shape (M, 2, 2)."""
    cell = np.array([lattice.cell for lattice in lattices])[owners, None]
    beside = np.ceil(BESIDE / cell).astype(np.int64)
    cells = np.stack(
        [
            ways.cells + np.rint((places[:, [0, 2]] - ways.anchors) / cell).astype(np.int64)
            for places in (starts, ways.places)
        ]
    )
    windows = np.empty((len(lattices), 2, 2), dtype=np.int64)
    windows[:, 0], windows[:, 1] = np.iinfo(np.int64).max, np.iinfo(np.int64).min
    np.minimum.at(windows[:, 0], owners, np.clip(cells.min(axis=0) - beside, ways.lowest, ways.highest))
    np.maximum.at(windows[:, 1], owners, np.clip(cells.max(axis=0) + beside, ways.lowest, ways.highest))
    return windows


def _widened(windows: IntArray, ends: Ends, rows: IntArray) -> IntArray:
    """The windows (M, 2, 2), some of them (M,) three times as wide, but no wider than ways may lead."""
    sizes = np.where(rows[:, None], windows[:, 1] - windows[:, 0] + 1, 0)
    wider = windows + sizes[:, None] * np.array([[-1], [1]])
    return np.clip(wider, ends.lowest[:, None], ends.highest[:, None])


def _parts(lattices: Sequence[Lattice], windows: IntArray, slots: IntArray, left: IntArray) -> Iterator[IntArray]:
    """Those searches that are left in parts that share a lattice, a window and the room in their tables, ascending."""
    kinds: dict[tuple[Lattice, int], list[int]] = {}
    tiles = windows[:, 0] // TILE
    for row in left[np.lexsort(tiles[left].T)]:
        kinds.setdefault((lattices[row], int(slots[row])), []).append(int(row))
    for (_, room), rows in kinds.items():
        part, window = rows[:1], windows[rows[0]]
        for row in rows[1:]:
            wider = np.stack([np.minimum(window[0], windows[row, 0]), np.maximum(window[1], windows[row, 1])])
            if np.prod(wider[1] - wider[0] + 1) > TOGETHER or room * len(part) >= MOST_SLOTS:
                yield np.sort(part)
                part, wider = [], windows[row]
            part, window = [*part, row], wider
        yield np.sort(part)
