"""Spots: the ground as a grid of places to stand on, on every level, and from which one can step to which."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground

__all__ = ["AROUND", "HEADROOM", "STEEPEST", "STEP", "Spots", "build_spots", "trace_way"]

STEEPEST = np.radians(35.0)
"""Ground steeper than this is not walked on; risers of stairs are stepped over."""
STEP = 0.35
"""Highest step up or down [m]."""
HEADROOM = 2.1
"""Free height that a body needs over the leg length."""
NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))
AROUND = ((0, 0), *NEIGHBOURS, *((-x, -z) for x, z in NEIGHBOURS))
HIGHEST = 1e4
"""Above all terrain [m]."""
SAME = 0.01
"""Faces so near below another are part of it [m]."""


@dataclass(frozen=True, kw_only=True)
class Spots:
    """S places at the centres of the cells of a grid, on the ground of every level where a body can stand."""

    corner: FloatArray
    """Centre of the first cell (x, z) [m], shape (2,)."""
    cell: float
    """Width of a cell [m]."""
    shape: tuple[int, int]
    """Cells along x and z."""
    columns: IntArray
    """Flat index of each spot's cell, ascending, shape (S,)."""
    heights: FloatArray
    """Of the ground [m], ascending within a cell, shape (S,)."""
    links: csr_array
    """Distances between neighbours from one of which one can step to the other [m], symmetric, shape (S, S)."""
    ground: BoolArray
    """Which cells have ground at all, shape (X * Z,)."""

    @cached_property
    def points(self) -> FloatArray:
        """Centres (x, z) [m], shape (S, 2)."""
        return self.corner + self.cell * np.stack(np.divmod(self.columns, self.shape[1]), axis=-1)

    @cached_property
    def first(self) -> IntArray:
        """First spot of each cell, shape (X * Z + 1,)."""
        return np.searchsorted(self.columns, np.arange(self.shape[0] * self.shape[1] + 1))

    @cached_property
    def levels(self) -> int:
        """Most spots above one another."""
        return int(np.diff(self.first).max(initial=0))

    @property
    def is_edge(self) -> BoolArray:
        """Whether there is no stepping on from a spot in one of the eight directions, shape (S,)."""
        return np.diff(self.links.indptr) < len(AROUND) - 1

    def only(self, kept: BoolArray) -> Spots:
        """The spots that are kept (S,)."""
        rows = np.flatnonzero(kept)
        return Spots(
            corner=self.corner,
            cell=self.cell,
            shape=self.shape,
            columns=self.columns[rows],
            heights=self.heights[rows],
            links=self.links[rows][:, rows],
            ground=self.ground,
        )

    def at(self, points: FloatArray, heights: FloatArray, *, within: float, touching: bool = True) -> IntArray:
        """The spot in the cell of each point (N, 2), or in one touching it, whose height is near; -1 if there is none.

        Args:
            points: (x, z) [m], shape (N, 2).
            heights: Of the points [m], shape (N,).
            within: How far above or below a spot may be [m].
            touching: Whether a cell that touches the point's own will do.
        """
        own = np.rint((points - self.corner) / self.cell).astype(np.intp)
        found, left = np.full(len(points), -1), np.arange(len(points))
        for x, z in AROUND if touching else AROUND[:1]:
            row, place = own[left, 0] + x, own[left, 1] + z
            inside = (row >= 0) & (row < self.shape[0]) & (place >= 0) & (place < self.shape[1])
            here = left[inside]
            column = row[inside] * self.shape[1] + place[inside]
            for level in range(self.levels):
                spot = self.first[column] + level
                usable = spot < self.first[column + 1]
                usable[usable] = np.abs(self.heights[spot[usable]] - heights[here[usable]]) <= within
                usable &= found[here] < 0
                found[here[usable]] = spot[usable]
            left = left[found[left] < 0]
            if not left.size:
                break
        return found


def build_spots(
    ground: Ground | None,
    corner: FloatArray,
    shape: tuple[int, int],
    *,
    cell: float,
    step: float = STEP,
    headroom: float,
) -> Spots:
    """Spots wherever the ground is walkable and not too steep and nothing hangs too low above it.

    Steep ground so narrow that one steps over it, as the risers of stairs are, counts as part of what it joins, if that
    is no more than a step above one another: a slanting wall is no stair.

    Args:
        ground: Terrain; None = level at height 0.
        corner: Centre of the first cell (x, z) [m], shape (2,).
        shape: Cells along x and z.
        cell: Width of a cell [m].
        step: Highest step up or down [m].
        headroom: Free height above [m].
    """
    columns, heights, flat, usable = _levels(ground, corner, shape, cell, headroom)
    filled = np.zeros(shape[0] * shape[1], dtype=bool)
    filled[columns] = True
    order = np.lexsort((heights, columns))
    order = order[usable[order]]
    columns, heights, flat = columns[order], heights[order], flat[order]
    links = _links(columns, heights, shape, cell, step)
    near = flat | (links @ flat.astype(float) > 0.0)
    beside_steep = links @ (~near).astype(float) > 0.0
    near &= _rises(links, flat, heights) <= step
    spots = Spots(corner=corner, cell=cell, shape=shape, columns=columns, heights=heights, links=links, ground=filled)
    return spots.only(flat | (near & ~beside_steep))


def _levels(
    ground: Ground | None, corner: FloatArray, shape: tuple[int, int], cell: float, headroom: float
) -> tuple[IntArray, FloatArray, BoolArray, BoolArray]:
    """Cell, height, whether it is flat and whether it can be used of all ground, from the highest level down."""
    columns = np.arange(shape[0] * shape[1])
    if ground is None:
        every = np.ones(len(columns), dtype=bool)
        return columns, np.zeros(len(columns)), every, every
    points = corner + cell * np.stack(np.divmod(columns, shape[1]), axis=-1)
    ceilings, limits = np.full(len(columns), np.inf), np.full(len(columns), HIGHEST)
    levels = []
    while len(columns):
        sample = ground.heights(points[columns], limits, step_up=0.0)
        below = sample.hit & (sample.heights <= limits)
        flat = sample.normals[:, 1] >= np.cos(STEEPEST)
        usable = sample.walkable & (ceilings - sample.heights >= headroom)
        levels.append((columns[below], sample.heights[below], flat[below], usable[below]))
        columns, ceilings = columns[below], sample.heights[below]
        limits = ceilings - SAME
        if not ground.has_terrain:
            break
    columns, heights, flat, usable = (np.concatenate(parts) for parts in zip(*levels, strict=True))
    return columns, heights, flat, usable


def _links(columns: IntArray, heights: FloatArray, shape: tuple[int, int], cell: float, step: float) -> csr_array:
    """Distances (S, S) between spots of neighbouring cells at most a step above one another."""
    first = np.searchsorted(columns, np.arange(shape[0] * shape[1] + 1))
    most = int(np.diff(first).max(initial=0))
    x, z = np.divmod(columns, shape[1])
    rows, others, lengths = [], [], []
    for along_x, along_z in NEIGHBOURS:
        inside = (x + along_x < shape[0]) & (z + along_z >= 0) & (z + along_z < shape[1])
        here = np.flatnonzero(inside)
        column = columns[here] + along_x * shape[1] + along_z
        for level in range(most):
            spot = first[column] + level
            linked = spot < first[column + 1]
            linked[linked] = np.abs(heights[spot[linked]] - heights[here[linked]]) <= step
            rows.append(here[linked])
            others.append(spot[linked])
            lengths.append(np.full(int(linked.sum()), cell * np.hypot(along_x, along_z)))
    row, other, length = np.concatenate(rows), np.concatenate(others), np.concatenate(lengths)
    pairs = np.concatenate([row, other]), np.concatenate([other, row])
    return coo_array((np.concatenate([length, length]), pairs), shape=(len(columns), len(columns))).tocsr()


def _rises(links: csr_array, flat: BoolArray, heights: FloatArray) -> FloatArray:
    """How far apart the heights of the flat spots are that each spot is linked to [m], below 0 for none, shape (S,)."""
    spots, others = np.repeat(np.arange(len(heights)), np.diff(links.indptr)), links.indices
    tops, bottoms = np.full((2, len(heights)), -np.inf)
    joins = flat[others]
    np.maximum.at(tops, spots[joins], heights[others[joins]])
    np.maximum.at(bottoms, spots[joins], -heights[others[joins]])
    return tops + bottoms


def trace_way(following: IntArray, start: int) -> IntArray:
    """Spots from `start` on, each followed by `following` of it, to one that none follows (< 0), as dijkstra says."""
    way = [start]
    while following[way[-1]] >= 0:
        way.append(int(following[way[-1]]))
    return np.array(way)
