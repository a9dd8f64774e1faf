"""Weights of three given corners."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.spaces.triangulation import signed_areas

__all__ = ["weigh_triples"]

SMALLEST_AREA = 1e-9
"""Twice the area [m^2] below which three corners count as collinear."""


def weigh_triples(corners: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights, not negative, sum 1, of the point of each triangle nearest to the query.

    Args:
        corners: Of either orientation; collinear or equal corners are allowed, shape (N, 3, 2).
        points: Queries, shape (N, 2).

    Returns:
        Weights (N, 3) and the nearest points (N, 2), inside the queries themselves.
    """
    areas = signed_areas(corners, points)
    totals = areas.sum(axis=1)
    areas *= np.sign(totals)[:, None]
    inside = (np.abs(totals) >= SMALLEST_AREA) & (areas.min(axis=1) >= 0.0)
    along = np.roll(corners, -1, axis=1) - corners  # edge from each corner to the next, (N, 3, 2)
    offsets = points[:, None] - corners
    squares = np.sum(along**2, axis=-1)
    fractions = np.clip(np.sum(offsets * along, axis=-1) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    rests = offsets - fractions[..., None] * along
    nearest = np.argmin(np.sum(rests**2, axis=-1), axis=1)
    rows = np.arange(len(points))
    weights = np.zeros((len(points), 3))
    weights[rows, (nearest + 1) % 3] = fractions[rows, nearest]
    weights[rows, nearest] = 1.0 - fractions[rows, nearest]
    weights[inside] = areas[inside] / np.abs(totals[inside, None])
    return weights, np.where(inside[:, None], points, points - rests[rows, nearest])
