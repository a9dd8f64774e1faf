"""Aims: where those that wander want to go, in the world as each knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.planning.free_ways import rooms_above
from usdfoot.planning.legs import find_near, find_routes
from usdfoot.planning.moving import measure_velocities, moved_on
from usdfoot.planning.route_kernel import STRAYED
from usdfoot.planning.route_searches import Looks
from usdfoot.planning.routes import Route, RouteFinder, look_along
from usdfoot.planning.sound_steps import sound_stands
from usdfoot.planning.spots import HEADROOM
from usdfoot.planning.wanderer import Wanderers, WanderOptions
from usdfoot.planning.world import World, is_clear

__all__ = ["Aims", "News", "find_aims", "finder_in", "look_ahead"]

AHEAD = 4.0
"""How far it looks along its way over how far it wants to see."""


@dataclass(frozen=True, kw_only=True)
class News:
    """What one that wanders is told before its next step; a world is everybody's, goals are its own."""

    world: World | None = None
    """As it is now; None = as before."""
    goals: Sequence[FloatArray] | None = None
    """Places to go to instead of those it has not reached (x, y, z) [m], each shape (3,); none = wander at random;
    None = as before."""


@dataclass(frozen=True, kw_only=True)
class Aims:
    """Where one that wanders wants to go, in the world as it knows it."""

    known: World
    """As it was when somebody told."""
    known_at: float
    """[s]"""
    world: World
    """As it is now, as far as is known."""
    goals: tuple[FloatArray, ...]
    """Not reached yet, on the ground [m], each shape (3,)."""
    routes: tuple[Route, ...]
    """To all of them, or none where they are to be found again."""
    at_random: bool

    @property
    def has_arrived(self) -> bool:
        """Whether there is nowhere left to go."""
        return not (self.goals or self.at_random)

    @property
    def route(self) -> Route | None:
        """To the next goal."""
        return self.routes[0] if self.routes else None

    def told(self, news: World | News | None, time: float) -> Aims:
        """What it aims at after news at a time [s]."""
        if news is None and not self.known.moves:
            return self
        news, elapsed = news if isinstance(news, News) else News(world=news), time - self.known_at
        if news.world is None:
            world = moved_on(self.known, seconds=elapsed)
            aims = replace(self, world=world, routes=self.routes if world is self.world else ())
        else:
            known = measure_velocities(news.world, self.known, seconds=elapsed)
            aims = replace(self, known=known, known_at=time, world=known, routes=())
        if news.goals is None:
            return aims
        goals = _goals(news.goals)
        if not np.isfinite(goals).all():
            raise _not_finite(goals)
        return replace(aims, goals=tuple(_on_ground(aims.world, goals)), routes=(), at_random=not len(goals))

    def passed(self, place: FloatArray, options: WanderOptions) -> Aims:
        """The same without a goal that it is at, in a place (3,)."""
        if not self.routes:
            return self
        apart = np.abs(place - self.routes[0].goal)
        if np.hypot(apart[0], apart[2]) > options.arrival or apart[1] > self.routes[0].step:
            return self
        return replace(self, goals=self.goals[1:], routes=self.routes[1:])


def find_aims(
    finder: RouteFinder,
    wanderers: Wanderers,
    goals: Sequence[Sequence[FloatArray]],
    *,
    options: WanderOptions,
    start_time: float,
) -> tuple[Wanderers, list[Aims | PlanError]]:
    """Where N stand in a finder's world, with room for both feet, and what they aim at, or why they cannot."""
    world, starts = finder.world, wanderers.positions
    clear = is_clear(world, starts[:, [0, 2]], starts[:, 1], radius=options.radius, step=options.step)
    wanderers, faults = sound_stands(wanderers, np.flatnonzero(clear), world.ground, options=options)
    found: list[Aims | PlanError] = []
    for row, ends in enumerate(_find_ends(world, goals, options)):
        fault = _start_fault(starts[row], bool(clear[row]), faults[row])
        if fault:
            found.append(fault)
        elif isinstance(ends, PlanError):
            found.append(ends)
        else:
            found.append(Aims(known=world, known_at=start_time, world=world, goals=ends, routes=(), at_random=not ends))
    begun = [row for row, aim in enumerate(found) if isinstance(aim, Aims)]
    places = wanderers.positions[begun]
    ways = find_routes(finder, places, [aim.goals for aim in found if isinstance(aim, Aims)], options=options)
    for row, routes in zip(begun, ways, strict=True):
        aim = found[row]
        if isinstance(routes, PlanError):
            found[row] = routes
        elif isinstance(aim, Aims):
            found[row] = replace(aim, routes=routes)
    return wanderers, found


def _start_fault(start: FloatArray, is_clear: bool, fault: str) -> PlanError | None:
    """What is wrong with a start (3,): there is no room to stand, or a foot has a fault there."""
    where = f"start ({start[0]:.2f}, {start[2]:.2f}) m"
    if not is_clear:
        what = "is too close to an obstacle, out of bounds or off the ground"
        return PlanError(where, what, "start where there is room to stand")
    if fault:
        return PlanError(where, f"is no place to stand: a foot {fault}", "start where there is room for both feet")
    return None


def _find_ends(
    world: World, goals: Sequence[Sequence[FloatArray]], options: WanderOptions
) -> list[tuple[FloatArray, ...] | PlanError]:
    """The goals of each on the ground, or what is wrong with one: no number, too low a ceiling."""
    first = np.cumsum([0, *(len(own) for own in goals)])
    places = _goals([goal for own in goals for goal in own])
    finite = np.flatnonzero(np.isfinite(places).all(axis=1))
    places[finite] = _on_ground(world, places[finite])
    needed = HEADROOM * options.body.leg_length
    rooms = np.full(len(places), np.nan)
    rooms[finite] = needed
    if world.ground is not None:
        rooms[finite] = rooms_above(places[finite][:, [0, 2]], places[finite, 1], world.ground, options=options)
    return [_ends(places[own], rooms[own], needed) for own in (slice(*ends) for ends in pairwise(first))]


def _ends(places: FloatArray, rooms: FloatArray, needed: float) -> tuple[FloatArray, ...] | PlanError:
    """Places (G, 3) with so much room above them (G,) [m], NaN where they are not finite, or what is wrong."""
    if np.isnan(rooms).any():
        return _not_finite(places)
    for (x, y, z), room in zip(places, rooms, strict=True):
        if room < needed:
            what = f"has only {room:.2f} m of room above it, a body needs {needed:.2f} m"
            return PlanError(f"goal ({x:.2f}, {z:.2f}) m, height {y:.2f} m", what, "move it to where one can stand")
    return tuple(places)


def _goals(given: Sequence[FloatArray]) -> FloatArray:
    """Goals (3,) [m] together, those that are none as numbers that are not finite, shape (G, 3)."""
    none = np.full(3, np.nan)
    return np.array([goal if np.shape(goal) == (3,) else none for goal in given], dtype=float).reshape(-1, 3)


def _not_finite(goals: FloatArray) -> PlanError:
    """What is wrong with goals (G, 3) of which one is not finite."""
    (stray, *_) = goals[~np.isfinite(goals).all(axis=1)]
    return PlanError("goal", f"is at {stray}", "give a goal three finite numbers")


def look_ahead(
    aims: Sequence[Aims], places: FloatArray, finders: Mapping[int, RouteFinder], *, options: WanderOptions
) -> tuple[list[Aims], Looks]:
    """The same with routes from places (N, 3), and what each sees of its way.

    Args:
        aims: N of them.
        places: Where they are (x, y, z) [m], shape (N, 3).
        finders: Of routes in their worlds, by the worlds' id.
        options: How they wander.
    """
    aims = list(aims)
    _route(aims, places, finders, options)
    looks = look_along([aim.route for aim in aims], places, ahead=AHEAD * options.look_ahead)
    strayed = np.flatnonzero(looks.led == STRAYED)
    if not strayed.size:
        return aims, looks
    for finder, own in _by_finder([aims[row] for row in strayed], finders):
        rows = strayed[own]
        routes = [route for route in (aims[row].route for row in rows) if route]
        for row, route in zip(rows, finder.extended(routes, places[rows]), strict=True):
            aims[row] = replace(aims[row], routes=(route, *aims[row].routes[1:]))
    again = look_along([aims[row].route for row in strayed], places[strayed], ahead=AHEAD * options.look_ahead)
    return aims, looks.with_rows(strayed, again)


def _route(aims: list[Aims], places: FloatArray, finders: Mapping[int, RouteFinder], options: WanderOptions) -> None:
    """Put routes from places (N, 3) into those that have none and need one."""
    lost = np.array([row for row, aim in enumerate(aims) if aim.goals and not aim.routes], dtype=int)
    for finder, own in _by_finder([aims[row] for row in lost], finders):
        rows = lost[own]
        for row, routes in zip(
            rows, find_near(finder, places[rows], [aims[row].goals for row in rows], options=options), strict=True
        ):
            aims[row] = replace(aims[row], routes=routes)


def _by_finder(aims: Sequence[Aims], finders: Mapping[int, RouteFinder]) -> list[tuple[RouteFinder, list[int]]]:
    """The finders of the worlds they are in, and who is in each."""
    rows: dict[int, list[int]] = {}
    for row, aim in enumerate(aims):
        rows.setdefault(id(aim.world), []).append(row)
    return [(finders[world], own) for world, own in rows.items()]


def _on_ground(world: World, points: FloatArray) -> FloatArray:
    """Points (G, 3) on the ground of the level below or just above them; off the ground they stay."""
    if world.ground is None or not world.ground.has_terrain:
        return points
    sample = world.ground.heights(points[:, [0, 2]], points[:, 1])
    return np.column_stack([points[:, 0], np.where(sample.hit, sample.heights, points[:, 1]), points[:, 2]])


def finder_in(world: World, options: WanderOptions) -> RouteFinder:
    """Finds the routes of those who wander in a world."""
    return RouteFinder(world, step=options.step, headroom=HEADROOM * options.body.leg_length)
