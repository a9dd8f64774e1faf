"""Blends that land on their footsteps: query the footstep space, measure the landing, correct ([B] 4.3, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from usdfoot.engine.correction_kernel import CorrectedStep, CorrectionOptions, correct_each
from usdfoot.engine.edge_kernel import edge_each
from usdfoot.engine.landing_kernel import BlendArrays
from usdfoot.engine.poses import Setup
from usdfoot.engine.queries import StepQueries, asked_landings
from usdfoot.engine.retry_kernel import retry_each
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.features import step_coordinates
from usdfoot.spaces.landings import left_landings, root_starts
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.tetrahedra import SPEED_SCALE

__all__ = ["CorrectedSteps", "correct_steps", "empty_blends"]


ON_HULL = 1e-9
"""A footstep this near to a hull is on it [m]: distances to hulls that are lines are rounded."""


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
    Where that still misses a footstep inside the hull, other examples around it are tried, those most like the step
    first. Footsteps that are missed still and lie between an edge of the hull and where its blends land are outside. In
    the 3-D space they are chosen anew each time.

    Args:
        setup: Library and options.
        spaces: Footstep spaces of the setup's examples.
        queries: The N steps.
        corrections: How often the query is corrected at most.
        entries: Poses the steps come from, as `EndPoses` has them, shape (N, P); None = whatever they are.
    """
    sides, count = queries.swing_sides, len(queries.landings)
    landings = asked_landings(queries, frame=setup.options.frame)
    coordinates = step_coordinates(landings, queries.features.as_left(sides), spaces.scales)
    if entries is not None:
        coordinates = np.column_stack([coordinates, entries])
    numbers = spaces.numbers(landings, swing_sides=sides, flights=queries.flights, styles=queries.styles)
    width = 4 if setup.options.space == "3d" else 3
    blends, corrected = empty_blends(count, width), wp.empty(count, dtype=CorrectedStep)
    device = spaces.device if entries is None else spaces.device_from_poses
    chosen = _options(setup, spaces, corrections)
    space, side = wp.array(numbers, dtype=wp.int32), wp.array(sides, dtype=wp.int32)
    places = wp.array(landings, dtype=wp.vec2d, copy=False)
    wanted = wp.array(coordinates, dtype=wp.float64, copy=False)
    speeds = wp.array(SPEED_SCALE * queries.speeds, dtype=wp.float64)
    wp.launch(
        correct_each,
        dim=count,
        inputs=[setup.library, device, chosen, space, side, places, speeds, wanted],
        outputs=[blends, corrected],
    )
    again = _missing(corrected.numpy(), chosen)
    if again.size:
        wp.launch(
            retry_each,
            dim=again.size,
            inputs=[setup.library, device, chosen, wp.array(again, dtype=wp.int32), space, side, places, wanted],
            outputs=[blends, corrected],
        )
    beyond = _missing(corrected.numpy(), chosen)
    if beyond.size:
        wp.launch(
            edge_each,
            dim=beyond.size,
            inputs=[setup.library, device, wp.array(beyond, dtype=wp.int32), space, side, places],
            outputs=[blends, corrected],
        )
    found, examples, weights = corrected.numpy(), blends.examples.numpy().astype(np.intp), blends.weights.numpy()
    missed = left_landings(found["missed"], sides)
    if setup.options.frame == "root":
        missed += _root_errors(setup, queries, examples=examples, weights=weights)
    return CorrectedSteps(
        examples=examples,
        weights=weights,
        missed=missed,
        hull_distances=found["hull_distance"],
        biases=found["bias"],
    )


def _root_errors(setup: Setup, queries: StepQueries, *, examples: IntArray, weights: FloatArray) -> FloatArray:
    """How far from the blends' root the footsteps' is as the steps start, (x, z) in the heading at the end [m], (N, 2).

    The support ball stays where it stands, so a step lands as far off as that.
    """
    turns = np.sum(weights * setup.examples.turns[examples], axis=1)
    blended = np.einsum("nk,nkd->nd", weights, root_starts(setup.examples.departures)[examples])
    return planar.rotate(-queries.turns, root_starts(queries.features.departures)) - planar.rotate(-turns, blended)


def _missing(corrected: Any, options: CorrectionOptions) -> IntArray:
    """The steps that miss a footstep inside the hull, where other examples may be tried."""
    tried = options.by_features and options.corrections > 0
    missed = np.linalg.norm(corrected["missed"], axis=1) > options.choice_near
    return np.flatnonzero(tried & missed & (corrected["hull_distance"] < ON_HULL))


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
    chosen.by_features, chosen.solid = options.space == "neighbours", options.space == "3d"
    chosen.corrections = corrections * options.correction
    chosen.near, chosen.choice_near = options.landing_tolerance, options.choice_tolerance
    chosen.landing_scale = spaces.scales.landing
    return chosen
