"""Footholds along ways: where a foot stands with its whole sole, and the steps that use those places only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.model.ground import Ground
from usdfoot.planning.faults import LintLimits
from usdfoot.planning.foothold_kernel import FootholdLimits, feel_ground, feel_walls
from usdfoot.planning.gait import Gait
from usdfoot.planning.prints import EDGE
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.tread_kernel import TreadWays, choose_treads
from usdfoot.planning.ways import Ways

__all__ = ["Footholds", "find_footholds", "find_walls", "firm_ends", "foot_places", "strained_ways", "tread_steps"]

STEEPEST = np.radians(35.0)
"""Ground steeper than this is nothing to stand on."""
POKES = 0.02
"""Ground that rises this much through the plane of the sole is in the way [m]."""
HANGS = 0.03
"""A heel or toe this far above the ground hangs over an edge [m]."""
MARGIN = 0.15
"""Free ground kept behind the heel and before the toes, over the foot length."""
HANGING = 0.15
"""Cost of a heel or toe over an edge; a step half as long as it should be costs 0.25."""
ASIDES = 0.02 * np.array([1.0, -1.0, 2.0, -2.0, 3.0])
"""Farther from the way than the step width says, where a foot would stand on an edge along it; farthest last [m]."""
ASIDE = 2.0
"""Cost of that [1/m]."""
BAD = 100.0
"""Cost of a place where no foot can stand."""
WALL = 0.3
"""Ground so far above the way is nothing feet swing over [m]."""
WALL_PLACES = np.arange(0.06, 0.5, 0.05)
"""Distances from the way at which walls are looked for [m]."""
WALL_EVERY = 4
"""Walls are looked for at one in so many samples of a way."""
FAR = 1e3
"""Where there is no wall [m]."""
GRAZED = 0.02
"""A swing so far through a wall costs 1 [m]."""
STEP = 1e-3
"""Least cost of a step, which keeps the search from treading on the spot."""
LONGEST = 1.7
"""Longest step over the gait's own."""
SHORTEST = 0.25
"""Shortest step over the gait's own."""
HIGH = 0.22
"""Rise of a step over the leg length that costs as much as a step twice as long as it should be."""
CROSSING = LintLimits.crossing
"""A foot this far on the other one's side, over the foot length, costs 1: so far lint lets it."""
EASY_TURN = 0.9
"""A step may turn this far for nothing [rad]; as much again costs 1."""


@dataclass(frozen=True, kw_only=True)
class Footholds:
    """What either foot would stand on at every sample of a way."""

    costs: FloatArray
    """0 = firm, more = worse, `BAD` = impossible, shape (M, 2)."""
    heights: FloatArray
    """Of the ground under the ball [m], shape (M, 2)."""
    widths: FloatArray
    """Twice the distance of the ball from the way there [m], shape (M, 2)."""

    @property
    def firm(self) -> BoolArray:
        """Whether both feet stand firmly wherever they come down, shape (M,)."""
        return np.asarray((self.costs <= 0.0).all(axis=1))


def foot_places(
    points: FloatArray, headings: FloatArray, sides: IntArray, *, widths: FloatArray, toe_out: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Places of the balls (x, z) [m] (N, 2) and yaws [rad] (N,) of feet at points of a way.

    Args:
        points: Of the way, (x, z) [m], shape (N, 2).
        headings: Of the way [rad], shape (N,).
        sides: 0 = left, 1 = right, shape (N,).
        widths: Between the feet across the way [m], shape (N,).
        toe_out: [rad], shape (N,).
    """
    outward = np.where(np.asarray(sides) == 0, 1.0, -1.0)
    across = planar.direction(headings + 0.5 * np.pi)  # to the left
    return points + (0.5 * widths * outward)[:, None] * across, headings + outward * toe_out


def find_footholds(
    ways: Ways, gaits: Sequence[Gait], bodies: Sequence[Proportions], *, ground: Ground, samples: IntArray | None = None
) -> Footholds:
    """Footholds of both feet at samples (M,) of the ways, None = at every one."""
    chosen = np.arange(len(ways.arcs)) if samples is None else samples
    shape, step_widths = (len(chosen), 2), np.array([gait.step_width for gait in gaits])
    if ground.faces is None or not len(chosen):
        return Footholds(
            costs=np.full(shape, BAD if ground.has_terrain else 0.0),
            heights=np.full(shape, float(ground.fallback_height)),
            widths=np.repeat(step_widths[ways.rows[chosen], None], 2, axis=1),
        )
    limits: Any = FootholdLimits()
    limits.flattest, limits.pokes, limits.edge = np.cos(STEEPEST), POKES, EDGE
    limits.hangs, limits.hanging, limits.bad, limits.aside = HANGS, HANGING, BAD, ASIDE
    tables: list[tuple[FloatArray | IntArray, type]] = [
        (ways.headings[chosen], wp.float64),
        (ways.rows[chosen], wp.int32),
        (0.5 * step_widths, wp.float64),
        (np.array([gait.toe_out for gait in gaits]), wp.float64),
        (_outlines(bodies), wp.vec2d),
        (ASIDES, wp.float64),
    ]
    centre = float(ground.centre[1])
    costs, heights, outward = (wp.empty(shape, dtype=wp.float64) for _ in range(3))
    wp.launch(
        feel_ground,
        dim=shape,
        inputs=[
            ground.faces,
            limits,
            ground.around_centre(ways.points[chosen], ways.heights[chosen]),
            *(wp.array(values, dtype=dtype) for values, dtype in tables),
            ground.fallback_height - centre,
        ],
        outputs=[costs, heights, outward],
        device="cpu",
    )
    return Footholds(costs=costs.numpy(), heights=heights.numpy() + centre, widths=2.0 * outward.numpy())


def find_walls(ways: Ways, ground: Ground) -> FloatArray:
    """How far to the left and right of each sample of the ways ground rises as a wall, `FAR` = nowhere [m], (M, 2)."""
    if ground.faces is None:
        return np.full((len(ways.arcs), 2), FAR)
    looked = np.arange(0, len(ways.arcs), WALL_EVERY)
    walls = wp.full((len(looked), 2), FAR, dtype=wp.float64)
    wp.launch(
        feel_walls,
        dim=walls.shape,
        inputs=[
            ground.faces,
            ground.around_centre(ways.points[looked], ways.heights[looked]),
            wp.array(ways.headings[looked], dtype=wp.float64),
            wp.array(WALL_PLACES, dtype=wp.float64),
            WALL,
        ],
        outputs=[walls],
        device="cpu",
    )
    return np.asarray(walls.numpy()).repeat(WALL_EVERY, axis=0)[: len(ways.arcs)]


def _outlines(bodies: Sequence[Proportions]) -> FloatArray:
    """Places about the balls, to the left and ahead [m]: ends of the free ground, corners of the sole, (P, 6, 2)."""
    lengths, heels, toes, widths = np.array(
        [(body.foot_length, body.heel, body.toe, body.half_width) for body in bodies]
    ).T
    margins, middle = MARGIN * lengths, np.zeros(len(bodies))
    ends = [(middle, -heels - margins), (middle, toes + margins)]
    corners = [(across, ahead) for across in (-widths, widths) for ahead in (-heels, toes)]
    return np.stack([np.stack(place, axis=-1) for place in (*ends, *corners)], axis=1)


def firm_ends(ways: Ways, footholds: Footholds, gaits: Sequence[Gait]) -> IntArray:
    """First and last sample within each way at which both feet can stand, within a step of its ends, shape (P, 2).

    Where there is none the end itself.
    """
    steps = np.array([gait.step_length for gait in gaits])
    costs, rows, lengths = footholds.costs.max(axis=1), ways.rows, ways.lengths
    within = np.minimum(steps, 0.4 * lengths)[rows]
    ends = []
    for distances in (ways.arcs, lengths[rows] - ways.arcs):
        near = np.where(distances <= within, costs + STEP * distances, np.inf)
        best = np.flatnonzero(near == np.minimum.reduceat(near, ways.first[:-1])[rows])
        ends.append(best[np.unique(rows[best], return_index=True)[1]] - ways.first[:-1])
    return np.stack(ends, axis=1)


def strained_ways(ways: Ways, gaits: Sequence[Gait], *, rows: IntArray, arcs: FloatArray, first_side: int) -> IntArray:
    """Ways on which steps cross the feet, or turn farther than is easy, ascending.

    Args:
        ways: All ways.
        gaits: Of each way's walker.
        rows: Way of each step, ascending, shape (S,).
        arcs: Where it ends along it [m], shape (S,).
        first_side: Foot of each way's first step.
    """
    starts = np.searchsorted(rows, np.arange(len(gaits)))
    outward = 1.0 - 2.0 * ((np.arange(len(rows)) - starts[rows] + first_side) % 2)
    before = np.roll(arcs, 1)
    before[starts] = 0.0
    x, z = (ways.at(rows, arcs, ways.points[:, i]) - ways.at(rows, before, ways.points[:, i]) for i in (0, 1))
    ahead, behind = ways.at(rows, arcs, ways.headings), ways.at(rows, before, ways.headings)
    across = planar.direction(0.5 * (ahead + behind + np.pi))
    widths = np.array([gait.step_width for gait in gaits])[rows] * np.cos(0.5 * (ahead - behind))
    crossed = outward * (x * across[:, 0] + z * across[:, 1]) + widths < 0.0
    return np.unique(rows[crossed | (np.abs(ahead - behind) > EASY_TURN)])


def tread_steps(
    ways: Ways,
    footholds: Footholds,
    gaits: Sequence[Gait],
    *,
    bodies: Sequence[Proportions],
    walls: FloatArray,
    ends: IntArray,
    support: int,
) -> IntArray:
    """Samples of ways to step on, from their starts to their ends: those nearest to even steps on firm footholds.

    On stairs these are the treads. A shortest path over (sample, foot): a step costs the square of how much its length
    differs from what it should be there, and a little more for a high rise, over what lies between too, for feet that
    cross, for a far turn, and for a foot that would swing through a wall from where it stood before. On ground where no
    foot can stand, steps longer than they should be cost as much more as they are longer.

    Args:
        ways: Samples at even spacing.
        footholds: At all of them.
        gaits: Of each way's walker.
        bodies: Of the walkers.
        walls: As from `find_walls`, shape (M, 2).
        ends: Samples within each way where the feet stand first and last, as from `firm_ends`, shape (P, 2).
        support: Foot that stands at the start while the other steps first.

    Returns:
        Indices of the samples of all ways, ascending, shape (S,), without those where the feet stand first.
    """
    start_warp()
    spacings, lengths = ways.arcs[ways.first[:-1] + 1], np.array([gait.step_length for gait in gaits])
    wanted = lengths[ways.rows] * ways.shares
    least = np.maximum((SHORTEST * np.minimum.reduceat(wanted, ways.first[:-1]) / spacings).astype(np.int32), 1)
    most = np.maximum(np.ceil(LONGEST * lengths / spacings).astype(np.int32), least + 1)
    count = len(ways.arcs)
    taken: Any = wp.zeros(count, dtype=wp.bool)
    treads: Any = TreadWays()
    for name, values, dtype in (
        ("first", ways.first, wp.int32),
        ("ends", ends, wp.int32),
        ("offsets", np.stack([least, most], axis=1), wp.int32),
        ("spacings", spacings, wp.float64),
        ("highs", HIGH * np.array([gait.rule.leg_length for gait in gaits]), wp.float64),
        ("crossings", CROSSING * np.array([body.foot_length for body in bodies]), wp.float64),
        ("wanted", wanted, wp.float64),
        ("points", ways.points, wp.vec2d),
        ("headings", ways.headings, wp.float64),
        ("across", planar.direction(ways.headings + 0.5 * np.pi), wp.vec2d),
        ("costs", footholds.costs, wp.float64),
        ("heights", footholds.heights, wp.float64),
        ("tops", footholds.heights.max(axis=1), wp.float64),
        ("widths", footholds.widths, wp.float64),
        ("walls", walls, wp.float64),
        ("walled", np.cumsum((walls < FAR).any(axis=1)).astype(np.int32), wp.int32),
    ):
        setattr(treads, name, wp.array(values, dtype=dtype, device="cpu"))
    treads.least, treads.bad, treads.easy_turn, treads.grazed = STEP, BAD, EASY_TURN, GRAZED
    wp.launch(
        choose_treads,
        dim=len(gaits),
        inputs=[treads, support],
        outputs=[wp.full((count, 2), np.inf, dtype=wp.float64), wp.full((count, 2), -1, dtype=wp.int32), taken],
        device="cpu",
    )
    return np.flatnonzero(taken.numpy())
