"""Runs along paths fly as long as in their agents' clips, feet of walks stand no longer; what was given stays."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tests.builders import Gait
from tests.engine.plans import crowd, no_terrain
from tests.engine.walkers import library_of
from usdfoot.engine.animate import PreparedLibraries
from usdfoot.engine.options import EngineOptions
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.flights import fly_like_clips
from usdfoot.planning.path import plan_path

OPTIONS = EngineOptions()
RUN = Gait(step_length=1.0, step_time=0.36, step_width=0.1, duty=0.28)
FLIGHT = (1.0 - 2.0 * RUN.duty) * RUN.step_time


@pytest.fixture(scope="module")
def runners():
    """Two walks, and runs that are in the air for nearly half of their time: a path's are for a quarter."""
    runs = (RUN, replace(RUN, step_width=0.3), replace(RUN, step_length=1.4))
    return library_of([Gait(), Gait(step_length=0.3), *runs])


def flown(library, *plans, flights_open=True):
    """The plans with the flights of the library's clips."""
    scene = crowd(library, plans)
    scene = replace(scene, agents=tuple(replace(agent, flights_open=flights_open) for agent in scene.agents))
    walked = fly_like_clips(scene, options=OPTIONS, libraries=PreparedLibraries(OPTIONS))
    return [agent.plan for agent in walked.agents]


def way(speed):
    path = WalkingPath(name="/Path", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 12.0)]), speed=speed)
    return plan_path(path, Ground(no_terrain()))


def test_a_run_flies_as_long_as_its_clips_at_their_pace_and_no_longer_where_it_is_slower(runners):
    plan = way(2.8)
    (found,) = flown(runners, plan)
    planned, flights = (each.strike_times[1:] - each.liftoff_times[:-1] for each in (plan, found))
    times = np.diff(plan.strike_times)
    runs = planned > 0.0
    assert runs.sum() > 6
    assert_allclose(flights[runs], FLIGHT * np.minimum(times[runs] / RUN.step_time, 1.0), atol=0.02)
    assert np.all(flights[runs] > planned[runs] + 0.03)
    assert_array_equal(found.liftoff_times[:-1][~runs], plan.liftoff_times[:-1][~runs])
    for name in ("strike_times", "positions", "orientations", "sides"):
        assert_array_equal(getattr(found, name), getattr(plan, name))


def test_liftoffs_that_were_given_stay_as_they_are(runners):
    for speed in (2.8, 1.2):
        plan = way(speed)
        assert flown(runners, plan, flights_open=False)[0] is plan


@pytest.mark.parametrize("duty", [0.53, 0.8])
def test_both_feet_of_a_walk_stand_together_no_longer_than_in_its_clips(duty):
    walk = Gait(step_length=0.7, step_time=0.52, duty=duty)
    walkers = library_of([walk, replace(walk, step_length=0.4), replace(walk, step_width=0.3)])
    plan = way(1.35)
    (found,) = flown(walkers, plan)
    planned, together = (each.liftoff_times[:-1] - each.strike_times[1:] for each in (plan, found))
    inner = slice(2, -3)  # the stands at both ends, and the swings from and to them, are as planned
    times = np.diff(plan.strike_times)[inner]
    clips = (2.0 * duty - 1.0) * np.minimum(times, walk.step_time) + np.maximum(times - walk.step_time, 0.0)
    assert_allclose(together[inner], np.minimum(clips, planned[inner]), atol=0.012)
    assert_array_equal(found.liftoff_times[:2], plan.liftoff_times[:2])
    assert_array_equal(found.liftoff_times[-3:], plan.liftoff_times[-3:])
    assert_array_equal(found.strike_times, plan.strike_times)


def test_the_flights_are_the_same_whoever_else_runs(runners):
    plan = way(2.8)
    together, alone = flown(runners, way(3.2), plan)[1], flown(runners, plan)[0]
    assert_array_equal(together.liftoff_times, alone.liftoff_times)
