"""Wandering: one footstep at a time through a world that may change, at random or towards goals ([P] 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import replace

import numpy as np

from usdfoot.analysis.timing import STAND_TIME, time_footsteps
from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.aims import Aims, News, find_aims, finder_in
from usdfoot.planning.free_ways import DRAWS, choose_facings, choose_steps
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.routes import Route
from usdfoot.planning.wanderer import (
    SIDEWAYS,
    Footstep,
    Footsteps,
    Wanderers,
    WanderOptions,
    concatenated,
    joined,
    lay_footsteps,
    rows_of,
    set_out,
    take_steps,
)
from usdfoot.planning.world import World

__all__ = ["Footstep", "News", "WanderOptions", "join_footsteps", "plan_wander", "plan_wanders", "wander"]


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
    starts = np.asarray(start, dtype=float)[None]
    (aims,) = find_aims(world, starts, [goals], options=options, start_time=start_time)
    if isinstance(aims, PlanError):
        raise aims
    way = _walk(
        set_out(starts, np.array([yaw], dtype=float), np.array([options.speed]), options=options),
        [aims],
        generators=[generator],
        options=options,
        start_time=start_time,
    )
    for _, footsteps in way:
        news = yield footsteps.of(0)
        while news is not None:
            try:
                _, footsteps = way.send([news])
            except StopIteration:
                return
            news = yield footsteps.of(0)


def _walk(
    wanderers: Wanderers,
    aims: Sequence[Aims],
    *,
    generators: Sequence[np.random.Generator],
    options: WanderOptions,
    start_time: float,
) -> Generator[tuple[IntArray, Footsteps], Sequence[World | News | None] | None, None]:
    """Who of N takes another step, and their footsteps; they are told what is sent, in the same order.

    All step at once, each as it would alone.
    """
    rows, aims = np.arange(len(wanderers)), list(aims)
    both = [_lay(wanderers, aims, np.full(len(rows), side), options, time=start_time) for side in (RIGHT, LEFT)]
    for footsteps in both:
        aims = _told(aims, (yield rows, footsteps), footsteps)
    before = replace(both[-1], strike_times=both[-1].strike_times + options.stand_time)
    while rows.size:
        stood = np.array([aim.has_arrived for aim in aims])
        finders = {id(aim.world): finder_in(aim.world, options) for aim in aims}
        standing = zip(aims, wanderers.positions, strict=True)
        aims = [aim.routed(place, options, finders[id(aim.world)]) for aim, place in standing]
        wanderers = _step(wanderers, aims, stood, [generators[int(row)] for row in rows], options)
        before = _lay(wanderers, aims, wanderers.sides, options, before=before)
        news = yield rows, before
        places = wanderers.positions
        aims = [aim.passed(place, options) for aim, place in zip(aims, places, strict=True)]
        aims = _told(aims, news, before)
        kept = np.flatnonzero(~(stood & [aim.has_arrived for aim in aims]))
        if len(kept) < len(rows):
            rows, aims = rows[kept], [aims[row] for row in kept]
            wanderers, before = rows_of(wanderers, kept), rows_of(before, kept)


def _told(aims: Sequence[Aims], news: Sequence[World | News | None] | None, footsteps: Footsteps) -> list[Aims]:
    """What they aim at after news, each as its foot is down."""
    everyone = zip(aims, news or [None] * len(aims), footsteps.strike_times, strict=True)
    return [aim.told(own, float(time)) for aim, own, time in everyone]


def _by_world(aims: Sequence[Aims]) -> list[tuple[World, IntArray]]:
    """The worlds they are in, and who is in each."""
    numbers = np.array([id(aim.world) for aim in aims])
    worlds = {id(aim.world): aim.world for aim in aims}
    return [(world, np.flatnonzero(numbers == number)) for number, world in worlds.items()]


def _lay(
    wanderers: Wanderers,
    aims: Sequence[Aims],
    sides: IntArray,
    options: WanderOptions,
    *,
    before: Footsteps | None = None,
    time: float = 0.0,
) -> Footsteps:
    """The footsteps of one foot of each in its world; see `lay_footsteps`."""
    parts = [(own, world.ground) for world, own in _by_world(aims)]
    laid = [
        lay_footsteps(
            rows_of(wanderers, own),
            sides[own],
            ground=ground,
            options=options,
            before=None if before is None else rows_of(before, own),
            time=time,
        )
        for own, ground in parts
    ]
    return joined(laid, [own for own, _ in parts])


def _step(
    wanderers: Wanderers,
    aims: Sequence[Aims],
    stood: BoolArray,
    generators: Sequence[np.random.Generator],
    options: WanderOptions,
) -> Wanderers:
    """The wanderers a step on in their worlds; who stands, or waits, closes up its feet."""
    parts = _by_world(aims)
    stepped = []
    for world, own in parts:
        some, routes = rows_of(wanderers, own), [aims[row].route for row in own]
        goes = np.flatnonzero(~(stood[own] | _waits(some, routes, options)))
        draws = np.array([generators[int(row)].standard_normal(1 + DRAWS) for row in own[goes]]).reshape(-1, 1 + DRAWS)
        stepped.append(_step_on(some, world, routes, goes, draws=draws, options=options))
    return joined(stepped, [own for _, own in parts])


def _waits(wanderers: Wanderers, routes: Sequence[Route | None], options: WanderOptions) -> BoolArray:
    """Who is where its way ends short of the goal, shape (N,)."""
    waits = np.zeros(len(wanderers), dtype=bool)
    for row, route in enumerate(routes):
        if route and route.falls_short:
            spot = int(route.find(wanderers.positions[[row]])[0])
            waits[row] = spot >= 0 and route.distances[spot] <= options.arrival
    return waits


def _step_on(
    wanderers: Wanderers,
    world: World,
    routes: Sequence[Route | None],
    goes: IntArray,
    *,
    draws: FloatArray,
    options: WanderOptions,
) -> Wanderers:
    """Those of a world a step on: who goes (M,) along its route if there is one, the others on the spot."""
    lengths, turns, facings = np.zeros(len(wanderers)), np.zeros(len(wanderers)), wanderers.facings.copy()
    spins = np.zeros(len(wanderers), dtype=int)
    if goes.size:
        some, own = rows_of(wanderers, goes), [routes[row] for row in goes]
        free, turns[goes], spins[goes] = choose_steps(some, world, own, draws=draws, options=options)
        facings[goes] = choose_facings(some, turns[goes], world, routes=own, options=options)
        turned = np.maximum(facings[goes], some.facings)
        sidewards = (options.side_step - free) / SIDEWAYS * turned + free
        lengths[goes] = np.minimum(free, np.where(turned < SIDEWAYS, sidewards, options.side_step))
    stepped = take_steps(wanderers, lengths, turns, ground=world.ground, options=options)
    return replace(stepped, spins=spins, facings=facings)


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
    (plan,) = plan_wanders(
        world,
        np.asarray(start, dtype=float)[None],
        np.array([yaw], dtype=float),
        generators=[generator],
        goals=[goals],
        steps=steps,
        options=options,
        start_time=start_time,
        later=later,
        names=[name],
    )
    if isinstance(plan, PlanError):
        raise plan
    return plan


def plan_wanders(
    world: World,
    starts: FloatArray,
    yaws: FloatArray,
    *,
    generators: Sequence[np.random.Generator],
    names: Sequence[str],
    goals: Sequence[Sequence[FloatArray]] | None = None,
    speeds: FloatArray | None = None,
    steps: int = 40,
    options: WanderOptions | None = None,
    start_time: float = 0.0,
    later: Callable[[float], World] | None = None,
) -> list[FootstepPlan | PlanError]:
    """Plans of N who wander in one world, each as by `plan_wander` alone, or why there is none.

    All take each footstep at once. They do not see each other. The route to each goal, 100 bytes a cell of
    half a radius, is held until all have arrived.

    Args:
        world: Bounds, obstacles, terrain.
        starts: Between the feet [m], shape (N, 3).
        yaws: Where they look [rad], shape (N,).
        generators: Of each.
        names: Of the plans.
        goals: Of each; None = all wander at random.
        speeds: Of each instead of the options' [m/s], shape (N,); None = all go at that.
        steps: Footsteps of each at most.
        options: How they wander.
        start_time: When they stand there [s].
        later: The world at a time [s], asked for as each foot is down; None = nobody is told.

    Raises:
        PlanError: If there are fewer than two steps.
    """
    options = options or WanderOptions()
    count = len(starts)
    aims = find_aims(world, starts, goals or [()] * count, options=options, start_time=start_time)
    begun = np.array([number for number, aim in enumerate(aims) if isinstance(aim, Aims)], dtype=int)
    paced = np.full(count, options.speed) if speeds is None else speeds
    way = _walk(
        set_out(starts[begun], yaws[begun], paced[begun], options=options),
        [aim for aim in aims if isinstance(aim, Aims)],
        generators=[generators[number] for number in begun],
        options=options,
        start_time=start_time,
    )
    taken = iter(_first_footsteps(way, steps, later, departure=start_time + options.stand_time) if begun.size else ())
    return [
        aim if isinstance(aim, PlanError) else _plan(next(taken), name, options, most=steps)
        for aim, name in zip(aims, names, strict=True)
    ]


def _first_footsteps(
    way: Generator[tuple[IntArray, Footsteps], Sequence[World | News | None] | None, None],
    steps: int,
    later: Callable[[float], World] | None,
    *,
    departure: float,
) -> list[Footsteps]:
    """The first footsteps of each on a way, told the world as it is when each is taken, but for stands [s]."""
    rounds: list[tuple[IntArray, Footsteps]] = []
    while len(rounds) < steps:
        news = None
        if later and rounds:
            news = [later(max(float(time), departure)) for time in rounds[-1][1].strike_times]
        try:
            rounds.append(way.send(news) if news else next(way))
        except StopIteration:
            break
    owners = np.concatenate([rows for rows, _ in rounds])
    order = np.argsort(owners, kind="stable")
    ends = np.cumsum(np.bincount(owners))[:-1]
    together = concatenated([footsteps for _, footsteps in rounds])
    return [rows_of(together, own) for own in np.split(order, ends)]


def _plan(footsteps: Footsteps, name: str, options: WanderOptions, *, most: int) -> FootstepPlan:
    """The plan of one's footsteps, standing at the end if they are fewer than asked for."""
    count = len(footsteps.sides)
    return join_footsteps(
        [footsteps.of(row) for row in range(count)],
        name=name,
        body=options.body,
        ends_standing=count < most,
        stand_time=options.stand_time,
    )


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
