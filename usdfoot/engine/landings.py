"""Where blended steps land: the blend of chosen examples, and the landing measured on its pose ([B] Fig. 5)."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import land_blends
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import StepQueries
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.landings import left_landings

__all__ = ["blend_landings", "blend_twists", "stand_blend", "with_steps"]


def stand_blend(count: int, stand: int, *, width: int) -> StepBlend:
    """Blend of `count` segments that stand; each may take `width` examples."""
    weights = np.zeros((count, width))
    weights[:, 0] = 1.0
    return StepBlend(examples=np.full((count, width), stand), weights=weights, twists=np.zeros(count))


def with_steps(
    blend: StepBlend, steps: IntArray, *, examples: IntArray, weights: FloatArray, twists: FloatArray
) -> StepBlend:
    """The blend with other examples and weights (N, K), heaviest first, and twists (N,) [rad] of the `steps` (N,)."""
    all_examples, all_weights, all_twists = blend.examples.copy(), blend.weights.copy(), blend.twists.copy()
    used = examples.shape[1]
    all_examples[steps] = examples[:, :1]
    all_examples[steps, :used] = examples
    all_weights[steps] = 0.0
    all_weights[steps, :used] = weights
    all_twists[steps] = twists
    return StepBlend(examples=all_examples, weights=all_weights, twists=all_twists)


def blend_twists(setup: Setup, queries: StepQueries, *, examples: IntArray, weights: FloatArray) -> FloatArray:
    """Turn on top of the examples' own that ends N blends in the planned heading [rad], shape (N,)."""
    return planar.wrap_angle(queries.turns - np.sum(weights * setup.examples.turns[examples], axis=1))


def blend_landings(
    device: LibraryArrays, swing_sides: IntArray, *, examples: IntArray, weights: FloatArray
) -> FloatArray:
    """Where the swing foot of N blends is going to be planted, (x, z) in the heading at the step's end [m], (N, 2).

    Measured on the blended pose, which lands a little off the blend of the examples' landings.

    Args:
        device: All examples.
        swing_sides: 0 = left, 1 = right, shape (N,).
        examples: Heaviest first, shape (N, K).
        weights: Not negative, sum 1, shape (N, K).
    """
    landings = wp.empty(len(examples), dtype=wp.vec2d)
    wp.launch(
        land_blends,
        dim=len(examples),
        inputs=[
            device,
            wp.array(examples, dtype=wp.int32),
            wp.array(weights, dtype=wp.float64),
            wp.array(swing_sides, dtype=wp.int32),
        ],
        outputs=[landings],
    )
    return left_landings(landings.numpy(), swing_sides)
