"""Free ways: which way a wanderer steps next, how far, and where it looks while it does."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.planning.route_kernel import LED
from usdfoot.planning.route_searches import Looks
from usdfoot.planning.spots import HEADROOM, STEEPEST
from usdfoot.planning.wanderer import SIDEWAYS, Wanderers, WanderOptions, rows_of
from usdfoot.planning.world import World, clearances

__all__ = ["DRAWS", "choose_facings", "choose_steps", "rooms_above"]

SLOPE = 8
"""Samples of the way ahead between which the ground may not rise more than a slope and half a step."""
SHOULDERS = 1.2
"""Who comes so near [m] to where it is narrower than its body turns the left shoulder first."""
DRAWS = 24
"""Directions tried when the one wanted leads too close to something."""


def choose_steps(
    wanderers: Wanderers,
    world: World,
    looks: Looks,
    *,
    radii: FloatArray,
    draws: FloatArray,
    options: WanderOptions,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Lengths [m] and turns [rad] of the next steps, and the sides to which they turn out of dead ends, 0 if in none.

    Args:
        wanderers: N of them.
        world: In which all of them are.
        looks: What each sees of its way to its goal.
        radii: Half the width that each needs on its way [m], shape (N,).
        draws: Random numbers, normally distributed, shape (N, 1 + DRAWS).
        options: How they wander.

    Returns:
        Shape (N,) each.
    """
    easy, count = wanderers.easy_steps, len(wanderers)
    wanted, farthest = options.wobble * draws[:, 0], easy
    needed, led = np.full(count, options.look_ahead), np.flatnonzero(looks.led == LED)
    if led.size:
        vectors, wanted, farthest = looks.aims[led] - wanderers.places[led], wanted.copy(), easy.copy()
        wanted[led] = planar.wrap_angle(planar.yaw_of(vectors) - wanderers.yaws[led])
        farthest[led] = needed[led] = np.minimum(easy[led], np.linalg.norm(vectors, axis=1))
    around = wanted[:, None] + draws[:, 1:] * np.linspace(0.2, 3.0, DRAWS)
    turns = np.clip(np.column_stack([wanted, around]), -options.turn, options.turn)
    chosen, free = turns[:, 0].copy(), _free_ways(wanderers, turns[:, :1], needed, radii, world, options)[:, 0]
    barred = np.flatnonzero(free < needed)
    if barred.size:
        ways = _free_ways(rows_of(wanderers, barred), turns[barred], needed[barred], radii[barred], world, options)
        best = np.argmax(ways, axis=1)  # the first of those that are wholly free
        chosen[barred], free[barred] = turns[barred, best], ways[np.arange(len(barred)), best]
    spins = np.zeros(count, dtype=int)
    dead = np.flatnonzero(free < np.minimum(0.5 * easy, needed))
    if dead.size:
        spins[dead] = np.where(wanderers.spins, wanderers.spins, np.where(wanted > 0.0, 1, -1))[dead]
        chosen[dead] = spins[dead] * options.turn
        ends = rows_of(wanderers, dead)
        free[dead] = _free_ways(ends, chosen[dead, None], needed[dead], radii[dead], world, options)[:, 0]
    slower = 1.0 - 0.6 * np.abs(chosen) / options.turn
    return np.minimum(free, farthest * slower), chosen, spins


def choose_facings(
    wanderers: Wanderers, turns: FloatArray, world: World, *, radii: FloatArray, options: WanderOptions
) -> FloatArray:
    """How far they look to the right of where they go in the next step: sideways where a narrow way leads."""
    narrow = radii < options.radius
    rows = np.flatnonzero(narrow)
    if rows.size:
        ahead = np.linspace(0.0, SHOULDERS, 9)[:, None]
        forward = planar.direction(wanderers.yaws[rows] + turns[rows])
        points = wanderers.places[rows, None] + ahead * forward[:, None]  # (M, 9, 2)
        room = clearances(world, points.reshape(-1, 2), np.repeat(wanderers.heights[rows], len(ahead)))
        narrow[rows] = room.reshape(len(rows), -1).min(axis=1) < options.radius
    changes = np.where(narrow, SIDEWAYS, 0.0) - wanderers.facings
    return wanderers.facings + np.clip(changes, -options.turn, options.turn)


def _free_ways(
    wanderers: Wanderers,
    turns: FloatArray,
    ahead: FloatArray,
    radii: FloatArray,
    world: World,
    options: WanderOptions,
) -> FloatArray:
    """How far directions (N, T) are free [m] for bodies of radii (N,) [m], at most `ahead` (N,), shape (N, T).

    Who is already too close to something, or below a low ceiling, may walk where it does not come closer. What moves
    is where it will be when the wanderer gets there.
    """
    spacings = 0.5 * radii
    counts = np.maximum(np.ceil(ahead / spacings).astype(int), 1)
    most, shape = int(counts.max(initial=1)), turns.shape
    distances = np.arange(1, most + 1) * spacings[:, None]  # (N, D)
    forward = planar.direction(wanderers.yaws[:, None] + turns)
    points = wanderers.places[:, None, None] + distances[:, None, :, None] * forward[:, :, None]  # (N, T, D, 2)
    heights = np.empty((*shape, most + 1))
    heights[:] = wanderers.heights[:, None, None]
    passable = np.ones((*shape, most), dtype=bool)
    if world.ground is not None:
        begins = np.broadcast_to(wanderers.places[:, None, None], (*shape, 1, 2))
        ways = np.concatenate([begins, points], axis=2).reshape(-1, 2)
        first = np.arange(turns.size + 1) * (most + 1)
        sample = world.ground.follow(ways, heights.ravel(), first=first, step_up=options.step)
        heights[..., 1:] = sample.heights.reshape(heights.shape)[..., 1:]
        passable = sample.walkable.reshape(heights.shape)[..., 1:] & (np.abs(np.diff(heights)) <= options.step)
        rises = np.abs(heights[..., SLOPE:] - heights[..., :-SLOPE])
        highest = SLOPE * spacings * np.tan(STEEPEST) + 0.5 * options.step
        passable[..., SLOPE - 1 :] &= rises <= highest[:, None, None]
        above = rooms_above(wanderers.places, wanderers.heights, world.ground, options=options)
        passable &= rooms_above(points, heights[..., 1:], world.ground, options=options) >= above[:, None, None]
    here = clearances(world, wanderers.places, wanderers.heights)
    times = np.broadcast_to((distances / wanderers.paces[:, None])[:, None], passable.shape).ravel()
    room = clearances(world, points.reshape(-1, 2), heights[..., 1:].ravel(), times=times).reshape(passable.shape)
    clear = passable & (room >= np.minimum(radii, here)[:, None, None])
    clear |= np.arange(most) >= counts[:, None, None]
    first_blocked = np.where(clear.all(axis=2), counts[:, None], np.argmin(clear, axis=2))
    return np.minimum(first_blocked * spacings[:, None], ahead[:, None])


def rooms_above(points: FloatArray, heights: FloatArray, ground: Ground, *, options: WanderOptions) -> FloatArray:
    """How far the lowest ceiling is above points (..., 2) on ground at heights (...), at most what a body needs [m]."""
    needed = HEADROOM * options.body.leg_length
    limits = np.ravel(heights) + needed
    above = ground.heights(points.reshape(-1, 2), limits, step_up=0.0).heights.reshape(heights.shape) - heights
    return np.asarray(np.where((above > options.step) & (above <= needed), above, needed))
