"""Bypass: paths that go round obstacles and ground nobody can walk on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.barred import ELBOWS, RADIUS, rises, where_barred, where_to
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.spots import HEADROOM, STEP, Spots, build_spots, trace_way
from usdfoot.planning.world import Obstacle, World, clearances

__all__ = ["go_round"]

SPACING = 0.05
"""Between the points of a path that are looked at [m]."""
CELL, MOST_CELLS = 0.1, 250_000
"""Width of the cells of the grid [m]; more than so many are made wider."""
ROUNDINGS = (0.25, 0.18, 0.12, 0.06)
"""Standard deviations along the way of the filter that rounds its corners, the widest that cuts none [m]."""
VIEW = 40
"""Cells ahead that are looked at for the next corner."""
DETOUR = 1.25
"""What way round costs over what way along the path costs."""
ASIDE = 10.0
"""A path may go round by this much [m]."""
NUDGE, NEAR = 0.25, 1.0
"""Ends of paths are moved this far at most to where one stands well, and to where one can stand at all [m]."""
EASY, TIGHT = 0.4, 2.0
"""Nearer to a rim than this [m] a way costs more, on the rim itself by this part of its length."""


def go_round(
    path: WalkingPath, ground: Ground, *, body: Proportions, obstacles: Sequence[Obstacle] = ()
) -> WalkingPath:
    """The path, led the shortest way round obstacles and ground that is too steep, too low or not walkable.

    Args:
        path: As drawn.
        ground: The terrain.
        body: That walks along.
        obstacles: To keep half a body's depth away from, and its breadth where there is room.

    Raises:
        PlanError: If the path begins or ends farther than `NEAR` from where one can stand, or there is no way round.
    """
    if not ground.has_terrain and not obstacles:
        return path
    points, world = _dense(path, ground), World(obstacles=tuple(obstacles))
    every = _spots(points, ground, headroom=HEADROOM * body.leg_length)
    room = clearances(world, every.points, every.heights)
    fits, roomy = room >= body.half_depth(RADIUS), (room >= RADIUS + ELBOWS) & ~every.is_edge
    narrow, wide = every.only(fits), every.only(roomy)
    if (_on_spots(wide, points) >= 0).all():
        return path
    prices = _prices(every, room)
    try:
        led = _led(path.name, points, wide, prices[roomy], ground, world, near=NUDGE)
    except PlanError:  # where it is narrow there is no keeping away from the rims
        if (_on_spots(narrow, points) >= 0).all():
            return path
        led = _led(path.name, points, narrow, prices[fits], ground, world, near=NEAR)
    if np.ptp(led, axis=0).max() < SPACING:
        raise PlanError(
            path.name, f"begins {where_barred(points, 0, ground, world=world)}", "lead it where one can stand"
        )
    return replace(path, points=_rounded(_even(led), narrow))


def _led(
    name: str,
    points: FloatArray,
    spots: Spots,
    prices: FloatArray,
    ground: Ground,
    world: World,
    *,
    near: float,
) -> FloatArray:
    """Points (K, 3) of a path, its ends up to `near` [m] away, and of ways on spots where it has none, (M, 3)."""
    found = _on_spots(spots, points)
    points = points.copy()
    at_ends = spots.at(points[[0, -1]][:, [0, 2]], points[[0, -1], 1], within=STEP, touching=False)
    for index, end in ((0, "begins"), (-1, "ends")):
        if at_ends[index] < 0:
            found[index] = _nearest(spots, points[index], near)
            if found[index] < 0:
                what = f"{end} {where_barred(points, index, ground, world=world)}"
                raise PlanError(name, what, where_to(spots, points[index], found))
            points[index] = np.insert(spots.points[found[index]], 1, spots.heights[found[index]])
    on = found >= 0
    stretches = _stretches(on)
    lasts = _trodden(spots, found, stretches)
    if lasts[-1] != len(stretches) - 1:
        place = where_barred(points, int(stretches[lasts[-1], 1]) + 1, ground, world=world)
        raise PlanError(
            name,
            f"leads {place}, and there is no way round",
            "lead it elsewhere, or over stones with usdfoot plan stones",
        )
    pieces, begin = [], 0
    for (_, leave), (back, stop) in pairwise(stretches[lasts].tolist()):
        start = leave - _turnoff(spots, found[begin : leave + 1][::-1], int(found[back]), back - leave)
        end = back + _turnoff(spots, found[back : stop + 1], int(found[start]), back - start)
        pieces += [points[begin : start + 1], _way(spots, prices, int(found[start]), int(found[end]))]
        begin = end
    return np.concatenate([*pieces, points[begin:]])


def _on_spots(spots: Spots, points: FloatArray) -> IntArray:
    """The spot under each point (K, 3) of a path, -1 where there is none or the path goes up or down a wall."""
    found = spots.at(points[:, [0, 2]], points[:, 1], within=STEP)
    return np.where(np.abs(rises(points)) > STEP, -1, found)


def _nearest(spots: Spots, point: FloatArray, near: float) -> int:
    """The spot nearest to a point (3,) on its level, -1 if none is near."""
    distances = np.linalg.norm(spots.points - point[[0, 2]], axis=1)
    distances[np.abs(spots.heights - point[1]) > STEP] = np.inf
    return int(np.argmin(distances)) if distances.min(initial=np.inf) <= near else -1


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


def _rounded(points: FloatArray, spots: Spots) -> FloatArray:
    """Evenly spaced points (M, 3) with their corners rounded seen from above and the ends where they are.

    As wide as leads off no spot that is on the way.
    """
    on = spots.at(points[:, [0, 2]], points[:, 1], within=STEP, touching=False) >= 0
    for rounding in ROUNDINGS:
        reach = min(round(3.0 * rounding / SPACING), len(points) - 1)
        padded = np.pad(points, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
        smooth = gaussian_filter1d(padded, rounding / SPACING, axis=0)[reach:-reach]
        rounded = np.insert(smooth[:, [0, 2]], 1, points[:, 1], axis=1)
        if (spots.at(rounded[on][:, [0, 2]], rounded[on, 1], within=STEP, touching=False) >= 0).all():
            break
    return rounded


def _spots(points: FloatArray, ground: Ground, *, headroom: float) -> Spots:
    """Where one can stand around the points, but for the rims."""
    lowest, highest = points[:, [0, 2]].min(axis=0) - ASIDE, points[:, [0, 2]].max(axis=0) + ASIDE
    cell = max(CELL, float(np.sqrt(np.prod(highest - lowest) / MOST_CELLS)))
    counts = np.ceil((highest - lowest) / cell).astype(int)
    spots = build_spots(ground, lowest, (int(counts[0]), int(counts[1])), cell=cell, headroom=headroom)
    return spots.only(~spots.is_edge)


def _way(spots: Spots, prices: FloatArray, start: int, end: int) -> FloatArray:
    """The corners (K, 3) of the cheapest way from spot to spot by `prices` (S,) of its length; there is a way."""
    starts = np.repeat(np.arange(len(prices)), np.diff(spots.links.indptr))
    links = spots.links.copy()
    links.data = links.data * 0.5 * (prices[starts] + prices[links.indices])
    costs, following = dijkstra(links, directed=False, indices=end, return_predecessors=True)
    way = trace_way(following, start)
    places = np.insert(spots.points[way], 1, spots.heights[way], axis=1)
    corners, last = [0], len(places) - 1
    while corners[-1] < last:
        ahead = slice(corners[-1] + 1, corners[-1] + 1 + VIEW)
        lines = places[ahead] - places[corners[-1]]
        views = (places[corners[-1]] + np.linspace(0.0, 1.0, 2 * VIEW)[:, None, None] * lines).reshape(-1, 3)
        under = spots.at(views[:, [0, 2]], views[:, 1], within=STEP, touching=False).reshape(2 * VIEW, -1)
        straight = np.linalg.norm(lines[:, [0, 2]], axis=1) * np.where(under >= 0, prices[under], np.inf).mean(axis=0)
        seen = np.flatnonzero(straight <= costs[way[corners[-1]]] - costs[way[ahead]] + 1e-9)
        corners.append(corners[-1] + 1 + int(seen[-1] if seen.size else 0))
    return places[corners]


def _prices(spots: Spots, room: FloatArray) -> FloatArray:
    """What way on each spot costs over its length, `room` (S,) [m] from obstacles, shape (S,)."""
    if spots.is_edge.any():
        rims = dijkstra(spots.links, directed=False, indices=np.flatnonzero(spots.is_edge), min_only=True)
        room = np.minimum(room, rims)
    return np.asarray(1.0 + TIGHT * np.clip(1.0 - room / EASY, 0.0, 1.0) ** 2)
