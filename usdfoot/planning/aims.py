"""Aims: where those that wander want to go, in the world as each knows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.planning.moving import measure_velocities, moved_on
from usdfoot.planning.routes import Route, RouteFinder
from usdfoot.planning.spots import HEADROOM
from usdfoot.planning.wanderer import WanderOptions
from usdfoot.planning.world import World, is_clear

__all__ = ["Aims", "News", "find_aims", "finder_in"]


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
        goals = tuple(_on_ground(aims.world, np.asarray(goal, dtype=float)) for goal in news.goals)
        return replace(aims, goals=goals, routes=(), at_random=not goals)

    def routed(self, place: FloatArray, options: WanderOptions, finder: RouteFinder) -> Aims:
        """The same with routes from a place (3,)."""
        if self.routes or not self.goals:
            return self
        routes = _routes(finder, place, self.goals, options, must_reach=False)
        return replace(self, routes=tuple(routes))

    def passed(self, place: FloatArray, options: WanderOptions) -> Aims:
        """The same without a goal that it is at, in a place (3,)."""
        if not self.routes:
            return self
        apart = np.abs(place - self.routes[0].goal)
        if np.hypot(apart[0], apart[2]) > options.arrival or apart[1] > self.routes[0].step:
            return self
        return replace(self, goals=self.goals[1:], routes=self.routes[1:])


def find_aims(
    world: World,
    starts: FloatArray,
    goals: Sequence[Sequence[FloatArray]],
    *,
    options: WanderOptions,
    start_time: float,
) -> list[Aims | PlanError]:
    """What those aim at who begin at starts (N, 3), or why they cannot."""
    places, heights = starts[:, [0, 2]], starts[:, 1]
    clear = is_clear(world, places, heights, radius=options.radius, step=options.step)
    found: list[Aims | PlanError] = []
    finder = finder_in(world, options)
    for start, own, stands in zip(starts, goals, clear, strict=True):
        try:
            if not stands:
                what = "is too close to an obstacle, out of bounds or off the ground"
                raise PlanError(f"start ({start[0]:.2f}, {start[2]:.2f}) m", what, "start where there is room to stand")
            ends = tuple(_on_ground(world, np.asarray(goal, dtype=float)) for goal in own)
            routes = tuple(_routes(finder, start, ends, options))
        except PlanError as error:
            found.append(error)
            continue
        found.append(Aims(known=world, known_at=start_time, world=world, goals=ends, routes=routes, at_random=not ends))
    return found


def _on_ground(world: World, point: FloatArray) -> FloatArray:
    """The point (3,) on the ground of the level below or just above it."""
    if not np.isfinite(point).all():
        raise PlanError("goal", f"is at {point}", "give a goal three finite numbers")
    if world.ground is None or not world.ground.has_terrain:
        return point
    sample = world.ground.heights(point[None, [0, 2]], point[[1]])
    return np.array([point[0], sample.heights[0], point[2]]) if sample.hit[0] else point


def finder_in(world: World, options: WanderOptions) -> RouteFinder:
    """Finds the routes of those who wander in a world."""
    return RouteFinder(world, step=options.step, headroom=HEADROOM * options.body.leg_length)


def _routes(
    finder: RouteFinder,
    place: FloatArray,
    goals: Sequence[FloatArray],
    options: WanderOptions,
    *,
    must_reach: bool = True,
) -> list[Route]:
    """Routes to goals (3,), each reached from the one before, the first from a place (3,).

    Raises:
        PlanError: If a goal is not clear or, if it must be, cannot be reached.
    """
    routes: list[Route] = []
    half_depth = options.body.half_depth(options.radius)
    for goal in goals:
        for radius in dict.fromkeys((options.radius, half_depth)):
            route = finder.find(place, goal, radius=radius, must_be_clear=must_reach)
            if route.find(place[None])[0] >= 0:
                break
        if must_reach and route.find(place[None])[0] < 0:
            raise PlanError(
                f"goal ({goal[0]:.2f}, {goal[2]:.2f}) m, height {goal[1]:.2f} m",
                f"cannot be reached from ({place[0]:.2f}, {place[2]:.2f}) m, height {place[1]:.2f} m, "
                f"on foot by a body {2 * options.radius:.2f} m wide, sideways {2 * half_depth:.2f} m",
                "open a way, join the levels by a ramp or stairs, or move the goal",
            )
        routes.append(route)
        place = goal
    return routes
