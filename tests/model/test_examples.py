"""The phases at which a step's events are put."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.model.examples import LIFTOFF_PHASES, event_knots


def knots(duration: float, swing: float, support: float) -> tuple[np.ndarray, np.ndarray]:
    times, phases = event_knots(np.array([duration]), np.array([swing]), np.array([support]))
    return times[0], phases[0]


def test_events_inside_the_step_lie_on_their_phases() -> None:
    times, phases = knots(0.6, 0.1, 0.5)
    assert_allclose(times, [0.0, 0.1, 0.5, 0.6])
    assert_allclose(phases, [0.0, *LIFTOFF_PHASES, 1.0])


def test_a_walk_has_no_support_liftoff_so_its_phase_runs_straight_to_the_end() -> None:
    times, phases = knots(0.6, 0.1, 0.7)
    assert_allclose(np.interp(phases, [0.0, LIFTOFF_PHASES[0], 1.0], [0.0, 0.1, 0.6]), times)


def test_a_run_has_no_swing_liftoff_so_its_phase_runs_straight_from_the_start() -> None:
    times, phases = knots(0.4, -0.1, 0.3)
    assert_allclose(np.interp(phases, [0.0, LIFTOFF_PHASES[1], 1.0], [0.0, 0.3, 0.4]), times)


def test_without_events_time_runs_straight() -> None:
    times, phases = knots(0.4, -0.1, 0.5)
    assert_allclose(times, 0.4 * phases)


@given(st.floats(0.05, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_knots_always_increase(duration: float, swing: float, support: float) -> None:
    times, phases = knots(duration, swing, support)
    assert np.diff(times).min() > 0.0 and np.diff(phases).min() > 0.0
    assert (times[0], times[-1]) == (0.0, duration)
