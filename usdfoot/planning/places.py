"""Places: whether seekers can stand where they start and get where they want, and a place of its own for each goal."""

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
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.walkable import walkable_areas

__all__ = ["find_places"]

FASTEST = 5.0
"""Who wants to go faster than people run is taken to go this fast [m/s]."""
ROOM = 1.1
"""Distance between places at one goal over the body's diameter."""


def find_places(
    scenario: Scenario, terrain: Terrain
) -> tuple[list[tuple[shapely.Polygon, list[Seeker]]], tuple[Problem, ...]]:
    """Connected areas with the seekers who can walk in them, and why others cannot.

    Goals too near a wall are moved away from it by as much as the body needs, and seekers with one goal get places
    around it: who is nearest at the start the nearest.
    """
    places = np.array([place[[0, 2]] for seeker in scenario.seekers for place in (seeker.start, *seeker.goals)])
    areas = walkable_areas(terrain, scenario.obstacles, bounds=scenario.bounds, places=places)
    groups: dict[int, list[Seeker]] = {}
    rooms: dict[tuple[int, float], shapely.Geometry] = {}
    problems = []
    clear = _clear_starts(scenario.seekers)
    for index, seeker in enumerate(scenario.seekers):
        try:
            other = clear[index]
            if other is not None:
                raise _crowded(seeker, scenario.seekers[other])
            area = _area_of(seeker, areas)
            if (area, seeker.radius) not in rooms:
                rooms[area, seeker.radius] = areas[area].buffer(-0.99 * seeker.radius)
            seeker = _with_goals(seeker, rooms[area, seeker.radius])
            if seeker.speed > FASTEST:
                what = f"{seeker.name}: wants to go {seeker.speed:.2f} m/s; {FASTEST:g} m/s were taken"
                problems.append(Problem(severity="warning", where=seeker.name, message=what))
            groups.setdefault(area, []).append(replace(seeker, speed=min(seeker.speed, FASTEST)))
        except PlanError as error:
            problems.append(Problem(severity="error", where=seeker.name, message=str(error)))
    found = [(areas[area], _spread(seekers, areas[area])) for area, seekers in sorted(groups.items())]
    return found, tuple(problems)


def _clear_starts(seekers: Sequence[Seeker]) -> list[int | None]:
    """For each seeker one before it, itself clear, that stands in the same place; None = none."""
    points = np.array([seeker.start[[0, 2]] for seeker in seekers])
    radii = np.array([seeker.radius for seeker in seekers])
    near = cKDTree(points).query_ball_point(points, 2.0 * radii.max())
    found: list[int | None] = []
    for index, others in enumerate(near):
        earlier = [other for other in sorted(others) if other < index and found[other] is None]
        gaps = np.linalg.norm(points[earlier] - points[index], axis=1) - radii[earlier] - radii[index]
        found.append(earlier[int(np.argmin(gaps))] if np.any(gaps < 0.0) else None)
    return found


def _crowded(seeker: Seeker, other: Seeker) -> PlanError:
    apart = float(np.linalg.norm((seeker.start - other.start)[[0, 2]]))
    what = f"starts {apart:.2f} m from {other.name}, where their bodies overlap"
    return PlanError(seeker.name, what, f"put them {seeker.radius + other.radius:.2f} m apart")


def _area_of(seeker: Seeker, areas: Sequence[shapely.Polygon]) -> int:
    """The area the seeker starts in.

    Raises:
        PlanError: If it starts in none or a goal is not in the same.
    """
    start = shapely.Point(seeker.start[[0, 2]])
    inside = [index for index, area in enumerate(areas) if area.covers(start)]
    where = f"({seeker.start[0]:.2f}, {seeker.start[2]:.2f}) m"
    if not inside:
        raise PlanError(seeker.name, f"starts at {where}, in an obstacle or off the walkable ground", "move it")
    room = areas[inside[0]].exterior.distance(start)
    room = min([room, *(ring.distance(start) for ring in areas[inside[0]].interiors)])
    if room < seeker.radius:
        what = f"starts at {where}, {room:.2f} m from an obstacle or the edge of the ground"
        raise PlanError(seeker.name, what, f"move it; its body has a radius of {seeker.radius:.2f} m")
    for goal in seeker.goals:
        point, place = shapely.Point(goal[[0, 2]]), f"({goal[0]:.2f}, {goal[2]:.2f}) m"
        if areas[inside[0]].covers(point):
            continue
        if any(area.covers(point) for area in areas):
            raise PlanError(
                seeker.name, f"cannot get to its goal {place}", "there is no way; open one, or move the goal"
            )
        raise PlanError(seeker.name, f"has its goal {place} in an obstacle or off the walkable ground", "move the goal")
    return inside[0]


def _with_goals(seeker: Seeker, room: shapely.Geometry) -> Seeker:
    """The seeker with its goals where its body has room, which is in `room`.

    Raises:
        PlanError: If there is no room between start and goal that is as wide as the body.
    """
    parts = shapely.get_parts(room)
    start = shapely.Point(seeker.start[[0, 2]])
    own = parts[int(np.argmin(shapely.distance(parts, start)))]
    goals = seeker.goals.copy()
    for goal in goals:
        point = shapely.Point(goal[[0, 2]])
        nearest = shapely.get_coordinates(shapely.shortest_line(own, point))[0]
        if np.linalg.norm(nearest - goal[[0, 2]]) > seeker.radius + 1e-6:
            what = f"cannot get to its goal ({goal[0]:.2f}, {goal[2]:.2f}) m"
            raise PlanError(seeker.name, what, f"the ways are narrower than its body, {2.0 * seeker.radius:.2f} m")
        goal[[0, 2]] = nearest
    return replace(seeker, goals=goals)


def _spread(seekers: list[Seeker], area: shapely.Polygon) -> list[Seeker]:
    """The seekers with a place of its own for each at goals that several have."""
    lasts = np.array([seeker.goals[-1][[0, 2]] for seeker in seekers])
    radius = max(seeker.radius for seeker in seekers)
    spacing = 2.0 * ROOM * radius
    room = area.buffer(-radius)
    shapely.prepare(room)
    taken = np.zeros((0, 2))
    starts = np.array([seeker.start[[0, 2]] for seeker in seekers])
    places = lasts.copy()
    for index in np.argsort(np.linalg.norm(starts - lasts, axis=1), kind="stable"):
        places[index] = _free_place(lasts[index], taken, room, spacing)
        taken = np.vstack([taken, places[index]])
    found = []
    for seeker, place in zip(seekers, places, strict=True):
        goals = seeker.goals.copy()
        goals[-1][[0, 2]] = place
        found.append(replace(seeker, goals=goals))
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
