"""What is wrong with where footsteps lie: off the terrain, on steep ground, under ceilings, in obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.planning.bumps import find_bumps
from usdfoot.planning.faults import WARNING, Fault, LintLimits, faults_at
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.world import Obstacle

__all__ = ["find_bump_faults", "find_ground_faults", "find_low_ceilings"]

CEILING = 0.5
"""Terrain so far above a print is another level, not the next stair [m]."""


def find_ground_faults(
    names: Sequence[str], feet: FootTable, laid: FloatArray, ground: Ground, limits: LintLimits
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
        (away, "offGround", above, "is {:+.2f} m above the ground"),
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
    names: Sequence[str], feet: FootTable, legs: FloatArray, ground: Ground, limits: LintLimits
) -> list[Fault]:
    """Footsteps under terrain too low to stand upright, or inside of it."""
    if not ground.has_terrain:
        return []
    heights = feet.positions[:, 1]
    above = ground.heights(feet.positions[:, [0, 2]], heights + limits.headroom * legs, step_up=0.0).heights - heights
    low = np.flatnonzero((above > CEILING) & (above <= limits.headroom * legs))
    message = "has only {:.2f} m of room above it"
    return faults_at(names, feet, low, kind="obstructed", values=above[low], message=message)


def find_bump_faults(
    names: Sequence[str], feet: FootTable, obstacles: Sequence[Obstacle], limits: LintLimits
) -> list[Fault]:
    """Footsteps in obstacles, and steps through them."""
    soles, bodies = find_bumps(feet, obstacles)
    found = []
    for bumps, least, what in (
        (soles, limits.bump, "is {:.2f} m in the obstacle "),
        (bodies, 0.0, "leads the body {:.2f} m into the obstacle "),
    ):
        for row, index, depth in zip(bumps.rows, bumps.obstacles, bumps.depths, strict=True):
            if depth > least:
                rows, values = np.array([row]), np.array([depth])
                message = what + obstacles[index].name
                found += faults_at(names, feet, rows, kind="obstacle", values=values, message=message)
    return found
