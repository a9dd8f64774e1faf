"""Timing from footprints alone."""

import numpy as np
import pytest

from usdfoot.analysis.footstep_times import time_footsteps, time_rows
from usdfoot.analysis.timing import TimingRule, time_steps
from usdfoot.errors import PlanError


def row_of_prints(distances):
    positions = np.zeros((len(distances) + 1, 3))
    positions[1:, 2] = np.cumsum(distances)
    return positions


def test_walking_steps_keep_the_walk_ratio():
    lengths = np.linspace(0.55, 0.85, 7)
    timing = time_steps(lengths, TimingRule())
    cadences = 60.0 / timing.step_times
    np.testing.assert_allclose(lengths / cadences, 0.006, rtol=1e-12)
    assert not timing.flies.any()
    assert (timing.overlaps > 0.0).all()


def test_short_steps_last_no_longer_than_the_longest():
    np.testing.assert_allclose(time_steps(np.array([0.0, 0.1, 0.3]), TimingRule()).step_times, 0.7)


def test_steps_fly_from_froude_number_one_half_on():
    rule = TimingRule()
    lengths = np.linspace(0.5, 1.5, 401)
    timing = time_steps(lengths, rule)
    walked = ~timing.flies
    fastest = (lengths[walked] / timing.step_times[walked]).max()
    assert fastest**2 / (rule.gravity * rule.leg_length) == pytest.approx(0.5, abs=0.01)
    assert (np.diff(timing.flies.astype(int)) >= 0).all()
    given = time_steps(lengths, TimingRule(flight_distance=1.2))
    np.testing.assert_array_equal(given.flies, lengths > 1.2)
    speeds = (lengths / given.step_times)[~given.flies]
    assert speeds.max() ** 2 / (rule.gravity * rule.leg_length) == pytest.approx(0.5)  # however long the step


@pytest.mark.parametrize("scale", [0.25, 3.0])
def test_legs_of_other_lengths_move_alike(scale):
    lengths = np.linspace(0.2, 2.5, 24)
    human = time_steps(lengths, TimingRule())
    other = time_steps(scale * lengths, TimingRule(leg_length=scale * TimingRule().leg_length))
    np.testing.assert_allclose(other.step_times, np.sqrt(scale) * human.step_times)
    np.testing.assert_allclose(other.overlaps, np.sqrt(scale) * human.overlaps)


def test_weaker_gravity_slows_all_steps_alike():
    lengths = np.linspace(0.2, 2.5, 24)
    earth = time_steps(lengths, TimingRule())
    light = time_steps(lengths, TimingRule(gravity=TimingRule().gravity / 4.0))
    np.testing.assert_allclose(light.step_times, 2.0 * earth.step_times)
    np.testing.assert_allclose(light.overlaps, 2.0 * earth.overlaps)


def test_feet_stand_as_long_as_those_of_people():
    """Of a stride 0.66 to 0.55 in walks (Grieve and Gear 1966), from 0.42 down in runs (Minetti and Alexander 1997)."""
    timing = time_steps(np.linspace(0.5, 2.0, 61), TimingRule())
    stances = 0.5 + 0.5 * timing.overlaps / timing.step_times
    walks, runs = stances[~timing.flies], stances[timing.flies]
    np.testing.assert_allclose([walks[0], walks[-1], runs[0]], [0.66, 0.55, 0.42], atol=0.01)
    assert (np.diff(walks) < 0.0).all() and (np.diff(runs) <= 0.0).all() and runs[-1] < 0.36


def test_two_long_steps_among_short_ones_become_leaps():
    lengths = np.array([0.6, 0.6, 1.1, 0.6, 0.6, 1.3, 0.6])
    times = time_footsteps(row_of_prints(lengths), start_time=2.0)
    flies = times.strike_times[1:] > times.liftoff_times[:-1]
    np.testing.assert_array_equal(np.flatnonzero(flies), [2, 5])
    assert times.strike_times[0] == 2.0


def test_a_leap_among_walking_steps_is_slower_than_a_running_step():
    lengths = np.array([0.6, 0.6, 1.3, 0.6, 0.6])
    times = time_footsteps(row_of_prints(lengths))
    leap = np.diff(times.strike_times)[2]
    run = np.diff(time_footsteps(row_of_prints(np.full(5, 1.3))).strike_times)
    np.testing.assert_allclose(run, run[0])
    walking = 0.6 / time_steps(np.array([0.6]), TimingRule()).step_times[0]
    assert leap > 1.5 * run[0]
    assert 1.3 / leap == pytest.approx(TimingRule().leap_gain * walking)
    flight = times.strike_times[3] - times.liftoff_times[2]  # half of what it takes longer is flown
    assert flight == pytest.approx(-time_steps(np.array([1.3]), TimingRule()).overlaps[0] + 0.5 * (leap - run[0]))


def test_a_leap_after_a_shuffle_waits_on_the_ground_instead_of_in_the_air():
    times = time_footsteps(row_of_prints(np.array([0.25, 0.25, 1.1, 0.25, 0.25])))
    flight = times.strike_times[3] - times.liftoff_times[2]
    rule = TimingRule()
    assert rule.gravity * flight**2 / 8.0 == pytest.approx(rule.highest_hop * rule.leg_length)


@pytest.mark.parametrize("standing", [False, True])
def test_contacts_of_one_foot_never_overlap(standing):
    random = np.random.default_rng(7)
    for _ in range(50):
        positions = row_of_prints(random.uniform(0.0, 2.5, random.integers(1, 9)))
        times = time_footsteps(positions, starts_standing=standing, ends_standing=standing)
        assert (times.liftoff_times > times.strike_times).all()
        assert (times.strike_times[2:] > times.liftoff_times[:-2]).all()
        assert (np.diff(times.strike_times)[standing:] > 0.0).all()
        assert (times.strike_times[1] == times.strike_times[0]) == standing
        assert (times.liftoff_times[-1] == times.liftoff_times[-2]) == standing


def test_the_first_step_from_a_stand_swings_as_long_as_in_a_walk():
    """Both feet stand first, then the foot leaves as in the middle of a walk; all later steps only come later."""
    positions = row_of_prints(np.array([0.12, 0.8, 0.6, 0.6]))
    at_once = time_footsteps(positions, starts_standing=True)
    stood = time_footsteps(positions, starts_standing=True, stand_time=0.5)
    first = time_steps(np.array([0.8]), TimingRule())
    swing = stood.strike_times[2] - stood.liftoff_times[0]
    assert swing == pytest.approx(first.step_times[0] - 0.5 * first.overlaps[0])
    np.testing.assert_allclose(stood.strike_times - at_once.strike_times, [0.0, 0.0, 0.5, 0.5, 0.5])
    np.testing.assert_allclose((stood.liftoff_times - at_once.liftoff_times)[1:], 0.5)
    walking = time_footsteps(positions, stand_time=0.5)
    np.testing.assert_array_equal(walking.liftoff_times, time_footsteps(positions).liftoff_times)


def test_a_speed_is_that_of_the_steps_taken_and_not_of_the_feet_that_stand():
    positions = row_of_prints(np.array([0.2, 0.6, 0.6, 0.6, 0.6]))
    strikes = time_footsteps(positions, speed=0.9, starts_standing=True).strike_times
    assert 4 * 0.6 / (strikes[-1] - strikes[1]) == pytest.approx(0.9)


def test_one_print_is_no_plan():
    with pytest.raises(PlanError, match=r"two or more"):
        time_footsteps(np.zeros((1, 3)))


@pytest.mark.parametrize("standing", [False, True])
@pytest.mark.parametrize("flight_distance", [0.0, 0.9])
def test_rows_timed_together_are_what_each_is_alone(standing, flight_distance):
    random, rule = np.random.default_rng(11), TimingRule(flight_distance=flight_distance)
    rows = [row_of_prints(random.uniform(0.1, 1.6, count)) for count in random.integers(1, 14, 30)]
    speeds, starts = random.choice([0.0, 0.9, 2.0], 30), random.uniform(0.0, 9.0, 30)
    ends = random.random(30) < 0.5
    counts, stand_time = np.array([len(row) for row in rows]), 0.5
    given = {"rule": rule, "starts_standing": standing, "stand_time": stand_time}
    found = time_rows(np.concatenate(rows), counts, speeds=speeds, start_times=starts, ends_standing=ends, **given)
    begun = np.cumsum(counts) - counts
    for row, begin, speed, start, ends_standing in zip(rows, begun, speeds, starts, ends, strict=True):
        alone = time_footsteps(row, speed=speed, start_time=start, ends_standing=ends_standing, **given)
        own = slice(begin, begin + len(row))
        np.testing.assert_array_equal(found.strike_times[own], alone.strike_times)
        np.testing.assert_array_equal(found.liftoff_times[own], alone.liftoff_times)
