"""Free ways: which way a wanderer steps next, how far, and where it looks while it does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.planning.routes import Route, aim_along
from usdfoot.planning.spots import STEEPEST
from usdfoot.planning.wanderer import SIDEWAYS, Wanderer, WanderOptions
from usdfoot.planning.world import World, clearances

__all__ = ["choose_facing", "choose_step"]

SLOPE = 8
"""Samples of the way ahead between which the ground may not rise more than a slope and half a step."""
SHOULDERS = 1.2
"""Who comes so near [m] to where it is narrower than its body turns the left shoulder first."""
DRAWS = 24
"""Directions tried when the one wanted leads too close to something."""


def choose_step(
    wanderer: Wanderer, world: World, routes: Sequence[Route], *, generator: np.random.Generator, options: WanderOptions
) -> tuple[float, float, int]:
    """Length [m] and turn [rad] of the next step, and the side to which it turns out of a dead end, 0 if in none."""
    easy = options.easy_step
    wanted, farthest, needed = generator.normal(scale=options.wobble), easy, options.look_ahead
    aim = None
    if routes:
        aim = aim_along(routes[0], wanderer.position, ahead=4.0 * options.look_ahead)
    if aim is not None:
        wanted = float(planar.wrap_angle(planar.yaw_of(aim - wanderer.place) - wanderer.yaw))
        farthest = min(easy, float(np.linalg.norm(aim - wanderer.place)))
        needed = farthest
    draws = generator.normal(size=DRAWS) * np.linspace(0.2, 3.0, DRAWS)
    turns = np.clip(np.append(wanted, wanted + draws), -options.turn, options.turn)
    radius = routes[0].radius if routes else options.radius
    free = _free_ways(wanderer, turns[:1], needed, world, options, radius=radius)
    if free[0] < needed:
        free = _free_ways(wanderer, turns, needed, world, options, radius=radius)
    chosen, spin = int(np.argmax(free)), 0  # the first of those that are wholly free
    if free[chosen] < min(0.5 * easy, needed):
        spin = wanderer.spin or (1 if wanted > 0.0 else -1)
        turns, chosen = np.array([spin * options.turn]), 0
        free = _free_ways(wanderer, turns, needed, world, options, radius=radius)
    slower = 1.0 - 0.6 * abs(turns[chosen]) / options.turn
    return float(min(free[chosen], farthest * slower)), float(turns[chosen]), spin


def choose_facing(
    wanderer: Wanderer, turn: float, world: World, *, routes: Sequence[Route], options: WanderOptions
) -> float:
    """How far it looks to the right of where it goes in the next step: sideways where a narrow way leads."""
    ahead = np.linspace(0.0, SHOULDERS, 9)[:, None]
    points = wanderer.place + ahead * planar.direction(np.array(wanderer.yaw + turn))
    narrow = bool(routes) and routes[0].radius < options.radius
    narrow = narrow and clearances(world, points, np.full(len(points), wanderer.height)).min() < options.radius
    change = (SIDEWAYS if narrow else 0.0) - wanderer.facing
    return wanderer.facing + float(np.clip(change, -options.turn, options.turn))


def _free_ways(
    wanderer: Wanderer, turns: FloatArray, ahead: float, world: World, options: WanderOptions, *, radius: float
) -> FloatArray:
    """How far each direction is free [m] for a body of a radius [m], at most `ahead`, shape (T,).

    Who is already too close to something may walk where it does not come closer. What moves is where it will be when
    the wanderer gets there.
    """
    spacing = 0.5 * radius
    distances = np.arange(1, max(1, int(np.ceil(ahead / spacing))) + 1) * spacing
    points = wanderer.place + distances[:, None] * planar.direction(wanderer.yaw + turns)[:, None]  # (T, D, 2)
    heights = np.full((len(turns), len(distances) + 1), wanderer.height)
    passable = np.ones((len(turns), len(distances)), dtype=bool)
    if world.ground is not None:
        ways = np.concatenate([np.broadcast_to(wanderer.place, (len(turns), 1, 2)), points], axis=1).reshape(-1, 2)
        first = np.arange(len(turns) + 1) * (len(distances) + 1)
        sample = world.ground.follow(ways, np.full(len(ways), wanderer.height), first=first, step_up=options.step)
        heights[:, 1:] = sample.heights.reshape(heights.shape)[:, 1:]
        passable = sample.walkable.reshape(heights.shape)[:, 1:] & (np.abs(np.diff(heights)) <= options.step)
        rises = np.abs(heights[:, SLOPE:] - heights[:, :-SLOPE])
        passable[:, SLOPE - 1 :] &= rises <= SLOPE * spacing * np.tan(STEEPEST) + 0.5 * options.step
    here = float(clearances(world, wanderer.place[None], np.array([wanderer.height]))[0])
    times = np.tile(distances / options.pace, len(turns))
    free = clearances(world, points.reshape(-1, 2), heights[:, 1:].ravel(), times=times) >= min(radius, here)
    clear = free.reshape(len(turns), -1) & passable
    first_blocked = np.where(clear.all(axis=1), len(distances), np.argmin(clear, axis=1))
    return np.minimum(first_blocked * spacing, ahead)
