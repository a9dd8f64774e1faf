"""Routes: the shortest ways to a goal around obstacles and over passable ground, on every level, on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.spots import Spots, build_spots
from usdfoot.planning.world import World, clearances, has_room

__all__ = ["Route", "aim_along", "find_route"]

MOST_CELLS = 4_000_000


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

    def find(self, place: FloatArray) -> int:
        """The spot with a way to the goal at or beside a place (3,), -1 if there is none."""
        spot = int(self.spots.at(place[None, [0, 2]], place[[1]], within=self.step)[0])
        return spot if spot >= 0 and np.isfinite(self.distances[spot]) else -1

    def way(self, spot: int, *, length: float = np.inf) -> IntArray:
        """The spots on the way to the goal from one of them on, for so many metres at most."""
        way = [spot]
        while self.following[way[-1]] >= 0 and len(way) * self.spots.cell < length:
            way.append(int(self.following[way[-1]]))
        return np.array(way)


def find_route(
    world: World,
    start: FloatArray,
    goal: FloatArray,
    *,
    radius: float,
    step: float,
    headroom: float,
    must_be_clear: bool = True,
) -> Route:
    """The ways to a goal from everywhere.

    Args:
        world: Bounds, obstacles, terrain; without bounds the route stays within 10 m of start, goal and obstacles.
        start: (x, y, z) [m], shape (3,).
        goal: On the ground (x, y, z) [m], shape (3,).
        radius: Of the body [m]; a cell is half of it.
        step: Highest rise of the ground from cell to cell [m].
        headroom: Free height that the body needs [m].
        must_be_clear: Whether a goal that is not clear is an error; else, and where the start has no way to it, the way
            leads as near to it as one gets.

    Raises:
        PlanError: If the goal is not clear, or the area too large.
    """
    if must_be_clear and not clearances(world, goal[None, [0, 2]], goal[[1]])[0] >= radius:
        raise PlanError(_place("goal", goal), *_obstruction(world, goal, radius))
    lowest, highest = _extent(world, np.stack([start, goal])[:, [0, 2]])
    cell = 0.5 * radius
    counts = np.ceil((highest - lowest) / cell) + 1.0
    if not counts.prod() <= MOST_CELLS:
        size = highest - lowest
        raise PlanError("area", f"is {size[0]:.0f} m by {size[1]:.0f} m, too large for a route", "give narrower bounds")
    corner = goal[[0, 2]] - np.rint((goal[[0, 2]] - lowest) / cell) * cell  # the goal is the centre of a cell
    shape = int(counts[0]), int(counts[1])
    spots = build_spots(world.ground, corner, shape, cell=cell, step=step, headroom=headroom)
    step = step if world.ground is not None and world.ground.has_terrain else np.inf
    target = spots.at(goal[None, [0, 2]], goal[[1]], within=step)[0]
    free = has_room(world, spots.points, spots.heights, radius=radius) & ~spots.is_edge
    free[target] |= target >= 0
    spots, count = spots.only(free), int(free.sum())
    target = spots.at(goal[None, [0, 2]], goal[[1]], within=step)[0]
    distances, following = np.full(count, np.inf), np.full(count, -1)
    if target >= 0:
        distances, following = dijkstra(spots.links, directed=False, indices=target, return_predecessors=True)
    begin = spots.at(start[None, [0, 2]], start[[1]], within=step)[0]
    falls_short = bool(not must_be_clear and begin >= 0 and not np.isfinite(distances[begin]))
    if falls_short:
        target = _nearest_within_reach(spots, int(begin), goal)
        distances, following = dijkstra(spots.links, directed=False, indices=target, return_predecessors=True)
    return Route(
        goal=goal,
        spots=spots,
        distances=distances,
        following=following,
        step=step,
        radius=radius,
        falls_short=falls_short,
    )


def _nearest_within_reach(spots: Spots, begin: int, goal: FloatArray) -> int:
    """The spot nearest to a goal (3,) of those to which one gets from the spot where one begins."""
    away = np.linalg.norm(np.insert(spots.points, 1, spots.heights, axis=1) - goal, axis=1)
    return int(np.argmin(np.where(np.isfinite(dijkstra(spots.links, directed=False, indices=begin)), away, np.inf)))


def aim_along(route: Route, place: FloatArray, *, ahead: float) -> FloatArray | None:
    """The farthest point (x, z) in plain view of the way from a place (3,), at most `ahead` [m] on; None without a way.

    In plain view is where a straight line leads over spots all the way.

    Args:
        route: To the goal.
        place: (x, y, z) [m], shape (3,).
        ahead: How far to look [m].
    """
    spot = route.find(place)
    if spot < 0:
        return None
    way = route.way(spot, length=ahead)
    points = np.insert(route.spots.points[way], 1, route.spots.heights[way], axis=1)
    shares = np.linspace(0.0, 1.0, 16)[1:, None, None]
    views = (place + shares * (points - place)).reshape(-1, 3)
    seen = route.spots.at(views[:, [0, 2]], views[:, 1], within=route.step).reshape(15, -1) >= 0
    visible = np.flatnonzero(seen.all(axis=0))
    return points[visible[-1] if visible.size else min(1, len(points) - 1), [0, 2]]


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
