"""Routes: the shortest ways to goals around obstacles and over passable ground, on every level, on a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.planning.route_grid import Lattice
from usdfoot.planning.route_kernel import NOWHERE
from usdfoot.planning.route_searches import Ends, Looks, Searched, find_starts, look_from
from usdfoot.planning.route_windows import RouteWindows
from usdfoot.planning.world import World

__all__ = ["Route", "RouteFinder", "look_along"]

MOST_CELLS = 4_000_000


@dataclass(frozen=True, kw_only=True)
class Route:
    """The ways to a goal, as far as they were looked for."""

    goal: FloatArray
    """On the ground [m], shape (3,)."""
    end: Ends
    """Where the ways end, a single one."""
    lattice: Lattice
    """Over whose cells they lead."""
    searched: Searched
    """What is known of them."""
    row: int
    """Which of its searches knows it."""
    step: float
    """Highest step on the way [m]; infinite without terrain, where heights mean nothing."""
    falls_short: bool = False
    """Whether there is no way to the goal from the start, and the way leads as near to it as one gets from there."""

    @property
    def radius(self) -> float:
        """Half the width of the narrowest places of the way [m], at least."""
        return 2.0 * self.lattice.cell


class RouteFinder:
    """Finds the ways to goals in one world.

    How long a way is, and over which spots it leads, depends on nothing but the world, the goal and, without bounds,
    the start: not on what else is asked for.

    Args:
        world: Bounds, obstacles, terrain; without bounds routes stay within 10 m of start, goal and obstacles.
        step: Highest rise of the ground from cell to cell [m].
        headroom: Free height that the body needs [m].
    """

    def __init__(self, world: World, *, step: float, headroom: float) -> None:
        self.world, self._windows = world, RouteWindows(world, step=step, headroom=headroom)

    def find(
        self, starts: FloatArray, goals: FloatArray, *, radius: float, own_lattice: bool = False
    ) -> list[Route | PlanError]:
        """Routes from starts to goals, or why they cannot be looked for; `look_along` says whether they lead there.

        Args:
            starts: (x, y, z) [m], shape (N, 3).
            goals: On the ground (x, y, z) [m], shape (N, 3).
            radius: Of the body [m]; a cell is half of it.
            own_lattice: Whether the ground too is looked at where the goal is a cell's centre: for each goal anew.
        """
        lowest, highest = _extents(self.world, starts, goals)
        counts = np.ceil((highest - lowest) / (0.5 * radius)) + 1.0
        found: list[Route | PlanError] = [_too_large(*size) for size in highest - lowest]
        fits = np.flatnonzero(counts.prod(axis=1) <= MOST_CELLS)
        lowest, counts, goals, cell = lowest[fits], counts[fits].astype(np.int64), goals[fits], 0.5 * radius
        centres = goals[:, [0, 2]]
        cells = np.rint(centres / cell).astype(np.int64)
        origins = centres - cell * cells if own_lattice else np.zeros((len(fits), 2))
        anchors = centres if self._windows.within == np.inf else origins + cell * cells  # spots of a terrain stay
        first = cells - np.rint((centres - lowest) / cell).astype(np.int64) + 1  # nobody stands at the rim
        ends = Ends(places=goals, anchors=anchors, cells=cells, lowest=first, highest=first + counts - 3)
        levels = starts[fits, 1] if self.world.ground is None else np.zeros(len(fits))
        lattices = [
            Lattice(cell=cell, origin=(float(x), float(z)), level=float(level))
            for (x, z), level in zip(origins, levels, strict=True)
        ]
        searched = self._windows.search(ends, starts[fits], lattices)
        for index, (row, lattice, (known, number)) in enumerate(zip(fits, lattices, searched, strict=True)):
            end = ends.of(np.array([index]))
            step = self._windows.within
            found[row] = Route(goal=goals[index], end=end, lattice=lattice, searched=known, row=number, step=step)
        return found

    def extended(self, routes: Sequence[Route], places: FloatArray) -> list[Route]:
        """The routes with the ways to their ends from places (N, 3), one of each."""
        ends, lattices = _joined([route.end for route in routes]), [route.lattice for route in routes]
        found = self._windows.search(ends, places, lattices)
        return [
            replace(route, searched=searched, row=row) for route, (searched, row) in zip(routes, found, strict=True)
        ]

    def shortened(self, routes: Sequence[Route], places: FloatArray) -> list[Route]:
        """The routes to as near to their goals as one gets from places (N, 3), which have no ways there.

        Those of places where nobody can stand stay as they are.
        """
        begins = [
            find_starts(route.searched, np.array([route.row]), place[None])
            for route, place in zip(routes, places, strict=True)
        ]
        stuck = [row for row, begin in enumerate(begins) if begin[0] >= 0]
        found = list(routes)
        if not stuck:
            return found
        ends = _joined([routes[row].end for row in stuck])
        own = [routes[row].searched.places_of(routes[row].row, begins[row])[0] for row in stuck]
        lattices = [routes[row].lattice for row in stuck]
        everywhere = self._windows.search(replace(ends, places=np.array(own)), None, lattices)
        nearest = []
        for number, (searched, row) in zip(stuck, everywhere, strict=True):
            reached = searched.places_of(row, searched.known_spots(row))
            away = np.linalg.norm(reached - routes[number].goal, axis=1)
            nearest.append(reached[np.argmin(away)])
        ends = replace(ends, places=np.array(nearest))
        short = [
            replace(routes[number], end=ends.of(np.array([index])), falls_short=True)
            for index, number in enumerate(stuck)
        ]
        for number, route in zip(stuck, self.extended(short, places[stuck]), strict=True):
            found[number] = route
        return found


def look_along(routes: Sequence[Route | None], places: FloatArray, *, ahead: float = 0.0) -> Looks:
    """What is known of the way from each place (N, 3) along its route; nobody is led without one.

    In plain view is where a straight line leads over spots all the way.

    Args:
        routes: Of each place.
        places: (x, y, z) [m], shape (N, 3).
        ahead: How far to look [m].
    """
    count = len(places)
    led, lengths, aims = np.full(count, NOWHERE), np.full(count, np.inf), np.zeros((count, 2))
    owners = np.array([id(route.searched) if route else 0 for route in routes])
    numbers = np.array([route.row if route else 0 for route in routes])
    for searched in {id(route.searched): route.searched for route in routes if route}.values():
        own = np.flatnonzero(owners == id(searched))
        looks = look_from(searched, numbers[own], places[own], ahead=ahead)
        led[own], lengths[own], aims[own] = looks.led, looks.lengths, looks.aims
    return Looks(led=led, lengths=lengths, aims=aims)


def _joined(ends: Sequence[Ends]) -> Ends:
    """All ends, one after the other."""
    return Ends(**{name: np.concatenate([vars(end)[name] for end in ends]) for name in vars(ends[0])})


def _extents(world: World, starts: FloatArray, goals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corners (x, z) of where ways from starts (N, 3) to goals may lead [m], shape (N, 2) each."""
    if world.bounds is not None:
        shape = len(goals), 2
        return np.broadcast_to(world.bounds.min(axis=0), shape), np.broadcast_to(world.bounds.max(axis=0), shape)
    places = np.stack([starts, goals])[:, :, [0, 2]]
    lowest, highest = places.min(axis=0), places.max(axis=0)
    if world.obstacles:
        corners = np.concatenate([obstacle.outline for obstacle in world.obstacles])
        lowest, highest = np.minimum(lowest, corners.min(axis=0)), np.maximum(highest, corners.max(axis=0))
    return lowest - 10.0, highest + 10.0


def _too_large(width: float, length: float) -> PlanError:
    return PlanError("area", f"is {width:.0f} m by {length:.0f} m, too large for a route", "give narrower bounds")
