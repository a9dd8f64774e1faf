"""Strolls: those who wander take one footstep after the other, all at once."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.planning.aims import Aims, News, finder_in, look_ahead
from usdfoot.planning.free_ways import DRAWS, choose_facings, choose_steps
from usdfoot.planning.route_kernel import LED
from usdfoot.planning.route_searches import Looks
from usdfoot.planning.routes import RouteFinder
from usdfoot.planning.wanderer import (
    SIDEWAYS,
    Footsteps,
    Wanderers,
    WanderOptions,
    joined,
    lay_footsteps,
    rows_of,
    take_steps,
)
from usdfoot.planning.world import World

__all__ = ["stroll"]


def stroll(
    wanderers: Wanderers,
    aims: Sequence[Aims],
    *,
    finder: RouteFinder,
    generators: Sequence[np.random.Generator],
    options: WanderOptions,
    start_time: float,
) -> Generator[tuple[IntArray, Footsteps], Sequence[World | News | None] | None, None]:
    """Who of N takes another step, and their footsteps; they are told what is sent, in the same order.

    All step at once, each as it would alone.

    Args:
        wanderers: As they set out.
        aims: Of each.
        finder: Of routes in the world that they set out in.
        generators: Of each.
        options: How they wander.
        start_time: When they stand there [s].
    """
    finders = {id(finder.world): finder}
    rows, aims = np.arange(len(wanderers)), list(aims)
    both = [_lay(wanderers, aims, np.full(len(rows), side), options, time=start_time) for side in (RIGHT, LEFT)]
    for footsteps in both:
        aims = _told(aims, (yield rows, footsteps), footsteps)
    before = replace(both[-1], strike_times=both[-1].strike_times + options.stand_time)
    while rows.size:
        stood = np.array([aim.has_arrived for aim in aims])
        worlds = {id(aim.world): aim.world for aim in aims}
        finders = {known: finders.get(known) or finder_in(world, options) for known, world in worlds.items()}
        aims, looks = look_ahead(aims, wanderers.positions, finders, options=options)
        own = [generators[int(row)] for row in rows]
        wanderers = _step(wanderers, aims, looks, stood=stood, generators=own, options=options)
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
    looks: Looks,
    *,
    stood: BoolArray,
    generators: Sequence[np.random.Generator],
    options: WanderOptions,
) -> Wanderers:
    """The wanderers a step on in their worlds; who stands, or waits, closes up its feet."""
    routes = [aim.route for aim in aims]
    radii = np.array([route.radius if route else options.radius for route in routes])
    short = np.array([bool(route and route.falls_short) for route in routes])
    goes = ~(stood | (short & (looks.led == LED) & (looks.lengths <= options.arrival)))  # who waits closes up too
    parts = _by_world(aims)
    stepped = []
    for world, own in parts:
        going = own[goes[own]]
        draws = np.array([generators[int(row)].standard_normal(1 + DRAWS) for row in going]).reshape(-1, 1 + DRAWS)
        stepped.append(
            _step_on(
                rows_of(wanderers, own),
                world,
                np.flatnonzero(goes[own]),
                looks=looks.of(going),
                radii=radii[going],
                draws=draws,
                options=options,
            )
        )
    return joined(stepped, [own for _, own in parts])


def _step_on(
    wanderers: Wanderers,
    world: World,
    goes: IntArray,
    *,
    looks: Looks,
    radii: FloatArray,
    draws: FloatArray,
    options: WanderOptions,
) -> Wanderers:
    """Those of a world a step on: who goes (M,) along its way if it sees one, the others on the spot."""
    lengths, turns, facings = np.zeros(len(wanderers)), np.zeros(len(wanderers)), wanderers.facings.copy()
    spins = np.zeros(len(wanderers), dtype=int)
    if goes.size:
        some = rows_of(wanderers, goes)
        free, turns[goes], spins[goes] = choose_steps(some, world, looks, radii=radii, draws=draws, options=options)
        facings[goes] = choose_facings(some, turns[goes], world, radii=radii, options=options)
        turned = np.maximum(facings[goes], some.facings)
        sidewards = (options.side_step - free) / SIDEWAYS * turned + free
        lengths[goes] = np.minimum(free, np.where(turned < SIDEWAYS, sidewards, options.side_step))
    stepped = take_steps(wanderers, lengths, turns, ground=world.ground, options=options)
    return replace(stepped, spins=spins, facings=facings)
