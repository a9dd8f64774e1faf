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
from usdfoot.planning.sound_steps import Moves, sound_steps
from usdfoot.planning.wanderer import (
    SIDEWAYS,
    Footsteps,
    Wanderers,
    WanderOptions,
    joined,
    lay_footsteps,
    rows_of,
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
) -> Generator[tuple[IntArray, Footsteps, BoolArray], Sequence[World | News | None] | None, None]:
    """Who of N takes another step, their footsteps, and who then stands at its last goal; what is sent they are told.

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
    ground, time = finder.world.ground, start_time
    both = [
        lay_footsteps(wanderers, np.full(len(rows), side), ground=ground, options=options, time=time)
        for side in (RIGHT, LEFT)
    ]
    for footsteps in both:
        aims = _told(aims, (yield rows, footsteps, np.zeros(len(rows), dtype=bool)), footsteps)
    feet = both[0], replace(both[1], strike_times=both[1].strike_times + options.stand_time)
    while rows.size:
        stood = np.array([aim.has_arrived for aim in aims])
        worlds = {id(aim.world): aim.world for aim in aims}
        finders = {known: finders.get(known) or finder_in(world, options) for known, world in worlds.items()}
        aims, looks = look_ahead(aims, wanderers.positions, finders, options=options)
        own = [generators[int(row)] for row in rows]
        wanderers, taken = _step(wanderers, aims, looks, feet=feet, stood=stood, generators=own, options=options)
        feet = feet[1], taken
        aims = [aim.passed(place, options) for aim, place in zip(aims, wanderers.positions, strict=True)]
        news = yield rows, taken, stood & [aim.has_arrived for aim in aims]
        aims = _told(aims, news, taken)
        kept = np.flatnonzero(~(stood & [aim.has_arrived for aim in aims]))
        if len(kept) < len(rows):
            rows, aims = rows[kept], [aims[row] for row in kept]
            wanderers, feet = rows_of(wanderers, kept), (rows_of(feet[0], kept), rows_of(feet[1], kept))


def _told(aims: Sequence[Aims], news: Sequence[World | News | None] | None, footsteps: Footsteps) -> list[Aims]:
    """What they aim at after news, each as its foot is down."""
    everyone = zip(aims, news or [None] * len(aims), footsteps.strike_times, strict=True)
    return [aim.told(own, float(time)) for aim, own, time in everyone]


def _by_world(aims: Sequence[Aims]) -> list[tuple[World, IntArray]]:
    """The worlds they are in, and who is in each."""
    numbers = np.array([id(aim.world) for aim in aims])
    worlds = {id(aim.world): aim.world for aim in aims}
    return [(world, np.flatnonzero(numbers == number)) for number, world in worlds.items()]


def _step(
    wanderers: Wanderers,
    aims: Sequence[Aims],
    looks: Looks,
    *,
    feet: tuple[Footsteps, Footsteps],
    stood: BoolArray,
    generators: Sequence[np.random.Generator],
    options: WanderOptions,
) -> tuple[Wanderers, Footsteps]:
    """The wanderers a step on in their worlds, and the footsteps; who stands, or waits, closes up its feet."""
    routes = [aim.route for aim in aims]
    radii = np.array([route.radius if route else options.radius for route in routes])
    short = np.array([bool(route and route.falls_short) for route in routes])
    goes = ~(stood | (short & (looks.led == LED) & (looks.lengths <= options.arrival)))  # who waits closes up too
    parts = _by_world(aims)
    stepped, taken = [], []
    for world, own in parts:
        going = own[goes[own]]
        draws = np.array([generators[int(row)].standard_normal(1 + DRAWS) for row in going]).reshape(-1, 1 + DRAWS)
        some = rows_of(wanderers, own)
        moves, spins = _moves(
            some,
            world,
            np.flatnonzero(goes[own]),
            looks=looks.of(going),
            radii=radii[own],
            draws=draws,
            options=options,
        )
        on, laid = sound_steps(some, moves, world, feet=(rows_of(feet[0], own), rows_of(feet[1], own)), options=options)
        stepped.append(replace(on, spins=spins))
        taken.append(laid)
    rows = [own for _, own in parts]
    return joined(stepped, rows), joined(taken, rows)


def _moves(
    wanderers: Wanderers,
    world: World,
    goes: IntArray,
    *,
    looks: Looks,
    radii: FloatArray,
    draws: FloatArray,
    options: WanderOptions,
) -> tuple[Moves, IntArray]:
    """The steps wanted of those of a world, and to which side each turns out of a dead end, 0 if it is in none.

    Who goes (M,) does so along its way if it sees one, the others stay on the spot.
    """
    lengths, turns, facings = np.zeros(len(wanderers)), np.zeros(len(wanderers)), wanderers.facings.copy()
    spins = np.zeros(len(wanderers), dtype=int)
    if goes.size:
        some, wide = rows_of(wanderers, goes), radii[goes]
        free, turns[goes], spins[goes] = choose_steps(some, world, looks, radii=wide, draws=draws, options=options)
        facings[goes] = choose_facings(some, turns[goes], world, radii=wide, options=options)
        turned = np.maximum(facings[goes], some.facings)
        sidewards = (options.side_step - free) / SIDEWAYS * turned + free
        lengths[goes] = np.minimum(free, np.where(turned < SIDEWAYS, sidewards, options.side_step))
    return Moves(lengths=lengths, turns=turns, facings=facings, radii=radii), spins
