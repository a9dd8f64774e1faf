"""Contacts and segments of plans, as tables."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

from tests.engine.plans import crowd, moved, way
from tests.engine.walkers import WALKS, library_of
from tests.strategies import footstep_plans
from usdfoot.engine.animate import animate_crowd, prepare_library
from usdfoot.engine.clock_kernel import PUSH_TIME, ClockArrays, fall_arc, phase_at
from usdfoot.engine.flight import centre_flights
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.segments import cut_segments
from usdfoot.errors import ClipError, UsdfootError
from usdfoot.maths import planar
from usdfoot.maths.monotone import pchip_slopes
from usdfoot.maths.timeline import locate
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contact_table import lay_contacts


@given(plan=footstep_plans(smallest=3))
def test_contacts_are_the_footsteps_and_what_is_before_and_after(plan):
    contacts = lay_contacts([plan])
    real = contacts.steps >= 0
    assert_array_equal(contacts.steps[real], np.arange(len(plan)))
    for name, values in (
        ("sides", plan.sides),
        ("positions", plan.positions),
        ("strikes", plan.strike_times),
        ("yaws", plan.yaws),
    ):
        assert_allclose(getattr(contacts, name)[real], values)
    assert_allclose(contacts.liftoffs[real][:-1], plan.liftoff_times[:-1])
    last = len(plan)
    assert contacts.liftoffs[last] - contacts.strikes[last + 1] == pytest.approx(
        max(plan.liftoff_times[-1] - contacts.strikes[last + 1], contacts.liftoffs[last - 1] - contacts.strikes[last])
    )
    assert contacts.liftoffs[last] < contacts.strikes[last + 2]
    assert contacts.ends[0] == plan.liftoff_times.max()
    assert_array_equal(np.flatnonzero(~real), [0, len(plan) + 1, len(plan) + 2])
    assert np.all(np.diff(contacts.sides) != 0)
    assert np.all(np.diff(contacts.strikes) > 0.0)
    assert np.all(contacts.liftoffs > contacts.strikes)
    overlaps = contacts.liftoffs[:2] - contacts.strikes[1:3]
    assert overlaps[0] == pytest.approx(min(overlaps[1], 0.5 * (contacts.strikes[2] - contacts.strikes[1])))
    headings = contacts.headings[1:]
    assert np.abs(np.diff(headings)).max() < np.pi
    middle = planar.circular_mean(np.stack([contacts.yaws[1:], contacts.yaws[:-1]]), axis=0)
    assert_allclose(planar.wrap_angle(headings - middle), 0.0, atol=1e-9)


@given(plan=footstep_plans(smallest=3))
def test_segments_partition_the_time_of_the_plan(plan):
    options = EngineOptions()
    contacts = lay_contacts([plan])
    segments = cut_segments(contacts, options)
    assert segments.begins[0] == plan.strike_times[0]
    assert segments.ends[-1] >= plan.liftoff_times.max() - 1e-9
    assert_allclose(segments.begins[1:], segments.ends[:-1])
    assert np.all(segments.ends > segments.begins)
    assert np.all(np.diff(segments.knot_times, axis=1) > 0.0)


@wp.kernel(enable_backward=False)
def phases_at(
    clocks: ClockArrays,
    segments: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
    phases: wp.array(dtype=wp.float64),
) -> None:
    frame = wp.tid()
    phases[frame] = phase_at(clocks, segments[frame], times[frame])


@given(plan=footstep_plans(smallest=3))
def test_phases_rise_from_strike_to_strike(plan):
    segments = cut_segments(lay_contacts([plan]), EngineOptions())
    clocks = ClockArrays()
    clocks.knot_times = wp.array(segments.knot_times, dtype=wp.vec4d)
    clocks.knot_shares = wp.array(segments.knot_shares, dtype=wp.vec4d)
    clocks.knot_slopes = wp.array(pchip_slopes(segments.knot_times, segments.knot_shares), dtype=wp.vec4d)
    rows = np.repeat(np.arange(len(segments)), 50)
    shares = np.tile(np.linspace(0.0, 1.0, 50), len(segments))
    times = segments.begins[rows] + shares * (segments.ends - segments.begins)[rows]
    found = wp.zeros(len(rows), dtype=wp.float64)
    wp.launch(
        phases_at,
        dim=len(rows),
        inputs=[clocks, wp.array(rows.astype(np.int32), dtype=wp.int32), wp.array(times, dtype=wp.float64)],
        outputs=[found],
    )
    phases = found.numpy().reshape(len(segments), 50)
    assert np.all(np.diff(phases, axis=1) > 0.0)
    assert_allclose(phases[~segments.stands, -1], 1.0, atol=1e-9)
    whole = ~segments.stands & (segments.begins == segments.knot_times[:, 0])
    assert_allclose(phases[whole, 0], 0.0, atol=1e-9)


@wp.kernel(enable_backward=False)
def arcs_at(
    flight: wp.vec3d,
    times: wp.array(dtype=wp.float64),
    earliest: wp.float64,
    latest: wp.float64,
    arcs: wp.array(dtype=wp.float64),
) -> None:
    frame = wp.tid()
    arcs[frame] = fall_arc(flight, times[frame], earliest, latest)


@pytest.mark.parametrize("room", [0.1, 1.0])
def test_a_drawn_out_flight_falls_freely_between_two_crouches(room):
    """The pelvis falls by what gravity lacks, and crouches before and after by 4/27 of push-off speed times time."""
    liftoff, duration, missing = 1.0, 0.4, 3.0
    times = np.linspace(0.0, 3.0, 30001)
    found = wp.empty(len(times), dtype=wp.float64)
    inputs = [wp.vec3d(liftoff, duration, missing), wp.array(times, dtype=wp.float64)]
    wp.launch(arcs_at, dim=len(times), inputs=[*inputs, liftoff - room, liftoff + duration + room], outputs=[found])
    arcs, rates = found.numpy(), np.gradient(found.numpy(), times)
    flies = (times >= liftoff) & (times <= liftoff + duration)
    after = times[flies] - liftoff
    assert_allclose(arcs[flies], 0.5 * missing * after * (duration - after), atol=1e-12)
    push = min(0.5 * room, float(PUSH_TIME))
    for pushes in (times < liftoff, times > liftoff + duration):
        assert_allclose(arcs[pushes].min(), -4.0 / 27.0 * 0.5 * missing * duration * push, rtol=1e-5)
    still = (times < liftoff - push) | (times > liftoff + duration + push)
    assert_array_equal(arcs[still], 0.0)
    assert np.abs(np.diff(rates)).max() < 1e-2  # no kink where flight, crouch and rest meet


def test_agents_keep_their_own_contacts():
    together = [way(5), moved(way(4, first=1), shift=(3.0, 0.0, 0.0)), way(6, stand_first=0.8, stand_last=0.9)]
    contacts = lay_contacts(together)
    for agent, plan in enumerate(together):
        alone = lay_contacts([plan])
        own = slice(contacts.first[agent], contacts.first[agent + 1])
        for name in ("steps", "sides", "positions", "yaws", "strikes", "liftoffs", "headings"):
            assert_array_equal(getattr(contacts, name)[own], getattr(alone, name))


def test_a_long_double_support_is_a_stand():
    plan = way(8, stand_first=1.0, stand_last=1.2)
    segments = cut_segments(lay_contacts([plan]), EngineOptions())
    assert segments.stands[0]
    assert segments.stands[-1]
    assert not segments.stands[1:-1].any()
    assert segments.ends[0] == plan.liftoff_times[0]


def test_flights_are_centred_but_walks_keep_their_times():
    """Of a plan in the middle, away from its stands; blends of a walk may have runs in them."""
    for duty, natural, shift in (
        (0.62, 0.1, 0.0),
        (0.55, 0.05, 0.0),
        (0.5, 0.04, 0.02),
        (0.45, 0.09, 0.02),
        (0.4, 0.06, -0.02),
    ):
        contacts = lay_contacts([way(8, step_time=0.5, duty=duty)])
        segments = cut_segments(contacts, EngineOptions())
        centred = centre_flights(contacts, segments, np.full(len(segments), natural))
        assert_allclose((centred.ends - segments.ends)[2:-2], shift, atol=1e-9)


def test_locate_finds_the_last_row_begun():
    agents, begins, origins = np.array([0, 0, 0, 1, 1]), np.array([0.0, 1.0, 2.0, 50.0, 51.0]), np.array([0.0, 50.0])
    queries = np.array([-1.0, 0.0, 0.99, 1.0, 9.0, 49.0, 50.5, 99.0])
    found = locate(agents, begins, origins, agents=np.array([0, 0, 0, 0, 0, 1, 1, 1]), times=queries)
    assert_array_equal(found, [0, 0, 0, 1, 2, 3, 3, 4])


@pytest.mark.parametrize("change", [{"seam": "dissolve"}, {"seam_time": 0.0}, {"stand_time": -1.0}])
def test_options_out_of_range_are_named(change):
    with pytest.raises(UsdfootError, match=next(iter(change))):
        EngineOptions(**change)


def test_a_library_without_steps_is_named(walker_library):
    source = walker_library.source
    with pytest.raises(ClipError, match="no clip with a usable step"):
        prepare_library(ClipLibrary(skeleton=source.skeleton, biped=source.biped, clips=()), EngineOptions())


def test_agents_whose_library_fails_are_skipped_and_the_others_go_on(walker_library):
    good = crowd(walker_library.source, [way(4), way(5), way(6)])
    source = walker_library.source
    empty = ClipLibrary(skeleton=source.skeleton, biped=source.biped, clips=())
    lost = type(good.agents[1])(**{**vars(good.agents[1]), "library": 1})
    scene = type(good)(**{**vars(good), "agents": (good.agents[2], lost, good.agents[0]), "libraries": (source, empty)})
    motions, problems = animate_crowd(scene)
    assert [motion.name for motion in motions] == ["agent2", "agent0"]
    errors = [problem for problem in problems if problem.severity == "error"]
    assert [problem.where for problem in errors] == ["/World/agent1"]
    assert (
        errors[0].message == "/World/agent1: clip library: has no clip with a usable step"
    )  # not whose was read first


def test_a_library_that_lacks_a_foot_is_a_problem_not_an_end():
    """Three contacts and no mirror image: only one foot ever swings."""
    source = library_of(WALKS[4:5], footsteps=3, mirror=False)
    clip = source.clips[0]
    one_step = type(clip)(**{**vars(clip), "range_start": 0.2, "range_end": 0.7})
    library = ClipLibrary(skeleton=source.skeleton, biped=source.biped, clips=(one_step,))
    motions, problems = animate_crowd(crowd(library, [way(4)]))
    assert motions == []
    assert any(problem.severity == "error" and problem.where == "/World/agent0" for problem in problems)
