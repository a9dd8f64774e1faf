"""The root examples of steps: which of a library's examples move the root as wanted, and with which weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.maths.types import BoolArray, FloatArray, IntArray, StyleArray
from usdfoot.spaces.features import StepFeatures, step_coordinates
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.root_choice_kernel import PICKED, choose_roots

__all__ = ["ROOT_EXAMPLES", "RootSteps", "fewer_roots", "find_roots"]

ROOT_EXAMPLES = PICKED
"""Root examples a step is blended from: with the three of its footstep, as many as the kernels take."""


@dataclass(frozen=True, kw_only=True)
class RootSteps:
    """Root examples of N steps."""

    examples: IntArray
    """Index into the library's examples, shape (N, ROOT_EXAMPLES)."""
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

    The heaviest of the gradient bands; of examples with nearly the same root velocity, wide and narrow steps for
    example, the one most like the wanted step. The weights are then tilted until their velocity is the wanted one, as
    nearly as these examples allow. Where they do not allow it, which is where the bands' examples all lie to one side,
    the triangle of examples around the wanted velocity gets as much of the weight as that needs. All of this goes on
    without a jump as the wanted velocity changes, and leaves every example to itself.

    Args:
        spaces: From `build_spaces`.
        velocities: Wanted root velocities, (x, z) in the heading at the step's end [m/s], shape (N, 2).
        landings: Of the footsteps, (x, z) in the heading at the step's end [m], shape (N, 2).
        features: Timing, turn, rise and departure of the steps.
        swing_sides: 0 = left, 1 = right, shape (N,).
        flights: Whether the support foot lifts off before the swing foot strikes, shape (N,).
        styles: Style of each step, N of them.
        meet: Bring the blended root velocity to the wanted one; without, it is what the gradient bands give.

    Raises:
        ClipError: If a style has no step of a swing side.
    """
    count = len(velocities)
    queries, left = left_landings(velocities, swing_sides), left_landings(landings, swing_sides)
    coordinates = step_coordinates(left, features.as_left(swing_sides), spaces.scales)
    weights: FloatArray = np.zeros((count, ROOT_EXAMPLES))
    examples: IntArray = np.zeros((count, ROOT_EXAMPLES), dtype=np.intp)
    numbers = spaces.numbers(left, swing_sides=swing_sides, flights=flights, styles=styles)
    for number in np.unique(numbers):
        steps = np.flatnonzero(numbers == number)
        chosen = wp.empty((len(steps), PICKED), dtype=wp.int32)
        shares = wp.empty((len(steps), PICKED), dtype=wp.float64)
        inputs = [
            spaces.device_velocities[number],
            wp.array(queries[steps], dtype=wp.vec2d, copy=False),
            wp.array(coordinates[steps], dtype=wp.float64, copy=False),
            meet,
        ]
        wp.launch(choose_roots, dim=len(steps), inputs=inputs, outputs=[chosen, shares])
        examples[steps], weights[steps] = chosen.numpy(), shares.numpy()
    return RootSteps(examples=examples, weights=weights)


def fewer_roots(roots: RootSteps, count: int) -> RootSteps:
    """The `count` heaviest; what the next one weighs is taken off all of them, so that none leaves with a jump."""
    order = np.argsort(-roots.weights, axis=1, kind="stable")
    examples, weights = (
        np.take_along_axis(roots.examples, order, axis=1),
        np.take_along_axis(roots.weights, order, axis=1),
    )
    kept = weights[:, :count] - weights[:, count, None]
    kept = np.where(kept.sum(axis=1, keepdims=True) > 0.0, kept, weights[:, :count])
    return RootSteps(examples=examples[:, :count], weights=kept / kept.sum(axis=1, keepdims=True))
