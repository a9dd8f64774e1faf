"""Routes: the way to a goal around obstacles, on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.world import World, clearances

__all__ = ["Route", "aim_along", "find_route"]

NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))
MOST_CELLS = 4_000_000
HIGHEST = 1e4
"""Above all terrain [m]."""


@dataclass(frozen=True, kw_only=True)
class Route:
    """How far every cell of a grid is from a goal, and which cell comes next on the way there."""

    goal: FloatArray
    """(x, z) [m], shape (2,)."""
    corner: FloatArray
    """Centre of the first cell (x, z) [m], shape (2,)."""
    cell: float
    """Width of a cell [m]."""
    distances: FloatArray
    """Of the way to the goal [m], infinite where there is none, shape (X, Z)."""
    following: IntArray
    """Flat index of the next cell on the way, negative at the goal and where there is none, shape (X, Z)."""

    def cells_of(self, points: FloatArray) -> IntArray:
        """Flat index of the nearest cell with a way of points (N, 2) whose own cell is or touches one, else -1."""
        own = np.rint((points - self.corner) / self.cell).astype(np.intp)
        around = own[:, None] + np.array([(0, 0), *NEIGHBOURS, *((-x, -z) for x, z in NEIGHBOURS)])  # (N, 9, 2)
        shape = np.array(self.distances.shape)
        inside = np.all((around >= 0) & (around < shape), axis=2)
        safe = np.clip(around, 0, shape - 1)
        usable = inside & np.isfinite(self.distances[safe[..., 0], safe[..., 1]])
        first = np.argmax(usable, axis=1)
        chosen = safe[np.arange(len(points)), first]
        return np.where(usable.any(axis=1), chosen[:, 0] * shape[1] + chosen[:, 1], -1)

    def centres(self, cells: IntArray) -> FloatArray:
        """Centres (N, 2) of cells by flat index [m]."""
        return self.corner + self.cell * np.stack(np.divmod(cells, self.distances.shape[1]), axis=-1)


def find_route(
    world: World, start: FloatArray, goal: FloatArray, *, radius: float, step: float, must_be_clear: bool = True
) -> Route:
    """The ways to a goal from everywhere.

    Args:
        world: Bounds, obstacles, terrain; without bounds the route stays within 10 m of start, goal and obstacles.
        start: (x, z) [m], shape (2,).
        goal: (x, z) [m], shape (2,).
        radius: Of the body [m]; a cell is half of it.
        step: Highest rise of the ground from cell to cell [m].
        must_be_clear: Whether a goal that is not clear is an error; else the way leads as near to it as it can.

    Raises:
        PlanError: If the goal is not clear, or the area too large.
    """
    if must_be_clear and not clearances(world, goal[None])[0] >= radius:
        raise PlanError(_place("goal", goal), *_obstruction(world, goal, radius))
    lowest, highest = _extent(world, np.stack([start, goal]))
    cell = 0.5 * radius
    counts = np.ceil((highest - lowest) / cell).astype(int) + 1
    if counts.prod() > MOST_CELLS:
        size = highest - lowest
        raise PlanError("area", f"is {size[0]:.0f} m by {size[1]:.0f} m, too large for a route", "give narrower bounds")
    goal_cell = np.rint((goal - lowest) / cell)
    corner = goal - goal_cell * cell  # the goal is the centre of a cell
    index = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing="ij"), axis=-1)
    points = (corner + cell * index).reshape(-1, 2)
    free = clearances(world, points) >= radius
    heights: FloatArray = np.zeros(len(points))
    if world.ground is not None:
        sample = world.ground.heights(points, np.full(len(points), HIGHEST))
        free, heights = free & sample.walkable, sample.heights
    target = int(goal_cell[0] * counts[1] + goal_cell[1])
    free[target] = True
    distances, following = _spread(free.reshape(counts), heights.reshape(counts), target, cell, step)
    return Route(goal=goal, corner=corner, cell=cell, distances=distances, following=following)


def aim_along(route: Route, world: World, point: FloatArray, *, radius: float, ahead: float) -> FloatArray | None:
    """The farthest point in plain view of the way from `point` (2,), at most `ahead` [m] on; None without a way.

    Args:
        route: To the goal.
        world: For what hides it.
        point: (x, z) [m], shape (2,).
        radius: Of the body [m].
        ahead: How far to look [m].
    """
    cell = int(route.cells_of(point[None])[0])
    if cell < 0:
        return None
    way = [cell]
    while route.following.flat[way[-1]] >= 0 and len(way) * route.cell < ahead:
        way.append(int(route.following.flat[way[-1]]))
    places = route.centres(np.array(way))
    shares = np.linspace(0.0, 1.0, 16)[:, None, None]
    views = (point + shares * (places - point)).reshape(-1, 2)
    visible = np.all((clearances(world, views) >= 0.9 * radius).reshape(16, -1)[1:], axis=0)
    seen = np.flatnonzero(visible)
    return places[seen[-1]] if seen.size else places[min(1, len(places) - 1)]


def _extent(world: World, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner of the grid."""
    if world.bounds is not None:
        return world.bounds.min(axis=0), world.bounds.max(axis=0)
    places = np.concatenate([points, *(obstacle.outline for obstacle in world.obstacles)])
    return places.min(axis=0) - 10.0, places.max(axis=0) + 10.0


def _obstruction(world: World, goal: FloatArray, radius: float) -> tuple[str, str]:
    """What is wrong with a goal, and what would be right."""
    for obstacle in world.obstacles:
        alone = World(obstacles=(obstacle,))
        if clearances(alone, goal[None])[0] < radius:
            return f"is within {radius:.2f} m of the obstacle {obstacle.name}", "move it away"
    return f"is outside the bounds or within {radius:.2f} m of them", "move it inside"


def _place(what: str, point: FloatArray) -> str:
    return f"{what} ({point[0]:.2f}, {point[1]:.2f}) m"


def _spread(free: BoolArray, heights: FloatArray, target: int, cell: float, step: float) -> tuple[FloatArray, IntArray]:
    """Distances from the target cell over free cells, and the next cell towards it."""
    numbers = np.arange(free.size).reshape(free.shape)
    rows, columns, costs = [], [], []
    for x, z in NEIGHBOURS:
        here = (slice(0, free.shape[0] - x), slice(max(0, -z), free.shape[1] - max(0, z)))
        there = (slice(x, None), slice(max(0, z), free.shape[1] + min(0, z)))
        open_way = free[here] & free[there] & (np.abs(heights[here] - heights[there]) <= step)
        rows.append(numbers[here][open_way])
        columns.append(numbers[there][open_way])
        costs.append(np.full(int(open_way.sum()), cell * np.hypot(x, z)))
    pairs = np.concatenate(rows), np.concatenate(columns)
    graph = coo_array((np.concatenate(costs), pairs), shape=(free.size, free.size)).tocsr()
    distances, before = dijkstra(graph, directed=False, indices=target, return_predecessors=True)
    return distances.reshape(free.shape), before.reshape(free.shape)
