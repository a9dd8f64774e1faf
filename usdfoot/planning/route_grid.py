"""Route grid: the ground of a world as windows of a lattice in which kernels search for ways, built where they lead."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.clearance_kernel import Outlines
from usdfoot.planning.route_kernel import GridSpots
from usdfoot.planning.spots import AROUND, Spots, build_spots
from usdfoot.planning.world import World, clearances

__all__ = ["HALO", "Lattice", "RouteGrid", "build_grid", "outlines_of"]

HALO = 6
"""Around the cells that are asked for so many more are looked at: what a spot is depends on those beside it."""


@dataclass(frozen=True)
class Lattice:
    """Places at whole numbers of cells."""

    cell: float
    """[m]"""
    origin: tuple[float, float] = (0.0, 0.0)
    """Where it begins (x, z) [m]."""
    level: float = 0.0
    """Height of the ground where a world has none [m]."""


@dataclass(frozen=True, kw_only=True)
class RouteGrid:
    """A window of a lattice with its spots, as many as one can stand on whatever is in the way."""

    lattice: Lattice
    lowest: IntArray
    """First cell (x, z), shape (2,)."""
    highest: IntArray
    """Last cell, shape (2,)."""
    spots: Spots
    clearances: FloatArray
    """From everything that stands in the way [m], shape (S,)."""

    def covers(self, lowest: IntArray, highest: IntArray) -> bool:
        """Whether the spots of cells are known."""
        return bool(np.all(lowest - HALO >= self.lowest) and np.all(highest + HALO <= self.highest))

    @cached_property
    def table(self) -> Any:
        """For kernels."""
        grid: Any = GridSpots()
        spots = self.spots
        for name, values, dtype in (
            ("around", np.array(AROUND, dtype=np.int32), wp.vec2i),
            ("first", spots.first.astype(np.int32), wp.int32),
            ("columns", spots.columns.astype(np.int32), wp.int32),
            ("heights", spots.heights, wp.float64),
            ("clearances", self.clearances, wp.float64),
            ("edges", spots.is_edge, wp.bool),
            ("linked", spots.links.indptr.astype(np.int32), wp.int32),
            ("links", spots.links.indices.astype(np.int32), wp.int32),
        ):
            setattr(grid, name, wp.array(values, dtype=dtype, device="cpu"))
        grid.cells, grid.cell = wp.vec2i(*spots.shape), spots.cell
        grid.inner_lowest = wp.vec2i(HALO - 1, HALO - 1)
        grid.inner_highest = wp.vec2i(*(count - HALO for count in spots.shape))
        return grid


def build_grid(
    world: World, lattice: Lattice, *, lowest: IntArray, highest: IntArray, step: float, headroom: float
) -> RouteGrid:
    """The window of a lattice in which the spots of cells from the lowest (2,) to the highest (2,) are known."""
    lowest, highest = lowest - HALO, highest + HALO
    columns, rows = (highest - lowest + 1).tolist()
    corner = np.array(lattice.origin) + lattice.cell * lowest
    spots = build_spots(world.ground, corner, (columns, rows), cell=lattice.cell, step=step, headroom=headroom)
    spots = replace(spots, heights=spots.heights + lattice.level)
    room = clearances(world, spots.points, spots.heights)
    return RouteGrid(lattice=lattice, lowest=lowest, highest=highest, spots=spots, clearances=room)


def outlines_of(world: World) -> Any:
    """The outlines of a world for kernels, none if it has none."""
    if world.outlines is not None:
        return world.outlines
    outlines: Any = Outlines()
    outlines.bounds = -1
    return outlines
