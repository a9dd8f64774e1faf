"""The device's root weights ([B] 5, Algorithm 1) of many steps at once, for arrays of the host."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.mix_kernel import REPLACEMENTS
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.root_weight_kernel import Corners, RootMix, find_largest, mix_root, replaces_corner


@dataclass(frozen=True, kw_only=True)
class RootWeighted:
    """N blends of a triangle's corners with the root's examples, which weigh `root_weights` together."""

    weights: FloatArray
    """lambda_1..3 of the corners, not negative, sum 1 - lambda4, shape (N, 3)."""
    root_weights: FloatArray
    """lambda4, shape (N,)."""
    betas: FloatArray
    """Largest lambda4 that still lands on the footstep: min over b_i(r) > 0 of b_i(q) / b_i(r), shape (N,)."""
    given_up: FloatArray
    """Share of the way from the footstep to the root's landing that [B]'s q' goes, 0 up to beta, 1 at lambda4 = 1,
    shape (N,)."""
    shifts: FloatArray
    """From the footstep to where the blend lands, (x, z) [m], shape (N, 2)."""


def replace_corners(
    corners: FloatArray, queries: FloatArray, landings: FloatArray, epsilons: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Corners replaced by root examples that land near them ([B] Algorithm 1, lines 1 to 14, counted from 0).

    A corner gives way to the first of the root's three heaviest examples that lands within epsilon of it, if the
    footstep still lies in the new triangle and that is not degenerate.

    Args:
        corners: Landings of the triangle's examples, (x, z) [m], shape (N, 3, 2).
        queries: Footsteps, shape (N, 2).
        landings: Landings of the root's examples, heaviest first, shape (N, k, 2).
        epsilons: Largest distance [m], shape (N,).

    Returns:
        The corners (N, 3, 2) and which root example each is now, -1 if it is as before, shape (N, 3).
    """
    start_warp()
    own = wp.array(corners, dtype=Corners)
    chosen = wp.empty(len(queries), dtype=wp.vec3i)
    inputs = [
        wp.array(queries, dtype=wp.vec2d),
        wp.array(landings[:, :REPLACEMENTS], dtype=wp.vec2d),
        wp.array(epsilons, dtype=wp.float64),
    ]
    wp.launch(replace_each, dim=len(queries), inputs=inputs, outputs=[own, chosen])
    return own.numpy(), chosen.numpy().astype(np.intp)


def solve_root_weight(
    corners: FloatArray,
    weights: FloatArray,
    roots: FloatArray,
    root_weights: FloatArray,
    *,
    beyond: str = "segment",
) -> RootWeighted:
    """Weights of the corners when the root's examples weigh lambda4 ([B] Eq. 4 and 5, in closed form).

    Up to beta lambda_i = b_i(q) - lambda4 b_i(r), which lands on q. Above, on the segment,
    lambda_i = (1 - lambda4) / (1 - beta) (b_i(q) - beta b_i(r)), which misses q by
    (lambda4 - beta) / (1 - beta) |r - q|. A degenerate triangle has beta 0.

    Args:
        corners: Landings of the corners, (x, z) [m], shape (N, 3, 2).
        weights: Barycentric coordinates b(q) of the footsteps, shape (N, 3).
        roots: Landings r of the root's examples, shape (N, 2).
        root_weights: lambda4, 0..1, shape (N,).
        beyond: Where a step lands beyond beta: segment or closest, as of `EngineOptions.beyond_beta`.
    """
    start_warp()
    mixes = wp.empty(len(roots), dtype=RootMix)
    inputs = [*_triangles(corners, weights, roots), wp.array(root_weights, dtype=wp.float64), beyond == "closest"]
    wp.launch(mix_root_each, dim=len(roots), inputs=inputs, outputs=[mixes])
    found = mixes.numpy()
    return RootWeighted(
        weights=found["weights"],
        root_weights=np.asarray(root_weights, dtype=float),
        betas=found["beta"],
        given_up=found["given_up"],
        shifts=found["shift"],
    )


def find_largest_root_weight(
    corners: FloatArray,
    weights: FloatArray,
    roots: FloatArray,
    tolerances: FloatArray,
    *,
    offsets: FloatArray | None = None,
    beyond: str = "segment",
) -> FloatArray:
    """Largest lambda4 at which the foot is planted within a tolerance of the footstep, shape (N,).

    Args:
        corners: Landings of the corners, (x, z) [m], shape (N, 3, 2).
        weights: Barycentric coordinates b(q) of the footsteps, shape (N, 3).
        roots: Landings r of the root's examples, shape (N, 2).
        tolerances: [m], shape (N,).
        offsets: From the wanted footstep to the one that `weights` give, for footsteps outside the hull [m], shape
            (N, 2). IK pulls the foot over what is not given up of it, so that it is planted at
            shift + given_up offset from the wanted footstep.
        beyond: Where a step lands beyond beta: segment or closest, as of `EngineOptions.beyond_beta`.
    """
    start_warp()
    largest = wp.empty(len(roots), dtype=wp.float64)
    inputs = [
        *_triangles(corners, weights, roots),
        wp.array(tolerances, dtype=wp.float64),
        wp.array(np.zeros_like(roots) if offsets is None else offsets, dtype=wp.vec2d),
        beyond == "closest",
    ]
    wp.launch(find_largest_each, dim=len(roots), inputs=inputs, outputs=[largest])
    return largest.numpy()


def _triangles(corners: FloatArray, weights: FloatArray, roots: FloatArray) -> list[wp.array]:
    return [wp.array(corners, dtype=Corners), wp.array(weights, dtype=wp.vec3d), wp.array(roots, dtype=wp.vec2d)]


@wp.kernel(enable_backward=False)
def mix_root_each(
    corners: wp.array(dtype=Corners),
    weights: wp.array(dtype=wp.vec3d),
    roots: wp.array(dtype=wp.vec2d),
    root_weights: wp.array(dtype=wp.float64),
    closest: bool,
    mixes: wp.array(dtype=RootMix),
):
    """`mix_root` of every step."""
    step = wp.tid()
    mixes[step] = mix_root(corners[step], weights[step], roots[step], root_weights[step], closest)


@wp.kernel(enable_backward=False)
def find_largest_each(
    corners: wp.array(dtype=Corners),
    weights: wp.array(dtype=wp.vec3d),
    roots: wp.array(dtype=wp.vec2d),
    tolerances: wp.array(dtype=wp.float64),
    offsets: wp.array(dtype=wp.vec2d),
    closest: bool,
    largest: wp.array(dtype=wp.float64),
):
    """`find_largest` of every step."""
    step = wp.tid()
    largest[step] = find_largest(corners[step], weights[step], roots[step], tolerances[step], offsets[step], closest)


@wp.kernel(enable_backward=False)
def replace_each(
    queries: wp.array(dtype=wp.vec2d),
    landings: wp.array2d(dtype=wp.vec2d),
    epsilons: wp.array(dtype=wp.float64),
    corners: wp.array(dtype=Corners),
    chosen: wp.array(dtype=wp.vec3i),
):
    """Corners (in place) that give way to root examples, and which: -1 if none ([B] Algorithm 1, lines 1 to 14)."""
    step = wp.tid()
    own = corners[step]
    which = wp.vec3i(-1, -1, -1)
    for corner in range(3):
        for example in range(landings.shape[1]):
            landing = landings[step, example]
            if which[corner] < 0 and replaces_corner(own, corner, landing, queries[step], epsilons[step]):
                own[corner] = landing
                which[corner] = example
    corners[step] = own
    chosen[step] = which
