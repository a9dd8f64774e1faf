"""Standing, flight, backward and side steps, and plans that mix them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.engine.synthesis import synthesise
from tests.engine.walkers import between, in_world
from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.engine.queries import step_queries
from usdfoot.engine.segments import cut_segments
from usdfoot.model.plan import FootstepPlan


def joined(first: FootstepPlan, second: FootstepPlan) -> FootstepPlan:
    """The second plan after the first, a step further and later; the sides must alternate."""
    ahead = first.positions[-1] * [0.0, 1.0, 1.0] + [0.0, 0.0, 0.4]
    time = float(np.diff(first.strike_times)[-1])
    start = first.strike_times[-1] + time - second.strike_times[0]
    return FootstepPlan(
        name=first.name,
        sides=np.concatenate([first.sides, second.sides]),
        positions=np.concatenate([first.positions, second.positions + ahead]),
        orientations=np.concatenate([first.orientations, second.orientations]),
        strike_times=np.concatenate([first.strike_times, second.strike_times + start]),
        liftoff_times=np.concatenate([first.liftoff_times, second.liftoff_times + start]),
        root_weights=np.concatenate([first.root_weights, second.root_weights]),
    )


def test_who_stands_stands_still(animate, walker_library):
    plan = way(8, stand_first=1.6, stand_last=1.8)
    motion = animate([plan], rate=60.0)[0]
    body = in_world(walker_library.source, motion)
    for start, end in (
        (plan.strike_times[0], plan.liftoff_times[0] - 0.55),
        (plan.strike_times[-1] + 0.55, plan.liftoff_times[-1]),
    ):
        standing = between(body.times, start, end)
        assert standing.sum() > 20
        assert np.ptp(body.positions[standing], axis=0).max() < 1e-4


def test_who_stands_is_upright_between_the_feet(animate, walker_library):
    plan = way(8, stand_first=1.6)
    body = in_world(walker_library.source, animate([plan])[0])
    middle = body.ankles[0].mean(axis=0)
    assert np.abs((body.pelvis[0] - middle)[[0, 2]]).max() < 0.1
    assert body.pelvis[0, 1] > 0.8


def test_one_only_standing_stands(animate, walker_library):
    plan = replace(way(2, length=0.0), strike_times=np.zeros(2), liftoff_times=np.full(2, 2.0))
    assert plan.starts_standing
    assert plan.ends_standing
    motion = animate([plan])[0]
    body = in_world(walker_library.source, motion)
    assert len(motion.times) > 30
    assert np.ptp(body.positions, axis=0).max() < 1e-4
    assert motion.results.placement_error.max() < 1e-3


def test_a_body_in_flight_falls_freely(animate, walker_library):
    """Twice the clips' flight time: the pelvis still follows a parabola of gravity."""
    plan = way(10, length=1.0, width=0.12, step_time=0.4, duty=0.33)
    rate = 240.0
    body = in_world(walker_library.source, animate([plan], rate=rate)[0])
    accelerations = []
    for number in range(3, 7):
        inside = between(body.times, plan.liftoff_times[number] + 0.02, plan.strike_times[number + 1] - 0.02)
        heights = body.pelvis[inside, 1]
        accelerations.append(2.0 * np.polyfit(body.times[inside], heights, 2)[0])
    assert_allclose(np.mean(accelerations), -EARTH_GRAVITY, rtol=0.25)


def test_longer_flights_rise_higher(animate, walker_library):
    rises = []
    for duty in (0.42, 0.36, 0.30):
        plan = way(10, length=1.0, width=0.12, step_time=0.4, duty=duty)
        heights = in_world(walker_library.source, animate([plan], rate=120.0)[0]).pelvis[:, 1]
        rises.append(np.ptp(heights[len(heights) // 4 : -len(heights) // 4]))
    assert rises[0] < rises[1] < rises[2]


def test_a_body_does_not_plunge_where_contacts_are_longer_than_the_clips(animate, walker_library):
    plan = way(12, length=1.15, width=0.12, step_time=0.36, duty=0.46)
    heights = in_world(walker_library.source, animate([plan], rate=30.0)[0]).pelvis[:, 1]
    assert np.abs(np.diff(heights, n=2)).max() * 30.0**2 < 3.0 * EARTH_GRAVITY


def test_heels_do_not_snap_up_where_a_run_is_longer_than_the_clips(animate, walker_library):
    """The leg behind would be too short at the liftoff, the heel makes up for it in time."""
    plan = way(10, length=1.3, width=0.12, step_time=0.38, duty=0.42)
    motion = animate([plan], rate=240.0)[0]
    body = in_world(walker_library.source, motion)
    feet = body.ankles - body.balls
    pitches = np.arctan2(feet[..., 1], np.linalg.norm(feet[..., [0, 2]], axis=-1))
    for number in range(3, 7):
        leaving = between(body.times, plan.liftoff_times[number] - 0.1, plan.liftoff_times[number])
        assert np.abs(np.diff(pitches[leaving, plan.sides[number]])).max() * 240.0 < 10.0
    assert motion.results.placement_error.max() < 1e-3


@pytest.mark.parametrize(
    ("plan", "direction"),
    [
        (way(length=-0.32, step_time=0.55), [0.0, -1.0]),
        (way(length=0.0, sideways=0.11, width=0.3, step_time=0.6), [1.0, 0.0]),
        (way(length=0.0, sideways=-0.11, width=0.3, step_time=0.6), [-1.0, 0.0]),
    ],
    ids=["backward", "to the left", "to the right"],
)
def test_backward_and_side_steps_face_forward(animate, walker_library, plan, direction):
    motion = animate([plan], rate=60.0)[0]
    body = in_world(walker_library.source, motion)
    inside = between(body.times, plan.strike_times[0], plan.strike_times[-1])
    travel = (body.pelvis[inside][-1] - body.pelvis[inside][0])[[0, 2]]
    assert_allclose(travel / np.linalg.norm(travel), direction, atol=0.15)
    assert np.abs(motion.root_yaws).max() < 0.05
    assert set(motion.results.status) <= {"ok", "outsideHull"}


def test_a_turn_in_place_turns(animate):
    plan = way(10, length=0.0, width=0.2, turn=0.25, step_time=0.6)
    motion = animate([plan], rate=60.0)[0]
    assert motion.results.placement_error.max() < 1e-3
    assert_allclose(motion.root_yaws[-1] - motion.root_yaws[0], 0.25 * 9, atol=0.3)


def test_gaits_change_within_a_plan(animate, walker_library):
    plan = joined(
        joined(way(6), way(6, length=1.0, width=0.12, step_time=0.36, duty=0.42)),
        way(6, length=-0.3, step_time=0.55),
    )
    motion = animate([plan], rate=60.0)[0]
    body = in_world(walker_library.source, motion)
    assert motion.results.placement_error.max() < 1e-3
    assert motion.results.slide.max() < 1e-3
    steps = np.linalg.norm(np.diff(body.pelvis, axis=0), axis=1)
    assert steps.max() * 60.0 < 6.0
    assert np.linalg.norm(np.diff(body.pelvis, n=2, axis=0), axis=1).max() < 0.03


def test_a_walk_that_ends_in_mid_gait_walks_on_to_its_last_frame(animate, walker_library):
    """Nobody slumps into a stand that the plan does not ask for."""
    plan = way(10)
    body = in_world(walker_library.source, animate([plan], rate=60.0)[0])
    speeds = np.diff(body.pelvis[:, 2]) * 60.0
    middle = between(body.times[1:], plan.strike_times[4], plan.strike_times[6])
    last = between(body.times[1:], plan.strike_times[-1], plan.liftoff_times[-1])
    assert speeds[last].min() > 0.7 * speeds[middle].min()


@pytest.mark.parametrize(
    "gait", [{}, {"length": 1.0, "step_time": 0.35, "duty": 0.4, "width": 0.13}], ids=["walk", "run"]
)
def test_a_last_contact_that_the_end_cuts_off_is_no_hurried_one(gait, animate):
    whole = way(10, **gait)
    end = whole.strike_times[-1] + 0.1
    cut = replace(whole, liftoff_times=np.append(whole.liftoff_times[:-1], end))
    times = np.arange(whole.strike_times[0], end + 0.2, 1.0 / 60.0)
    expected, motion = (animate([plan], times=times)[0] for plan in (whole, cut))
    seen = np.count_nonzero(times < end)
    assert_allclose(motion.root_positions[:seen], expected.root_positions[:seen], atol=1e-6)
    assert_allclose(motion.rotations[:seen], expected.rotations[:seen], atol=1e-5)
    assert motion.times[-2] < cut.liftoff_times.max() <= motion.times[-1] + 1e-6


def test_a_motion_covers_its_plan_only(animate):
    plan = way()
    motion = animate([plan], times=np.arange(-60, 300) / 30.0)[0]
    assert motion.times[0] <= plan.strike_times[0] < motion.times[1]
    assert motion.times[-2] < plan.liftoff_times.max() <= motion.times[-1] + 1e-6


def test_frames_beyond_the_plan_hold_the_end(animate):
    plan = way()
    start, end = plan.strike_times[0], plan.liftoff_times.max()
    whole = animate([plan], times=np.array([start, 1.0, end]))[0]
    held = animate([plan], times=np.array([-60.0, start - 0.004, 1.0, end + 0.004, 60.0]))[0]
    assert_allclose(held.times, [start - 0.004, 1.0, end + 0.004])
    assert_allclose(held.rotations, whole.rotations, atol=1e-7)
    assert_allclose(held.root_positions, whole.root_positions, atol=1e-9)


def test_a_run_asks_for_steps_after_as_long_a_flight(walker_library):
    """What is asked of the spaces of a step is what an example of the same step says of itself."""
    plan = way(8, length=1.0, width=0.12, step_time=0.35, duty=0.4)
    setup = synthesise(walker_library, [plan]).setup
    setup = replace(setup, segments=cut_segments(setup.contacts, setup.options))  # as planned
    steps = np.flatnonzero(~setup.segments.stands)[1:-2]
    asked = step_queries(setup, steps).features
    assert_allclose(asked.swing_liftoffs, plan.liftoff_times[0] - plan.strike_times[1], atol=1e-9)
    assert_allclose(asked.durations, 0.35, atol=1e-9)
    examples = walker_library.examples
    runs = np.flatnonzero(examples.durations - examples.support_liftoffs > 0.04)[:-1]  # the last stands
    assert_allclose(examples.swing_liftoffs[runs], asked.swing_liftoffs[0], atol=0.02)
