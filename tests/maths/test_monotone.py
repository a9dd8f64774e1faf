"""Monotone cubics against scipy, and the rules they must keep."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from usdfoot.maths.monotone import pchip_slopes


def random_knots(seed: int, sets: int, knots: int) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    times = np.cumsum(generator.uniform(0.01, 1.0, (sets, knots)), axis=1)
    values = generator.normal(size=(sets, knots)) * generator.choice([0.0, 1.0, 5.0], size=(sets, knots))
    return times, values


@pytest.mark.parametrize("knots", [2, 3, 4, 7])
def test_agrees_with_scipy(knots: int) -> None:
    times, values = random_knots(knots, 200, knots)
    slopes = pchip_slopes(times, values)
    for i in range(200):
        reference = PchipInterpolator(times[i], values[i])
        assert_allclose(slopes[i], reference(times[i], 1), rtol=0, atol=1e-12 * max(1.0, np.abs(slopes[i]).max()))


@given(st.integers(0, 10_000), st.integers(2, 8))
def test_increasing_knots_give_an_increasing_warp(seed: int, knots: int) -> None:
    generator = np.random.default_rng(seed)
    times = np.cumsum(generator.uniform(1e-3, 1.0, (1, knots)), axis=1)
    values = np.cumsum(generator.uniform(1e-3, 1.0, (1, knots)), axis=1)
    queries = np.linspace(times[0, 0], times[0, -1], 301)
    warped = CubicHermiteSpline(times[0], values[0], pchip_slopes(times, values)[0])(queries)
    assert np.all(np.diff(warped) >= -1e-13)


def test_straight_knots_stay_straight() -> None:
    times = np.array([[0.0, 0.3, 0.4, 1.0]])
    assert_allclose(pchip_slopes(times, 2.0 * times + 1.0), 2.0, atol=1e-14)
