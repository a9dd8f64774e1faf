"""Blends that land on their footsteps: query the footstep space, measure the landing, correct ([B] 4.3, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.correction_kernel import CorrectedStep, CorrectionOptions, correct_each
from usdfoot.engine.landing_kernel import BlendArrays
from usdfoot.engine.landings import blend_landings
from usdfoot.engine.poses import Setup
from usdfoot.engine.queries import StepQueries, ask_tetrahedra
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.device_spaces import device_spaces
from usdfoot.spaces.features import step_coordinates
from usdfoot.spaces.library import FootstepSpaces, left_landings

__all__ = ["CorrectedSteps", "correct_steps", "empty_blends"]


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
    biases: FloatArray
    """Blended landing minus the blend of the examples' landings, as if the left foot swung [m], shape (N, 2)."""


def correct_steps(
    setup: Setup, spaces: FootstepSpaces, queries: StepQueries, *, corrections: int, entries: FloatArray | None = None
) -> CorrectedSteps:
    """Blends that land on the footsteps asked for, as nearly as the examples allow.

    The blended landing is measured and the query moved by what it missed; the chosen examples are weighed anew, twice,
    before others are chosen. Beyond an edge of theirs, those that adjoin there follow. Of all tries the best is kept.
    In the 3-D space they are chosen anew each time.

    Args:
        setup: Library and options.
        spaces: Footstep spaces of the setup's examples.
        queries: The N steps.
        corrections: How often the query is corrected at most.
        entries: Poses the steps come from, as `EndPoses` has them, shape (N, P); None = whatever they are.
    """
    if setup.options.space == "3d":
        return _correct_solid(setup, spaces, queries, corrections=corrections)
    sides, count = queries.swing_sides, len(queries.landings)
    landings = left_landings(queries.landings, sides)
    coordinates = step_coordinates(landings, queries.features.as_left(sides), spaces.scales)
    if entries is not None:
        coordinates = np.column_stack([coordinates, entries])
    numbers = spaces.numbers(landings, swing_sides=sides, flights=queries.flights, styles=queries.styles)
    blends, corrected = empty_blends(count, 3), wp.empty(count, dtype=CorrectedStep)
    wp.launch(
        correct_each,
        dim=count,
        inputs=[
            setup.library,
            spaces.device if entries is None else device_spaces(spaces, entered=True),
            _options(setup, spaces, corrections),
            wp.array(numbers, dtype=wp.int32),
            wp.array(sides, dtype=wp.int32),
            wp.array(landings, dtype=wp.vec2d, copy=False),
            wp.array(coordinates, dtype=wp.float64, copy=False),
        ],
        outputs=[blends, corrected],
    )
    found = corrected.numpy()
    return CorrectedSteps(
        examples=blends.examples.numpy().astype(np.intp),
        weights=blends.weights.numpy(),
        missed=left_landings(found["missed"], sides),
        hull_distances=found["hull_distance"],
        biases=found["bias"],
    )


def empty_blends(count: int, width: int) -> BlendArrays:
    """Room for blends of `count` steps of `width` examples."""
    blends = BlendArrays()
    blends.examples = wp.empty((count, width), dtype=wp.int32)
    blends.weights = wp.empty((count, width), dtype=wp.float64)
    blends.tried_examples = wp.empty((count, width), dtype=wp.int32)
    blends.tried_weights = wp.empty((count, width), dtype=wp.float64)
    return blends


def _options(setup: Setup, spaces: FootstepSpaces, corrections: int) -> CorrectionOptions:
    options, chosen = setup.options, CorrectionOptions()
    chosen.by_features = options.space == "neighbours"
    chosen.corrections = corrections * options.correction
    chosen.near, chosen.choice_near = options.landing_tolerance, options.choice_tolerance
    chosen.landing_scale = spaces.scales.landing
    return chosen


def _correct_solid(setup: Setup, spaces: FootstepSpaces, queries: StepQueries, *, corrections: int) -> CorrectedSteps:
    """The same with the corners of tetrahedra."""
    options, count = setup.options, len(queries.landings)
    examples, weights = np.zeros((count, 4), dtype=np.intp), np.zeros((count, 4))
    missed, best = np.zeros((count, 2)), np.full(count, np.inf)
    hull: FloatArray = np.zeros(count)
    asked, active, own = queries.landings.copy(), np.arange(count), queries
    for round_ in range(1 + corrections * options.correction):
        solved = ask_tetrahedra(spaces, own, asked[active])
        if round_ == 0:
            hull = solved.hull_distances
        rest = own.landings - blend_landings(setup.library, own.swing_sides, solved.examples, solved.weights)
        distance = np.linalg.norm(rest, axis=1)
        better = distance < best[active]
        rows = active[better]
        best[rows], missed[rows] = distance[better], rest[better]
        examples[rows], weights[rows] = solved.examples[better], solved.weights[better]
        asked[active] = solved.projections + rest
        choosing = (round_ + 1) % 3 == 0
        active = active[distance > (options.choice_tolerance if choosing else options.landing_tolerance)]
        if not active.size:
            break
        own = queries[active]
    return CorrectedSteps(
        examples=examples, weights=weights, missed=missed, hull_distances=hull, biases=np.zeros((count, 2))
    )
