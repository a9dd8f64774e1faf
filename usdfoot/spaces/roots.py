"""The root examples of steps: which of a library's examples move the root as wanted, and where they land."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray, StyleArray
from usdfoot.spaces.features import StepFeatures, step_coordinates
from usdfoot.spaces.library import FootstepSpaces, left_landings
from usdfoot.spaces.root_velocity import pick_heaviest, solve_root_velocities
from usdfoot.spaces.tilt import tilt_weights

__all__ = ["ROOT_EXAMPLES", "RootSteps", "find_roots"]

ROOT_EXAMPLES = 5
"""Root examples a step is blended from: with the three of its footstep, as many as the kernels take."""


@dataclass(frozen=True, kw_only=True)
class RootSteps:
    """Root examples of N steps."""

    examples: IntArray
    """Index into the library's examples, heaviest band first, shape (N, ROOT_EXAMPLES)."""
    weights: FloatArray
    """Not negative, sum 1, shape (N, ROOT_EXAMPLES)."""


def find_roots(
    spaces: FootstepSpaces,
    velocities: FloatArray,
    landings: FloatArray,
    *,
    features: StepFeatures,
    swing_sides: IntArray,
    flights: BoolArray,
    styles: Sequence[str] | StyleArray,
    meet: bool = True,
) -> RootSteps:
    """Root examples and weights of steps, from the same style, gait and swing side as their footstep's examples.

    Of examples with nearly the same root velocity, wide and narrow steps for example, it is the one most like the
    wanted step.

    Args:
        spaces: From `build_spaces`.
        velocities: Wanted root velocities, (x, z) in the heading at the step's end [m/s], shape (N, 2).
        landings: Of the footsteps, (x, z) in the heading at the step's end [m], shape (N, 2).
        features: Timing, turn, rise and departure of the steps.
        swing_sides: 0 = left, 1 = right, shape (N,).
        flights: Whether the support foot lifts off before the swing foot strikes, shape (N,).
        styles: Style of each step, N of them.
        meet: Tilt the weights so that the blended root velocity is the wanted one as nearly as these examples allow;
            without, it is what the gradient bands give.

    Raises:
        ClipError: If a style has no step of a swing side.
    """
    count = len(velocities)
    queries, left = left_landings(velocities, swing_sides), left_landings(landings, swing_sides)
    coordinates = step_coordinates(left, features.as_left(swing_sides), spaces.scales)
    weights: FloatArray = np.zeros((count, ROOT_EXAMPLES))
    examples: IntArray = np.zeros((count, ROOT_EXAMPLES), dtype=np.intp)
    for space, steps in spaces.group(left, swing_sides=swing_sides, flights=flights, styles=styles):
        solved = solve_root_velocities(space.roots, queries[steps])
        vertices, weights[steps] = pick_heaviest(solved.weights[:, space.roots.vertices], ROOT_EXAMPLES)
        members = space.roots.members[vertices]  # (n, ROOT_EXAMPLES, most)
        away = spaces.coordinates[space.examples[members]]
        away -= coordinates[steps][:, None, None]
        squares = np.einsum("nkmd,nkmd->nkm", away, away)
        nearest = np.argmin(np.where(members >= 0, squares, np.inf), axis=2)
        examples[steps] = space.examples[np.take_along_axis(members, nearest[..., None], axis=2)[..., 0]]
    if meet:
        weights = tilt_weights(weights, spaces.velocities[examples], queries)
    return RootSteps(examples=examples, weights=weights)
