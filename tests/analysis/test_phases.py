"""Phases of gaits whose contacts are known."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from usdfoot.analysis.phases import DOUBLE, FLIGHT, LEFT_STANCE, RIGHT_STANCE, phase_changes, stance_phases
from usdfoot.model.plan import FootstepPlan


def plan_of(sides, strikes, liftoffs):
    count = len(sides)
    return FootstepPlan(
        name="plan",
        sides=np.array(sides),
        positions=np.zeros((count, 3)),
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)),
        strike_times=np.array(strikes),
        liftoff_times=np.array(liftoffs),
        root_weights=np.zeros(count),
    )


def test_a_walk_a_run_and_a_stand_have_their_phases():
    plan = plan_of([0, 1, 0, 1], [0.0, 0.5, 1.3, 1.7], [0.6, 1.0, 2.0, 2.0])
    phases = stance_phases(plan, np.array([0.1, 0.55, 0.7, 1.1, 1.5, 1.8]))
    assert_array_equal(phases, [LEFT_STANCE, DOUBLE, RIGHT_STANCE, FLIGHT, LEFT_STANCE, DOUBLE])


def test_an_instant_of_change_belongs_to_what_follows():
    plan = plan_of([0, 1], [0.0, 0.5], [0.6, 1.0])
    assert_array_equal(stance_phases(plan, np.array([0.5, 0.6])), [DOUBLE, RIGHT_STANCE])


def test_changes_are_the_strikes_and_liftoffs_inside():
    plan = plan_of([0, 1, 0], [0.0, 0.0, 1.0], [0.8, 1.2, 2.0])
    assert_allclose(phase_changes(plan), [0.8, 1.0, 1.2])
