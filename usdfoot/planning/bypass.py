"""Bypass: paths that go round ground nobody can walk on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
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
    spots = _spots(points, ground, headroom=HEADROOM * body.leg_length)
    found = spots.at(points[:, [0, 2]], points[:, 1], within=STEP)
    on = found >= 0
    if on.all():
        return path
    for index, end in ((0, "begins"), (-1, "ends")):
        if not on[index]:
            raise PlanError(path.name, f"{end} {_where(points[index], ground)}", "move its end to where one can stand")
    leaves = np.flatnonzero(on[:-1] & ~on[1:])
    returns = np.flatnonzero(~on[:-1] & on[1:]) + 1
    pieces, begin = [], 0
    for leave, back in zip(leaves.tolist(), returns.tolist(), strict=True):
        way = _way(spots, int(found[leave]), int(found[back]))
        if way is None:
            place = _where(points[leave + 1], ground)
            raise PlanError(path.name, f"leads {place}, and there is no way round", "lead it elsewhere")
        pieces += [points[begin : leave + 1], way]
        begin = back
    return replace(path, points=_rounded(_even(np.concatenate([*pieces, points[begin:]]))))


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


def _way(spots: Spots, start: int, end: int) -> FloatArray | None:
    """The corners (K, 3) of the shortest way from spot to spot; None if there is none."""
    following = dijkstra(spots.links, directed=False, indices=end, return_predecessors=True)[1]
    way = trace_way(following, start)
    if way[-1] != end:
        return None
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
