"""Routes: the shortest ways to a goal around obstacles and over passable ground, on every level, on a grid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.spots import Spots, build_spots
from usdfoot.planning.world import World, clearances

__all__ = ["Route", "RouteFinder", "aims_along"]

MOST_CELLS = 4_000_000
VIEWS = 15
"""Places on a straight line at which one looks whether it leads over spots."""


@dataclass(frozen=True, kw_only=True)
class Route:
    """How far every spot is from a goal, and which spot comes next on the way there."""

    goal: FloatArray
    """On the ground [m], shape (3,)."""
    spots: Spots
    """Where a body has room."""
    distances: FloatArray
    """Of the way to the goal [m], infinite where there is none, shape (S,)."""
    following: IntArray
    """Next spot on the way, negative at the goal and where there is none, shape (S,)."""
    step: float
    """Highest step on the way [m]; infinite without terrain, where heights mean nothing."""
    radius: float
    """Half the width of the narrowest places of the way [m], at least."""
    falls_short: bool = False
    """Whether there is no way to the goal from the start, and the way leads as near to it as one gets from there."""

    def find(self, places: FloatArray) -> IntArray:
        """The spots with a way to the goal at or beside places (N, 3), -1 where there is none, shape (N,)."""
        spots = self.spots.at(places[:, [0, 2]], places[:, 1], within=self.step)
        spots[np.append(~np.isfinite(self.distances), True)[spots]] = -1
        return spots

    def ways(self, spots: IntArray, *, length: float) -> IntArray:
        """The spots on the ways to the goal from some of them (N,) on, for so many metres, the goal last, (N, L)."""
        ways = [spots]
        while len(ways) * self.spots.cell < length:
            following = self.following[ways[-1]]
            if not (following >= 0).any():
                break
            ways.append(np.where(following >= 0, following, ways[-1]))
        return np.stack(ways, axis=1)


class RouteFinder:
    """Finds the ways to goals in one world from everywhere, those to one goal once.

    Args:
        world: Bounds, obstacles, terrain; without bounds routes stay within 10 m of start, goal and obstacles.
        step: Highest rise of the ground from cell to cell [m].
        headroom: Free height that the body needs [m].
    """

    def __init__(self, world: World, *, step: float, headroom: float) -> None:
        self._world, self._step, self._headroom = world, step, headroom
        self._found: dict[tuple[object, ...], Route] = {}

    def find(self, start: FloatArray, goal: FloatArray, *, radius: float, must_be_clear: bool = True) -> Route:
        """The ways to a goal.

        Args:
            start: (x, y, z) [m], shape (3,).
            goal: On the ground (x, y, z) [m], shape (3,).
            radius: Of the body [m]; a cell is half of it.
            must_be_clear: Whether a goal that is not clear is an error; else, and where the start has no way to it, the
                way leads as near to it as one gets.

        Raises:
            PlanError: If the goal is not clear, or the area too large.
        """
        world, cell = self._world, 0.5 * radius
        if must_be_clear and not clearances(world, goal[None, [0, 2]], goal[[1]])[0] >= radius:
            raise PlanError(_place("goal", goal), *_obstruction(world, goal, radius))
        corner, shape = _grid(world, start, goal, cell)
        level = float(start[1]) if world.ground is None else 0.0
        asked = goal.tobytes(), radius, corner.tobytes(), shape, level
        if asked not in self._found:
            self._found[asked] = self._lay(goal, corner, shape, cell, level)
        route = self._found[asked]
        begin = int(route.spots.at(start[None, [0, 2]], start[[1]], within=route.step)[0])
        if must_be_clear or begin < 0 or np.isfinite(route.distances[begin]):
            return route
        return _to(replace(route, falls_short=True), _nearest_within_reach(route.spots, begin, goal))

    def _lay(self, goal: FloatArray, corner: FloatArray, shape: tuple[int, int], cell: float, level: float) -> Route:
        """The ways to a goal on a grid; without terrain all spots are on one level [m]."""
        world, step = self._world, self._step
        spots = build_spots(world.ground, corner, shape, cell=cell, step=step, headroom=self._headroom)
        spots = replace(spots, heights=spots.heights + level)
        within = step if world.ground is not None and world.ground.has_terrain else np.inf
        target = spots.at(goal[None, [0, 2]], goal[[1]], within=within)[0]
        free = (clearances(world, spots.points, spots.heights) >= 2.0 * cell) & ~spots.is_edge
        free[target] |= target >= 0
        spots = spots.only(free)
        target = int(spots.at(goal[None, [0, 2]], goal[[1]], within=within)[0])
        count = len(spots.heights)
        route = Route(
            goal=goal,
            spots=spots,
            distances=np.full(count, np.inf),
            following=np.full(count, -1),
            step=within,
            radius=2.0 * cell,
        )
        return _to(route, target) if target >= 0 else route


def _to(route: Route, target: int) -> Route:
    """The route with the ways to a spot."""
    distances, following = dijkstra(route.spots.links, directed=False, indices=target, return_predecessors=True)
    return replace(route, distances=distances, following=following)


def _grid(world: World, start: FloatArray, goal: FloatArray, cell: float) -> tuple[FloatArray, tuple[int, int]]:
    """Centre of the first cell (x, z) [m] and cells along x and z of a grid with start and goal, the latter a centre.

    Raises:
        PlanError: If the area is too large.
    """
    lowest, highest = _extent(world, np.stack([start, goal])[:, [0, 2]])
    counts = np.ceil((highest - lowest) / cell) + 1.0
    if not counts.prod() <= MOST_CELLS:
        size = highest - lowest
        raise PlanError("area", f"is {size[0]:.0f} m by {size[1]:.0f} m, too large for a route", "give narrower bounds")
    corner = goal[[0, 2]] - np.rint((goal[[0, 2]] - lowest) / cell) * cell
    return corner, (int(counts[0]), int(counts[1]))


def _nearest_within_reach(spots: Spots, begin: int, goal: FloatArray) -> int:
    """The spot nearest to a goal (3,) of those to which one gets from the spot where one begins."""
    away = np.linalg.norm(np.insert(spots.points, 1, spots.heights, axis=1) - goal, axis=1)
    return int(np.argmin(np.where(np.isfinite(dijkstra(spots.links, directed=False, indices=begin)), away, np.inf)))


def aims_along(route: Route, places: FloatArray, *, ahead: float) -> tuple[IntArray, FloatArray]:
    """Which of some places (N, 3) have a way to the goal (M,), and the farthest points in plain view on it.

    In plain view is where a straight line leads over spots all the way.

    Args:
        route: To the goal.
        places: (x, y, z) [m], shape (N, 3).
        ahead: How far to look [m].

    Returns:
        Rows of the places, shape (M,); points (x, z) [m], shape (M, 2).
    """
    spots = route.find(places)
    led = np.flatnonzero(spots >= 0)
    ways = route.ways(spots[led], length=ahead)
    points = np.insert(route.spots.points, 1, route.spots.heights, axis=1)[ways]  # (M, L, 3)
    begins, shares = places[led, None], np.linspace(0.0, 1.0, VIEWS + 1)[1:, None, None, None]
    views = (begins + shares * (points - begins)).reshape(-1, 3)
    seen = route.spots.at(views[:, [0, 2]], views[:, 1], within=route.step).reshape(VIEWS, *ways.shape) >= 0
    visible = np.asarray(seen.all(axis=0))
    last = visible.shape[1] - 1
    farthest = np.where(visible.any(axis=1), last - np.argmax(visible[:, ::-1], axis=1), min(1, last))
    return led, points[np.arange(len(led)), farthest][:, [0, 2]]


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
        if clearances(alone, goal[None, [0, 2]], goal[[1]])[0] < radius:
            return f"is within {radius:.2f} m of the obstacle {obstacle.name}", "move it away"
    return f"is outside the bounds or within {radius:.2f} m of them", "move it inside"


def _place(what: str, point: FloatArray) -> str:
    return f"{what} ({point[0]:.2f}, {point[2]:.2f}) m"
