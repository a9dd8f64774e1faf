"""Bumps: footsteps whose soles are in obstacles, and bodies led through them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.world import UNDERFOOT, Obstacle, World, clearances

__all__ = ["Bumps", "find_bumps"]

ON_TOP = 0.02
"""Soles no more than this below the top of an obstacle stand on it [m]."""
STEPPED_OVER = 0.35
"""Bodies step over obstacles that are no higher [m]."""
INSTANT = 0.05
"""Strikes this near each other [s] see moving obstacles in one place."""
WAY = np.linspace(-1.0, 0.0, 5)
"""Places of the body from one footstep to the next, the last at the step's end, over the way between."""


@dataclass(frozen=True, kw_only=True)
class Bumps:
    """B footsteps that are in an obstacle, or whose step leads through one."""

    rows: IntArray
    """Of the footsteps in the table, shape (B,)."""
    obstacles: tuple[str, ...]
    """Name of the obstacle, B of them."""
    depths: FloatArray
    """How far inside its outline [m], shape (B,)."""


def find_bumps(
    feet: FootTable, obstacles: Sequence[Obstacle], *, moving: Callable[[float], Sequence[Obstacle]] | None = None
) -> tuple[Bumps, Bumps]:
    """Soles in obstacles, and bodies, midway between the feet, in them; margins do not count.

    Args:
        feet: Of all plans.
        obstacles: That stay where they are.
        moving: Others at a time [s], asked for as each foot strikes; None = there are none.
    """
    forward = planar.direction(feet.yaws)
    places, heights = feet.positions[:, [0, 2]], feet.positions[:, 1]
    ends = np.stack([-feet.heels + feet.half_widths, np.zeros(len(heights)), feet.toes - feet.half_widths])
    soles = places + np.insert(ends, 1, 0.5 * ends[0], axis=0)[..., None] * forward
    stepping = feet.numbers > 0
    before = np.where(stepping, np.arange(len(places)) - 1, np.arange(len(places)))
    middles = 0.5 * (places + places[before])
    began = np.where((feet.numbers > 1)[:, None], middles[before], middles)
    bodies = middles + WAY[:, None, None] * (middles - began)
    lower = np.minimum(heights, heights[before])
    none = np.zeros(len(places))
    standing = _inside(soles, feet.half_widths, heights + ON_TOP, obstacles)
    walking = _inside(bodies, none, lower + STEPPED_OVER, obstacles)
    if moving is None:
        return standing, walking
    return (
        _joined(standing, _inside_at(feet.strikes, soles, feet.half_widths, heights + ON_TOP, moving)),
        _joined(walking, _inside_at(feet.strikes, bodies[-1:], none, lower + STEPPED_OVER, moving)),
    )


def _inside_at(
    times: FloatArray,
    points: FloatArray,
    radii: FloatArray,
    heights: FloatArray,
    moving: Callable[[float], Sequence[Obstacle]],
) -> Bumps:
    """As `_inside`, each of N rows at its own time (N,) [s]."""
    found = Bumps(rows=np.zeros(0, dtype=int), obstacles=(), depths=np.zeros(0))
    instants = np.round(times / INSTANT)
    for instant in np.unique(instants):
        rows = np.flatnonzero(instants == instant)
        own = _inside(points[:, rows], radii[rows], heights[rows], moving(float(instant) * INSTANT))
        found = _joined(found, replace(own, rows=rows[own.rows]))
    return found


def _joined(first: Bumps, second: Bumps) -> Bumps:
    return Bumps(
        rows=np.concatenate([first.rows, second.rows]),
        obstacles=first.obstacles + second.obstacles,
        depths=np.concatenate([first.depths, second.depths]),
    )


def _inside(points: FloatArray, radii: FloatArray, heights: FloatArray, obstacles: Sequence[Obstacle]) -> Bumps:
    """Which of N rows have discs round points (K, N, 2) in obstacles higher than heights (N,) [m]."""
    reach = np.broadcast_to(radii, points.shape[:2]).ravel()
    levels = np.broadcast_to(heights + UNDERFOOT, points.shape[:2]).ravel()
    flat = points.reshape(-1, 2)
    rows, names, depths = [np.zeros(0, dtype=int)], [], [np.zeros(0)]
    for obstacle in obstacles:
        lowest, highest = obstacle.outline.min(axis=0), obstacle.outline.max(axis=0)
        near = ((flat > lowest - reach[:, None]) & (flat < highest + reach[:, None])).all(axis=1)
        if not near.any():
            continue
        bare = World(obstacles=(replace(obstacle, margin=0.0),))
        depth = np.zeros(len(flat))
        depth[near] = reach[near] - clearances(bare, flat[near], levels[near])
        deepest = depth.reshape(points.shape[:2]).max(axis=0)
        own = np.flatnonzero(deepest > 0.0)
        rows.append(own)
        names += [obstacle.name] * len(own)
        depths.append(deepest[own])
    return Bumps(rows=np.concatenate(rows), obstacles=tuple(names), depths=np.concatenate(depths))
