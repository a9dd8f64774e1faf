"""The phases at which a step's events are put."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.model.examples import LIFTOFF_PHASES, LIFTOFF_WINDOW, event_knots


def knots(duration: float, swing: float, support: float) -> tuple[np.ndarray, np.ndarray]:
    times, phases = event_knots(np.array([duration]), np.array([swing]), np.array([support]))
    return times[0], phases[0]


def test_events_inside_the_step_lie_on_their_phases() -> None:
    times, phases = knots(0.6, 0.1, 0.45)
    assert_allclose(times, [0.0, 0.1, 0.45, 0.6])
    assert_allclose(phases, [0.0, *LIFTOFF_PHASES, 1.0])


@pytest.mark.parametrize(("swing", "support"), [(-0.1, 0.7), (0.59, 0.01)])
def test_events_outside_their_windows_stay_at_the_edge(swing: float, support: float) -> None:
    edge, middle = LIFTOFF_WINDOW
    times, _ = knots(0.6, swing, support)
    expected = (edge, 1.0 - edge) if swing < 0.0 else (middle, 1.0 - middle)
    assert_allclose(times[1:3], 0.6 * np.array(expected))


def test_knots_scale_with_the_step() -> None:
    assert_allclose(knots(1.2, 0.2, 0.9)[0], 2.0 * knots(0.6, 0.1, 0.45)[0])


@given(st.floats(0.05, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_knots_always_increase(duration: float, swing: float, support: float) -> None:
    times, phases = knots(duration, swing, support)
    assert np.diff(times).min() > 0.0 and np.diff(phases).min() > 0.0
    assert (times[0], times[-1]) == (0.0, duration)
