"""Weights of three corners against a search over all weights."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.spaces.corners import weigh_triples


def searched_distance(corners: np.ndarray, point: np.ndarray) -> float:
    first, second = np.meshgrid(np.linspace(0, 1, 401), np.linspace(0, 1, 401))
    weights = np.stack([first, second, 1.0 - first - second])[:, first + second <= 1.0 + 1e-12]
    return float(np.linalg.norm(weights.T @ corners - point, axis=1).min())


@pytest.mark.parametrize("kind", ["triangle", "collinear", "edge", "point"])
def test_nearest_point_of_the_triangle(kind: str, generator: np.random.Generator) -> None:
    corners, points = generator.uniform(-1, 1, (20, 3, 2)), generator.uniform(-1.5, 1.5, (20, 2))
    if kind == "collinear":
        corners[:, 2] = 0.25 * corners[:, 0] + 0.75 * corners[:, 1]
    if kind in ("edge", "point"):
        corners[:, 2] = corners[:, 1]
    if kind == "point":
        corners[:, 0] = corners[:, 1]
    weights, nearest = weigh_triples(corners, points)
    assert weights.min() >= 0.0
    assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    assert_allclose(np.einsum("nk,nkd->nd", weights, corners), nearest, atol=1e-12)
    found = np.linalg.norm(nearest - points, axis=1)
    expected = [searched_distance(*pair) for pair in zip(corners, points, strict=True)]
    assert_allclose(found, expected, atol=0.01)
    assert np.all(found <= np.array(expected) + 1e-12)
