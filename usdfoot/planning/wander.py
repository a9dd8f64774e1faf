"""Wandering: one footstep at a time through a world that may change, at random or towards goals ([P] 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.aims import Aims, News, find_aims, finder_in
from usdfoot.planning.joining import join_plans
from usdfoot.planning.strolls import stroll
from usdfoot.planning.wanderer import Footstep, Footsteps, WanderOptions, concatenated, rows_of, set_out
from usdfoot.planning.world import World

__all__ = ["plan_wander", "plan_wanders", "wander"]


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
    finder = finder_in(world, options)
    begun = set_out(starts, np.array([yaw], dtype=float), np.array([options.speed]), options=options)
    begun, (aims,) = find_aims(finder, begun, [goals], options=options, start_time=start_time)
    if isinstance(aims, PlanError):
        raise aims
    way = stroll(
        begun,
        [aims],
        finder=finder,
        generators=[generator],
        options=options,
        start_time=start_time,
    )
    for _, footsteps, _ in way:
        news = yield footsteps.of(0)
        while news is not None:
            try:
                _, footsteps, _ = way.send([news])
            except StopIteration:
                return
            news = yield footsteps.of(0)


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

    All take each footstep at once. They do not see each other. What is known of the ground between starts and goals,
    200 bytes a cell of half a radius, and of each route, 30 kB or more, is held until all have arrived.

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
    count, finder = len(starts), finder_in(world, options)
    paced = np.full(count, options.speed) if speeds is None else speeds
    stood = set_out(starts, yaws, paced, options=options)
    stood, aims = find_aims(finder, stood, goals or [()] * count, options=options, start_time=start_time)
    begun = np.array([number for number, aim in enumerate(aims) if isinstance(aim, Aims)], dtype=int)
    way = stroll(
        rows_of(stood, begun),
        [aim for aim in aims if isinstance(aim, Aims)],
        finder=finder,
        generators=[generators[number] for number in begun],
        options=options,
        start_time=start_time,
    )
    if not begun.size:
        return [aim for aim in aims if isinstance(aim, PlanError)]
    footsteps, counts, standing = _first_footsteps(way, steps, later, departure=start_time + options.stand_time)
    plans = join_plans(
        footsteps,
        counts,
        names=[names[number] for number in begun],
        body=options.body,
        ends_standing=standing,
        stand_time=options.stand_time,
    )
    made = iter(plans)
    return [aim if isinstance(aim, PlanError) else next(made) for aim in aims]


def _first_footsteps(
    way: Generator[tuple[IntArray, Footsteps, BoolArray], Sequence[World | News | None] | None, None],
    steps: int,
    later: Callable[[float], World] | None,
    *,
    departure: float,
) -> tuple[Footsteps, IntArray, BoolArray]:
    """The first footsteps of each on a way, one after the other, how many each has, and whether it stands at its goal.

    They are told the world as it is when each is taken, but for stands [s].
    """
    rounds: list[tuple[IntArray, Footsteps, BoolArray]] = []
    while len(rounds) < steps:
        news = None
        if later and rounds:
            news = [later(max(float(time), departure)) for time in rounds[-1][1].strike_times]
        try:
            rounds.append(way.send(news) if news else next(way))
        except StopIteration:
            break
    owners = np.concatenate([rows for rows, _, _ in rounds])
    together = concatenated([footsteps for _, footsteps, _ in rounds])
    counts = np.bincount(owners)
    standing = np.zeros(len(counts), dtype=bool)
    for rows, _, stands in rounds:
        standing[rows] = stands
    return rows_of(together, np.argsort(owners, kind="stable")), counts, standing
