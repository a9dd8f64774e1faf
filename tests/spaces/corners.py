"""The device's weights of three corners, for arrays of the host."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.spaces.root_weight_kernel import Corners, weigh_corners


@wp.kernel(enable_backward=False)
def weigh_each(
    corners: wp.array(dtype=Corners), points: wp.array(dtype=wp.vec2d), weights: wp.array(dtype=wp.vec3d)
) -> None:
    """`weigh_corners` of each query."""
    query = wp.tid()
    weights[query] = weigh_corners(corners[query], points[query])


def weigh_triples(corners: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights (N, 3) of the points (N, 2) of triangles (N, 3, 2) nearest to queries (N, 2), and those points."""
    weights = wp.empty(len(points), dtype=wp.vec3d)
    inputs = [wp.array(corners, dtype=Corners), wp.array(points, dtype=wp.vec2d)]
    wp.launch(weigh_each, dim=len(points), inputs=inputs, outputs=[weights])
    return weights.numpy(), np.einsum("nk,nkd->nd", weights.numpy(), corners)
