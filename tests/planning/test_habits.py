"""Habits: step lengths, times and widths of clips, and plans of those whom these clips move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait
from tests.engine.plans import crowd
from tests.engine.walkers import library_of
from tests.planning.terrains import slab, terrain_of
from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.timing import HUMAN_LEG
from usdfoot.engine.animate import animate_crowd
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.habits import PEOPLE, SPAN, Habits, find_habits
from usdfoot.planning.lint import lint_clips, lint_plans
from usdfoot.planning.path import plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.spaces.library import spaces_of

LEVEL = Ground(terrain_of([slab((-60.0, 60.0), (-60.0, 60.0), (0.0, 0.0))]))
LOPE = Gait(step_length=0.9, step_width=0.22, step_time=0.75)
RUN = Gait(step_length=1.1, step_time=0.42, duty=0.4, step_width=0.12)
TURN = Gait(step_length=0.5, turn=0.4, step_time=0.4)
SIDE = Gait(step_length=0.0, sideways=0.12, step_width=0.3, step_time=0.5, heel_strike=False)
BACK = Gait(step_length=-0.4, step_time=0.5, heel_strike=False)


def habits_of(*gaits: Gait) -> tuple[Habits, float]:
    """Habits of clips, and the leg length of who walks in them."""
    library = library_of(gaits)
    leg_length = library.biped.maximal_leg_length
    examples, _ = build_examples(library, samples=31)
    return find_habits(examples, leg_length=leg_length), leg_length


def test_they_are_those_of_the_steady_steps_ahead():
    found, leg_length = habits_of(LOPE, RUN, TURN, SIDE, BACK)
    size = leg_length / HUMAN_LEG
    assert found.walk_ratio == pytest.approx(0.9 * 0.75 / 60.0 / size**1.5, rel=0.03)
    gait = derive_gait(Proportions(leg_length=leg_length, habits=found), speed=1.1 / 0.42)
    assert (gait.step_length, gait.step_time) == pytest.approx((1.1, 0.42), rel=0.03)
    assert found.easy_step == pytest.approx(0.9 / leg_length, rel=0.02)
    assert found.step_width == pytest.approx(0.22 / leg_length, rel=0.02)


def test_who_runs_faster_than_the_clips_steps_as_much_quicker_as_people():
    found, leg_length = habits_of(LOPE, RUN)
    own, people = (Proportions(leg_length=leg_length, habits=habits) for habits in (found, PEOPLE))
    slow, fast = (
        [1.0 / derive_gait(body, speed=speed).step_time for body in (own, people)] for speed in (1.1 / 0.42, 5.0)
    )
    assert slow[0] < fast[0]
    assert fast[0] - slow[0] == pytest.approx(fast[1] - slow[1], rel=1e-3)


def test_who_leaps_along_takes_slower_running_steps_no_longer_than_legs_span():
    """A cartoon's run: at its own speed as it is, at that of a walk no step is longer than legs."""
    leap = Gait(step_length=2.9, step_time=0.55, duty=0.2)
    found, leg_length = habits_of(LOPE, leap)
    body = Proportions(leg_length=leg_length, habits=found)
    own = derive_gait(body, speed=2.9 / 0.55)
    assert (own.step_length, own.step_time) == pytest.approx((2.9, 0.55), rel=0.03)
    slow = derive_gait(body, speed=1.01 * own.fastest_walk)
    assert slow.step_length <= 1.05 * SPAN * leg_length
    assert found.quickening < PEOPLE.quickening == habits_of(LOPE, RUN)[0].quickening


def test_where_clips_show_no_such_steps_they_are_peoples():
    assert habits_of(TURN, SIDE, BACK)[0] == PEOPLE
    runs, _ = habits_of(RUN)
    assert (runs.walk_ratio, runs.easy_step, runs.step_width) == (PEOPLE.walk_ratio, PEOPLE.easy_step, 0.0)
    slow, _ = habits_of(LOPE)
    assert slow.run_step == pytest.approx(PEOPLE.run_step * np.sqrt(slow.walk_ratio / PEOPLE.walk_ratio))


def test_a_path_at_the_speed_of_the_clips_is_walked_in_their_steps():
    found, leg_length = habits_of(LOPE, TURN)
    body = Proportions(leg_length=leg_length, habits=found)
    path = WalkingPath(name="/Along", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 20.0)]), speed=0.9 / 0.75)
    plan = plan_path(path, LEVEL, proportions=body)
    middle = slice(6, -6)
    assert_allclose(np.diff(plan.positions[:, 2])[middle], 0.9, rtol=0.04)
    assert_allclose(np.diff(plan.strike_times)[middle], 0.75, rtol=0.04)
    assert_allclose(np.abs(np.diff(plan.positions[:, 0]))[middle], 0.22, rtol=0.02)


@pytest.mark.parametrize("speed", [0.4, 0.8, 1.2, 2.0, 3.0])
@pytest.mark.parametrize("length", [0.5, 6.0])
def test_who_takes_steps_as_long_as_the_legs_span_takes_no_longer_ones(speed, length):
    body = Proportions(leg_length=0.38, hip_width=0.34, habits=Habits(walk_ratio=0.0156, easy_step=1.37, run_step=0.58))
    path = WalkingPath(name="/Along", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, length)]), speed=speed)
    assert lint_plans([plan_path(path, LEVEL, proportions=body)], LEVEL, bodies=[body]) == []


@pytest.mark.parametrize("speed", [1.9, 2.1, 2.5])
def test_who_runs_in_long_steps_leaps_rather_than_walks_farther_than_legs_span(speed):
    """A cartoon slows down in curves from running steps of more than two legs to walking ones."""
    habits = Habits(walk_ratio=0.0156, easy_step=1.37, run_step=0.6, quickening=0.0, step_width=0.9)
    body = Proportions(leg_length=0.38, hip_width=0.34, habits=habits)
    along = np.linspace(0.0, 2.0 * np.pi, 200)
    path = WalkingPath(name="/S", points=np.stack([2.0 * np.sin(along), 0.0 * along, along], axis=1), speed=speed)
    assert lint_plans([plan_path(path, LEVEL, proportions=body)], LEVEL, bodies=[body]) == []


def test_one_walk_is_enough_to_come_to_a_stand():
    """The foot that closes lands beside the other one, 0.65 m from where it does in the only clip."""
    library = library_of((Gait(step_length=0.65),))
    leg_length = library.biped.maximal_leg_length
    examples, _ = build_examples(library)
    body = Proportions(leg_length=leg_length, habits=find_habits(examples, leg_length=leg_length))
    path = WalkingPath(name="/Along", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 5.0)]))
    plan = plan_path(path, LEVEL, proportions=body)
    faults = lint_clips(plan, spaces_of(library, examples), style=examples.default_style, reach=0.3)
    (motion,), problems = animate_crowd(crowd(library, [plan]))
    assert not faults and not problems
    assert motion.results.blend_error[-1] > 0.3  # farther than IK pulls feet on the way
    assert motion.results.placement_error.max() < 1e-3 and motion.results.slide.max() < 1e-3
    on = replace(plan, positions=plan.positions + (np.arange(len(plan)) > 4)[:, None] * np.array([0.0, 0.0, -0.6]))
    assert "ikLimited" in animate_crowd(crowd(library, [on]))[0][0].results.status


def test_widths_and_times_scale_with_the_body():
    large, small = (
        derive_gait(Proportions(leg_length=leg, habits=Habits(walk_ratio=0.007, step_width=0.2))) for leg in (0.8, 0.4)
    )
    assert_allclose(small.step_length / large.step_length, 0.5)
    assert_allclose(small.step_time / large.step_time, np.sqrt(0.5))
    assert_allclose(small.step_width, 0.08)
