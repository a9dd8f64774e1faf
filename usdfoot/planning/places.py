"""Places: whether seekers can stand where they start and get where they want, and a place of its own for each goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.spatial import cKDTree

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.itineraries import Itineraries, Itinerary
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.spots import HEADROOM
from usdfoot.planning.walkable import Area, walkable_areas

__all__ = ["Party", "find_places"]

FASTEST = 5.0
"""Who wants to go faster than people run is taken to go this fast [m/s]."""
ROOM = 1.1
"""Distance between places at one goal over the body's diameter."""
SAME = 0.3
"""Ground this near above or below a level's [m] is that level's."""


@dataclass(frozen=True, kw_only=True)
class Party:
    """Those who walk in one area."""

    area: Area
    sideways: bool
    """Whether somebody gets to its goal only through a passage narrower than its body."""
    seekers: tuple[Seeker, ...]
    starts: IntArray
    """Level on which each starts, shape (N,)."""
    itineraries: tuple[Itinerary, ...]
    """Of each, to a place of its own at the last goal."""
    goals: FloatArray
    """The last goals, which several may have (x, z) [m], shape (N, 2)."""

    @property
    def narrowest(self) -> float:
        """Half the width of ways that are left out [m]: for a body, unless somebody has to go sideways."""
        return min(seeker.narrowest if self.sideways else seeker.radius for seeker in self.seekers)


@dataclass(frozen=True, kw_only=True)
class _Spot:
    """On which level of which area a place is."""

    area: int
    """-1 = in none."""
    level: int
    height: float
    """Of the ground [m]."""
    room: float
    """Distance from the level's edges [m]."""


def find_places(scenario: Scenario, terrain: Terrain) -> tuple[list[Party], tuple[Problem, ...]]:
    """Connected areas with the seekers who can walk in them, and why others cannot.

    A place is on the highest ground below it, or else the lowest above it. Goals too near a wall are moved away from it
    by as much as the body needs, and seekers with one goal get places around it: who is nearest at the start the
    nearest.
    """
    places = np.array([place for seeker in scenario.seekers for place in (seeker.start, *seeker.goals)])
    headroom = HEADROOM * max(seeker.body.leg_length for seeker in scenario.seekers)
    areas = walkable_areas(
        terrain, scenario.obstacles, bounds=scenario.bounds, places=places[:, [0, 2]], headroom=headroom
    )
    if terrain.meshes:
        places[:, 1] = Ground(terrain, fallback_height=np.nan).heights(places[:, [0, 2]], places[:, 1]).heights
    spots = iter(_levels_of(places, areas))
    placed = [[next(spots) for _ in range(1 + len(seeker.goals))] for seeker in scenario.seekers]
    ways = [Itineraries(area) for area in areas]
    found: dict[int, list[tuple[Seeker, int, Itinerary]]] = {}
    problems, sideways = [], [False] * len(areas)
    clear = _clear_starts(scenario.seekers, np.array([start.height for start, *_ in placed]))
    for index, (seeker, (start, *goals)) in enumerate(zip(scenario.seekers, placed, strict=True)):
        try:
            other = clear[index]
            if other is not None:
                raise _crowded(seeker, scenario.seekers[other])
            _check_area(seeker, start, goals)
            seeker, radius = _placed(seeker, start, goals, ways[start.area])
            itinerary = _itinerary(seeker, start, goals, ways[start.area], radius)
            if seeker.speed > FASTEST:
                what = f"{seeker.name}: wants to go {seeker.speed:.2f} m/s; {FASTEST:g} m/s were taken"
                problems.append(Problem(severity="warning", where=seeker.name, message=what))
            slower = replace(seeker, speed=min(seeker.speed, FASTEST))
            found.setdefault(start.area, []).append((slower, start.level, itinerary))
            sideways[start.area] |= radius < seeker.radius
        except PlanError as error:
            problems.append(Problem(severity="error", where=seeker.name, message=str(error)))
    parties = [_spread(areas[area], people, sideways=sideways[area]) for area, people in sorted(found.items())]
    return parties, tuple(problems)


def _levels_of(places: FloatArray, areas: Sequence[Area]) -> list[_Spot]:
    """Where places (P, 3) on the ground are; where levels join, on the one whose edges are farther away."""
    points, count = places[:, [0, 2]], len(places)
    shapes = shapely.points(points)
    rooms, where = np.full(count, -1.0), np.full((count, 2), -1)
    for number, area in enumerate(areas):
        for row, level in enumerate(area.levels):
            own = area.height_at(np.full(count, row), points)
            here = shapely.intersects_xy(level, points[:, 0], points[:, 1])
            here &= (np.abs(own - places[:, 1]) <= SAME) | (area.spots is None)
            room = np.where(here, shapely.distance(level.boundary, shapes), -1.0)
            better = room > rooms
            rooms = np.where(better, room, rooms)
            where[better] = number, row
    return [
        _Spot(area=int(area), level=int(level), height=float(height), room=float(room))
        for (area, level), height, room in zip(where, places[:, 1], rooms, strict=True)
    ]


def _clear_starts(seekers: Sequence[Seeker], heights: FloatArray) -> list[int | None]:
    """For each seeker, on the ground at heights (N,), one before it, itself clear, in the same place; None = none.

    Heights that are no number are off the ground, all in one plane.
    """
    points = np.column_stack([np.array([seeker.start for seeker in seekers])[:, [0, 2]], np.nan_to_num(heights)])
    radii = np.array([seeker.radius for seeker in seekers])
    near = cKDTree(points).query_ball_point(points, 2.0 * radii.max())
    found: list[int | None] = []
    for index, others in enumerate(near):
        earlier = [other for other in sorted(others) if other < index and found[other] is None]
        gaps = np.linalg.norm((points[earlier] - points[index])[:, :2], axis=1) - radii[earlier] - radii[index]
        found.append(earlier[int(np.argmin(gaps))] if np.any(gaps < 0.0) else None)
    return found


def _crowded(seeker: Seeker, other: Seeker) -> PlanError:
    apart = float(np.linalg.norm((seeker.start - other.start)[[0, 2]]))
    what = f"starts {apart:.2f} m from {other.name}, where their bodies overlap"
    return PlanError(seeker.name, what, f"put them {seeker.radius + other.radius:.2f} m apart")


def _check_area(seeker: Seeker, start: _Spot, goals: Sequence[_Spot]) -> None:
    """Raise a PlanError if a seeker starts in no area or has no room there, or a goal is not in the same area."""
    where = f"({seeker.start[0]:.2f}, {seeker.start[2]:.2f}) m"
    if start.area < 0:
        raise PlanError(seeker.name, f"starts at {where}, in an obstacle or off the walkable ground", "move it")
    if start.room < seeker.radius:
        what = f"starts at {where}, {start.room:.2f} m from an obstacle or the edge of the ground"
        raise PlanError(seeker.name, what, f"move it; its body has a radius of {seeker.radius:.2f} m")
    for goal, place in zip(goals, seeker.goals, strict=True):
        where = f"({place[0]:.2f}, {place[2]:.2f}) m"
        if goal.area < 0:
            what = f"has its goal {where} in an obstacle or off the walkable ground"
            raise PlanError(seeker.name, what, "move the goal")
        if goal.area != start.area:
            what = f"cannot get to its goal {where}, height {goal.height:.2f} m, from height {start.height:.2f} m"
            raise PlanError(seeker.name, what, "there is no way on foot; open one, a ramp or stairs, or move the goal")


def _with_goals(
    seeker: Seeker, start: _Spot, levels: Sequence[_Spot], ways: Itineraries, *, radius: float
) -> Seeker | None:
    """The seeker with its goals where its body has room; None if no way there is as wide as a radius [m]."""
    goals = seeker.goals.copy()
    for goal, spot in zip(goals, levels, strict=True):
        place, room = shapely.Point(goal[[0, 2]]), ways.room(spot.level, seeker.radius)
        if spot.level == start.level:
            way = _nearest_part(ways.parts(spot.level, radius), shapely.Point(seeker.start[[0, 2]]))
            room = way if radius == seeker.radius else _nearest_part(ways.parts(spot.level, seeker.radius), place)
            if room is None or way is None or (room is not way and not way.intersects(room)):
                return None
        nearest = shapely.get_coordinates(shapely.shortest_line(room, place))
        if not len(nearest) or np.linalg.norm(nearest[0] - goal[[0, 2]]) > seeker.radius + 1e-6:
            return None
        goal[[0, 2]] = nearest[0]
    return replace(seeker, goals=goals)


def _placed(seeker: Seeker, start: _Spot, levels: Sequence[_Spot], ways: Itineraries) -> tuple[Seeker, float]:
    """The seeker with its goals where its body has room, and half the width [m] of its ways: sideways if need be.

    Raises:
        PlanError: If there is no way that is wide enough.
    """
    for radius in (seeker.radius, seeker.narrowest):
        placed = _with_goals(seeker, start, levels, ways, radius=radius)
        if placed is not None:
            return placed, radius
    x, _, z = seeker.goals[-1]
    what = (
        f"the ways are narrower than its body, {2.0 * seeker.radius:.2f} m, and sideways {2.0 * seeker.narrowest:.2f} m"
    )
    raise PlanError(seeker.name, f"cannot get to its goal ({x:.2f}, {z:.2f}) m", what)


def _nearest_part(parts: Sequence[shapely.Geometry], place: shapely.Point) -> shapely.Geometry | None:
    """The one of the parts of a room that is nearest to a place, None if there is none."""
    if len(parts) == 1:
        return parts[0]
    return parts[int(np.argmin(shapely.distance(parts, place)))] if len(parts) else None


def _itinerary(seeker: Seeker, start: _Spot, goals: Sequence[_Spot], ways: Itineraries, radius: float) -> Itinerary:
    """The seeker's, to its goals or, if it has none, to where it stands."""
    places, levels = list(seeker.goals), [goal.level for goal in goals]
    if not places:
        places, levels = [seeker.start], [start.level]
    points = [place[[0, 2]] for place in places]
    try:
        return ways.find(seeker.start[[0, 2]], start.level, goals=points, levels=levels, radius=radius)
    except PlanError as error:
        raise PlanError(seeker.name, f"cannot get to its goals: {error.where} {error.what}", error.remedy) from error


def _spread(area: Area, people: Sequence[tuple[Seeker, int, Itinerary]], *, sideways: bool) -> Party:
    """The people with a place of its own for each at goals that several have."""
    seekers = [seeker for seeker, _, _ in people]
    lasts = np.array([itinerary.points[-1] for _, _, itinerary in people])
    levels = np.array([itinerary.levels[-1] for _, _, itinerary in people])
    starts = np.array([seeker.start[[0, 2]] for seeker in seekers])
    radius = max(seeker.radius for seeker in seekers)
    places = lasts.copy()
    order = np.argsort(np.linalg.norm(starts - lasts, axis=1), kind="stable")
    for level in np.unique(levels):
        room = area.levels[level].buffer(-radius)
        shapely.prepare(room)
        own = order[levels[order] == level]
        taken = np.zeros((0, 2))
        for goal in dict.fromkeys(map(tuple, lasts[own].tolist())):
            going = own[np.all(lasts[own] == goal, axis=1)]
            places[going] = _free_places(np.array(goal), len(going), taken, room, 2.0 * ROOM * radius)
            taken = np.vstack([taken, places[going]])
    return Party(
        area=area,
        sideways=sideways,
        seekers=tuple(seekers),
        starts=np.array([start for _, start, _ in people], dtype=np.intp),
        itineraries=tuple(
            replace(itinerary, points=np.vstack([itinerary.points[:-1], place]))
            for (_, _, itinerary), place in zip(people, places, strict=True)
        ),
        goals=lasts,
    )


def _free_places(goal: FloatArray, count: int, taken: FloatArray, room: shapely.Geometry, spacing: float) -> FloatArray:
    """The places of a triangular lattice around a goal that are nearest to it, free and in the room, shape (count, 2).

    Where there are fewer the goal stands for the rest.
    """
    gaps = cKDTree(taken).query(goal[None])[0] if len(taken) else np.array([np.inf])
    if count == 1 and gaps[0] >= spacing * (1.0 - 1e-6):
        return goal[None]
    near = count + int(np.sum(np.linalg.norm(taken - goal, axis=1) < spacing * np.sqrt(len(taken) + count + 7.0)))
    reach = 2 + int(np.ceil(2.0 * np.sqrt(near)))
    row, column = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1), indexing="ij")
    lattice = spacing * np.stack([column + 0.5 * row, np.sqrt(0.75) * row], axis=-1).reshape(-1, 2)
    lattice = goal + lattice[np.argsort(np.linalg.norm(lattice, axis=1).round(9), kind="stable")]
    free = shapely.contains_xy(room, lattice[:, 0], lattice[:, 1])
    if len(taken):
        free &= cKDTree(taken).query(lattice)[0] >= spacing * (1.0 - 1e-6)
    found = lattice[np.flatnonzero(free)[:count]]
    return np.concatenate([found, np.repeat(goal[None], count - len(found), axis=0)])
