"""Wandering: one footstep at a time through a world that may change, at random or towards goals ([P] 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from usdfoot.analysis.timing import STAND_TIME, time_footsteps
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.free_ways import choose_facing, choose_step
from usdfoot.planning.moving import measure_velocities, moved_on
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.routes import Route, find_route
from usdfoot.planning.spots import HEADROOM
from usdfoot.planning.wanderer import SIDEWAYS, Footstep, Wanderer, WanderOptions, lay_footstep, take_step
from usdfoot.planning.world import World, is_clear

__all__ = ["Footstep", "News", "WanderOptions", "join_footsteps", "plan_wander", "wander"]


@dataclass(frozen=True, kw_only=True)
class News:
    """What one that wanders is told before its next step; a world is everybody's, goals are its own."""

    world: World | None = None
    """As it is now; None = as before."""
    goals: Sequence[FloatArray] | None = None
    """Places to go to instead of those it has not reached (x, y, z) [m], each shape (3,); none = wander at random;
    None = as before."""


def wander(
    world: World,
    start: FloatArray,
    yaw: float,
    *,
    generator: np.random.Generator,
    goals: Sequence[FloatArray] = (),
    options: WanderOptions | None = None,
    start_time: float = 0.0,
) -> Generator[Footstep, World | News | None, None]:
    """Footsteps one at a time; `send` instead of `next` tells of a world that has changed, or news of goals that have.

    It stands, then walks: at random for ever, or from goal to goal until it stands at the last, where it ends unless it
    is sent another. When the way ahead leads too close to an obstacle, the bounds or bad ground, directions are drawn
    at random around the wanted one, ever farther from it, until one is free; where none is, it takes the freest, with
    short steps and on the spot if need be. To a goal to which no way is as wide as the body it side-steps through those
    that are wide enough for that. What is sent may shut a goal in, or put it where nobody can stand: then it goes as
    near to it as it gets, and treads on the spot.
    An obstacle with a velocity is avoided where it will be when the wanderer gets there, and goes on until a new world
    says where it is; one without gets that at which it has moved from the world told before.
    The same generator and worlds give the same footsteps.

    Args:
        world: Bounds, obstacles, terrain.
        start: Between the feet [m], shape (3,).
        yaw: Where it looks [rad].
        generator: Draws the directions.
        goals: Places to go to (x, y, z) [m], each shape (3,); none = wander at random.
        options: How.
        start_time: When it stands there [s]; it does so for `stand_time`.

    Raises:
        PlanError: If start or a goal is in an obstacle, out of bounds or off the ground, or a goal cannot be reached.
    """
    options = options or WanderOptions()
    wanderer = Wanderer(place=np.asarray(start, dtype=float)[[0, 2]], height=float(start[1]), yaw=yaw, side=LEFT)
    here = wanderer.place[None], np.array([wanderer.height])
    if not is_clear(world, *here, radius=options.radius, step=options.step)[0]:
        x, z = wanderer.place
        what = "is too close to an obstacle, out of bounds or off the ground"
        raise PlanError(f"start ({x:.2f}, {z:.2f}) m", what, "start where there is room to stand")
    places = [_on_ground(world, np.asarray(goal, dtype=float)) for goal in goals]
    routes = _routes(world, wanderer.position, places, options)
    aims = _Aims(
        known=world,
        known_at=start_time,
        world=world,
        goals=tuple(places),
        routes=tuple(routes),
        at_random=not places,
    )
    for before in [lay_footstep(wanderer, side, world, options=options, time=start_time) for side in (RIGHT, LEFT)]:
        aims = aims.told((yield before), before.strike_time)
    before = replace(before, strike_time=before.strike_time + options.stand_time)
    while True:
        stands = not (aims.goals or aims.at_random)
        aims = aims.routed(wanderer.position, options)
        if stands:
            wanderer = _close_up(wanderer, aims.world, options)
        else:
            wanderer = _step_on(wanderer, aims.world, aims.routes, generator, options)
        before = lay_footstep(wanderer, wanderer.side, aims.world, options=options, before=before)
        news = yield before
        aims = aims.passed(wanderer, options).told(news, before.strike_time)
        if stands and not (aims.goals or aims.at_random):
            return


@dataclass(frozen=True, kw_only=True)
class _Aims:
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

    def told(self, news: World | News | None, time: float) -> _Aims:
        """What it aims at after news at a time [s]."""
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

    def routed(self, place: FloatArray, options: WanderOptions) -> _Aims:
        """The same with routes from a place (3,)."""
        if self.routes or not self.goals:
            return self
        routes = _routes(self.world, place, self.goals, options, must_reach=False)
        return replace(self, routes=tuple(routes))

    def passed(self, wanderer: Wanderer, options: WanderOptions) -> _Aims:
        """The same without a goal that it is at."""
        if not (self.routes and _is_at(wanderer, self.routes[0], options)):
            return self
        return replace(self, goals=self.goals[1:], routes=self.routes[1:])


def _step_on(
    wanderer: Wanderer, world: World, routes: Sequence[Route], generator: np.random.Generator, options: WanderOptions
) -> Wanderer:
    """The wanderer a step on, along the first route if there is one; it waits where that gets no nearer to the goal."""
    if routes and routes[0].falls_short:
        spot = routes[0].find(wanderer.position)
        if spot >= 0 and routes[0].distances[spot] <= options.arrival:
            return _close_up(wanderer, world, options)
    length, turn, spin = choose_step(wanderer, world, routes, generator=generator, options=options)
    facing = choose_facing(wanderer, turn, world, routes=routes, options=options)
    turned = max(facing, wanderer.facing)
    length = min(length, float(np.interp(turned, (0.0, SIDEWAYS), (length, options.side_step))))
    return replace(take_step(wanderer, length, turn, world=world, options=options), spin=spin, facing=facing)


def _close_up(wanderer: Wanderer, world: World, options: WanderOptions) -> Wanderer:
    """The wanderer with its feet side by side."""
    return replace(take_step(wanderer, 0.0, 0.0, world=world, options=options), facing=wanderer.facing)


def plan_wander(
    world: World,
    start: FloatArray,
    yaw: float,
    *,
    generator: np.random.Generator,
    goals: Sequence[FloatArray] = (),
    steps: int = 40,
    options: WanderOptions | None = None,
    start_time: float = 0.0,
    later: Callable[[float], World] | None = None,
    name: str = "wander",
) -> FootstepPlan:
    """The plan of `steps` footsteps of `wander`, or of those it takes to the last goal if that is fewer.

    It is told `later`, the world at a time [s], as each foot is down.

    Raises:
        PlanError: As `wander`; if there are fewer than two steps.
    """
    options = options or WanderOptions()
    way = wander(world, start, yaw, generator=generator, goals=goals, options=options, start_time=start_time)
    told = way if later is None else _told(way, later, start_time + options.stand_time)
    footsteps = list(islice(told, steps))
    ends_standing = len(footsteps) < steps
    return join_footsteps(
        footsteps,
        name=name,
        body=options.body,
        ends_standing=ends_standing,
        stand_time=options.stand_time,
    )


def _told(
    way: Generator[Footstep, World | News | None, None], later: Callable[[float], World], departure: float
) -> Iterator[Footstep]:
    """Footsteps of one that is told the world as it is when it takes each, the first at its `departure` [s]."""
    try:
        footstep = next(way)
        while True:
            yield footstep
            footstep = way.send(later(max(footstep.strike_time, departure)))
    except StopIteration:
        return


def join_footsteps(
    footsteps: Iterable[Footstep],
    *,
    name: str,
    body: Proportions | None = None,
    speed: float = 0.0,
    ends_standing: bool = False,
    stand_time: float = STAND_TIME,
) -> FootstepPlan:
    """The plan of footsteps as they came.

    Args:
        footsteps: From `wander`, the first two of which stand.
        name: Of the plan.
        body: That walks.
        speed: Mean of all steps [m/s]; 0 = as fast as such steps are.
        ends_standing: Whether it stands at the end, as `wander` does at its last goal.
        stand_time: How long it stands before the first step [s].
    """
    body = body or Proportions()
    steps = list(footsteps)
    if len(steps) < 2:
        raise PlanError(name, f"has {len(steps)} footstep(s)", "let it take at least two")
    positions = np.array([step.position for step in steps])
    times = time_footsteps(
        positions,
        body.timing,
        speed=speed,
        start_time=steps[0].strike_time,
        starts_standing=True,
        ends_standing=ends_standing,
        stand_time=stand_time,
    )
    return FootstepPlan(
        name=name,
        sides=np.array([step.side for step in steps]),
        positions=positions,
        orientations=np.array([step.orientation for step in steps]),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(len(steps)),
    )


def _on_ground(world: World, point: FloatArray) -> FloatArray:
    """The point (3,) on the ground of the level below or just above it."""
    if not np.isfinite(point).all():
        raise PlanError("goal", f"is at {point}", "give a goal three finite numbers")
    if world.ground is None or not world.ground.has_terrain:
        return point
    sample = world.ground.heights(point[None, [0, 2]], point[[1]])
    return np.array([point[0], sample.heights[0], point[2]]) if sample.hit[0] else point


def _routes(
    world: World, place: FloatArray, goals: Sequence[FloatArray], options: WanderOptions, *, must_reach: bool = True
) -> list[Route]:
    """Routes to goals (3,), each reached from the one before, the first from a place (3,).

    Raises:
        PlanError: If a goal is not clear or, if it must be, cannot be reached.
    """
    headroom, routes = HEADROOM * options.body.leg_length, []
    half_depth = options.body.half_depth(options.radius)
    for goal in goals:
        for radius in dict.fromkeys((options.radius, half_depth)):
            route = find_route(
                world,
                place,
                goal,
                radius=radius,
                step=options.step,
                headroom=headroom,
                must_be_clear=must_reach,
            )
            if route.find(place) >= 0:
                break
        if must_reach and route.find(place) < 0:
            raise PlanError(
                f"goal ({goal[0]:.2f}, {goal[2]:.2f}) m, height {goal[1]:.2f} m",
                f"cannot be reached from ({place[0]:.2f}, {place[2]:.2f}) m, height {place[1]:.2f} m, "
                f"on foot by a body {2 * options.radius:.2f} m wide, sideways {2 * half_depth:.2f} m",
                "open a way, join the levels by a ramp or stairs, or move the goal",
            )
        routes.append(route)
        place = goal
    return routes


def _is_at(wanderer: Wanderer, route: Route, options: WanderOptions) -> bool:
    apart = np.abs(wanderer.position - route.goal)
    return bool(np.hypot(apart[0], apart[2]) <= options.arrival and apart[1] <= route.step)
