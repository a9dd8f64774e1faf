"""Bumps: footsteps whose soles are in obstacles, and bodies led through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.collisions import FootTable
from usdfoot.planning.world import UNDERFOOT, Obstacle, World, clearances

__all__ = ["Bumps", "find_bumps"]

ON_TOP = 0.02
"""Soles no more than this below the top of an obstacle stand on it [m]."""
STEPPED_OVER = 0.35
"""Bodies step over obstacles that are no higher [m]."""
WAY = np.linspace(-1.0, 0.0, 5)
"""Places of the body from one footstep to the next, the last at the step's end, over the way between."""


@dataclass(frozen=True, kw_only=True)
class Bumps:
    """B footsteps that are in an obstacle, or whose step leads through one."""

    rows: IntArray
    """Of the footsteps in the table, shape (B,)."""
    obstacles: IntArray
    """Which obstacle, shape (B,)."""
    depths: FloatArray
    """How far inside its outline [m], shape (B,)."""


def find_bumps(feet: FootTable, obstacles: Sequence[Obstacle]) -> tuple[Bumps, Bumps]:
    """Soles in obstacles, and bodies, midway between the feet, in them; margins do not count."""
    forward = planar.direction(feet.yaws)
    left = planar.direction(feet.yaws + 0.5 * np.pi)
    places, heights = feet.positions[:, [0, 2]], feet.positions[:, 1]
    ahead = np.stack([-feet.heels, -0.5 * feet.heels, np.zeros(len(heights)), feet.toes])  # (4, N)
    soles = (
        places
        + ahead[..., None] * forward
        + np.array([-1.0, 1.0])[:, None, None, None] * (feet.half_widths[:, None] * left)
    )
    stepping = feet.numbers > 0
    before = np.where(stepping, np.arange(len(places)) - 1, np.arange(len(places)))
    middles = 0.5 * (places + places[before])
    began = np.where((feet.numbers > 1)[:, None], middles[before], middles)
    bodies = middles + WAY[:, None, None] * (middles - began)
    lower = np.minimum(heights, heights[before])
    return (
        _inside(soles.reshape(-1, *places.shape), heights + ON_TOP, obstacles),
        _inside(bodies, lower + STEPPED_OVER, obstacles),
    )


def _inside(points: FloatArray, heights: FloatArray, obstacles: Sequence[Obstacle]) -> Bumps:
    """Which of N rows have points (K, N, 2) in obstacles higher than heights (N,) [m]."""
    levels = np.broadcast_to(heights + UNDERFOOT, points.shape[:2]).ravel()
    flat = points.reshape(-1, 2)
    lows, highs = flat.min(axis=0, initial=np.inf), flat.max(axis=0, initial=-np.inf)
    rows, which, depths = [], [], []
    for index, obstacle in enumerate(obstacles):
        if (obstacle.outline.max(axis=0) < lows).any() or (obstacle.outline.min(axis=0) > highs).any():
            continue
        near = ((flat >= obstacle.outline.min(axis=0)) & (flat <= obstacle.outline.max(axis=0))).all(axis=1)
        bare = Obstacle(name=obstacle.name, outline=obstacle.outline, heights=obstacle.heights)
        depth = np.zeros(len(flat))
        depth[near] = -clearances(World(obstacles=(bare,)), flat[near], levels[near])
        deepest = depth.reshape(points.shape[:2]).max(axis=0)
        own = np.flatnonzero(deepest > 0.0)
        rows.append(own)
        which.append(np.full(len(own), index))
        depths.append(deepest[own])
    if not rows:
        return Bumps(rows=np.zeros(0, dtype=int), obstacles=np.zeros(0, dtype=int), depths=np.zeros(0))
    return Bumps(rows=np.concatenate(rows), obstacles=np.concatenate(which), depths=np.concatenate(depths))
