"""Bypass: paths that go round ground nobody can walk on."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.spots import HEADROOM, STEP, Spots, build_spots, trace_way

__all__ = ["go_round"]

SPACING = 0.05
"""Between the points of a path that are looked at [m]."""
CELL, MOST_CELLS = 0.1, 250_000
"""Width of the cells of the grid [m]; more than so many are made wider."""
ROUNDING = 0.25
"""Standard deviation along the way of the filter that rounds its corners [m]."""
VIEW = 40
"""Cells ahead that are looked at for the next corner."""
DETOUR = 1.25
"""What way round costs over what way along the path costs."""
ASIDE = 10.0
"""A path may go round by this much [m]."""


def go_round(path: WalkingPath, ground: Ground, *, body: Proportions) -> WalkingPath:
    """The path, led the shortest way round where it would cross ground that is too steep, too low or not walkable.

    Args:
        path: As drawn.
        ground: The terrain.
        body: That walks along.

    Raises:
        PlanError: If the path begins or ends on such ground, or there is no way round.
    """
    if not ground.has_terrain:
        return path
    points = _dense(path, ground)
    narrow = _spots(points, ground, headroom=HEADROOM * body.leg_length)
    if (narrow.at(points[:, [0, 2]], points[:, 1], within=STEP) >= 0).all():
        return path
    try:
        led = _led(path.name, points, narrow.only(~narrow.is_edge), ground)
    except PlanError:  # where it is narrow there is no keeping away from the rims
        led = _led(path.name, points, narrow, ground)
    return replace(path, points=_rounded(_even(led)))


def _led(name: str, points: FloatArray, spots: Spots, ground: Ground) -> FloatArray:
    """Points (K, 3) of a path and of ways on spots round where it has none, shape (M, 3)."""
    found = spots.at(points[:, [0, 2]], points[:, 1], within=STEP)
    on = found >= 0
    for index, end in ((0, "begins"), (-1, "ends")):
        if not on[index]:
            raise PlanError(name, f"{end} {_where(points[index], ground)}", "move its end to where one can stand")
    stretches = _stretches(on)
    lasts = _trodden(spots, found, stretches)
    if lasts[-1] != len(stretches) - 1:
        place = _where(points[stretches[lasts[-1], 1] + 1], ground)
        raise PlanError(name, f"leads {place}, and there is no way round", "lead it elsewhere")
    pieces, begin = [], 0
    for (_, leave), (back, stop) in pairwise(stretches[lasts].tolist()):
        start = leave - _turnoff(spots, found[begin : leave + 1][::-1], int(found[back]), back - leave)
        end = back + _turnoff(spots, found[back : stop + 1], int(found[start]), back - start)
        pieces += [points[begin : start + 1], _way(spots, int(found[start]), int(found[end]))]
        begin = end
    return np.concatenate([*pieces, points[begin:]])


def _stretches(on: BoolArray) -> IntArray:
    """First and last point of every stretch of a path that is on spots, shape (S, 2)."""
    changes = np.diff(np.concatenate([[False], on, [False]]).astype(int))
    return np.stack([np.flatnonzero(changes > 0), np.flatnonzero(changes < 0) - 1], axis=1)


def _trodden(spots: Spots, found: IntArray, stretches: IntArray) -> list[int]:
    """Which stretches (S, 2) to go along: not those to which it is farther than past them.

    Way round counts as at least as long as what it replaces, so that a path that crosses itself is not cut short. Ends
    with the farthest stretch there is a way to.
    """
    firsts, lasts = stretches.T
    round_by = dijkstra(spots.links, directed=False, indices=found[lasts])[:, found[firsts]]
    costs = DETOUR * np.maximum(round_by, SPACING * (firsts - lasts[:, None]))
    totals, before = np.zeros(len(stretches)), np.zeros(len(stretches), dtype=int)
    for to in range(1, len(stretches)):
        through = totals[:to] + SPACING * (lasts - firsts)[:to] + costs[:to, to]
        before[to], totals[to] = np.argmin(through), through.min()
    chosen = [int(np.flatnonzero(np.isfinite(totals))[-1])]
    while chosen[-1]:
        chosen.append(int(before[chosen[-1]]))
    return chosen[::-1]


def _turnoff(spots: Spots, along: IntArray, goal: int, between: int) -> int:
    """Which spot of those along a path (K,) to leave it at for a goal, `between` points from the first of them.

    The one from which the way is no farther than turning back later; it is no shortcut, as in `_trodden`.
    """
    numbers = np.arange(len(along))
    lengths = np.maximum(dijkstra(spots.links, directed=False, indices=goal)[along], SPACING * (between + numbers))
    return int(np.argmin(DETOUR * lengths - SPACING * numbers))


def _dense(path: WalkingPath, ground: Ground) -> FloatArray:
    """Points of the path at even spacing on the level it keeps to, shape (K, 3)."""
    points = _even(path.points)
    points[:, 1] = ground.follow(points[:, [0, 2]], points[:, 1], first=np.array([0, len(points)])).heights
    return points


def _even(points: FloatArray) -> FloatArray:
    """The way along points (K, 3) at even spacing, shape (M, 3)."""
    steps = np.linalg.norm(np.diff(points[:, [0, 2]], axis=0), axis=1)
    arcs = np.concatenate([[0.0], np.cumsum(steps)])
    even = np.linspace(0.0, arcs[-1], int(np.ceil(arcs[-1] / SPACING)) + 1)
    return np.stack([np.interp(even, arcs, points[:, axis]) for axis in range(3)], axis=1)


def _rounded(points: FloatArray) -> FloatArray:
    """Evenly spaced points (M, 3) with their corners rounded seen from above and the ends where they are."""
    reach = min(round(3.0 * ROUNDING / SPACING), len(points) - 1)
    padded = np.pad(points, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    smooth = gaussian_filter1d(padded, ROUNDING / SPACING, axis=0)[reach:-reach]
    return np.insert(smooth[:, [0, 2]], 1, points[:, 1], axis=1)


def _spots(points: FloatArray, ground: Ground, *, headroom: float) -> Spots:
    """Where one can stand around the points, but for the rims."""
    lowest, highest = points[:, [0, 2]].min(axis=0) - ASIDE, points[:, [0, 2]].max(axis=0) + ASIDE
    cell = max(CELL, float(np.sqrt(np.prod(highest - lowest) / MOST_CELLS)))
    counts = np.ceil((highest - lowest) / cell).astype(int)
    spots = build_spots(ground, lowest, (int(counts[0]), int(counts[1])), cell=cell, headroom=headroom)
    return spots.only(~spots.is_edge)


def _way(spots: Spots, start: int, end: int) -> FloatArray:
    """The corners (K, 3) of the shortest way from spot to spot; there is one."""
    way = trace_way(dijkstra(spots.links, directed=False, indices=end, return_predecessors=True)[1], start)
    places = np.insert(spots.points[way], 1, spots.heights[way], axis=1)
    corners, last = [0], len(places) - 1
    while corners[-1] < last:
        ahead = places[corners[-1] + 1 : corners[-1] + 1 + VIEW]
        shares = np.linspace(0.0, 1.0, 2 * VIEW)[:, None, None]
        views = (places[corners[-1]] + shares * (ahead - places[corners[-1]])).reshape(-1, 3)
        clear = spots.at(views[:, [0, 2]], views[:, 1], within=STEP, touching=False).reshape(2 * VIEW, -1) >= 0
        seen = np.flatnonzero(clear.all(axis=0))
        corners.append(corners[-1] + 1 + int(seen[-1] if seen.size else 0))
    return places[corners]


def _where(point: FloatArray, ground: Ground) -> str:
    """Over what ground a point (3,) is, and where."""
    sample = ground.heights(point[None, [0, 2]], point[[1]])
    place = f"at ({point[0]:.2f}, {point[1]:.2f}, {point[2]:.2f}) m"
    if not sample.hit[0]:
        return f"off the terrain {place}"
    slope = float(np.degrees(np.arccos(min(float(sample.normals[0, 1]), 1.0))))
    return f"over ground of {slope:.0f} degrees {place}, too steep to stand, too low or too near an edge"
