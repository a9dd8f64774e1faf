"""Corridor: of very many footholds those near the way that a coarse look over all of them finds."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.crossings import Stance, Stones
from usdfoot.planning.reach import Reach

__all__ = ["count_pairs", "order_by_way", "within_pairs"]

CELL = 0.5
"""Width of the cells of the coarse look, over the length of a comfortable step."""
AROUND = 2.0
"""Footholds so near to where a way ends are looked at even if it does not lead to them, over the longest step."""


def count_pairs(stones: Stones, reach: Reach) -> int:
    """How many pairs of footholds are within a step of each other, each way."""
    tree = cKDTree(stones.positions[:, [0, 2]])
    return int(tree.count_neighbors(tree, reach.farthest))


def order_by_way(stones: Stones, start: Stance, goal: Stance, *, reach: Reach) -> tuple[IntArray, bool]:
    """Footholds in order of how much a way from start to goal over each would cost (N,), and whether there may be one.

    Footholds of a cell are taken for one, from which one gets as far as from any of them: where no way leads here, none
    leads over the footholds. Then the way goes as near to the goal as it gets, and what is around its end comes first.

    Args:
        stones: All footholds.
        start: Where both feet are.
        goal: Where both feet shall be.
        reach: Of the character.
    """
    ends = np.stack([start.positions.mean(axis=0), goal.positions.mean(axis=0)])
    places, owners, radii, heights = _cells(stones.positions, reach)
    places = np.concatenate([places, ends])
    radii = np.append(radii, np.repeat(0.5 * reach.comfortable[0], 2))  # the feet of the stances
    links, count = _links(places, radii, np.append(heights, [0.0, 0.0]), reach), len(places)
    begun = dijkstra(links, directed=False, indices=count - 2)
    target, around_end = count - 1, np.zeros(len(stones.positions), dtype=bool)
    if not np.isfinite(begun[target]):
        left = np.linalg.norm(places - ends[1], axis=1)
        target = int(np.argmin(np.where(np.isfinite(begun), left, np.inf)))
        around_end = np.linalg.norm(stones.positions - places[target], axis=1) <= AROUND * reach.farthest
    costs = (begun + dijkstra(links, directed=False, indices=target))[owners]
    aside = np.linalg.norm(stones.positions - places[owners], axis=1)
    return np.lexsort((aside, np.round(costs, 9), ~around_end)), target == count - 1


def within_pairs(stones: Stones, order: IntArray, reach: Reach, *, most: int) -> IntArray:
    """The first footholds of an order that have at most so many pairs within a step, at least one, ascending."""
    tree = cKDTree(stones.positions[:, [0, 2]])
    beside = tree.query_ball_point(stones.positions[:, [0, 2]], reach.farthest, return_length=True)
    kept = int(np.searchsorted(np.cumsum(beside[order]), most, side="right"))
    return np.sort(order[: max(kept, 1)])


def _cells(positions: FloatArray, reach: Reach) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Middles (C, 3) of cells with footholds, each foothold's cell (N,), and how far they reach level and up (C,)."""
    width = CELL * float(np.linalg.norm(reach.comfortable))
    keys = np.floor(positions / (width, reach.rise, width)).astype(np.int64)
    _, owners = np.unique(keys, axis=0, return_inverse=True)
    owners = owners.reshape(-1)
    counts = np.bincount(owners)
    middles = np.stack([np.bincount(owners, weights=positions[:, axis]) / counts for axis in range(3)], axis=1)
    apart = positions - middles[owners]
    radii, heights = np.zeros(len(counts)), np.zeros(len(counts))
    np.maximum.at(radii, owners, np.hypot(apart[:, 0], apart[:, 2]))
    np.maximum.at(heights, owners, np.abs(apart[:, 1]))
    return middles, owners, radii, heights


def _links(places: FloatArray, radii: FloatArray, heights: FloatArray, reach: Reach) -> csr_array:
    """How many comfortable steps it is from cell to cell (C, 3), where a step may lead there, shape (C, C)."""
    tree = cKDTree(places[:, [0, 2]])
    one, other = tree.query_pairs(reach.farthest + 2.0 * float(radii.max()), output_type="ndarray").T
    offsets = places[other] - places[one]
    lengths, rises = np.hypot(offsets[:, 0], offsets[:, 2]), np.abs(offsets[:, 1])
    near = lengths <= reach.farthest + radii[one] + radii[other]
    near &= rises <= reach.rise + heights[one] + heights[other]
    one, other, lengths, rises = one[near], other[near], lengths[near], rises[near]
    easy = float(np.linalg.norm(reach.comfortable))
    shares = np.maximum(lengths / easy, 1e-3)
    costs = shares * (1.0 + (rises / np.maximum(shares, 1.0) / (0.5 * reach.rise)) ** 2)
    return csr_array((costs, (one, other)), shape=(len(places), len(places)))
