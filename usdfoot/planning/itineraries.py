"""Itineraries: by which levels people get to their goals, and where they go over from one to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse.csgraph import dijkstra

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.spots import trace_way
from usdfoot.planning.walkable import Area

__all__ = ["SNUG", "Itineraries", "Itinerary"]

SNUG = 0.99
"""Part of the radius that is kept from walls: a way as wide as the body is one."""


@dataclass(frozen=True, kw_only=True)
class Itinerary:
    """Where one goes, one point after the other, K of them."""

    levels: IntArray
    """Level of the area on which it goes there, shape (K,)."""
    points: FloatArray
    """(x, z) [m], shape (K, 2)."""
    stops: BoolArray
    """Whether it is a goal; else it is where the next level begins, shape (K,)."""


class Itineraries:
    """Finds ways through the levels of an area on its spots; the way to a goal is found once for everyone of a size.

    Args:
        area: Its levels.
    """

    def __init__(self, area: Area) -> None:
        self._area = area
        self._rooms: dict[tuple[int, float], shapely.Geometry] = {}
        self._parts: dict[tuple[int, float], Sequence[shapely.Geometry]] = {}
        self._free: dict[float, BoolArray] = {}
        self._routes: dict[tuple[float, float, int, float], IntArray] = {}

    def room(self, level: int, radius: float) -> shapely.Geometry:
        """Where on a level the middle of a body of a radius [m] can be."""
        if (level, radius) not in self._rooms:
            self._rooms[level, radius] = self._area.levels[level].buffer(-SNUG * radius)
        return self._rooms[level, radius]

    def parts(self, level: int, radius: float) -> Sequence[shapely.Geometry]:
        """The polygons of that room."""
        if (level, radius) not in self._parts:
            self._parts[level, radius] = shapely.get_parts(self.room(level, radius))
        return self._parts[level, radius]

    def find(
        self, start: FloatArray, level: int, *, goals: Sequence[FloatArray], levels: Sequence[int], radius: float
    ) -> Itinerary:
        """From a start (2,) on a level to goals (2,) on their levels, one after the other.

        Raises:
            PlanError: If no way between two levels is wide enough.
        """
        legs: list[tuple[int, FloatArray, bool]] = []
        for goal, goal_level in zip(goals, levels, strict=True):
            if level != goal_level:
                legs += [(on, point, False) for on, point in self._legs(start, level, goal, goal_level, radius)]
            legs.append((goal_level, goal, True))
            start, level = goal, goal_level
        return Itinerary(
            levels=np.array([on for on, _, _ in legs], dtype=np.intp),
            points=np.array([point for _, point, _ in legs]).reshape(-1, 2),
            stops=np.array([stop for _, _, stop in legs], dtype=bool),
        )

    def _legs(
        self, start: FloatArray, level: int, goal: FloatArray, goal_level: int, radius: float
    ) -> list[tuple[int, FloatArray]]:
        """Levels from start to goal and the point of each where the next begins, without the last."""
        spots = self._area.spots
        assert spots is not None  # an area without spots has one level
        way = self._way(start, level, goal, goal_level, radius)
        at, legs = 0, []
        while level != goal_level or not self._on(level, way[at:]).all():
            at += int(np.argmin(np.append(self._on(level, way[at:]), False))) - 1
            legs.append((level, spots.points[way[at]]))
            runs = [int(np.argmin(np.append(self._on(other, way[at:]), False))) for other in range(self._count)]
            runs[level] = 0
            runs[goal_level] += runs[goal_level] > 0
            level = int(np.argmax(runs))
            if runs[level] < 2:
                raise PlanError("way", "leads over a join of levels that is too narrow", "widen it")
        return legs

    @property
    def _count(self) -> int:
        return len(self._area.levels)

    def _on(self, level: int, way: IntArray) -> BoolArray:
        """Whether spots belong to a level or its aprons."""
        spots = self._area.spots
        assert spots is not None
        return self._area.heights[level, spots.columns[way]] == spots.heights[way]

    def _way(self, start: FloatArray, level: int, goal: FloatArray, goal_level: int, radius: float) -> IntArray:
        """The spots from start to goal."""
        spots = self._area.spots
        assert spots is not None
        if radius not in self._free:
            everything = np.arange(len(spots.columns))
            x, z = spots.points.T
            levels = range(self._count)
            rooms = [self._on(one, everything) & shapely.contains_xy(self.room(one, radius), x, z) for one in levels]
            self._free[radius] = np.any(rooms, axis=0)
        rows = np.flatnonzero(self._free[radius])
        key = (float(goal[0]), float(goal[1]), goal_level, radius)
        if key not in self._routes:
            target = self._nearest(rows, goal, goal_level)
            links = spots.only(self._free[radius]).links
            self._routes[key] = dijkstra(links, directed=False, indices=target, return_predecessors=True)[1]
        way = trace_way(self._routes[key], self._nearest(rows, start, level))
        if way[-1] != self._nearest(rows, goal, goal_level):
            what = f"to ({goal[0]:.2f}, {goal[1]:.2f}) m on another level is none"
            raise PlanError("way", what, f"the ways are narrower than the body, {2.0 * radius:.2f} m")
        return rows[way]

    def _nearest(self, rows: IntArray, point: FloatArray, level: int) -> int:
        """Which of the spots on a level is the nearest to a point."""
        spots = self._area.spots
        assert spots is not None
        distances = np.linalg.norm(spots.points[rows] - point, axis=1)
        distances[~self._on(level, rows)] = np.inf
        return int(np.argmin(distances))
