"""Places: whether walkers can stand where they start and get where they want, and a place of its own for each goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from scipy.spatial import cKDTree

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.scenario import Scenario, Walker
from usdfoot.planning.walkable import walkable_areas

__all__ = ["find_places"]

FASTEST = 5.0
"""Who wants to go faster than people run is taken to go this fast [m/s]."""
ROOM = 1.1
"""Distance between places at one goal over the body's diameter."""


def find_places(
    scenario: Scenario, terrain: Terrain
) -> tuple[list[tuple[shapely.Polygon, list[Walker]]], tuple[Problem, ...]]:
    """Connected areas with the walkers who can walk in them, and why others cannot.

    Goals too near a wall are moved away from it by as much as the body needs, and walkers with one goal get places
    around it: who is nearest at the start the nearest.
    """
    places = np.array([place[[0, 2]] for walker in scenario.walkers for place in (walker.start, *walker.goals)])
    areas = walkable_areas(terrain, scenario.obstacles, bounds=scenario.bounds, places=places)
    groups: dict[int, list[Walker]] = {}
    rooms: dict[tuple[int, float], shapely.Geometry] = {}
    problems = []
    clear = _clear_starts(scenario.walkers)
    for index, walker in enumerate(scenario.walkers):
        try:
            if clear[index] is not None:
                raise _crowded(walker, scenario.walkers[clear[index]])
            area = _area_of(walker, areas)
            if (area, walker.radius) not in rooms:
                rooms[area, walker.radius] = areas[area].buffer(-0.99 * walker.radius)
            walker = _with_goals(walker, rooms[area, walker.radius])
            if walker.speed > FASTEST:
                what = f"{walker.name}: wants to go {walker.speed:.2f} m/s; {FASTEST:g} m/s were taken"
                problems.append(Problem(severity="warning", where=walker.name, message=what))
            groups.setdefault(area, []).append(replace(walker, speed=min(walker.speed, FASTEST)))
        except PlanError as error:
            problems.append(Problem(severity="error", where=walker.name, message=str(error)))
    found = [(areas[area], _spread(walkers, areas[area])) for area, walkers in sorted(groups.items())]
    return found, tuple(problems)


def _clear_starts(walkers: Sequence[Walker]) -> list[int | None]:
    """For each walker one before it, itself clear, that stands in the same place; None = none."""
    points = np.array([walker.start[[0, 2]] for walker in walkers])
    radii = np.array([walker.radius for walker in walkers])
    near = cKDTree(points).query_ball_point(points, 2.0 * radii.max())
    found: list[int | None] = []
    for index, others in enumerate(near):
        earlier = [other for other in sorted(others) if other < index and found[other] is None]
        gaps = np.linalg.norm(points[earlier] - points[index], axis=1) - radii[earlier] - radii[index]
        found.append(earlier[int(np.argmin(gaps))] if np.any(gaps < 0.0) else None)
    return found


def _crowded(walker: Walker, other: Walker) -> PlanError:
    apart = float(np.linalg.norm((walker.start - other.start)[[0, 2]]))
    what = f"starts {apart:.2f} m from {other.name}, where their bodies overlap"
    return PlanError(walker.name, what, f"put them {walker.radius + other.radius:.2f} m apart")


def _area_of(walker: Walker, areas: Sequence[shapely.Polygon]) -> int:
    """The area the walker starts in.

    Raises:
        PlanError: If it starts in none or a goal is not in the same.
    """
    start = shapely.Point(walker.start[[0, 2]])
    inside = [index for index, area in enumerate(areas) if area.covers(start)]
    where = f"({walker.start[0]:.2f}, {walker.start[2]:.2f}) m"
    if not inside:
        raise PlanError(walker.name, f"starts at {where}, in an obstacle or off the walkable ground", "move it")
    room = areas[inside[0]].exterior.distance(start)
    room = min([room, *(ring.distance(start) for ring in areas[inside[0]].interiors)])
    if room < walker.radius:
        what = f"starts at {where}, {room:.2f} m from an obstacle or the edge of the ground"
        raise PlanError(walker.name, what, f"move it; its body has a radius of {walker.radius:.2f} m")
    for goal in walker.goals:
        point, place = shapely.Point(goal[[0, 2]]), f"({goal[0]:.2f}, {goal[2]:.2f}) m"
        if areas[inside[0]].covers(point):
            continue
        if any(area.covers(point) for area in areas):
            raise PlanError(walker.name, f"cannot get to its goal {place}", "there is no way; open one, or move the goal")
        raise PlanError(walker.name, f"has its goal {place} in an obstacle or off the walkable ground", "move the goal")
    return inside[0]


def _with_goals(walker: Walker, room: shapely.Geometry) -> Walker:
    """The walker with its goals where its body has room, which is in `room`.

    Raises:
        PlanError: If there is no room between start and goal that is as wide as the body.
    """
    parts = shapely.get_parts(room)
    start = shapely.Point(walker.start[[0, 2]])
    own = parts[int(np.argmin(shapely.distance(parts, start)))]
    goals = walker.goals.copy()
    for goal in goals:
        point = shapely.Point(goal[[0, 2]])
        nearest = shapely.get_coordinates(shapely.shortest_line(own, point))[0]
        if np.linalg.norm(nearest - goal[[0, 2]]) > walker.radius + 1e-6:
            what = f"cannot get to its goal ({goal[0]:.2f}, {goal[2]:.2f}) m"
            raise PlanError(walker.name, what, f"the ways are narrower than its body, {2.0 * walker.radius:.2f} m")
        goal[[0, 2]] = nearest
    return replace(walker, goals=goals)


def _spread(walkers: list[Walker], area: shapely.Polygon) -> list[Walker]:
    """The walkers with a place of its own for each at goals that several have."""
    lasts = np.array([walker.goals[-1][[0, 2]] for walker in walkers])
    radius = max(walker.radius for walker in walkers)
    spacing = 2.0 * ROOM * radius
    room = area.buffer(-radius)
    shapely.prepare(room)
    taken = np.zeros((0, 2))
    starts = np.array([walker.start[[0, 2]] for walker in walkers])
    places = lasts.copy()
    for index in np.argsort(np.linalg.norm(starts - lasts, axis=1), kind="stable"):
        places[index] = _free_place(lasts[index], taken, room, spacing)
        taken = np.vstack([taken, places[index]])
    found = []
    for walker, place in zip(walkers, places, strict=True):
        goals = walker.goals.copy()
        goals[-1][[0, 2]] = place
        found.append(replace(walker, goals=goals))
    return found


def _free_place(goal: FloatArray, taken: FloatArray, room: shapely.Geometry, spacing: float) -> FloatArray:
    """The place of a triangular lattice around a goal that is nearest to it, free and in the room; else the goal."""
    if not len(taken) or np.linalg.norm(taken - goal, axis=1).min() >= spacing * (1.0 - 1e-6):
        return goal
    near = int(np.sum(np.linalg.norm(taken - goal, axis=1) < spacing * np.sqrt(len(taken) + 7.0)))
    reach = 2 + int(np.ceil(2.0 * np.sqrt(near)))
    row, column = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1), indexing="ij")
    lattice = spacing * np.stack([column + 0.5 * row, np.sqrt(0.75) * row], axis=-1).reshape(-1, 2)
    lattice = goal + lattice[np.argsort(np.linalg.norm(lattice, axis=1).round(9), kind="stable")]
    free = cKDTree(taken).query(lattice)[0] >= spacing * (1.0 - 1e-6)
    free &= shapely.contains_xy(room, lattice[:, 0], lattice[:, 1])
    return lattice[int(np.argmax(free))] if free.any() else goal
