"""Footsteps as they come: the offline motion if they come early, no jump and no slide if they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, moved, stairs
from tests.engine.walkers import OTHERS, WALKS, library_of
from tests.realtime.walks import RATE, footsteps, from_stand, off_footsteps, see, times_of, walk
from usdfoot.engine.animate import animate_agents, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.planning.proportions import proportions_of
from usdfoot.realtime import controller as controllers
from usdfoot.realtime import walks as kept_walks
from usdfoot.realtime.controller import Controller
from usdfoot.realtime.footsteps import Footsteps

NOWHERE = np.zeros((1, 3))
AHEAD = np.zeros(1)


@pytest.fixture(scope="module")
def library():
    return prepare_library(library_of([*WALKS, *OTHERS]), EngineOptions())


def stand(library, plan=None, *, agents: int = 1, **about) -> Controller:
    """A controller of agents side by side; its clock begins with the plan's."""
    places = np.stack([4.0 * np.arange(agents), np.zeros(agents), np.zeros(agents)], axis=1)
    start = 0.0 if plan is None else plan.start
    return Controller(library, positions=places, yaws=np.zeros(agents), start=start, **about)


def offline(library, plan, times, **about):
    """Joints of the whole plan's motion, in the world, at the frames among its samples."""
    scene = crowd(library.source, [plan], times=times, **about)
    options = controllers.ControllerOptions().engine
    [motion] = animate_agents(library, scene.agents, scene, options=options)
    rows = [int(np.argmin(np.abs(motion.times - time))) for time in times]
    turn = quaternion.yaw_quaternion(motion.root_yaws[rows])
    pelvis = quaternion.rotate(turn, motion.pelvis_positions[rows].astype(float)) + motion.root_positions[rows]
    return pelvis, motion.rotations[rows].astype(float)


@pytest.mark.parametrize(
    ("ahead", "within", "about"),
    [
        (2, 1e-5, {"turn": 0.06, "width": 0.2}),
        (2, 3e-3, {"length": 0.95, "step_time": 0.36, "duty": 0.4, "width": 0.12}),
        (3, 1e-5, {"length": 0.95, "step_time": 0.36, "duty": 0.4, "width": 0.12}),
    ],
    ids=["walk", "run, a flight early", "run"],
)
def test_fed_early_it_is_the_motion_of_the_whole_plan(library, ahead, within, about):
    plan = from_stand(stand(library), 9, **about)
    times = times_of(plan, until=plan.strike_times[-2] - 0.05)
    controller = stand(library, plan)
    poses, problems = walk(controller, [plan], times, ahead=ahead)
    assert problems == []
    seen = see(library, poses)
    pelvis, rotations = offline(library, plan, times)
    hips = library.source.biped.pelvis
    assert np.abs(seen.joints[:, hips] - pelvis).max() < within
    own = np.array([pose.rotations[0] for pose in poses], dtype=float)
    others = np.delete(np.arange(own.shape[1]), hips)
    turned = quaternion.compose(quaternion.inverse(own), rotations)[:, others]
    assert np.linalg.norm(quaternion.to_rotation_vector(turned), axis=-1).max() < max(1e-4, 10.0 * within)


def test_on_stairs_too(library):
    plan = from_stand(stand(library), 7, length=0.4, rise=0.12)
    positions = plan.positions.copy()
    positions[2:, 1] = 0.12 * np.round(positions[2:, 2] / 0.4)
    plan = replace(plan, positions=positions)
    times = times_of(plan, until=plan.strike_times[-2] - 0.05)
    terrain = stairs(0.12, 0.4)
    poses, _ = walk(stand(library, plan, terrain=terrain), [plan], times, ahead=2)
    pelvis, _ = offline(library, plan, times, terrain=terrain)
    assert np.abs(see(library, poses).joints[:, library.source.biped.pelvis] - pelvis).max() < 2e-4


def test_one_ahead_lands_all_the_same(library):
    plan = from_stand(stand(library), 9, width=0.2)
    times = times_of(plan)
    poses, problems = walk(stand(library, plan), [plan], times, ahead=1)
    assert problems == []
    assert off_footsteps(see(library, poses), times, plan, range(2, 8)).max() < 1e-3


def test_a_change_of_mind_in_mid_swing_neither_jumps_nor_slides(library):
    """A footstep that the foot is on its way to stays; the next ones go elsewhere."""
    plan = from_stand(stand(library), 10, width=0.2)
    times = times_of(plan)
    controller, poses, jumps = stand(library, plan), [], []
    controller.plan(np.zeros(8, dtype=int), footsteps(plan, range(2, 10)))
    middle = 0.5 * (plan.liftoff_times[3] + plan.strike_times[5])
    elsewhere = moved(plan, yaw=0.5)
    positions = elsewhere.positions + (plan.positions[5] - elsewhere.positions[5])
    changed = replace(elsewhere, positions=positions)
    for time in times:
        poses.append(controller.pose(float(time)))
        if abs(time - middle) < 0.5 / RATE:
            controller.plan(np.zeros(4, dtype=int), footsteps(changed, range(6, 10)), instead=True)
            jumps.append((poses[-1], controller.pose(float(time))))
    [(before, after)] = jumps
    there = see(library, [before, after])
    assert np.abs(np.diff(there.joints, axis=0)).max() < 1e-5
    seen = see(library, poses)
    assert off_footsteps(seen, times, plan, range(2, 6)).max() < 1e-3
    assert off_footsteps(seen, times, changed, range(6, 9)).max() < 1e-3
    assert np.linalg.norm(np.diff(seen.joints, axis=0), axis=-1).max() < 0.35


def test_without_footsteps_it_stands_and_goes_on_when_one_comes(library):
    controller = stand(library)
    still = see(library, [controller.pose(time) for time in (0.0, 0.5, 3.0)])
    assert np.abs(np.diff(still.joints, axis=0)).max() < 1e-6
    plan = from_stand(controller, 4, width=0.2)
    late = replace(plan, strike_times=plan.strike_times + 3.9, liftoff_times=plan.liftoff_times + 3.9)
    assert controller.plan(np.zeros(2, dtype=int), footsteps(late, [2, 3])) == ()
    times = np.arange(3.0, 8.0, 1.0 / RATE)
    poses = [controller.pose(float(time)) for time in times]
    seen = see(library, poses)
    assert poses[-1].halted.all()
    assert np.abs(seen.joints[-1] - seen.joints[-25]).max() < 1e-6
    assert_allclose(seen.balls[-1][:, [0, 2]], plan.positions[[2, 3]][:, [0, 2]], atol=1e-3)


def test_a_late_footstep_strikes_later_and_is_warned_of(library):
    controller = stand(library)
    plan = from_stand(controller, 5, width=0.2)
    controller.pose(plan.strike_times[2] + 1.0)
    [problem, *_] = controller.plan(np.zeros(1, dtype=int), footsteps(plan, [2]))
    assert problem.severity == "warning"
    assert "late by 1." in problem.message
    times = np.arange(plan.strike_times[2] + 1.0, plan.strike_times[2] + 3.0, 1.0 / RATE)
    seen = see(library, [controller.pose(float(time)) for time in times])
    assert_allclose(seen.balls[-1, plan.sides[2]][[0, 2]], plan.positions[2, [0, 2]], atol=1e-3)
    assert np.linalg.norm(np.diff(seen.joints, axis=0), axis=-1).max() < 0.35


def test_who_runs_out_of_footsteps_in_a_run_comes_to_a_halt(library):
    plan = from_stand(stand(library), 8, length=0.9, step_time=0.36, duty=0.4, width=0.12)
    times = np.arange(plan.start, plan.strike_times[6] + 3.0, 1.0 / RATE)
    controller = stand(library, plan)
    poses, _ = walk(controller, [replace_end(plan, 7)], times, ahead=3)
    seen = see(library, poses)
    assert np.abs(seen.joints[-1] - seen.joints[-10]).max() < 1e-6
    apart = seen.balls[-1, 0] - seen.balls[-1, 1]
    assert np.linalg.norm(apart[[0, 2]]) < 0.4
    assert np.all(seen.balls[-1][:, 1] < 0.06)


def replace_end(plan, count: int):
    """The first footsteps of a plan."""
    fields = ("sides", "positions", "orientations", "strike_times", "liftoff_times", "root_weights")
    return replace(plan, **{name: getattr(plan, name)[:count] for name in fields})


def test_agents_are_independent_and_bad_ones_stop_nobody(library):
    plan = from_stand(stand(library), 6, width=0.2)
    times = times_of(plan, until=plan.strike_times[4])
    alone, _ = walk(stand(library, plan), [plan], times, ahead=2)
    positions = plan.positions.copy()
    positions[3, 0] = np.nan
    controller = stand(library, plan, agents=4)
    bad = footsteps(plan, [2])
    bad = replace(bad, positions=np.full((1, 3), np.nan))
    problems = controller.plan(np.array([1]), bad)
    problems += controller.plan(np.array([2]), footsteps(plan, [3]))
    problems += controller.plan(np.array([2]), replace(footsteps(plan, [3]), sides=np.array([1])))
    problems += controller.plan(np.array([9]), footsteps(plan, [2]))
    problems += controller.steer(np.array([3]), np.full((1, 2), np.inf), np.zeros(1))
    assert [problem.where for problem in problems] == ["agent 1", "agent 2", "agent 9", "agent 3"]
    assert "positions is not a finite number" in problems[0].message
    assert "left and right alternate" in problems[1].message
    together, _ = walk(controller, [plan], times, ahead=2)
    for one, all_ in zip(alone, together, strict=True):
        assert_allclose(all_.rotations[0], one.rotations[0], atol=2e-6)
        assert_allclose(all_.root_positions[0], one.root_positions[0], atol=1e-9)
        assert np.isfinite(all_.rotations).all()


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [("positions", 1e30, "positions is beyond 1e+09 m"), ("liftoff_times", 1e300, "liftoff_times is beyond 1e+10 s")],
)
def test_footsteps_beyond_all_measure_are_refused(library, name, value, fault):
    plan = from_stand(stand(library), 6)
    controller = stand(library, plan)
    wild = footsteps(plan, [2, 3])
    wild = replace(wild, **{name: np.full_like(getattr(wild, name), value)})
    problems = controller.plan(np.array([0, 0]), wild)
    assert [problem.message.split(": ", 1)[-1] for problem in problems] == [fault] * 2
    assert all(np.isfinite(controller.pose(time).translations).all() for time in (1.0, 2.0))
    with pytest.raises(UsdfootError, match=r"positions: row 0 is 1e\+30 m from the origin"):
        controller.add(np.full((1, 3), 1e30), np.zeros(1))


def test_new_origins_change_nothing(library, monkeypatch):
    plan = from_stand(stand(library), 8, width=0.2, turn=0.1)
    times = times_of(plan, until=plan.strike_times[-2] - 0.05)
    far, _ = walk(stand(library, plan), [plan], times, ahead=2)
    monkeypatch.setattr(kept_walks, "FARTHEST_ORIGIN", 0.5)
    near, _ = walk(stand(library, plan), [plan], times, ahead=2)
    assert_allclose(see(library, near).joints, see(library, far).joints, atol=1e-5)


def test_steered_agents_go_as_fast_and_as_wanted_turn_and_stop(library):
    controller = stand(library, agents=3)
    velocities = np.array([[0.0, 0.6], [0.0, 1.2], [0.5, 0.0]])
    times = np.arange(0.0, 9.0, 1.0 / RATE)
    controller.steer(np.arange(3), velocities, np.array([0.0, 0.0, 0.5 * np.pi]))
    poses = []
    for time in times:
        if abs(time - 6.0) < 1e-6:
            controller.steer(np.arange(3), np.zeros((3, 2)), np.zeros(3))
        poses.append(controller.pose(float(time)))
    roots = np.array([pose.root_positions for pose in poses])
    had = (roots[int(5.8 * RATE)] - roots[int(3.8 * RATE)]) / 2.0
    assert np.linalg.norm(had[:, [0, 2]] - velocities, axis=1).max() < 0.1
    assert abs(poses[int(5.8 * RATE)].root_yaws[2] - 0.5 * np.pi) < 0.1
    assert poses[-1].halted.all()
    for agent in range(3):
        balls = see(library, poses, agent).balls[:, :, [0, 2]]
        steps = np.linalg.norm(np.diff(balls, axis=0), axis=-1)
        assert (steps.min(axis=1) < 1e-3).mean() > 0.95  # a walk: one foot stands at any time, without sliding


@pytest.mark.parametrize("until", [4.5, 9.0])
def test_who_is_steered_while_nobody_looks_is_where_it_would_be(library, until):
    """As after a file was loaded or a program stood still: agents began anew at the origin, or went on at 10 m/s."""
    usual, late = stand(library), stand(library)
    for controller in (usual, late):
        controller.steer(np.zeros(1, dtype=int), np.array([[0.3, 1.1]]), np.full(1, 0.2))
    times = np.arange(0.0, until + 2.0, 1.0 / RATE)
    seen = {float(time): usual.pose(float(time)) for time in times}
    for time in times[(times < 2.0) | (times >= until)].tolist():
        pose = late.pose(time)
        assert_allclose(pose.root_positions, seen[time].root_positions, atol=1e-6)
        assert_allclose(pose.rotations, seen[time].rotations, atol=1e-5)


def test_nobody_has_no_footsteps_and_nobody_goes_at_any_speed(library):
    controller = stand(library)
    assert controller.plan(np.zeros(0, dtype=int), footsteps(from_stand(controller, 4), range(0))) == ()
    [problem] = controller.steer(np.zeros(1, dtype=int), np.array([[0.0, 1e300]]), AHEAD)
    assert problem.message.endswith("velocity is beyond 1000 m/s")
    assert controller.pose(2.0).halted.all()


def test_steered_agents_stand_with_whole_soles_on_treads(library):
    controller = stand(library, terrain=stairs(0.15, 0.36))
    controller.steer(np.zeros(1, dtype=int), np.array([[0.0, 0.6]]), AHEAD)
    steps = []
    for time in np.arange(0.0, 4.2, 0.2):
        controller.pose(float(time))
        steps.append(controller.footing)
    body = proportions_of(library.source.skeleton, library.source.biped)
    balls, yaws = np.concatenate([step.positions for step in steps]), np.concatenate([step.yaws for step in steps])
    treads = np.round(balls[:, 1] / 0.15)
    assert_allclose(balls[:, 1], 0.15 * treads, atol=1e-6)
    assert treads.max() > 4
    for ahead in (-body.heel, body.toe):
        assert np.all(np.round((balls[:, 2] + ahead * np.cos(yaws)) / 0.36) <= treads)


def test_time_goes_on(library):
    controller = stand(library)
    controller.pose(1.0)
    with pytest.raises(UsdfootError, match=r"goes on from 1\.0 s"):
        controller.pose(0.9)
    with pytest.raises(UsdfootError, match="finite"):
        Controller(library, positions=np.full((1, 3), np.nan), yaws=np.zeros(1))


def test_agents_come_and_go_and_nobody_else_is_touched(library):
    plan = from_stand(stand(library), 9, width=0.2, turn=0.05)
    times = times_of(plan, until=plan.strike_times[-2])
    alone, _ = walk(stand(library, plan), [plan], times, ahead=7)
    controller, poses = stand(library, plan), []
    controller.plan(np.zeros(7, dtype=int), footsteps(plan, range(2, 9)))
    for frame, time in enumerate(times):
        if frame == 20:
            crowd_ = np.stack([[3.0 + agent, 0.0, 1.0] for agent in range(40)])
            assert list(controller.add(crowd_, np.zeros(40))) == list(range(1, 41))
            controller.steer(np.arange(1, 41), np.tile([0.0, 1.0], (40, 1)), np.zeros(40))
        if frame == 50:
            assert controller.remove(np.arange(2, 41)) == ()
        poses.append(controller.pose(float(time)))
    early, late = poses[19], poses[-1]
    assert len(early.there) == 1 and late.there.sum() == 2 and list(controller.there) == [0, 1]
    assert_allclose(late.rotations[2:], np.tile(library.source.skeleton.rest_rotations, (39, 1, 1)), atol=1e-6)
    for one, all_ in zip(alone, poses, strict=True):
        assert_allclose(all_.rotations[0], one.rotations[0], atol=2e-6)
        assert_allclose(all_.translations[0], one.translations[0], atol=2e-6)
        assert_allclose(all_.root_positions[0], one.root_positions[0], atol=1e-9)


def test_who_comes_later_walks_as_who_was_there_from_the_start(library):
    plan = from_stand(stand(library), 8, width=0.2, turn=0.05)
    times = times_of(plan, until=plan.strike_times[-2])
    alone, _ = walk(stand(library, plan), [plan], times, ahead=2)
    controller = Controller(library, positions=np.zeros((0, 3)), yaws=np.zeros(0), start=plan.start - 5.0)
    assert controller.pose(plan.start - 4.0).rotations.shape == (0, len(library.source.skeleton.joints), 4)
    others = controller.add(np.array([[9.0, 0.0, 0.0], [12.0, 0.0, 0.0]]), np.zeros(2))
    controller.steer(others, np.array([[0.0, 1.2], [0.0, 1.4]]), np.zeros(2))
    for time in np.arange(plan.start - 4.0, plan.start, 1.0 / RATE):
        controller.pose(float(time))
    controller.pose(plan.start)
    controller.remove(others[:1])
    assert list(controller.add(NOWHERE, AHEAD)) == [0]  # the number that became free
    together, _ = walk(controller, [plan], times, ahead=2)
    for one, all_ in zip(alone, together, strict=True):
        assert_allclose(all_.rotations[0], one.rotations[0], atol=1e-5)
        assert_allclose(all_.root_positions[0], one.root_positions[0], atol=1e-6)


def test_who_is_gone_is_told_nothing(library):
    controller = stand(library, agents=2)
    assert controller.remove(np.array([0, 5]))[0].message == "agent 5: is not there; 1 are, from 1 to 1"
    plan = from_stand(controller, 4)
    [gone] = controller.plan(np.array([0]), footsteps(plan, [2]))
    assert "agent 0: is not there" in gone.message
    [gone] = controller.steer(np.array([0]), np.ones((1, 2)), np.zeros(1))
    assert "agent 0: is not there" in gone.message
    assert not controller.pose(1.0).there[0]
    controller.remove(np.array([1]))
    assert not controller.pose(2.0).there.any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c, s: c.plan(np.array([0, 0]), s), "agents: has 2 numbers for 1 footsteps. give one for each"),
        (lambda c, s: c.plan(np.array([True]), s), r"agents: has shape \(1,\) and type bool. give the agents' numbers"),
        (lambda c, s: c.plan(0, s), r"agents: has shape \(\)"),
        (
            lambda c, s: c.steer([0], np.zeros(2), [0.0]),
            r"velocities: has shape \(2,\). give numbers of shape \(1, 2\)",
        ),
        (lambda c, s: c.steer([0], np.zeros((1, 2)), []), r"yaws: has shape \(0,\)"),
        (lambda c, s: c.pose("now"), r"time: is no array of numbers"),
        (lambda c, s: c.pose(np.zeros(2)), r"time: has shape \(2,\)"),
        (lambda c, s: c.add(np.zeros(3), np.zeros(1)), r"positions: has shape \(3,\). give numbers of shape \(1, 3\)"),
        (lambda c, s: c.add(np.full((1, 3), np.inf), np.zeros(1)), "positions: has values that are not finite"),
        (lambda c, s: replace(s, yaws=np.zeros(2)), r"arrays differ in length \(.*yaws \(2,\)"),
        (lambda c, s: replace(s, yaws=0.0), r"arrays differ in length \(.*yaws \(\)"),
        (lambda c, s: replace(s, positions=[["a", 0.0, 0.0]]), "positions: is no array of numbers"),
    ],
)
def test_arguments_of_another_shape_are_named_and_nothing_happens(library, call, message):
    controller = stand(library)
    before = controller.pose(0.5)
    steps = Footsteps(sides=[0], positions=[[0.1, 0.0, 0.5]], yaws=[0.0], strike_times=[1.5], liftoff_times=[2.0])
    with pytest.raises(UsdfootError, match=message):
        call(controller, steps)
    assert len(controller) == 1 and controller.footing.strike_times[0] == 0.0
    assert_allclose(controller.pose(1.0).rotations, before.rotations, atol=1e-6)


def test_joints_beside_the_body_go_along_with_it(library):
    """As Unreal's ik_foot_l does with foot_l."""
    skeleton, biped = library.source.skeleton, library.source.biped
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    ankle, count = biped.ankles[0], len(skeleton.joints)
    with_ik = replace(
        skeleton,
        joints=(*skeleton.joints, "ik_root", "ik_root/ik_foot_l"),
        parents=np.append(skeleton.parents, [-1, count]),
        rest_translations=np.vstack([skeleton.rest_translations, np.zeros(3), places[ankle]]),
        rest_rotations=np.vstack([skeleton.rest_rotations, [0.0, 0.0, 0.0, 1.0], turns[ankle]]),
    )
    clips = tuple(
        replace(
            clip,
            translations=with_rest(clip.translations, with_ik.rest_translations[count:]),
            rotations=with_rest(clip.rotations, with_ik.rest_rotations[count:]),
        )
        for clip in library.source.clips
    )
    wide = prepare_library(replace(library.source, skeleton=with_ik, clips=clips), EngineOptions())
    controller = stand(wide)
    controller.steer(np.zeros(1, dtype=int), np.array([[0.0, 1.2]]), AHEAD)
    poses = [controller.pose(float(time)) for time in np.arange(0.0, 2.0, 1.0 / RATE)]
    seen = see(wide, poses)
    assert np.abs(seen.joints[:, -1] - seen.joints[:, ankle]).max() < 1e-5
    assert np.abs(np.sum(seen.rotations[:, -1] * seen.rotations[:, ankle], axis=-1)).min() > 1.0 - 1e-6
    assert np.ptp(seen.joints[:, ankle, 1]) > 0.05


def with_rest(values, rest):
    """Samples (F, J, ...) with more joints, which rest."""
    return np.concatenate([values, np.tile(rest, (len(values), 1, 1))], axis=1)
