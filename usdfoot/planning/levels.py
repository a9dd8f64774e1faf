"""Levels: spots as sheets that lie nowhere above themselves, and where one goes over into another."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from usdfoot.maths.types import BoolArray, IntArray
from usdfoot.planning.spots import Spots

__all__ = ["extend_level", "split_levels"]

APRON = 1.2
"""Two levels have so much of the way from one to the other in common [m]."""


def split_levels(spots: Spots) -> IntArray:
    """The level of each spot, shape (S,): no level has two spots in one cell, and each is in one piece.

    How many spots of the same piece of ground are below a spot in its cell cuts the ground into parts; parts that are
    joined and nowhere above each other become one level, beginning with the largest. So a floor with a hole for the
    stairs, and above the pillars of the floor below it, is one level.
    """
    _, pieces = connected_components(spots.links, directed=False)
    if int(np.diff(spots.first).max(initial=0)) < 2:
        return pieces
    _, parts = connected_components(_within(spots, _ranks(spots, pieces)), directed=False)
    sizes = np.bincount(parts)
    above, beside = _above(spots, parts), _beside(spots, parts)
    level_of, members = np.full(len(sizes), -1), list[set[int]]()
    for part in np.argsort(-sizes, kind="stable").tolist():
        joined = sorted({int(level_of[other]) for other in beside.get(part, ()) if level_of[other] >= 0})
        open_ones = [level for level in joined if not members[level] & above.get(part, set())]
        if not open_ones:
            members.append(set())
        level_of[part] = open_ones[0] if open_ones else len(members) - 1
        members[level_of[part]].add(part)
    return _with_landings(spots, level_of[parts])


def extend_level(spots: Spots, levels: IntArray, level: int) -> BoolArray:
    """A level's spots and those of others up to an apron beyond it that are neither above nor below it, shape (S,)."""
    own = levels == level
    reached, taken = own.copy(), np.zeros(spots.shape[0] * spots.shape[1], dtype=bool)
    taken[spots.columns[own]] = True
    for _ in range(int(np.ceil(APRON / spots.cell))):
        found = np.flatnonzero((spots.links @ reached.astype(float) > 0.0) & ~reached & ~taken[spots.columns])
        _, once = np.unique(spots.columns[found], return_index=True)
        reached[found[once]] = True
        taken[spots.columns[found]] = True
    return reached


def _ranks(spots: Spots, pieces: IntArray) -> IntArray:
    """How many spots of its own piece are below each in its cell, shape (S,)."""
    order = np.lexsort((spots.heights, spots.columns, pieces))
    keys = np.stack([pieces, spots.columns])[:, order]
    starts = np.concatenate([[True], np.any(keys[:, 1:] != keys[:, :-1], axis=0)])
    first = np.maximum.accumulate(np.where(starts, np.arange(len(order)), 0))
    ranks = np.zeros(len(order), dtype=np.intp)
    ranks[order] = np.arange(len(order)) - first
    return ranks


def _within(spots: Spots, kinds: IntArray):  # type: ignore[no-untyped-def]
    """The links between spots of one kind."""
    links = spots.links.tocoo()
    same = kinds[links.row] == kinds[links.col]
    return type(links)((links.data[same], (links.row[same], links.col[same])), shape=links.shape)


def _beside(spots: Spots, parts: IntArray) -> dict[int, set[int]]:
    """Which parts are joined to which."""
    links = spots.links.tocoo()
    return _pairs(parts[links.row], parts[links.col])


def _above(spots: Spots, parts: IntArray) -> dict[int, set[int]]:
    """Which parts have spots in the same cells."""
    found: dict[int, set[int]] = {}
    for apart in range(1, int(np.diff(spots.first).max(initial=0))):
        same = np.flatnonzero(spots.columns[apart:] == spots.columns[:-apart])
        for one, others in _pairs(parts[same], parts[same + apart]).items():
            found.setdefault(one, set()).update(others)
    return found


def _pairs(one: IntArray, other: IntArray) -> dict[int, set[int]]:
    """Both ways round, without pairs of the same."""
    found: dict[int, set[int]] = {}
    apart = one != other
    for a, b in np.unique(np.stack([one[apart], other[apart]], axis=1), axis=0).tolist():
        found.setdefault(a, set()).add(b)
        found.setdefault(b, set()).add(a)
    return found


def _with_landings(spots: Spots, levels: IntArray) -> IntArray:
    """The levels, with one more at each join of two of which neither can be extended into the other.

    A spiral stair is such a join: after a whole turn what comes next is above the level, and what was before below it.
    """
    levels = levels.copy()
    for level, others in sorted(_beside(spots, levels).items()):
        reach = extend_level(spots, levels, level)
        for other in sorted(others):
            border = (levels == other) & (spots.links @ (levels == level).astype(float) > 0.0)
            back = extend_level(spots, levels, other)
            far_border = (levels == level) & (spots.links @ (levels == other).astype(float) > 0.0)
            if not border.any() or np.any(reach & border) or np.any(back & far_border):
                continue
            landing = border
            for _ in range(int(np.ceil(APRON / spots.cell))):
                landing = landing | ((levels == other) & (spots.links @ landing.astype(float) > 0.0))
            levels[landing] = levels.max() + 1
    return levels
