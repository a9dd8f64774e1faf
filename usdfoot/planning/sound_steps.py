"""Sound steps: of the footsteps that those who wander could take next, the nearest to the wanted one that is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from usdfoot.analysis.timing import time_steps
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.model.ground import Ground
from usdfoot.model.terrain import no_terrain
from usdfoot.planning.faults import Fault, LintLimits
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.free_ways import rooms_above
from usdfoot.planning.lint import lint_feet
from usdfoot.planning.wanderer import (
    Footsteps,
    Wanderers,
    WanderOptions,
    concatenated,
    follow_feet,
    lay_footsteps,
    rows_of,
    take_steps,
)
from usdfoot.planning.world import World, clearances

__all__ = ["Moves", "sound_stands", "sound_steps"]

LENGTHS = np.array([1.0, 0.8, 0.6, 0.4, 0.2, 0.0, -0.2, -0.4])
"""Of steps that are tried, over that of the one wanted."""
SHORTEST = 0.35
"""Steps shorter than this are tried like this one, over the leg length."""
TURNS = np.radians([0.0, 12.0, -12.0, 25.0, -25.0, 45.0, -45.0])
"""From where a wanted step leads [rad]."""
ASIDES = np.array([0.0, 0.06, -0.06, 0.12, -0.12, 0.2, -0.2])
"""How far the body goes to the left of where a wanted step leads [m]."""
AT_ONCE = 48
"""So many other steps are looked at before those farther from the one wanted."""
STANDS = 0.05 * np.array(list(product(range(-5, 6), repeat=2)))
"""Beside a place to stand [m]."""


@dataclass(frozen=True, kw_only=True)
class Moves:
    """Wanted steps of N that wander."""

    lengths: FloatArray
    """[m], shape (N,)."""
    turns: FloatArray
    """[rad], shape (N,)."""
    facings: FloatArray
    """How far each looks to the right of where it goes in it [rad], shape (N,)."""
    radii: FloatArray
    """Half the width that each needs [m], shape (N,)."""

    def of(self, rows: IntArray) -> Moves:
        """Those of some rows."""
        return Moves(**{name: values[rows] for name, values in vars(self).items()})


def sound_steps(
    wanderers: Wanderers,
    moves: Moves,
    world: World,
    *,
    feet: tuple[Footsteps, Footsteps],
    options: WanderOptions,
) -> tuple[Wanderers, Footsteps]:
    """N that wander a step on, and the footsteps: where lint finds a fault in the step wanted, the next best without.

    Where all of those tried have faults, one with the fewest.

    Args:
        wanderers: Before the step.
        moves: The steps wanted.
        world: In which all of them are.
        feet: The last footsteps of the feet that step, and of the others.
        options: How they wander.
    """
    everyone = np.arange(len(wanderers))
    stepped, footsteps = _taken(wanderers, moves, world.ground, feet=feet, options=options)
    faults = _count_faults(wanderers, footsteps, world.ground, feet=feet, options=options)
    left = np.flatnonzero(faults)
    others = _other_moves(options)
    for first in range(0, len(others), AT_ONCE):
        if not left.size:
            break
        part = others[first : first + AT_ONCE]
        rows = np.repeat(left, len(part))
        some, before = rows_of(wanderers, rows), (rows_of(feet[0], rows), rows_of(feet[1], rows))
        begins, tried = _moved(some, moves.of(rows), np.tile(part, (len(left), 1)), options)
        ends, laid = _taken(begins, tried, world.ground, feet=before, options=options)
        found = _count_faults(some, laid, world.ground, feet=before, options=options)
        found += _is_barred(some, ends, world, radii=tried.radii, options=options)
        best = np.argmin(found.reshape(len(left), -1), axis=1) + len(part) * np.arange(len(left))
        better = found[best] < faults[left]
        chosen, better_rows = best[better], left[better]
        faults[better_rows] = found[chosen]
        source = everyone.copy()
        source[better_rows] = len(everyone) + np.arange(len(chosen))
        stepped = rows_of(concatenated([stepped, rows_of(ends, chosen)]), source)
        footsteps = rows_of(concatenated([footsteps, rows_of(laid, chosen)]), source)
        left = np.flatnonzero(faults)
    return stepped, footsteps


def sound_stands(
    wanderers: Wanderers, rows: IntArray, ground: Ground | None, *, options: WanderOptions
) -> tuple[Wanderers, list[str]]:
    """N that stand, those of rows moved up to a foot's length to where both feet do so soundly, and what is wrong."""
    reasons = [""] * len(wanderers)
    if not rows.size:
        return wanderers, reasons
    faults = _stand_faults(rows_of(wanderers, rows), ground, options)
    beside = STANDS[np.argsort(np.linalg.norm(STANDS, axis=1), kind="stable")]
    for row, fault in zip(rows.tolist(), faults, strict=True):
        if not fault:
            continue
        some = rows_of(wanderers, np.repeat(row, len(beside)))
        some = replace(some, places=some.places + beside)
        if ground is not None:
            sample = ground.heights(some.places, some.heights, step_up=options.step)
            some = replace(some, heights=np.where(sample.hit, sample.heights, some.heights))
        sound = [not reason for reason in _stand_faults(some, ground, options)]
        reasons[row] = "" if any(sound) else fault
        if any(sound):
            others = np.where(np.arange(len(wanderers)) == row, len(wanderers), np.arange(len(wanderers)))
            wanderers = rows_of(concatenated([wanderers, rows_of(some, np.array([np.argmax(sound)]))]), others)
    return wanderers, reasons


def _taken(
    wanderers: Wanderers,
    moves: Moves,
    ground: Ground | None,
    *,
    feet: tuple[Footsteps, Footsteps],
    options: WanderOptions,
) -> tuple[Wanderers, Footsteps]:
    """Those that wander after their moves, their bodies where their feet are, and the footsteps."""
    stepped = take_steps(wanderers, moves.lengths, moves.turns, ground=ground, options=options)
    stepped = replace(stepped, facings=moves.facings)
    footsteps = lay_footsteps(stepped, stepped.sides, ground=ground, options=options, before=feet[1])
    return follow_feet(stepped, footsteps, options=options) if ground is not None else stepped, footsteps


def _other_moves(options: WanderOptions) -> FloatArray:
    """Lengths over the wanted one, turns from it [rad] and ways aside [m] to try, the most like it first, (K, 3)."""
    moves = np.array(list(product(LENGTHS, TURNS, ASIDES)))[1:]
    costs = np.abs(moves - (1.0, 0.0, 0.0)) / (0.5, options.turn, 0.15)
    return moves[np.argsort(costs.sum(axis=1), kind="stable")]


def _moved(wanderers: Wanderers, moves: Moves, others: FloatArray, options: WanderOptions) -> tuple[Wanderers, Moves]:
    """Where moves (N,) that are others (N, 3) than those wanted begin, and what they are."""
    shares, turns, asides = others.T
    base = np.maximum(moves.lengths, SHORTEST * options.body.leg_length)
    lengths = np.clip(moves.lengths + (shares - 1.0) * base, -0.4 * base, None)
    left = planar.direction(wanderers.yaws + moves.turns + turns + 0.5 * np.pi)
    begins = replace(wanderers, places=wanderers.places + asides[:, None] * left)
    return begins, replace(moves, lengths=lengths, turns=moves.turns + turns)


def _count_faults(
    wanderers: Wanderers,
    footsteps: Footsteps,
    ground: Ground | None,
    *,
    feet: tuple[Footsteps, Footsteps],
    options: WanderOptions,
) -> IntArray:
    """How much lint finds wrong with each next footstep, and whether it needs a leap of who walks, shape (N,)."""
    distances = np.linalg.norm(footsteps.positions - feet[1].positions, axis=1)
    timing = time_steps(distances, options.body.timing)
    leaps = timing.flies & ~time_steps(wanderers.easy_steps, options.body.timing).flies
    faults = leaps + _is_below(footsteps, ground, options)
    shown = (*feet, footsteps)
    strikes = np.stack([part.strike_times for part in shown], axis=1)
    liftoffs = np.stack([strikes[:, 1], strikes[:, 2] + timing.overlaps, strikes[:, 2]], axis=1)
    found = _lint(shown, strikes=strikes, liftoffs=liftoffs, ground=ground, options=options)
    np.add.at(faults, [int(fault.plan) for fault in found if fault.footstep == 2], 1)
    return faults


def _is_barred(
    wanderers: Wanderers, ends: Wanderers, world: World, *, radii: FloatArray, options: WanderOptions
) -> BoolArray:
    """Whether N that wander come nearer to something than they may, or are, if they step to ends."""
    here = clearances(world, wanderers.places, wanderers.heights)
    room = clearances(world, ends.places, ends.heights)
    return np.asarray(room < np.minimum(radii, here))


def _is_below(footsteps: Footsteps, ground: Ground | None, options: WanderOptions) -> IntArray:
    """Whether footsteps are below what is too high to step on and too low to stand under, shape (N,)."""
    if ground is None:
        return np.zeros(len(footsteps.sides), dtype=int)
    above = rooms_above(footsteps.positions[:, [0, 2]], footsteps.positions[:, 1], ground, options=options)
    return (above <= LintLimits().headroom * options.body.leg_length).astype(int)


def _lint(
    shown: Sequence[Footsteps],
    *,
    strikes: FloatArray,
    liftoffs: FloatArray,
    ground: Ground | None,
    options: WanderOptions,
) -> list[Fault]:
    """What lint finds wrong with N plans, each named by its number, of one footstep in each of P parts.

    Args:
        shown: The parts, N footsteps each.
        strikes: [s], shape (N, P).
        liftoffs: [s], shape (N, P).
        ground: None = level.
        options: Who walks.
    """
    (count, most), body = strikes.shape, options.body
    orientations = np.stack([part.orientations for part in shown], axis=1).reshape(-1, 4)
    forward, normals = (quaternion.rotate(orientations, np.eye(3)[axis]) for axis in (2, 1))
    numbers = np.tile(np.arange(most), count)
    sizes = {
        name: np.full(len(numbers), size)
        for name, size in (("heels", body.heel), ("toes", body.toe), ("half_widths", body.half_width))
    }
    table = FootTable(
        owners=np.repeat(np.arange(count), most),
        numbers=numbers,
        positions=np.stack([part.positions for part in shown], axis=1).reshape(-1, 3),
        yaws=planar.yaw_of(forward[:, [0, 2]]),
        sides=np.stack([part.sides for part in shown], axis=1).ravel(),
        strikes=strikes.ravel(),
        liftoffs=liftoffs.ravel(),
        last=numbers >= most - 2,
        **sizes,
    )
    names = [str(number) for number in range(count)]
    level = ground or Ground(no_terrain())
    return lint_feet(names, table, normals, bodies=[body] * count, ground=level, limits=LintLimits())


def _stand_faults(wanderers: Wanderers, ground: Ground | None, options: WanderOptions) -> list[str]:
    """What lint finds first in how each stands, nothing where that is right."""
    count, sides = len(wanderers), (RIGHT, LEFT)
    shown = [lay_footsteps(wanderers, np.full(count, side), ground=ground, options=options) for side in sides]
    times = np.zeros((count, 2))
    found = _lint(shown, strikes=times, liftoffs=times + options.stand_time, ground=ground, options=options)
    reasons = [""] * count
    for fault in reversed(found):
        reasons[int(fault.plan)] = fault.message
    return reasons
