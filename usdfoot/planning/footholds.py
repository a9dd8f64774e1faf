"""Footholds along ways: where a foot stands with its whole sole, and the steps that use those places only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.planning.gait import Gait
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.ways import Ways

__all__ = ["Footholds", "find_footholds", "firm_ends", "foot_places", "tread_steps"]

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
BAD = 100.0
"""Cost of a place where no foot can stand."""
STEP = 1e-3
"""Least cost of a step, which keeps the search from treading on the spot."""
LONGEST = 1.7
"""Longest step over the gait's own."""
SHORTEST = 0.25
"""Shortest step over the gait's own."""
HIGH = 0.22
"""Rise of a step over the leg length that costs as much as a step twice as long as it should be."""


@dataclass(frozen=True, kw_only=True)
class Footholds:
    """What either foot would stand on at every sample of a way."""

    costs: FloatArray
    """0 = firm, more = worse, `BAD` = impossible, shape (M, 2)."""
    heights: FloatArray
    """Of the ground under the ball [m], shape (M, 2)."""

    @property
    def firm(self) -> BoolArray:
        """Whether both feet stand firmly wherever they come down, shape (M,)."""
        return np.asarray((self.costs <= 0.0).all(axis=1))


def foot_places(
    points: FloatArray, headings: FloatArray, sides: IntArray, widths: FloatArray, toe_out: FloatArray
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


def find_footholds(ways: Ways, gaits: list[Gait], bodies: list[Proportions], ground: Ground) -> Footholds:
    """Footholds of both feet at every sample of the ways."""
    rows = ways.rows
    widths = np.array([gait.step_width for gait in gaits])[rows]
    toe_out = np.array([gait.toe_out for gait in gaits])[rows]
    heels = np.array([body.heel + MARGIN * body.foot_length for body in bodies])[rows]
    toes = np.array([body.toe + MARGIN * body.foot_length for body in bodies])[rows]
    costs, heights = np.zeros((len(rows), 2)), np.zeros((len(rows), 2))
    for side in (0, 1):
        places, yaws = foot_places(ways.points, ways.headings, np.full(len(rows), side), widths, toe_out)
        balls = ground.heights(places, ways.heights)
        forward = planar.direction(yaws)
        rise = -np.sum(balls.normals[:, [0, 2]] * forward, axis=1) / balls.normals[:, 1]
        bad = ~balls.walkable | (balls.normals[:, 1] < np.cos(STEEPEST))
        cost = np.zeros(len(rows))
        for reach in (-heels, toes):
            end = ground.heights(places + reach[:, None] * forward, balls.heights)
            above = end.heights - (balls.heights + reach * rise)
            bad |= end.hit & (above > POKES)
            cost += HANGING * (~end.hit | (above < -HANGS)) * ground.has_terrain
        costs[:, side], heights[:, side] = np.where(bad, BAD, cost), balls.heights
    return Footholds(costs=costs, heights=heights)


def firm_ends(ways: Ways, way: int, footholds: Footholds, gait: Gait) -> tuple[int, int]:
    """First and last sample of a way at which both feet can stand, within a step of its ends.

    Where there is none the end itself.
    """
    own = slice(int(ways.first[way]), int(ways.first[way + 1]))
    costs, arcs = footholds.costs[own].max(axis=1), ways.arcs[own]
    ends = []
    for distances in (arcs, arcs[-1] - arcs):
        near = np.where(distances <= min(gait.step_length, 0.4 * arcs[-1]), costs + STEP * distances, np.inf)
        ends.append(int(np.argmin(near)))
    return ends[0], ends[1]


def tread_steps(
    ways: Ways, way: int, footholds: Footholds, gait: Gait, *, ends: tuple[int, int], support: int
) -> IntArray:
    """Samples of a way to step on, from its start to its end: the sequence nearest to even steps on firm footholds.

    On stairs these are the treads. A shortest path over (sample, foot): a step costs the square of how much its length
    differs from what it should be there, and a little more for a high rise.

    Args:
        ways: All ways.
        way: Which.
        footholds: Of all ways.
        gait: Of the walker.
        ends: Samples of the way where the feet stand first and last, as from `firm_ends`.
        support: Foot that stands at the start while the other steps first.

    Returns:
        Sample indices within the way, shape (S,), the last of them the second of `ends`.
    """
    own = slice(int(ways.first[way]), int(ways.first[way + 1]))
    arcs, costs, heights = ways.arcs[own], footholds.costs[own], footholds.heights[own]
    count, spacing = len(arcs), float(arcs[1])
    wanted = gait.step_length * ways.shares[own]
    least = max(1, int(SHORTEST * wanted.min() / spacing))
    most = max(least + 1, int(np.ceil(LONGEST * gait.step_length / spacing)))
    start, offset = np.meshgrid(np.arange(count), np.arange(least, min(most, count - 1) + 1), indexing="ij")
    inside = start + offset < count
    start, end = start[inside], (start + offset)[inside]
    mean = 0.5 * (wanted[start] + wanted[end])
    stretch = ((arcs[end] - arcs[start]) / mean - 1.0) ** 2
    edges = []
    for side in (0, 1):  # the foot that steps
        rise = (heights[end, side] - heights[start, 1 - side]) / (HIGH * gait.rule.leg_length)
        cost = STEP + stretch + rise**4 + costs[end, side]
        edges.append((start + count * (1 - side), end + count * side, cost))
    rows, columns, values = (np.concatenate(parts) for parts in zip(*edges, strict=True))
    graph = csr_array((values, (rows, columns)), shape=(2 * count, 2 * count))
    reached, before = dijkstra(graph, indices=ends[0] + count * support, return_predecessors=True)
    node = ends[1] + count * int(reached[ends[1] + count] < reached[ends[1]])
    if not np.isfinite(reached[node]):
        return np.array([ends[1]])
    steps = [node]
    while before[steps[-1]] >= 0:
        steps.append(int(before[steps[-1]]))
    return np.array(steps[::-1][1:], dtype=int) % count
