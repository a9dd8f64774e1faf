"""World: what a planner walks about in, seen from above: a bounded area, obstacles, terrain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.device import start_warp
from usdfoot.model.ground import Ground
from usdfoot.planning.clearance_kernel import BODY, UNDERFOOT, Outlines, find_clearances

__all__ = ["Obstacle", "World", "box_outline", "clearances", "is_beside", "is_clear"]


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
class World:
    """Where one may walk: within the bounds, on walkable terrain, away from obstacles."""

    bounds: FloatArray | None = None
    """Outline to stay in (x, z) [m], shape (K, 2); None = nothing but the terrain ends it."""
    obstacles: tuple[Obstacle, ...] = ()
    ground: Ground | None = None
    """None = level ground at the height one stands at."""

    @cached_property
    def moves(self) -> bool:
        """Whether an obstacle is known to move."""
        return any(obstacle.moves for obstacle in self.obstacles)

    @cached_property
    def outlines(self) -> Any:
        """Of the obstacles, and of the bounds as the last, for kernels; None without any."""
        corners = [obstacle.outline for obstacle in self.obstacles]
        corners += [] if self.bounds is None else [self.bounds]
        if not corners:
            return None
        still, bounded = (0.0, 0.0), len(corners) - len(self.obstacles)
        tables: dict[str, tuple[Any, Any]] = {
            "corners": (np.concatenate(corners), wp.vec2d),
            "first": (np.cumsum([0, *map(len, corners)]).astype(np.int32), wp.int32),
            "lowest": (np.array([outline.min(axis=0) for outline in corners]), wp.vec2d),
            "highest": (np.array([outline.max(axis=0) for outline in corners]), wp.vec2d),
            "margins": (np.array([obstacle.margin for obstacle in self.obstacles] + bounded * [0.0]), wp.float64),
            "heights": (np.array([obstacle.heights for obstacle in self.obstacles] + bounded * [still]), wp.vec2d),
            "velocities": (
                np.array([obstacle.velocity or still for obstacle in self.obstacles] + bounded * [still]),
                wp.vec2d,
            ),
        }
        start_warp()
        outlines: Any = Outlines()
        for name, (values, dtype) in tables.items():
            setattr(outlines, name, wp.array(values, dtype=dtype, device="cpu"))
        outlines.bounds = len(self.obstacles) if bounded else -1
        return outlines


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
    distances = np.full(len(points), np.inf)
    if world.outlines is None or not len(points):
        return distances
    given = (points, *(np.zeros(0) if values is None else values for values in (heights, times)))
    tables: list[Any] = [
        wp.array(np.ascontiguousarray(values, dtype=float), dtype=dtype, device="cpu", copy=False)
        for values, dtype in zip((*given, distances), (wp.vec2d, wp.float64, wp.float64, wp.float64), strict=True)
    ]
    wp.launch(find_clearances, dim=len(points), inputs=[world.outlines, *tables], device="cpu")
    return distances


def is_beside(obstacle: Obstacle, heights: FloatArray) -> BoolArray:
    """Whether an obstacle is in the way of bodies on ground at heights (N,) [m], neither above nor below them."""
    lowest, highest = obstacle.heights
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
