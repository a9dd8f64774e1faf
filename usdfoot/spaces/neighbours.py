"""Blend weights from the examples most like the wanted step, not only from those around its landing.

Delaunay triangles know landings only: a slow and a quick step to nearly the same spot become corners of one triangle,
chosen by millimetres. Here all triples of the K nearest examples in landing *and* features compete.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, solve_footsteps

__all__ = ["NeighbourSpace", "build_neighbour_space", "solve_neighbours"]

INSIDE_TOLERANCE = 1e-10
SMALLEST_AREA = 1e-5
"""Twice the area [m^2] below which a triple counts as collinear."""
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
    tree: cKDTree
    """Finds the nearest of `coordinates`."""


def build_neighbour_space(footsteps: FootstepSpace, landings: FloatArray, coordinates: FloatArray) -> NeighbourSpace:
    """The space of examples with landings (E, 2) [m] and scaled coordinates (E, D) over their footstep space."""
    order = np.lexsort(coordinates.T[::-1])
    return NeighbourSpace(
        footsteps=footsteps,
        examples=order,
        landings=landings[order],
        coordinates=coordinates[order],
        tree=cKDTree(coordinates[order]),
    )


def solve_neighbours(
    space: NeighbourSpace, queries: FloatArray, coordinates: FloatArray, *, nearest: int = 10
) -> FootstepWeights:
    """Blend weights of the triple around each query that is most like the wanted step.

    Of all triples of the `nearest` examples that contain the landing, the one with the least
    sum_i weight_i |coordinates_i - coordinates|^2, which is the squared error of the blend plus the spread of what is
    blended. Where none contains it, the footstep space's answer.

    Args:
        space: From `build_neighbour_space`.
        queries: Wanted landings, (x, z) [m], shape (N, 2).
        coordinates: Scaled landings and features of the wanted steps, shape (N, D).
        nearest: How many examples compete, at least 3; 10 make 120 triples.

    Returns:
        The weights; simplices and vertices as the footstep space has them, -1 and 0 where a triple is used.
    """
    fallback = solve_footsteps(space.footsteps, queries)
    nearest = min(nearest, len(space.landings))
    if nearest < 3 or len(queries) == 0:
        return fallback
    parts = [slice(begin, begin + CHUNK) for begin in range(0, len(queries), CHUNK)]
    solved = [_solve_part(space, queries[part], coordinates[part], nearest) for part in parts]
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


def _solve_part(
    space: NeighbourSpace, queries: FloatArray, coordinates: FloatArray, nearest: int
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Examples (N, 3), weights (N, 3) and whether a triple was found (N,)."""
    distances, near = space.tree.query(coordinates, k=nearest)
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
    inside = (areas.min(axis=0) >= -INSIDE_TOLERANCE * totals) & (totals >= SMALLEST_AREA)
    squares = distances**2
    costs = areas[0] * squares[:, first] + areas[1] * squares[:, second] + areas[2] * squares[:, third]
    costs = np.where(inside, costs / np.maximum(totals, SMALLEST_AREA), np.inf)
    best = np.argmin(costs, axis=1)
    rows = np.arange(len(queries))
    weights = np.maximum(areas[:, rows, best].T, 0.0)
    found = inside[rows, best]
    weights[~found] = 1.0
    examples = space.examples[near[rows[:, None], triples[best]]]
    return examples, weights / weights.sum(axis=1, keepdims=True), found
