"""Blend weights from the examples most like the wanted step, not only from those around its landing.

Delaunay triangles know landings only: a slow and a quick step to nearly the same spot become corners of one triangle,
chosen by millimetres. Here the examples nearest in landing *and* features compete, the best of each direction seen
from the wanted landing, so that a row of steady steps on one line finds partners on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, solve_footsteps

__all__ = ["NeighbourSpace", "build_neighbour_space", "solve_neighbours"]

INSIDE_TOLERANCE = 1e-10
SMALLEST_AREA = 1e-5
"""Twice the area [m^2] below which a triple counts as collinear."""
OCTANTS = 8
CLOSEST = 3
FAR = 1e12
CHUNK = 1024
"""Queries solved in one go; their triples then stay in the processor's cache."""


@dataclass(frozen=True, kw_only=True)
class NeighbourSpace:
    """E examples of one swing side in the space of landings and features."""

    footsteps: FootstepSpace
    """Answers where no triple contains the landing."""
    examples: IntArray
    """Examples in lexicographic order of coordinates, which settles ties, shape (E,)."""
    landings: FloatArray
    """Their landings, (x, z) [m], shape (E, 2)."""
    coordinates: FloatArray
    """Their scaled landings and features, shape (E, D)."""


def build_neighbour_space(footsteps: FootstepSpace, landings: FloatArray, coordinates: FloatArray) -> NeighbourSpace:
    """The space of examples with landings (E, 2) [m] and scaled coordinates (E, D) over their footstep space."""
    order = np.lexsort(coordinates.T[::-1])
    return NeighbourSpace(
        footsteps=footsteps,
        examples=order,
        landings=landings[order],
        coordinates=coordinates[order],
    )


def solve_neighbours(space: NeighbourSpace, queries: FloatArray, coordinates: FloatArray) -> FootstepWeights:
    """Blend weights of the triple around each query that is most like the wanted step.

    Of all triples of candidates that contain the landing, the one with the least
    sum_i weight_i |coordinates_i - coordinates|^2, which is the squared error of the blend plus the spread of what is
    blended. Candidates are the nearest example in each octant about the landing and the CLOSEST nearest of all.
    Where no triple contains the landing, the footstep space's answer.

    Args:
        space: From `build_neighbour_space`.
        queries: Wanted landings, (x, z) [m], shape (N, 2).
        coordinates: Scaled landings and features of the wanted steps, shape (N, D).

    Returns:
        The weights; simplices and vertices as the footstep space has them, -1 and 0 where a triple is used.
    """
    fallback = solve_footsteps(space.footsteps, queries)
    if len(space.landings) < 3 or len(queries) == 0:
        return fallback
    parts = [slice(begin, begin + CHUNK) for begin in range(0, len(queries), CHUNK)]
    solved = [_solve_part(space, queries[part], coordinates[part]) for part in parts]
    examples, weights, found = (np.concatenate(arrays) for arrays in zip(*solved, strict=True))
    rows = found[:, None]
    return FootstepWeights(
        examples=np.where(rows, examples, fallback.examples),
        weights=np.where(rows, weights, fallback.weights),
        hull_distances=np.where(found, 0.0, fallback.hull_distances),
        projections=np.where(rows, queries, fallback.projections),
        simplices=np.where(found, -1, fallback.simplices),
        vertices=np.where(rows, 0, fallback.vertices),
    )


def _candidates(offsets: FloatArray, squares: FloatArray) -> tuple[IntArray, FloatArray]:
    """Examples that compete, shape (N, OCTANTS + CLOSEST), and their squared distances; infinite if there is none.

    Args:
        offsets: Examples' landings from the wanted ones, (x, z) [m], shape (N, E, 2).
        squares: Squared distances in coordinates, shape (N, E).
    """
    x, z = offsets[..., 0], offsets[..., 1]
    octants = 4 * (x < 0.0) + 2 * (z < 0.0) + (np.abs(x) < np.abs(z))
    near, costs = [], []
    for octant in range(OCTANTS):
        own = np.where(octants == octant, squares, np.inf)
        best = np.argmin(own, axis=1)
        near.append(best)
        costs.append(np.take_along_axis(own, best[:, None], axis=1)[:, 0])
    closest = min(CLOSEST, squares.shape[1])
    extra = np.argpartition(squares, closest - 1, axis=1)[:, :closest]
    extra = np.sort(extra, axis=1)
    extra_costs = np.take_along_axis(squares, extra, axis=1)
    return np.column_stack([*near, extra]), np.column_stack([*costs, extra_costs])


def _solve_part(
    space: NeighbourSpace, queries: FloatArray, coordinates: FloatArray
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Examples (N, 3), weights (N, 3) and whether a triple was found (N,)."""
    differences = space.coordinates - coordinates[:, None]
    near, squares = _candidates(space.landings - queries[:, None], np.einsum("ned,ned->ne", differences, differences))
    nearest = near.shape[1]
    x, z = np.moveaxis(space.landings[near] - queries[:, None], -1, 0)  # (N, K)
    triples = np.array(list(combinations(range(nearest), 3)))
    pairs = np.array(list(combinations(range(nearest), 2)))
    number = np.zeros((nearest, nearest), dtype=np.intp)
    number[pairs[:, 0], pairs[:, 1]] = np.arange(len(pairs))
    crosses = x[:, pairs[:, 0]] * z[:, pairs[:, 1]] - z[:, pairs[:, 0]] * x[:, pairs[:, 1]]
    first, second, third = triples.T
    areas = np.stack(  # (3, N, triples), twice the area opposite each corner
        [crosses[:, number[second, third]], -crosses[:, number[first, third]], crosses[:, number[first, second]]]
    )
    totals = areas.sum(axis=0)
    areas *= np.sign(totals)
    totals = np.abs(totals)
    present = np.isfinite(squares)
    inside = (areas.min(axis=0) >= -INSIDE_TOLERANCE * totals) & (totals >= SMALLEST_AREA)
    inside &= present[:, first] & present[:, second] & present[:, third]
    squares = np.minimum(squares, FAR)
    costs = areas[0] * squares[:, first] + areas[1] * squares[:, second] + areas[2] * squares[:, third]
    costs = np.where(inside, costs / np.maximum(totals, SMALLEST_AREA), np.inf)
    best = np.argmin(costs, axis=1)
    rows = np.arange(len(queries))
    weights = np.maximum(areas[:, rows, best].T, 0.0)
    found = inside[rows, best]
    weights[~found] = 1.0
    examples = space.examples[near[rows[:, None], triples[best]]]
    return examples, weights / weights.sum(axis=1, keepdims=True), found
