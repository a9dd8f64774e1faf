"""Rules of motion: what is done to a plan happens to the motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tests.engine.plans import MIRROR, later, mirrored, moved, way
from tests.engine.walkers import in_world
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.maths import planar, quaternion

PLANS = {
    "walk": way(),
    "turning": way(turn=0.2, length=0.5),
    "starts and ends standing": way(stand_first=0.8, stand_last=1.0),
    "run": way(length=1.0, width=0.15, step_time=0.35, duty=0.4),
    "backward": way(length=-0.3, step_time=0.55),
    "far steps": way(length=1.3),
}
plans = pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS.keys())


@plans
@pytest.mark.parametrize("yaw", [0.5 * np.pi, -2.3])
def test_a_turned_and_shifted_plan_gives_the_turned_and_shifted_motion(animate, walker_library, plan, yaw):
    shift = np.array([3.0, -0.7, 11.0])
    motion, image = animate([plan])[0], animate([moved(plan, yaw=yaw, shift=shift)])[0]
    before, after = in_world(walker_library.source, motion), in_world(walker_library.source, image)
    turned = quaternion.rotate(quaternion.yaw_quaternion(np.array(yaw)), before.positions) + shift
    body = walker_library.source.biped.pelvis
    assert_allclose(after.positions[:, body:], turned[:, body:], atol=1e-4)
    assert_allclose(planar.wrap_angle(image.root_yaws - motion.root_yaws - yaw), 0.0, atol=1e-6)


@plans
def test_a_mirrored_plan_gives_the_mirrored_motion(animate, walker_library, plan):
    source = walker_library.source
    before, after = (in_world(source, animate([each])[0]) for each in (plan, mirrored(plan)))
    partners = joint_pairs(source.skeleton, source.biped)
    body = source.biped.pelvis
    assert_allclose(after.positions[:, body:], (before.positions[:, partners] * MIRROR)[:, body:], atol=1e-5)


def test_a_later_plan_gives_the_same_motion_later(animate, walker_library):
    plan = way(turn=0.1, stand_first=0.7)
    before, after = animate([plan])[0], animate([later(plan, 40.0)])[0]
    assert_allclose(after.times, before.times + 40.0)
    first, second = in_world(walker_library.source, before), in_world(walker_library.source, after)
    assert_allclose(second.positions, first.positions, atol=1e-5)


@settings(max_examples=8)
@given(yaw=st.floats(-3.1, 3.1), x=st.floats(-50.0, 50.0), start=st.floats(-5.0, 5.0))
def test_results_do_not_depend_on_where_and_when(animate, yaw, x, start):
    plan = way(5, turn=0.15)
    here = animate([plan], rate=60.0)[0].results
    there = animate([later(moved(plan, yaw=yaw, shift=(x, 1.0, 0.0)), start)], rate=60.0)[0].results
    assert_allclose(there.blend_error, here.blend_error, atol=2e-5)
    assert_allclose(there.hull_distance, here.hull_distance, atol=1e-7)
    assert there.status == here.status


def test_agents_do_not_know_of_each_other(animate):
    together = [PLANS["walk"], moved(PLANS["run"], yaw=1.0, shift=(30.0, -2.0, 0.0)), PLANS["starts and ends standing"]]
    times = np.arange(-30, 200) / 30.0
    crowd_of_three = animate(together, times=times)
    for plan, motion in zip(together, crowd_of_three, strict=True):
        alone = animate([plan], times=times)[0]
        for name in ("times", "root_positions", "root_yaws", "pelvis_positions", "pelvis_rotations", "rotations"):
            assert getattr(alone, name).tobytes() == getattr(motion, name).tobytes(), name
        assert alone.results.clips == motion.results.clips


def test_the_same_input_gives_the_same_bytes(animate):
    first, second = (animate([PLANS["turning"]])[0] for _ in range(2))
    assert first.rotations.tobytes() == second.rotations.tobytes()
    assert first.pelvis_positions.tobytes() == second.pelvis_positions.tobytes()


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
def test_frame_rates_agree_where_they_meet(animate, rate):
    plan = way(turn=0.1)
    common, finer = animate([plan], rate=24.0)[0], animate([plan], rate=rate)[0]
    rows = [np.flatnonzero(np.abs(finer.times - time) < 1e-9) for time in common.times]
    shared = [(index, found[0]) for index, found in enumerate(rows) if found.size]
    assert len(shared) > 10
    ours, theirs = np.array(shared).T
    assert_allclose(finer.rotations[theirs], common.rotations[ours], atol=2e-6)
    assert_allclose(finer.root_positions[theirs], common.root_positions[ours], atol=1e-9)
    assert_allclose(finer.pelvis_positions[theirs], common.pelvis_positions[ours], atol=2e-6)
