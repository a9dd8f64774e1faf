"""Footsteps the clips do not reach: outside the hull, beyond IK; and the correction of landings inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tests.builders import Gait
from tests.engine.plans import crowd, slope, way
from tests.engine.walkers import WALKS, in_world, library_of
from usdfoot.analysis.hip_spacing import hip_width, space_hips
from usdfoot.engine import reaching
from usdfoot.engine.animate import animate_crowd, blend_steps, prepare_library
from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.queries import step_queries
from usdfoot.model.contact_table import lay_contacts
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.animate import animate_all

FAR = 5


def with_far_step(where: tuple[float, float, float], far: int = FAR) -> FootstepPlan:
    """A walk with a footstep that lies `where` from where it belongs: to the outside, up, ahead [m]."""
    plan = way(10, length=0.5)
    positions = plan.positions.copy()
    positions[far] += np.array(where) * [np.where(plan.sides[far] == 0, 1.0, -1.0), 1.0, 1.0]
    return replace(plan, positions=positions)


def test_a_step_out_of_reach_is_reported_and_the_next_ones_are_exact_again(animate):
    """The foot comes down where the one that stands stays and the next footstep is kept: one error, on one step."""
    cases = [
        (far, where)
        for far in (1, FAR, 8, 9)
        for where in ((1.2, 0.0, 0.0), (0.0, 0.0, 1.1), (0.4, 0.0, 1.5), (0.6, 0.2, 0.9))
    ]
    motions = animate([with_far_step(where, far) for far, where in cases], rate=60.0)
    for (far, _), motion in zip(cases, motions, strict=True):
        results, others = motion.results, np.delete(np.arange(10), far)
        assert results.status[far] == "unreachable"
        assert results.placement_error[far] > 0.1
        assert {results.status[step] for step in others} <= {"ok", "outsideHull"}
        assert results.placement_error[others].max() < 1e-3
        assert results.slide.max() < 1e-3
        assert results.yaw_error.max() < np.radians(0.5)


def test_steps_are_weighed_for_where_their_feet_ended_up(walker_library):
    """Only the steps beside a foot that moved are weighed anew, which must leave none as it was before."""
    ways = [way(24, length=length, turn=0.05, stand_first=0.5) for length in (0.5, 1.2, 3.0)]
    every_third = ways[0].positions + np.where(np.arange(24) % 3 == 2, 1.4, 0.0)[:, None] * [0.0, 0.0, 1.0]
    scene = crowd(walker_library.source, [*ways, replace(ways[0], positions=every_third)])
    contacts = lay_contacts([agent.plan for agent in scene.agents])
    setup, blend, landings = blend_steps(walker_library, scene.agents, contacts, options=EngineOptions())
    steps = np.flatnonzero(~setup.segments.stands)
    anew = correct_steps(setup, walker_library.spaces, step_queries(setup, steps), corrections=8)
    assert landings.limited.sum() > 25
    assert_allclose(blend.weights[steps, :3], anew.weights, atol=1e-12)
    assert np.array_equal(blend.examples[steps, :3], anew.examples)


def test_footsteps_all_out_of_reach_cost_what_they_are_many(walker_library, monkeypatch):
    asked = []

    def counted(setup, spaces, queries, **options):
        asked.append(len(queries.landings))
        return correct_steps(setup, spaces, queries, **options)

    monkeypatch.setattr(reaching, "correct_steps", counted)
    totals = []
    for count in (30, 120):
        scene = crowd(walker_library.source, [way(count, length=3.0)])
        contacts = lay_contacts([agent.plan for agent in scene.agents])
        asked.clear()
        blend_steps(walker_library, scene.agents, contacts, options=EngineOptions())
        totals.append(sum(asked))
    assert totals[1] < 5 * totals[0]


def test_feet_that_stand_stay_however_far_the_next_step_goes(animate):
    """Two far steps in a row, up or down: the body goes to where both legs reach, down first, then between the feet."""
    plan = way(10, step_time=0.6)
    moved = ((np.arange(10) > 3) * 1.0 + (np.arange(10) > 4))[:, None]
    plans = [
        replace(plan, positions=plan.positions + moved * np.array([0.0, 0.5 * rise, distance - 0.55]))
        for rise in (-0.45, -0.2, 0.0, 0.2, 0.45)
        for distance in (1.0, 1.3, 1.6)
    ]
    for motion in animate(plans, rate=60.0):
        results = motion.results
        kept = np.isin(results.status, ["ok", "outsideHull"])
        assert kept[[0, 1, 2, 3, 7, 8, 9]].all()
        assert results.placement_error[kept].max() < 1e-3
        assert results.slide.max() < 1e-3
        assert results.yaw_error.max() < np.radians(0.5)


@pytest.mark.parametrize(("rise", "status"), [(0.45, "ok"), (-0.45, "ok"), (0.6, "unreachable"), (-0.6, "unreachable")])
def test_a_step_higher_than_legs_reach_is_reported(animate, rise, status):
    plan = way(8, step_time=0.8)
    positions = plan.positions + np.array([0.0, rise, 0.0]) * (np.arange(8) > 3)[:, None]
    results = animate([replace(plan, positions=positions)], rate=60.0)[0].results
    assert results.status == ("ok",) * 4 + (status,) + ("ok",) * 3
    assert results.slide.max() < 1e-3


def test_footsteps_out_of_reach_are_named(walker_library):
    scene = crowd(walker_library.source, [with_far_step((0.0, 0.0, 1.5))])
    _, problems = animate_crowd(scene)
    warnings = [problem.message for problem in problems if "out of reach" in problem.message]
    assert len(warnings) == 1
    assert f"first footstep {FAR}" in warnings[0]
    assert "the one before" not in warnings[0]


def test_how_much_higher_a_missed_footstep_is_than_the_one_before_is_said(walker_library):
    plan = way(8, step_time=0.8)
    positions = plan.positions + np.array([0.0, -0.6, 0.0]) * (np.arange(8) > 3)[:, None]
    _, problems = animate_crowd(crowd(walker_library.source, [replace(plan, positions=positions)]))
    (message,) = [problem.message for problem in problems if "out of reach" in problem.message]
    assert "from footstep 4, which is 0.60 m below the one before. " in message


def test_feet_that_stand_farther_apart_than_legs_reach_are_named(walker_library):
    """Nobody steps there, so that it is neither a step out of reach nor one that IK may not pull to."""
    plan = replace(way(2), strike_times=np.zeros(2), liftoff_times=np.ones(2), positions=np.diag([0.2, 0.0, 0.0])[:2])
    stand = replace(plan, positions=np.array([[1.5, 0.0, 0.0], [-1.5, 0.0, 0.0]]))
    [motion], problems = animate_crowd(crowd(walker_library.source, [stand]))
    assert motion.results.status == ("ikLimited",) * 2 and motion.results.placement_error.min() > 0.1
    [warning] = [problem.message for problem in problems if "too short" in problem.message]
    assert "2 footstep(s) are missed, as the legs are too short for both, first footstep 0" in warning
    assert not animate_crowd(crowd(walker_library.source, [plan]))[1]


@pytest.mark.parametrize("motion", ["clips", "physics", "hybrid"])
def test_footsteps_off_the_terrain_are_named(walker_library, motion):
    plan = way()
    terrain = slope(0.0, 0.0, size=float(plan.positions[-2, 2]) - 0.1)
    scene = crowd(walker_library.source, [plan], terrain=terrain)
    scene = replace(scene, agents=tuple(replace(agent, motion=motion) for agent in scene.agents))
    _, problems = animate_all(scene)
    (message,) = [problem.message for problem in problems if "off the terrain" in problem.message]
    x, _, z = plan.positions[-2]
    last = len(plan) - 2
    assert f"2 footstep(s) are off the terrain, first footstep {last} at ({x:.2f}, 0.00, {z:.2f}) m" in message


def test_footsteps_planted_between_two_frames_are_named_as_not_measured(walker_library):
    plan = way(8)
    liftoffs = plan.liftoff_times.copy()
    liftoffs[4] = plan.strike_times[4] + 0.01
    scene = crowd(walker_library.source, [replace(plan, liftoff_times=liftoffs), plan])
    motions, problems = animate_crowd(replace(scene, frame_times=scene.frame_times + 0.5 / 30.0))
    unmeasured = [problem for problem in problems if "planted in no frame" in problem.message]
    assert np.flatnonzero(np.isnan(motions[0].results.placement_error[1:])).tolist() == [3]
    assert [problem.where for problem in unmeasured] == ["/World/agent0"]
    assert "first footstep 4, which lasts 0.01 s" in unmeasured[0].message


def test_footsteps_that_no_frame_shows_are_not_named(walker_library):
    plan = with_far_step((0.0, 0.0, 1.5))
    scene = crowd(walker_library.source, [plan])
    early = replace(scene, frame_times=scene.frame_times[scene.frame_times < plan.strike_times[FAR - 2]])
    (motion,), problems = animate_crowd(early)
    assert motion.results.status[FAR] == "unreachable"
    assert not [problem for problem in problems if "out of reach" in problem.message]


def test_an_unreachable_step_is_placed_as_far_as_ik_may_pull(animate):
    """It reports how far the clips' landing is from it; IK takes `reach` of that."""
    for reach in (0.05, 0.1, 0.15):
        results = animate([with_far_step((1.2, 0.0, 0.0), 9)], reach=reach, rate=60.0)[0].results
        assert results.status[9] == "unreachable"
        assert results.blend_error[9] > 0.4
        assert_allclose(results.placement_error[9], results.blend_error[9] - reach, atol=2e-3)


def test_a_longer_reach_leaves_less_to_miss(animate):
    missed = [
        animate([with_far_step((1.2, 0.0, 0.0))], reach=reach, rate=60.0)[0].results.placement_error[FAR]
        for reach in (0.02, 0.1, 0.2)
    ]
    assert missed[0] > missed[1] > missed[2]


def test_without_any_reach_only_landings_of_the_clips_are_kept(animate):
    results = animate([way(length=1.6)], reach=0.0, rate=60.0)[0].results
    assert set(results.status[1:]) == {"unreachable"}
    assert results.hull_distance[1:].min() > 0.1
    assert_allclose(results.hull_distance[1:], results.blend_error[1:], atol=2e-3)


@settings(max_examples=10)
@given(length=st.floats(0.3, 0.7), width=st.floats(0.12, 0.25), turn=st.floats(-0.05, 0.05))
def test_landings_inside_the_hull_are_met_before_ik(animate, length, width, turn):
    results = animate([way(6, length=length, width=width, turn=turn)])[0].results
    inside = results.hull_distance < 1e-6
    assert inside.sum() >= 4
    assert results.blend_error[inside].mean() < 1e-3


def test_the_correction_makes_landings_better(animate):
    plan = way(length=0.63, width=0.2, turn=0.08)
    corrected = animate([plan])[0].results.blend_error
    plain = animate([plan], options=EngineOptions(correction=False))[0].results.blend_error
    assert corrected.mean() < 0.5 * plain.mean()
    assert np.all(corrected <= plain + 1e-6)


def test_the_distance_outside_the_hull_is_reported(animate):
    near, far = (animate([way(length=0.5, width=width)])[0].results for width in (0.16, 0.45))
    assert np.all(near.hull_distance < 1e-6)
    assert np.all(far.hull_distance[1:] > 0.1)
    assert set(far.status[1:]) == {"outsideHull"}
    assert far.placement_error.max() < 1e-3


def test_time_warp_is_planned_over_blended(animate):
    slow, fast = (animate([way(step_time=time)])[0].results.time_warp for time in (1.0, 0.5))
    assert np.all(slow[1:] > 1.3 * fast[1:])
    assert_allclose(fast[1:], 1.0, atol=0.2)


@pytest.mark.parametrize("clips", [1, 2], ids=["one clip", "two clips"])
def test_tiny_libraries_still_keep_to_the_footsteps(animate, clips):
    library = prepare_library(library_of(WALKS[4 : 4 + clips]), EngineOptions())
    for plan in (way(length=0.4), way(length=0.5, width=0.12, turn=0.1)):
        motion = animate([plan], library=library, rate=60.0)[0]
        assert set(motion.results.status) <= {"ok", "outsideHull"}
        assert motion.results.placement_error.max() < 2e-3
        assert set(motion.results.clips) <= {clip.name for clip in library.source.clips}


def test_copies_of_one_clip_blend_to_that_clip(animate):
    alone = library_of(WALKS[4:5])
    copies = replace(alone, clips=tuple(replace(alone.clips[0], name=f"/copy{index}") for index in range(3)))
    plan = way(length=0.4, width=0.14)
    first = animate([plan], library=prepare_library(alone, EngineOptions()))[0]
    second = animate([plan], library=prepare_library(copies, EngineOptions()))[0]
    assert_allclose(in_world(alone, second).positions, in_world(alone, first).positions, atol=1e-5)


def test_a_library_without_flight_serves_a_run(animate):
    library = prepare_library(library_of(WALKS), EngineOptions())
    plan = way(length=0.7, step_time=0.4, duty=0.42)
    motion = animate([plan], library=library, rate=60.0)[0]
    assert np.isfinite(motion.rotations).all()
    assert motion.results.placement_error.max() < 3e-3


def test_a_library_of_runs_only_serves_a_walk(animate):
    library = prepare_library(
        library_of([Gait(step_length=length, step_time=0.35, duty=0.4) for length in (0.8, 1.0)]), EngineOptions()
    )
    motion = animate([way(length=0.5)], library=library, rate=60.0)[0]
    assert np.isfinite(motion.rotations).all()
    assert motion.results.slide.max() < 1e-3


@pytest.mark.parametrize("first", [0, 1])
def test_two_footsteps_are_a_plan(animate, first):
    for plan in (way(2, first=first), way(2, first=first, stand_last=0.8)):
        motion = animate([plan], rate=60.0)[0]
        assert np.isfinite(motion.rotations).all()
        assert len(motion.results.status) == 2


def test_clip_weights_are_listed_step_by_step(animate):
    results = animate([way()])[0].results
    assert len(results.clips) == len(results.clip_weights) == results.clip_counts.sum()
    begins = np.cumsum(results.clip_counts) - results.clip_counts
    for begin, count in zip(begins, results.clip_counts, strict=True):
        if count:
            assert_allclose(results.clip_weights[begin : begin + count].sum(), 1.0, atol=1e-9)
            assert len(set(results.clips[begin : begin + count])) == count


def test_a_footstep_whose_foot_is_pulled_along_is_not_called_ok(animate):
    """Told that legs span more than they do: footsteps are met on the mean, but feet do not stay."""
    plan = way(8, length=1.06, step_time=0.55)
    positions = plan.positions + np.array([0.0, 0.0, 0.9]) * (np.arange(8) > 3)[:, None]
    options = EngineOptions(longest_step=3.0)
    results = animate([replace(plan, positions=positions)], options=options, reach=2.0, rate=60.0)[0].results
    pulled = np.flatnonzero(results.slide > 3e-3)
    assert pulled.size
    assert {results.status[step] for step in pulled} == {"ikLimited"}


def test_a_footstep_that_only_ik_may_not_pull_to_is_ik_limited(walker_library):
    """The legs reach it: with a longer `reach` the same plan is kept."""
    plan = way(length=0.5, width=0.45)
    for reach, statuses in ((0.05, {"ikLimited", "outsideHull"}), (0.5, {"outsideHull"})):
        (motion,), problems = animate_crowd(crowd(walker_library.source, [plan], reach=reach))
        assert set(motion.results.status[1:]) == statuses
        warned = [problem.message for problem in problems if "usdfoot:agent:ikReach" in problem.message]
        assert len(warned) == ("ikLimited" in statuses)


@pytest.mark.parametrize(("hips", "reached"), [(1.0, False), (4.0, True)])
def test_legs_reach_farther_where_the_hips_are_wide(hips, reached):
    library = library_of(WALKS)
    wide = replace(library, skeleton=space_hips(library.skeleton, library.biped, hips))
    leg = library.biped.maximal_leg_length
    plan = way(8, length=1.4 * leg, width=0.7 * leg)
    assert 1.5 * leg < np.hypot(1.4, 0.7) * leg < np.hypot(1.5 * leg, 4.0 * hip_width(library.skeleton, library.biped))
    scene = crowd(wide, [plan])
    scene = replace(scene, agents=tuple(replace(agent, ik_reach=10.0) for agent in scene.agents))
    motions, _ = animate_crowd(scene, options=EngineOptions())
    assert ("unreachable" not in motions[0].results.status) == reached
