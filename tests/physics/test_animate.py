"""Crowds whose agents mix clips, physics and both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.plans import crowd, way
from tests.engine.walkers import WALKS, in_world, library_of
from usdfoot.maths import planar, quaternion
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import Pose, forward_kinematics
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.physics.animate import animate_all
from usdfoot.physics.motion_options import MotionOptions

MOTIONS = ("clips", "physics", "hybrid")


@pytest.fixture(scope="module")
def mixed():
    scene = crowd(library_of(WALKS), [way(6), way(6), way(6)])
    agents = tuple(replace(agent, motion=motion) for agent, motion in zip(scene.agents, MOTIONS, strict=True))
    return animate_all(replace(scene, agents=agents))


def test_agents_mix_sources_in_the_order_of_the_crowd(mixed):
    motions, problems = mixed
    assert [motion.name for motion in motions] == ["agent0", "agent1", "agent2"]
    assert not [problem for problem in problems if problem.severity == "error"]
    assert [motion.results.forces is not None for motion in motions] == [False, True, True]
    assert [bool(motion.results.clips) for motion in motions] == [True, False, True]


def test_every_source_keeps_its_footsteps(mixed):
    for motion in mixed[0]:
        assert motion.results.placement_error.max() < 1e-4
        assert np.nanmax(motion.results.slide) < 1e-4
        assert np.isfinite(motion.rotations).all() and np.isfinite(motion.pelvis_positions).all()


def test_hybrids_rise_and_fall_as_physics_does_with_the_upper_body_of_the_clips(mixed):
    source = library_of(WALKS)
    clips, physics, hybrid = mixed[0]
    strikes = np.sort(np.concatenate([foot.strike_times for foot in hybrid.contacts]))
    heights = [
        np.interp(
            np.linspace(*strikes[[1, -1]], 200), each.times, each.root_positions[:, 1] + each.pelvis_positions[:, 1]
        )
        for each in mixed[0]
    ]
    assert np.ptp(heights[2] - heights[1]) < 0.25 * np.ptp(heights[1])
    assert np.ptp(heights[2] - heights[0]) > 0.5 * np.ptp(heights[1])
    legs = {*source.biped.hips, *source.biped.knees, *source.biped.ankles, *source.biped.balls}
    above = [joint for joint in range(len(source.skeleton.joints)) if joint not in legs]
    times = np.intersect1d(clips.times, hybrid.times)
    turned, own = (each.rotations[np.isin(each.times, times)][:, above] for each in (hybrid, clips))
    assert np.abs(turned - own).max() < 1e-5
    assert np.abs(physics.rotations[np.isin(physics.times, times)][:, above] - own).max() > 0.01


def test_physics_needs_no_clips_and_turns_with_the_plan():
    source = library_of(WALKS)
    bare = ClipLibrary(skeleton=source.skeleton, biped=source.biped, clips=())
    scene = crowd(bare, [way(6)])
    agents = (replace(scene.agents[0], motion="physics"),)
    motions, problems = animate_all(replace(scene, agents=agents), options=MotionOptions())
    assert not problems
    assert motions[0].results.status == ("ok",) * 6


def test_a_rest_pose_that_is_a_frame_of_a_walk_does_not_matter_where_there_is_a_bind_pose():
    standing = replace(library_of(WALKS), clips=())
    skeleton, biped = standing.skeleton, standing.biped
    rest = skeleton.rest_rotations
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, rest)
    joints = [biped.hips[0], biped.knees[0], biped.ankles[0], biped.hips[1]]
    pitches = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array([-0.7, 0.8, -0.6, 0.5]))
    walking = rest.copy()
    walking[joints] = quaternion.compose(rest[joints], pitches)
    exported = replace(
        standing, skeleton=replace(skeleton, rest_rotations=walking), bind_pose=Pose(places=places, turns=turns)
    )
    motions = []
    for library in (standing, exported):
        scene = crowd(library, [way(5)])
        found, problems = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
        assert not problems
        motions.append(found[0])
    np.testing.assert_allclose(motions[1].rotations, motions[0].rotations, atol=1e-5)


def test_the_body_faces_where_its_root_trajectory_does():
    source = library_of(WALKS)
    scene = crowd(source, [way(8)])
    end = scene.agents[0].plan.liftoff_times.max()
    sideways = RootTrajectory(
        name="/Path",
        times=np.array([0.0, end]),
        positions=np.array([[0.0, 0, 0], [0, 0, 3]]),
        yaws=np.array([0.7, 0.7]),
    )
    agents = (replace(scene.agents[0], motion="physics", root_trajectory=sideways),)
    (motion,), problems = animate_all(replace(scene, agents=agents))
    rest = forward_kinematics(
        source.skeleton.parents, source.skeleton.rest_translations, source.skeleton.rest_rotations
    )[1][source.biped.pelvis]
    turned = quaternion.compose(motion.pelvis_rotations, quaternion.inverse(rest))
    facing = quaternion.rotate(quaternion.compose(quaternion.yaw_quaternion(motion.root_yaws), turned), [0.0, 0.0, 1.0])
    assert not problems and motion.results.placement_error.max() < 1e-4
    assert np.abs(np.mean(planar.yaw_of(facing[:, [0, 2]])) - 0.7) < 0.05


def test_runs_begin_in_mid_gait_at_the_height_they_go_on_at():
    scene = crowd(library_of(WALKS), [way(8, length=0.9, step_time=0.4, duty=0.35)])
    (motion,), _ = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
    heights = motion.root_positions[:, 1] + motion.pelvis_positions[:, 1]
    first, third = (heights[(motion.times >= begin) & (motion.times <= begin + 0.4)] for begin in (0.0, 0.8))
    assert abs(first.min() - third.min()) < 0.02


def test_the_knee_bends_on_as_the_foot_leaves_the_ground(mixed):
    source, motion = library_of(WALKS), mixed[0][MOTIONS.index("physics")]
    translations = np.repeat(source.skeleton.rest_translations[None], len(motion.times), axis=0)
    places, _ = forward_kinematics(source.skeleton.parents, translations, motion.rotations)
    for side in (0, 1):
        hip, knee, ankle = (
            places[:, pair[side]] for pair in (source.biped.hips, source.biped.knees, source.biped.ankles)
        )
        thigh, shank = knee - hip, ankle - knee
        lengths = np.linalg.norm(thigh, axis=1) * np.linalg.norm(shank, axis=1)
        bends = np.degrees(np.arccos(np.clip(np.sum(thigh * shank, axis=1) / lengths, -1.0, 1.0)))
        contacts = motion.contacts[side]
        for liftoff, strike in zip(contacts.liftoff_times[:-1], contacts.strike_times[1:], strict=True):
            about = (motion.times > liftoff - 0.15) & (motion.times < 0.5 * (liftoff + strike))
            sunk = np.maximum.accumulate(bends[about]) - bends[about]
            assert sunk.max() < 10.0


def test_plans_that_physics_cannot_make_are_told_per_step():
    source = library_of(WALKS)
    for plan in (way(6, length=3.0), way(6, length=0.0), way(8, step_time=0.05)):
        scene = crowd(source, [plan])
        motions, _ = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
        assert np.isfinite(motions[0].pelvis_positions).all() and np.isfinite(motions[0].rotations).all()
        assert np.isfinite(motions[0].results.forces.force_imbalance).all()
    far = crowd(source, [way(6, length=3.0)])
    motions, _ = animate_all(replace(far, agents=(replace(far.agents[0], motion="physics"),)))
    assert "unreachable" in motions[0].results.status
    assert motions[0].results.forces.force_imbalance.max() > 5.0


@pytest.mark.parametrize("motion", ["physics", "hybrid"])
def test_footsteps_out_of_reach_are_told_of_and_none_is_ok_whose_ball_slides(motion):
    scene = crowd(library_of(WALKS), [way(8, length=2.3)])
    (found,), problems = animate_all(replace(scene, agents=(replace(scene.agents[0], motion=motion),)))
    statuses = np.array(found.results.status)
    (problem,) = [each for each in problems if "out of reach" in each.message]
    assert problem.severity == "warning"
    assert f"{np.sum(statuses == 'unreachable')} footstep(s) are out of reach, first footstep" in problem.message
    assert (found.results.slide[statuses == "ok"] < 3e-3).all()


@pytest.mark.parametrize("step", [{"length": 0.0, "width": 0.5}, {"length": -0.4}], ids=["apart", "backward"])
def test_swings_of_legs_that_are_stretched_at_the_strike_end_where_the_foot_stands(step):
    """They ended up to 4 mm above: a strike that rounding puts after its frame had the ball slide there."""
    plan = way(8, step_time=0.55, stand_first=0.6, **step)
    before = np.array([plan.strike_times[2:-1] - 1e-6, plan.strike_times[2:-1]]).T
    scene = crowd(library_of(WALKS), [plan], times=np.union1d(np.arange(-1.0, 6.0, 1.0 / 30.0), before))
    [motion], _ = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
    balls = in_world(library_of(WALKS), motion).balls
    for strikes, side in zip(before, plan.sides[2:-1], strict=True):
        rows = np.argmin(np.abs(motion.times - strikes[:, None]), axis=1)
        assert np.abs(motion.times[rows] - strikes).max() < 1e-7
        assert np.linalg.norm(np.diff(balls[rows, side], axis=0)) < 2e-4


def test_a_biped_with_impossible_legs_becomes_a_problem():
    source = library_of(WALKS)
    biped = replace(source.biped, nominal_leg_length=2.0)
    scene = crowd(ClipLibrary(skeleton=source.skeleton, biped=biped, clips=()), [way(6)])
    motions, problems = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
    assert motions == []
    assert [problem.severity for problem in problems] == ["error"] and "legLength" in problems[0].message


def test_the_heel_of_a_run_rises_from_before_the_middle_of_the_contact_on():
    source = library_of(WALKS)
    scene = crowd(source, [way(8, length=0.9, step_time=0.4, duty=0.35)])
    (motion,), _ = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
    translations = np.repeat(source.skeleton.rest_translations[None], len(motion.times), axis=0)
    _, turns = forward_kinematics(source.skeleton.parents, translations, motion.rotations)
    leans = quaternion.rotate(turns[:, source.biped.ankles[0]], np.array([0.0, 1.0, 0.0]))[:, 2]
    contacts = motion.contacts[0]
    for strike, liftoff in zip(contacts.strike_times[1:-1], contacts.liftoff_times[1:-1], strict=True):
        shares = (motion.times - strike) / (liftoff - strike)
        assert np.abs(leans[(shares > 0.2) & (shares < 0.44)]).max() < 0.02
        assert leans[(shares > 0.55) & (shares < 0.62)].min() > 0.08


def test_the_last_swing_of_a_plan_cut_off_in_a_contact_is_that_of_a_walk():
    source, plan, heights = library_of(WALKS), way(7), []
    begin = plan.liftoff_times[-2]
    for cut in (0.0, 0.3):
        liftoffs = np.append(plan.liftoff_times[:-1], plan.liftoff_times[-1] - cut)
        scene = crowd(source, [replace(plan, liftoff_times=liftoffs)])
        (motion,), _ = animate_all(replace(scene, agents=(replace(scene.agents[0], motion="physics"),)))
        swung = in_world(source, motion)
        end = plan.liftoff_times[-1] - 0.3
        heights.append(np.interp(np.linspace(begin, end, 20), swung.times, swung.ankles[:, plan.sides[-2], 1]))
    np.testing.assert_allclose(heights[1], heights[0], atol=0.06)
