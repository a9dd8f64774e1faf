"""Barred ways: what is in the way of a path that nobody can walk, where, and what to do about it."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.planning.spots import STEEPEST, STEP, Spots
from usdfoot.planning.world import World, clearances

__all__ = ["ELBOWS", "RADIUS", "rises", "where_barred", "where_to"]

WALL = 2
"""Points of a path to either side within which a rise of more than a step is no stair."""
RADIUS, ELBOWS = 0.25, 0.05
"""Half the width of a body, and what it keeps free beside it where it goes round [m]."""


def rises(points: FloatArray) -> FloatArray:
    """How far a path rises about each of its points (K, 3) [m], shape (K,)."""
    beside = np.pad(points[:, 1], WALL, mode="edge")
    return np.asarray(beside[2 * WALL :] - beside[: -2 * WALL])


def where_barred(points: FloatArray, index: int, ground: Ground, *, world: World) -> str:
    """Over what ground, up which wall or into which obstacle one of a path's points (K, 3) is, and where."""
    point, place = points[index], f"at {_at(points[index])}"
    for obstacle in world.obstacles:
        if clearances(World(obstacles=(obstacle,)), point[None, [0, 2]], point[[1]])[0] < RADIUS + ELBOWS:
            return f"too near to the obstacle {obstacle.name} {place}"
    sample = ground.heights(point[None, [0, 2]], point[[1]])
    if not sample.hit[0]:
        return f"off the terrain {place}"
    if not sample.walkable[0]:
        return f"over ground that is not walkable {place}"
    rise = float(rises(points)[index])
    if abs(rise) > STEP:
        return f"{'up' if rise > 0.0 else 'down'} a wall of {abs(rise):.2f} m {place}, more than one steps"
    slope, steepest = (np.degrees(angle) for angle in (np.arccos(min(float(sample.normals[0, 1]), 1.0)), STEEPEST))
    if slope > steepest:
        return f"over ground of {slope:.0f} degrees {place}, too steep to stand: people do on {steepest:.0f}"
    return f"{place} too near to an edge, to a wall or steep ground, or to what is above"


def where_to(spots: Spots, point: FloatArray, found: IntArray) -> str:
    """What to do about a path that begins or ends at a point (3,) where nobody stands.

    Args:
        spots: Where one can stand.
        point: The end of the path [m].
        found: The spots under the path, -1 where there is none; the nearest place is one to walk to from these.
    """
    keep = "keep to the curve: --no-around"
    if not len(spots.heights):
        return f"draw it where one can stand, or {keep}"
    places = np.insert(spots.points, 1, spots.heights, axis=1)
    parts = connected_components(spots.links, directed=False)[1]
    joined = np.isin(parts, parts[found[found >= 0]]) if (found >= 0).any() else np.ones(len(parts), dtype=bool)
    distances = np.where(joined, np.linalg.norm(places - point, axis=1), np.inf)
    return f"move that end to {_at(places[np.argmin(distances)])}, or {keep}"


def _at(point: FloatArray) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f}, {point[2]:.2f}) m"
