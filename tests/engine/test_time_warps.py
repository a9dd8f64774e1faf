"""Steps against the pace of their clips: the corrected total time, waits that are stood through, warnings ([B] 5)."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, way
from tests.engine.walkers import in_world
from usdfoot.engine.animate import animate_crowd, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError


def drawn_out(wait, *, swing=0.4, support=0.45):
    """A walk in whose fourth step both feet stand for `support`, and the foot is `wait` longer in the air."""
    plan = way(8)
    later = np.arange(8) >= 4
    extra = support + swing + wait - 0.5
    liftoffs = plan.liftoff_times + np.where(np.arange(8) >= 3, extra, 0.0)
    liftoffs[2] = plan.strike_times[3] + support
    return replace(plan, strike_times=plan.strike_times + extra * later, liftoff_times=liftoffs)


def animated(walker_library, plan, **options):
    scene = crowd(walker_library.source, [plan])
    motions, problems = animate_crowd(scene, options=EngineOptions(**options))
    return motions[0], [problem for problem in problems if "pace" in problem.message]


@pytest.mark.parametrize("root_weight", [0.0, 0.4, 1.0])
def test_total_time_has_the_root_examples_at_their_share(walker_library, root_weight):
    plan = way(8)
    scene = crowd(walker_library.source, [plan])
    steps = prepare_steps(walker_library, scene.agents, scene, options=EngineOptions(root_weight=root_weight))
    segments, blend = steps.setup.segments, steps.blend
    rows = np.flatnonzero(~segments.stands)
    assert_allclose(blend.weights[rows].sum(axis=1), 1.0)
    assert_allclose(steps.landings.rooted.root_weights[rows], root_weight)
    totals = [
        sum(weight * walker_library.examples.durations[example] for example, weight in zip(*pair, strict=True))
        for pair in zip(blend.examples[rows], blend.weights[rows], strict=True)
    ]
    planned = segments.knot_times[rows, -1] - segments.knot_times[rows, 0]
    assert_allclose(steps.landings.time_warp[rows], planned / np.array(totals), rtol=1e-9)


def test_a_long_step_waits_on_both_feet_and_then_goes_at_its_pace(walker_library):
    plan = drawn_out(0.4)
    motion, problems = animated(walker_library, plan)
    held, _ = animated(walker_library, plan, most_time_warp=9.0)
    assert not problems
    assert motion.results.time_warp[4] < held.results.time_warp[4] <= 2.5
    pelvis = in_world(walker_library.source, motion).pelvis
    speeds = np.linalg.norm(np.diff(pelvis, axis=0), axis=1) * 30.0
    middle = plan.strike_times[3] + 0.25
    waiting = np.abs(motion.times[1:] - middle) < 0.06
    assert speeds[waiting].max() < 0.5 * np.median(speeds)
    assert motion.results.slide.max() < 1e-3 and motion.results.placement_error.max() < 1e-3


def test_feet_strike_and_leave_when_the_plan_says_however_long_it_takes(walker_library):
    plan = drawn_out(2.0)
    motion, problems = animated(walker_library, plan)
    balls = in_world(walker_library.source, motion).balls
    swinging = (motion.times > plan.liftoff_times[2] + 0.05) & (motion.times < plan.strike_times[4] - 0.05)
    side = plan.sides[4]
    target = np.linalg.norm(balls[swinging, side] - plan.positions[4], axis=1)
    assert target.min() > 0.02
    assert motion.results.placement_error.max() < 1e-3
    (problem,) = problems
    assert problem.severity == "warning" and "first to footstep 4" in problem.message


def test_a_mid_gait_start_whose_feet_stand_together_for_long_is_walked(walker_library):
    plan = way(6, step_time=2.0)
    plan = replace(plan, liftoff_times=plan.strike_times + 2.8)
    motion, _ = animated(walker_library, plan)
    assert motion.results.placement_error.max() < 1e-3


def test_hurried_steps_are_named_with_what_would_be_right(walker_library):
    motion, problems = animated(walker_library, way(8, step_time=0.2))
    assert motion.results.time_warp[3] < 0.5
    (problem,) = problems
    assert problem.where == "/World/agent0" and problem.message.startswith("/World/Plan: ")
    assert "(0.2 s)" in problem.message and "add clips of this pace" in problem.message
    assert not animated(walker_library, way(8, step_time=0.2), least_time_warp=0.2)[1]


@pytest.mark.parametrize("bad", [(0.0, 2.0), (1.2, 2.0), (0.5, 0.9)])
def test_ranges_hold_the_clips_own_pace(bad):
    with pytest.raises(UsdfootError, match="the least must be above 0, the most no less than 1"):
        EngineOptions(least_time_warp=bad[0], most_time_warp=bad[1])
