"""Root weights: the blend of a footstep's triangle with the root velocity's examples ([B] 5, Algorithm 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.triangulation import signed_areas
from usdfoot.spaces.triples import weigh_triples

__all__ = [
    "BEYONDS",
    "RootWeighted",
    "find_beta",
    "find_largest_root_weight",
    "is_in_triangle",
    "replace_corners",
    "root_landing",
    "solve_root_weight",
]

BEYONDS = ("segment", "closest")
"""Where a step lands beyond beta: on the way from the footstep to the root's landing ([B]'s q'), or as near to the
footstep as weights allow none of which is negative."""
SMALLEST_AREA = 1e-9
"""Twice the area [m^2] below which a triangle is degenerate."""
REPLACEMENTS = 3
"""The root's heaviest examples that may replace a corner."""
HALVINGS = 40


@dataclass(frozen=True, kw_only=True)
class RootWeighted:
    """N blends of a triangle's corners with the root's examples, which weigh `root_weights` together."""

    weights: FloatArray
    """lambda_1..3 of the corners, not negative, sum 1 - lambda4, shape (N, 3)."""
    root_weights: FloatArray
    """lambda4, shape (N,)."""
    betas: FloatArray
    """Largest lambda4 that still lands on the footstep, shape (N,)."""
    given_up: FloatArray
    """Share of the way from the footstep to the root's landing that [B]'s q' goes, 0 up to beta, 1 at lambda4 = 1,
    shape (N,)."""
    shifts: FloatArray
    """From the footstep to where the blend lands, (x, z) [m], shape (N, 2)."""


def is_in_triangle(points: FloatArray, corners: FloatArray) -> BoolArray:
    """Whether points (N, 2) lie in triangles (N, 3, 2) of either orientation; never in degenerate ones, shape (N,)."""
    areas = signed_areas(corners, points)
    totals = areas.sum(axis=1)
    areas *= np.sign(totals)[:, None]
    return (np.abs(totals) >= SMALLEST_AREA) & (areas.min(axis=1) >= 0.0)


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
    corners = corners.copy()
    chosen = np.full((len(corners), 3), -1, dtype=np.intp)
    for corner in range(3):
        for example in range(min(REPLACEMENTS, landings.shape[1])):
            trial = corners.copy()
            trial[:, corner] = landings[:, example]
            near = np.linalg.norm(corners[:, corner] - landings[:, example], axis=1) <= epsilons
            fits = (chosen[:, corner] < 0) & near & is_in_triangle(queries, trial)
            corners[fits] = trial[fits]
            chosen[fits, corner] = example
    return corners, chosen


def root_landing(landings: FloatArray, weights: FloatArray) -> FloatArray:
    """R = sum_j w_j p_j ([B] Eq. 3) of landings (N, k, 2) with weights (N, k), shape (N, 2)."""
    return np.einsum("nk,nkd->nd", weights, landings)


def find_beta(corners: FloatArray, weights: FloatArray, roots: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Largest lambda4 for which Eq. 4 and 5 have no negative solution: min over b_i(r) > 0 of b_i(q) / b_i(r).

    Args:
        corners: Shape (N, 3, 2).
        weights: Barycentric coordinates b(q) of the footsteps, not negative, sum 1, shape (N, 3).
        roots: Landings r of the root's examples, shape (N, 2).

    Returns:
        beta, 0..1, shape (N,), and b(r), shape (N, 3). A degenerate triangle has beta 0 and b(r) 0.
    """
    areas = signed_areas(corners, roots)
    totals = areas.sum(axis=1)
    flat = np.abs(totals) < SMALLEST_AREA
    coordinates = areas / np.where(flat, 1.0, totals)[:, None]
    coordinates[flat] = 0.0
    positive = coordinates > 0.0
    ratios = np.where(positive, weights / np.where(positive, coordinates, 1.0), np.inf)
    betas = np.where(flat, 0.0, np.minimum(ratios.min(axis=1), 1.0))
    return betas, coordinates


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
    (lambda4 - beta) / (1 - beta) |r - q|.

    Args:
        corners: Landings of the corners, (x, z) [m], shape (N, 3, 2).
        weights: Barycentric coordinates b(q) of the footsteps, shape (N, 3).
        roots: Landings r of the root's examples, shape (N, 2).
        root_weights: lambda4, 0..1, shape (N,).
        beyond: One of BEYONDS.
    """
    betas, coordinates = find_beta(corners, weights, roots)
    rest = 1.0 - betas
    given_up = np.clip((root_weights - betas) / np.where(rest > 0.0, rest, 1.0), 0.0, 1.0)
    used = np.minimum(root_weights, betas)[:, None]
    solved = (1.0 - given_up)[:, None] * np.maximum(weights - used * coordinates, 0.0)
    shifts = given_up[:, None] * (roots - root_landing(corners, weights))
    if beyond == "closest":
        over = np.flatnonzero(given_up > 0.0)
        solved[over], shifts[over] = _closest(corners[over], weights[over], roots[over], root_weights[over])
    return RootWeighted(
        weights=solved,
        root_weights=np.asarray(root_weights, dtype=float),
        betas=betas,
        given_up=given_up,
        shifts=shifts,
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
        beyond: One of BEYONDS.
    """
    betas, _ = find_beta(corners, weights, roots)
    offsets = np.zeros_like(roots) if offsets is None else offsets
    if beyond == "closest":
        return _halve(corners, weights, roots, tolerances, offsets, betas)
    lengths = np.linalg.norm(roots - root_landing(corners, weights) + offsets, axis=1)
    share = np.where(lengths > tolerances, tolerances / np.where(lengths > 0.0, lengths, 1.0), 1.0)
    return betas + (1.0 - betas) * share


def _closest(
    corners: FloatArray, weights: FloatArray, roots: FloatArray, root_weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weights (N, 3) of the landing nearest to the footstep, and the way there (N, 2).

    What the root's examples leave of the footstep, (q - lambda4 r) / (1 - lambda4), is brought into the triangle.
    """
    footsteps = root_landing(corners, weights)
    rest = 1.0 - root_weights[:, None]
    left = (footsteps - root_weights[:, None] * roots) / np.where(rest > 0.0, rest, 1.0)
    inner, nearest = weigh_triples(corners, left)
    return rest * inner, rest * nearest + root_weights[:, None] * roots - footsteps


def _halve(
    corners: FloatArray,
    weights: FloatArray,
    roots: FloatArray,
    tolerances: FloatArray,
    offsets: FloatArray,
    betas: FloatArray,
) -> FloatArray:
    """Largest lambda4 by bisection: the closest point gets no nearer again, its distance is convex in lambda4."""

    def within(root_weights: FloatArray) -> BoolArray:
        solved = solve_root_weight(corners, weights, roots, root_weights, beyond="closest")
        return np.linalg.norm(solved.shifts + solved.given_up[:, None] * offsets, axis=1) <= tolerances

    low, high = betas.copy(), np.ones_like(betas)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        good = within(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return np.where(within(np.ones_like(betas)), 1.0, low)
