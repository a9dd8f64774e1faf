"""World: what a planner walks about in, seen from above: a bounded area, obstacles, terrain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground

__all__ = ["Obstacle", "World", "box_outline", "clearances", "has_room", "is_beside", "is_clear"]

BODY, UNDERFOOT = 1.8, 0.1
"""Obstacles higher above the ground, or as far below it, are in nobody's way [m]."""
BATCH = 2_000_000
"""Distances from points to edges held at once."""
SURE = 1e-3
"""Who is so much farther from a box than wanted [m] is so in spite of rounding."""


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """Something to walk around.

    Raises:
        PlanError: If the outline has no area or is not finite.
    """

    name: str
    """Prim path, for messages."""
    outline: FloatArray
    """Corners of a simple polygon (x, z) [m], in either direction, shape (K, 2)."""
    margin: float = 0.0
    """Distance to keep from it [m]."""
    heights: tuple[float, float] = (-np.inf, np.inf)
    """Of its lowest and its highest point [m]; who walks below or above it passes."""
    velocity: tuple[float, float] | None = None
    """At which it moves (x, z) [m/s]; None = nobody has said, it stands as far as is known."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.outline).all() or len(self.outline) < 3:
            raise PlanError(self.name, "has no finite outline of at least three corners", "repair the obstacle")
        if not (np.isfinite(self.margin) and self.margin >= 0.0):
            raise PlanError(self.name, f"has a margin of {self.margin:g} m", "author a number of at least 0")
        if self.velocity is not None and not np.isfinite(self.velocity).all():
            raise PlanError(self.name, f"has a velocity of {self.velocity} m/s", "give two finite numbers, or None")

    @property
    def moves(self) -> bool:
        """Whether it is known to move."""
        return self.velocity is not None and any(self.velocity)


@dataclass(frozen=True, kw_only=True)
class Edges:
    """Edges of outlines, one outline after the other."""

    starts: FloatArray
    """(x, z) [m], shape (E, 2)."""
    ends: FloatArray
    """(x, z) [m], shape (E, 2)."""
    first: IntArray
    """First edge of each outline, shape (O,)."""
    velocities: FloatArray
    """At which they move (x, z) [m/s], shape (E, 2)."""


@dataclass(frozen=True, kw_only=True)
class World:
    """Where one may walk: within the bounds, on walkable terrain, away from obstacles."""

    bounds: FloatArray | None = None
    """Outline to stay in (x, z) [m], shape (K, 2); None = nothing but the terrain ends it."""
    obstacles: tuple[Obstacle, ...] = ()
    ground: Ground | None = None
    """None = level ground at height 0."""

    @cached_property
    def heights(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest points of the obstacles [m], shape (O,) each."""
        lowest, highest = np.array([obstacle.heights for obstacle in self.obstacles]).reshape(-1, 2).T
        return lowest, highest

    @cached_property
    def edges(self) -> Edges:
        """Of the obstacles, and of the bounds as the last."""
        outlines = [obstacle.outline for obstacle in self.obstacles]
        outlines += [] if self.bounds is None else [self.bounds]
        velocities = [obstacle.velocity or (0.0, 0.0) for obstacle in self.obstacles]
        velocities += [] if self.bounds is None else [(0.0, 0.0)]
        counts = [len(outline) for outline in outlines]
        return Edges(
            starts=np.concatenate([np.zeros((0, 2)), *outlines]),
            ends=np.concatenate([np.zeros((0, 2)), *(np.roll(outline, -1, axis=0) for outline in outlines)]),
            first=np.cumsum([0, *counts])[:-1],
            velocities=np.repeat(np.array(velocities).reshape(-1, 2), counts, axis=0),
        )


def box_outline(lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """Corners (4, 2) of the box between two ground points (x, z) [m]."""
    (x0, z0), (x1, z1) = lowest, highest
    return np.array([(x0, z0), (x0, z1), (x1, z1), (x1, z0)], dtype=float)


def clearances(
    world: World, points: FloatArray, heights: FloatArray | None = None, *, times: FloatArray | None = None
) -> FloatArray:
    """Distance [m] to the nearest obstacle's margin or to the bounds, negative inside the one and outside the other.

    Args:
        world: Bounds and obstacles; terrain does not count here.
        points: (x, z) [m], shape (N, 2).
        heights: Of the ground there [m], shape (N,); obstacles that are wholly above a body or below its feet there do
            not count. None = all do.
        times: When, from now on [s], shape (N,); None = now.

    Returns:
        Shape (N,), infinite where there is neither.
    """
    edges = world.edges
    if not len(edges.first):
        return np.full(len(points), np.inf)
    times = np.zeros(len(points)) if times is None else times
    count = max(1, -(-len(points) * len(edges.starts) // BATCH))
    batches = zip(np.array_split(points, count), np.array_split(times, count), strict=True)
    distances = np.concatenate([_signed_distances(edges, batch, instants) for batch, instants in batches])
    distances[:, : len(world.obstacles)] -= [obstacle.margin for obstacle in world.obstacles]
    if heights is not None and world.obstacles:
        own = distances[:, : len(world.obstacles)]
        own[~_is_between(heights[:, None], *world.heights)] = np.inf
    if world.bounds is not None:
        distances[:, -1] *= -1.0
    return distances.min(axis=1)


def has_room(world: World, points: FloatArray, heights: FloatArray, *, radius: float) -> BoolArray:
    """Whether `clearances` are a radius [m] at least at very many points: each obstacle is asked only about those near.

    Args:
        world: Bounds and obstacles; terrain does not count here.
        points: (x, z) [m], shape (N, 2).
        heights: Of the ground there [m], shape (N,).
        radius: Of the body [m].
    """
    room = clearances(World(bounds=world.bounds), points) >= radius
    for obstacle in world.obstacles:
        reach = radius + obstacle.margin + SURE
        lowest, highest = obstacle.outline.min(axis=0) - reach, obstacle.outline.max(axis=0) + reach
        near = np.flatnonzero(room & np.all((points >= lowest) & (points <= highest), axis=1))
        if near.size:
            room[near] = clearances(World(obstacles=(obstacle,)), points[near], heights[near]) >= radius
    return room


def is_beside(obstacle: Obstacle, heights: FloatArray) -> BoolArray:
    """Whether an obstacle is in the way of bodies on ground at heights (N,) [m], neither above nor below them."""
    return _is_between(heights, *obstacle.heights)


def _is_between(heights: FloatArray, lowest: FloatArray | float, highest: FloatArray | float) -> BoolArray:
    """Whether bodies on ground at heights [m] are neither wholly above nor below what reaches from low to high [m]."""
    return (heights + BODY > lowest) & (heights - UNDERFOOT < highest)


def is_clear(world: World, points: FloatArray, heights: FloatArray, *, radius: float, step: float) -> BoolArray:
    """Whether a body may stand at points (N, 2): clear of everything by `radius`, the ground walkable and in reach.

    Args:
        world: Bounds, obstacles, terrain.
        points: (x, z) [m], shape (N, 2).
        heights: From which the ground is looked for [m], shape (N,).
        radius: Of the body [m].
        step: Highest rise or drop of the ground [m].
    """
    clear = clearances(world, points, heights) >= radius
    if world.ground is not None:
        sample = world.ground.heights(points, heights, step_up=step)
        clear &= sample.walkable & (np.abs(sample.heights - heights) <= step)
    return clear


def _signed_distances(edges: Edges, points: FloatArray, times: FloatArray) -> FloatArray:
    """Distances of points (N, 2) at times (N,) from outlines, negative inside, shape (N, O).

    The nearest edge gives the distance, the number of edges that a ray towards +x crosses gives the sign.
    """
    vectors = edges.ends - edges.starts
    places = points[:, None]  # (N, E, 2), as seen from the edges
    if edges.velocities.any():
        places = places - times[:, None, None] * edges.velocities
    offsets = places - edges.starts
    lengths = np.maximum(np.sum(vectors**2, axis=1), np.finfo(float).tiny)
    along = np.clip(np.sum(offsets * vectors, axis=2) / lengths, 0.0, 1.0)
    distances = np.linalg.norm(offsets - along[..., None] * vectors, axis=2)
    spans = (places[..., 1] < edges.starts[:, 1]) != (places[..., 1] < edges.ends[:, 1])  # each corner's height alike
    rises = np.where(vectors[:, 1] == 0.0, 1.0, vectors[:, 1])
    crosses = spans & (offsets[..., 0] < vectors[:, 0] * offsets[..., 1] / rises)
    inside = np.add.reduceat(crosses, edges.first, axis=1, dtype=int) % 2 == 1
    nearest = np.minimum.reduceat(distances, edges.first, axis=1)
    return np.where(inside, -nearest, nearest)
