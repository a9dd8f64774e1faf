"""Blend weights from the examples most like the wanted step, not only from those around its landing.

Delaunay triangles know landings only: a slow and a quick step to nearly the same spot become corners of one triangle,
chosen by millimetres. Here the examples nearest in landing *and* features compete, the best of each direction seen
from the wanted landing, so that a row of steady steps on one line finds partners on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, solve_footsteps
from usdfoot.spaces.neighbour_kernel import find_triples

__all__ = ["NeighbourSpace", "build_neighbour_space", "solve_neighbours"]


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
    if len(space.landings) < 3 or len(queries) == 0:
        return solve_footsteps(space.footsteps, queries)
    examples, weights = _best_triples(space, queries, coordinates)
    missing = np.flatnonzero(examples[:, 0] < 0)
    fallback = solve_footsteps(space.footsteps, queries[missing])
    solved = FootstepWeights(
        examples=space.examples[examples],
        weights=weights,
        hull_distances=np.zeros(len(queries)),
        projections=np.array(queries, dtype=float),
        simplices=np.full(len(queries), -1, dtype=np.intp),
        vertices=np.zeros((len(queries), 3), dtype=np.intp),
    )
    for field in fields(FootstepWeights):
        getattr(solved, field.name)[missing] = getattr(fallback, field.name)
    return solved


def _best_triples(space: NeighbourSpace, queries: FloatArray, coordinates: FloatArray) -> tuple[IntArray, FloatArray]:
    """Rows of the space (N, 3), -1 where no triple contains the landing, and their weights (N, 3)."""
    start_warp()
    count = len(queries)
    triples, weights = wp.empty(count, dtype=wp.vec3i), wp.empty(count, dtype=wp.vec3d)
    wp.launch(
        find_triples,
        dim=count,
        inputs=[
            wp.array(space.landings, dtype=wp.vec2d),
            wp.array(space.coordinates, dtype=wp.float64),
            wp.array(np.ascontiguousarray(queries), dtype=wp.vec2d),
            wp.array(np.ascontiguousarray(coordinates), dtype=wp.float64),
        ],
        outputs=[triples, weights],
    )
    return triples.numpy(), weights.numpy()
