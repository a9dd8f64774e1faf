"""Legs: routes from goal to goal, as wide as a body or else wide enough to side-step through."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.planning.route_kernel import LED
from usdfoot.planning.routes import Route, RouteFinder, look_along
from usdfoot.planning.wanderer import WanderOptions
from usdfoot.planning.world import World, clearances

__all__ = ["find_near", "find_routes"]


def find_routes(
    finder: RouteFinder, places: FloatArray, goals: Sequence[Sequence[FloatArray]], *, options: WanderOptions
) -> list[tuple[Route, ...] | PlanError]:
    """Routes from places (N, 3) to the goals (3,) of each, every one from the one before, or why there are none.

    Where the lattice that all share shows no way over a terrain, one with the goal may, before narrower ways are taken.
    """
    starts, ends = _legs(places, goals)
    clear = clearances(finder.world, ends[:, [0, 2]], ends[:, 1]) >= options.radius
    found: list[Route | PlanError] = [
        _no_way(start, end, options) if free else _not_clear(finder.world, end, options.radius)
        for start, end, free in zip(starts, ends, clear, strict=True)
    ]
    left, terrain = np.flatnonzero(clear), finder.world.ground is not None and finder.world.ground.has_terrain
    for radius in _radii(options):
        for own_lattice in (False, True) if terrain else (False,):
            tried = finder.find(starts[left], ends[left], radius=radius, own_lattice=own_lattice)
            led = look_along([_route(route) for route in tried], starts[left]).led == LED
            for row, route, arrives in zip(left, tried, led, strict=True):
                if arrives or isinstance(route, PlanError):
                    found[row] = route
            left = left[
                [isinstance(found[row], PlanError) and isinstance(tried[n], Route) for n, row in enumerate(left)]
            ]
    return _by_owner(found, goals)


def find_near(
    finder: RouteFinder, places: FloatArray, goals: Sequence[Sequence[FloatArray]], *, options: WanderOptions
) -> list[tuple[Route, ...]]:
    """Routes as by `find_routes`, but as near to goals as one gets where there is no way.

    Raises:
        PlanError: If the area is too large.
    """
    starts, ends = _legs(places, goals)
    found: dict[int, Route] = {}
    left = np.arange(len(starts))
    for radius in _radii(options):
        routes = [_checked(route) for route in finder.find(starts[left], ends[left], radius=radius)]
        lost = np.flatnonzero(look_along(routes, starts[left]).led != LED)
        for row, route in zip(lost, finder.shortened([routes[row] for row in lost], starts[left[lost]]), strict=True):
            routes[row] = route
        found |= dict(zip(left.tolist(), routes, strict=True))
        left = left[look_along(routes, starts[left]).led != LED]
    owned = (found[row] for row in range(len(starts)))
    return [tuple(next(owned) for _ in own) for own in goals]


def _legs(places: FloatArray, goals: Sequence[Sequence[FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Starts and ends (x, y, z) [m] of all ways from places (N, 3) to the goals of each, shape (M, 3) each."""
    starts = [start for place, own in zip(places, goals, strict=True) for start in (place, *own)[: len(own)]]
    ends = [goal for own in goals for goal in own]
    return np.array(starts).reshape(-1, 3), np.array(ends).reshape(-1, 3)


def _radii(options: WanderOptions) -> dict[float, None]:
    """Half the width of the ways to look for one after the other [m]: ahead, sideways."""
    return dict.fromkeys((options.radius, options.body.half_depth(options.radius)))


def _by_owner(
    found: Sequence[Route | PlanError], goals: Sequence[Sequence[FloatArray]]
) -> list[tuple[Route, ...] | PlanError]:
    """The routes of each who has so many goals, or the first error among them."""
    owned = iter(found)
    parts = [[next(owned) for _ in own] for own in goals]
    errors = [[route for route in part if isinstance(route, PlanError)] for part in parts]
    return [
        faults[0] if faults else tuple(route for route in part if isinstance(route, Route))
        for part, faults in zip(parts, errors, strict=True)
    ]


def _route(found: Route | PlanError) -> Route | None:
    return found if isinstance(found, Route) else None


def _checked(found: Route | PlanError) -> Route:
    if isinstance(found, PlanError):
        raise found
    return found


def _no_way(place: FloatArray, goal: FloatArray, options: WanderOptions) -> PlanError:
    return PlanError(
        f"goal ({goal[0]:.2f}, {goal[2]:.2f}) m, height {goal[1]:.2f} m",
        f"cannot be reached from ({place[0]:.2f}, {place[2]:.2f}) m, height {place[1]:.2f} m, on foot by a body "
        f"{2 * options.radius:.2f} m wide, sideways {2 * options.body.half_depth(options.radius):.2f} m",
        "open a way, join the levels by a ramp or stairs, or move the goal",
    )


def _not_clear(world: World, goal: FloatArray, radius: float) -> PlanError:
    """What is wrong with a goal, and what would be right."""
    where = f"goal ({goal[0]:.2f}, {goal[2]:.2f}) m"
    for obstacle in world.obstacles:
        alone = World(obstacles=(obstacle,))
        if clearances(alone, goal[None, [0, 2]], goal[[1]])[0] < radius:
            return PlanError(where, f"is within {radius:.2f} m of the obstacle {obstacle.name}", "move it away")
    return PlanError(where, f"is outside the bounds or within {radius:.2f} m of them", "move it inside")
