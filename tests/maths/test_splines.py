"""Splines of many runs against scipy's of each."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from usdfoot.maths.runs import Runs
from usdfoot.maths.splines import Splines, build_splines, spline_shares

LENGTHS = np.array([2, 7, 3, 40, 4, 5])


def some_splines() -> Splines:
    generator = np.random.default_rng(1)
    values = generator.standard_normal((LENGTHS.sum(), 3))
    starts, rates = generator.uniform(-2.0, 2.0, len(LENGTHS)), generator.uniform(24.0, 120.0, len(LENGTHS))
    return build_splines(values, first=Runs.of_lengths(LENGTHS).first, starts=starts, rates=rates)


@pytest.mark.parametrize("run", range(len(LENGTHS)))
def test_each_run_is_the_not_a_knot_spline_of_its_own_samples(run: int) -> None:
    splines = some_splines()
    own = slice(splines.first[run], splines.first[run + 1])
    samples = splines.starts[run] + np.arange(LENGTHS[run]) / splines.rates[run]
    times = np.linspace(splines.starts[run], splines.ends[run], 29)
    expected = CubicSpline(samples, splines.values[own])
    runs = np.full(len(times), run)
    assert_allclose(splines.at(runs, times), expected(times), atol=1e-12)
    assert_allclose(
        splines.rates_at(runs, times) / splines.rates[run], expected(times, 1) / splines.rates[run], atol=1e-11
    )


def test_columns_are_those_of_the_whole() -> None:
    splines = some_splines()
    runs = np.array([3, 0, 5])
    times = splines.starts[runs] + 0.01
    columns = np.array([2, 0])
    assert_allclose(splines.at(runs, times, columns), splines.at(runs, times)[:, columns], atol=1e-15)


@pytest.mark.parametrize("knots", [np.array([0, 1, 2, 4, 8, 9]), np.array([-1.0, 0.5, 0.6, 3.0])])
def test_shares_of_uneven_knots_are_the_not_a_knot_spline(knots: np.ndarray) -> None:
    places = np.linspace(knots[0], knots[-1], 41)
    assert_allclose(spline_shares(knots, places), CubicSpline(knots, np.eye(len(knots)))(places), atol=1e-13)
