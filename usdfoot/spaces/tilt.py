"""Blend weights tilted so that what they blend meets a wish: corrects weights that are smooth but not exact."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.root_kernels import find_tilts

__all__ = ["tilt_weights"]


def tilt_weights(weights: FloatArray, points: FloatArray, wanted: FloatArray, *, softness: float = 0.03) -> FloatArray:
    """Weights nearest to those given whose points' mean is the wanted one, as far as that goes, shape (N, K).

    Nearest in relative entropy, so they are w_i exp(u . p_i) over their sum: none becomes negative, those of 0 stay 0
    and they change smoothly with the wish. u is the minimum of the convex log sum_i w_i exp(u . (p_i - p)) +
    softness^2 |u|^2 / 2, whose second term bounds u where p cannot be reached; it leaves softness^2 u to miss.

    Args:
        weights: Not negative, sum 1, shape (N, K).
        points: What each of them gives alone, shape (N, K, 2).
        wanted: p, shape (N, 2).
        softness: Spread of points below which they are hardly told apart, in their unit, above 0.
    """
    start_warp()
    tilted = wp.empty(weights.shape, dtype=wp.float64)
    wp.launch(
        find_tilts,
        dim=len(weights),
        inputs=[
            wp.array(np.ascontiguousarray(weights, dtype=float), dtype=wp.float64, copy=False),
            wp.array(np.ascontiguousarray(points, dtype=float), dtype=wp.vec2d, copy=False),
            wp.array(np.ascontiguousarray(wanted, dtype=float), dtype=wp.vec2d, copy=False),
            softness,
        ],
        outputs=[tilted],
    )
    return tilted.numpy()
