"""Blends that land on their footsteps: query the footstep space, measure the landing, correct ([B] 4.3, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.landings import blend_landings
from usdfoot.engine.poses import Setup
from usdfoot.engine.queries import StepQueries, ask_spaces
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["CorrectedSteps", "correct_steps"]


@dataclass(frozen=True, kw_only=True)
class CorrectedSteps:
    """Blends of N steps, and what they are left to miss."""

    examples: IntArray
    """Heaviest first, shape (N, 3); (N, 4) in the 3-D space."""
    weights: FloatArray
    """Not negative, sum 1, of the same shape."""
    missed: FloatArray
    """Footstep minus blended landing, (x, z) in the heading at the step's end [m], shape (N, 2)."""
    hull_distances: FloatArray
    """Footstep to the hull of the space [m], shape (N,)."""
    landings: FloatArray
    """Landing the weights were solved for, in that heading [m], shape (N, 2)."""


def correct_steps(
    setup: Setup, spaces: FootstepSpaces, queries: StepQueries, *, corrections: int, entries: FloatArray | None = None
) -> CorrectedSteps:
    """Blends that land on the footsteps asked for, as nearly as the examples allow.

    The blended landing is measured and the query moved by what it missed; the chosen examples are weighed anew, twice,
    before others are chosen. Of all tries the best is kept.

    Args:
        setup: Library and options.
        spaces: Footstep spaces of the setup's examples.
        queries: The N steps.
        corrections: How often the query is corrected at most.
        entries: Poses the steps come from, as `EndPoses` has them, shape (N, P); None = whatever they are.
    """
    options, count = setup.options, len(queries.landings)
    width = 4 if options.space == "3d" else 3
    chosen, examples = np.zeros((2, count, width), dtype=np.intp)
    weights, missed, best = np.zeros((count, width)), np.zeros((count, 2)), np.full(count, np.inf)
    hull: FloatArray = np.zeros(count)
    asked, kept = queries.landings.copy(), queries.landings.copy()
    active, own = np.arange(count), queries
    for round_ in range(1 + corrections * options.correction):
        solved = ask_spaces(
            setup,
            spaces,
            own,
            asked[active],
            examples=chosen[active] if round_ % 3 else None,
            entries=None if entries is None else entries[active],
        )
        chosen[active] = solved.examples
        if round_ == 0:
            hull = solved.hull_distances
        rest = own.landings - blend_landings(
            setup.examples, setup.library, own.swing_sides, solved.examples, solved.weights
        )
        distance = np.linalg.norm(rest, axis=1)
        better = distance < best[active]
        rows = active[better]
        best[rows], missed[rows], kept[rows] = distance[better], rest[better], asked[rows]
        examples[rows], weights[rows] = solved.examples[better], solved.weights[better]
        asked[active] = solved.projections + rest
        choosing = (round_ + 1) % 3 == 0
        active = active[distance > (options.choice_tolerance if choosing else options.landing_tolerance)]
        if not active.size:
            break
        own = queries[active]
    return CorrectedSteps(examples=examples, weights=weights, missed=missed, hull_distances=hull, landings=kept)
