"""Bumps: footsteps whose soles are in obstacles, and bodies led through them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.clearance_kernel import UNDERFOOT
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.world import Obstacle, World, clearances

__all__ = [
    "ON_TOP",
    "STEPPED_OVER",
    "Bumps",
    "body_places",
    "coming_times",
    "find_bumps",
    "lower_heights",
    "sole_places",
]

ON_TOP = 0.02
"""Soles no more than this below the top of an obstacle stand on it [m]."""
STEPPED_OVER = 0.35
"""Bodies step over obstacles that are no higher [m]."""
INSTANT = 0.05
"""Times this near each other [s] see moving obstacles in one place."""
SPACING = 0.1
"""Between the instants at which feet that stand are looked at [s]."""
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
        moving: Others at a time [s], asked for while each foot stands and as it comes; None = there are none.
    """
    soles, bodies = sole_places(feet), body_places(feet)
    lower = lower_heights(feet)
    none = np.zeros(len(feet.owners))
    standing = _inside(soles, feet.half_widths, feet.positions[:, 1] + ON_TOP, obstacles)
    walking = _inside(bodies, none, lower + STEPPED_OVER, obstacles)
    if moving is None:
        return standing, walking
    rows, times = standing_times(feet)
    met = _inside_at(times, soles[:, rows], feet.half_widths[rows], feet.positions[rows, 1] + ON_TOP, moving)
    stood, waits = both_standing_times(feet)
    came, comes = coming_times(feet)
    owners = np.concatenate([stood, came.ravel()])
    places = np.concatenate([bodies[-1, stood], bodies.reshape(-1, 2)])
    hit = _inside_at(
        np.concatenate([waits, comes.ravel()]), places[None], none[owners], lower[owners] + STEPPED_OVER, moving
    )
    return _joined(standing, _deepest(met, rows)), _joined(walking, _deepest(hit, owners))


def sole_places(feet: FootTable) -> FloatArray:
    """Middles of three discs as wide as the foot, from heel to toe (x, z) [m], shape (3, S, 2)."""
    ends = np.stack([-feet.heels + feet.half_widths, np.zeros(len(feet.heels)), feet.toes - feet.half_widths])
    return feet.positions[:, [0, 2]] + np.insert(ends, 1, 0.5 * ends[0], axis=0)[..., None] * planar.direction(
        feet.yaws
    )


def body_places(feet: FootTable) -> FloatArray:
    """Where the body is in each step at `WAY`, in the end midway between the feet (x, z) [m], shape (W, S, 2)."""
    places, before = feet.positions[:, [0, 2]], _before(feet)
    middles = 0.5 * (places + places[before])
    began = np.where((feet.numbers > 1)[:, None], middles[before], middles)
    return middles + WAY[:, None, None] * (middles - began)


def standing_times(feet: FootTable) -> tuple[IntArray, FloatArray]:
    """Rows (K,) and times (K,) [s] at which feet stand: as they strike, and every so often until they leave."""
    return _every(np.arange(len(feet.owners)), feet.strikes, feet.liftoffs)


def both_standing_times(feet: FootTable) -> tuple[IntArray, FloatArray]:
    """Rows (K,) and times (K,) [s] at which the foot before still stands as well."""
    rows = np.flatnonzero(feet.numbers > 0)
    return _every(rows, feet.strikes[rows], feet.liftoffs[rows - 1])


def coming_times(feet: FootTable) -> tuple[IntArray, FloatArray]:
    """Rows and times [s] of each step at `WAY`, shape (W, S) each."""
    rows = np.arange(len(feet.owners))
    left = np.where(feet.numbers > 1, feet.liftoffs[np.maximum(rows - 2, 0)], feet.strikes)
    began = np.clip(left, np.minimum(feet.strikes[_before(feet)], feet.strikes), feet.strikes)
    times = feet.strikes + WAY[:, None] * (feet.strikes - began)
    return np.broadcast_to(rows, times.shape), times


def _before(feet: FootTable) -> IntArray:
    """Row of the footstep before each in its plan, shape (S,); of first footsteps their own."""
    rows = np.arange(len(feet.owners))
    return np.where(feet.numbers > 0, rows - 1, rows)


def lower_heights(feet: FootTable) -> FloatArray:
    """Height of the lower of the feet a body stands on [m], shape (S,)."""
    return np.minimum(feet.positions[:, 1], feet.positions[_before(feet), 1])


def _every(rows: IntArray, begins: FloatArray, ends: FloatArray) -> tuple[IntArray, FloatArray]:
    """Each of rows (R,) as often as `SPACING` fits in from its begin (R,) to its end (R,) [s], and at which times."""
    counts = 1 + np.maximum((ends - begins) / SPACING, 0.0).astype(np.intp)
    numbers = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(rows, counts), np.repeat(begins, counts) + SPACING * numbers


def _inside_at(
    times: FloatArray,
    points: FloatArray,
    radii: FloatArray,
    heights: FloatArray,
    moving: Callable[[float], Sequence[Obstacle]],
) -> Bumps:
    """As `_inside`, each of N rows at its own time (N,) [s]."""
    instants = np.round(times / INSTANT).astype(np.intp)
    order = np.argsort(instants, kind="stable")
    found = [Bumps(rows=np.zeros(0, dtype=int), obstacles=(), depths=np.zeros(0))]
    for rows in np.split(order, np.flatnonzero(np.diff(instants[order])) + 1) if len(order) else ():
        own = _inside(points[:, rows], radii[rows], heights[rows], moving(float(instants[rows[0]]) * INSTANT))
        found.append(replace(own, rows=rows[own.rows]))
    return _joined(*found)


def _deepest(bumps: Bumps, owners: IntArray) -> Bumps:
    """Of bumps in rows that owners (N,) have, those of each owner and obstacle that are deepest, in order of owners."""
    names, which = np.unique(np.array(bumps.obstacles, dtype=str), return_inverse=True)
    own = owners[bumps.rows]
    order = np.lexsort((-bumps.depths, which, own))
    kept = order[np.unique(own[order] * max(len(names), 1) + which[order], return_index=True)[1]]
    return Bumps(
        rows=own[kept], obstacles=tuple(bumps.obstacles[index] for index in kept.tolist()), depths=bumps.depths[kept]
    )


def _joined(*parts: Bumps) -> Bumps:
    return Bumps(
        rows=np.concatenate([part.rows for part in parts]),
        obstacles=tuple(name for part in parts for name in part.obstacles),
        depths=np.concatenate([part.depths for part in parts]),
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
