"""What is wrong with where footsteps lie: off the terrain, on steep ground, under ceilings, in obstacles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from usdfoot.engine.detours import BLIND_HEIGHT
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.ground import Ground
from usdfoot.planning.bumps import find_bumps
from usdfoot.planning.faults import WARNING, Fault, LintLimits, faults_at
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.world import Obstacle

__all__ = ["find_bump_faults", "find_ground_faults", "find_low_ceilings", "find_walls"]

ALONG = np.linspace(0.0, 1.0, 14)[1:-1, None, None]
ASIDES = np.array([-0.05, 0.0, 0.05])[:, None, None, None]
"""Places on the line from print to print of a foot, and on two beside it [m], at which there may be a wall. Over the
edge of what is not on all three a foot is lifted, but none is over what is higher than `BLIND_HEIGHT`."""
ROUNDED = 1e-3
"""A wall may be so much higher than is said [m]."""
CEILING = 0.5
"""Terrain so far above a print is another level, not the next stair [m]."""


def find_ground_faults(
    names: Sequence[str], feet: FootTable, laid: FloatArray, *, ground: Ground, limits: LintLimits
) -> list[Fault]:
    """What is wrong with where footsteps, laid on normals (N, 3), are on the terrain."""
    if not ground.has_terrain:
        return []
    places, heights = feet.positions[:, [0, 2]], feet.positions[:, 1]
    under = ground.heights(places, heights, step_up=limits.off_ground)
    above = heights - under.heights
    slopes = np.arccos(np.clip(under.normals[:, 1], -1.0, 1.0))
    forward = planar.direction(feet.yaws)
    left, inclines = planar.direction(feet.yaws + 0.5 * np.pi), -laid[:, [0, 2]] / laid[:, [1]]
    pokes = np.zeros(len(heights))
    for reach, across in product((-feet.heels, feet.toes), (-feet.half_widths, feet.half_widths)):
        offsets = reach[:, None] * forward + across[:, None] * left
        end = ground.heights(places + offsets, heights, step_up=0.3)
        sole = heights + np.sum(offsets * inclines, axis=1)
        pokes = np.maximum(pokes, np.where(end.hit, end.heights - sole, 0.0))
    off = ~under.hit
    barred = under.hit & ~under.walkable
    away = under.hit & ~barred & (np.abs(above) > limits.off_ground)
    good = ~(off | barred | away)
    steep = good & (slopes > limits.steepest)
    checks = (
        (off, "offTerrain", np.zeros(len(off)), "is off the terrain"),
        (barred, "offTerrain", np.zeros(len(off)), "is on ground that is not walkable"),
        (away & (above > 0.0), "offGround", above, "is {:.2f} m above the ground"),
        (away & (above < 0.0), "offGround", -above, "is {:.2f} m below the ground"),
        (steep, "steep", np.degrees(slopes), "is on a slope of {:.0f} degrees"),
    )
    found = []
    for wrong, kind, values, message in checks:
        rows = np.flatnonzero(wrong)
        found += faults_at(names, feet, rows, kind=kind, values=values[rows], message=message)
    poked = np.flatnonzero(good & ~steep & (pokes > limits.poke))
    message = "has ground {:.2f} m high in its sole"
    return found + faults_at(
        names, feet, poked, kind="obstructed", values=pokes[poked], message=message, severity=WARNING
    )


def find_low_ceilings(
    names: Sequence[str], feet: FootTable, legs: FloatArray, *, ground: Ground, limits: LintLimits
) -> list[Fault]:
    """Footsteps under terrain too low to stand upright, or inside of it."""
    if not ground.has_terrain:
        return []
    above = _room(feet, legs, ground, limits)
    low = np.flatnonzero(_is_low(above, legs, limits))
    message = "has only {:.2f} m of room above it"
    return faults_at(names, feet, low, kind="obstructed", values=above[low], message=message)


def _room(feet: FootTable, legs: FloatArray, ground: Ground, limits: LintLimits) -> FloatArray:
    """How far the highest terrain below a head is over each print [m], shape (N,)."""
    heights = feet.positions[:, 1]
    return ground.heights(feet.positions[:, [0, 2]], heights + limits.headroom * legs, step_up=0.0).heights - heights


def _is_low(above: FloatArray, legs: FloatArray, limits: LintLimits) -> BoolArray:
    """Whether terrain so far above prints [m] (N,) is a ceiling too low to stand under, shape (N,)."""
    return (above > CEILING) & (above <= limits.headroom * legs)


def find_walls(
    names: Sequence[str], feet: FootTable, legs: FloatArray, *, ground: Ground, limits: LintLimits
) -> list[Fault]:
    """Footsteps to which a foot has to swing over ground higher above both its prints than legs step.

    Not to and from places below a ceiling, which are faults themselves.
    """
    if not ground.has_terrain:
        return []
    clear = ~_is_low(_room(feet, legs, ground, limits), legs, limits)
    rows = np.flatnonzero((feet.numbers > 1) & clear & np.roll(clear, 2))
    places, leads = feet.positions[rows - 2][:, [0, 2]], (feet.positions[rows] - feet.positions[rows - 2])[:, [0, 2]]
    across = leads[:, ::-1] * (1.0, -1.0) / np.maximum(np.linalg.norm(leads, axis=1, keepdims=True), 1e-9)
    lines = places + ALONG * leads + ASIDES * across  # (K, L, N, 2)
    tops = np.maximum(feet.positions[rows, 1], feet.positions[rows - 2, 1])
    tallest = np.broadcast_to(tops + limits.headroom * legs[rows], lines.shape[:-1]).ravel()
    under = ground.heights(lines.reshape(-1, 2), tallest, step_up=0.0)
    walls = np.where(under.hit & (under.heights <= tallest), under.heights, -np.inf).reshape(lines.shape[:-1])
    over = walls.max(axis=1) - tops
    over = np.where(over[1] > BLIND_HEIGHT + ROUNDED, over[1], over.min(axis=0))
    high = over > limits.highest_step * legs[rows]
    message = "swings over ground {:.2f} m above where the foot stands before and after"
    return faults_at(names, feet, rows[high], kind="obstructed", values=over[high], message=message)


def find_bump_faults(
    names: Sequence[str],
    feet: FootTable,
    obstacles: Sequence[Obstacle],
    *,
    limits: LintLimits,
    moving: Callable[[float], Sequence[Obstacle]] | None = None,
) -> list[Fault]:
    """Footsteps in obstacles, and steps through them; in those that move as `find_bumps` has it."""
    soles, bodies = find_bumps(feet, obstacles, moving=moving)
    found = []
    for bumps, least, what in (
        (soles, limits.bump, "is {:.2f} m in the obstacle "),
        (bodies, 0.0, "leads the body {:.3f} m into the obstacle "),
    ):
        for row, name, depth in zip(bumps.rows, bumps.obstacles, bumps.depths, strict=True):
            if depth > least:
                rows, values = np.array([row]), np.array([depth])
                message = what + name
                found += faults_at(names, feet, rows, kind="obstacle", values=values, message=message)
    return found
