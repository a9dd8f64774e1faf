"""Root trajectories given with plans: where the root goes and faces, and the velocity asked for ([B] 4.2, 5)."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, way
from tests.engine.walkers import in_world
from usdfoot.engine.animate import animate_agents, animate_crowd, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.root_goals import root_goals
from usdfoot.maths import planar, quaternion
from usdfoot.model.trajectory import RootTrajectory

TIMES = np.linspace(-1.0, 12.0, 261)


def beside(plan, *, turned=0.0, shift=0.0):
    """A trajectory through the middle of the feet, turned against them [rad] and moved to the left [m]."""
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    columns = [np.interp(TIMES, plan.strike_times[1:], column) for column in middles.T]
    heading = plan.yaws.mean()
    positions = np.stack(columns, axis=1) + np.insert(planar.rotate(heading, np.array([shift, 0.0])), 1, 0.0)
    return RootTrajectory(name="/Root", times=TIMES, positions=positions, yaws=np.full(len(TIMES), heading + turned))


def walk(walker_library, plan, trajectory, **options):
    scene = crowd(walker_library.source, [plan])
    agents = [replace(scene.agents[0], root_trajectory=trajectory)]
    (motion,) = animate_agents(walker_library, agents, scene, options=EngineOptions(**options))
    return motion


def facing(library, motion):
    """Yaw of the pelvis in the world [rad]."""
    world = in_world(library.source, motion)
    forward = quaternion.rotate(world.rotations[:, library.source.biped.pelvis], np.array([0.0, 0.0, 1.0]))
    return planar.yaw_of(forward[:, [0, 2]])


def test_agent_prim_goes_along_the_trajectory(walker_library):
    plan = way(10)
    trajectory = beside(plan, turned=0.2, shift=0.1)
    motion = walk(walker_library, plan, trajectory)
    wanted = np.stack([np.interp(motion.times, TIMES, column) for column in trajectory.positions.T], axis=1)
    assert_allclose(motion.root_positions[:, [0, 2]], wanted[:, [0, 2]], atol=1e-6)
    assert_allclose(motion.root_yaws, trajectory.yaws[0], atol=1e-6)


@pytest.mark.parametrize("turned", [-0.4, 0.3])
def test_body_turns_about_the_support_ball_and_the_feet_stay(walker_library, turned):
    plan = way(10)
    straight, given = walk(walker_library, plan, None), walk(walker_library, plan, beside(plan, turned=turned))
    difference = planar.wrap_angle(facing(walker_library, given) - facing(walker_library, straight))
    assert_allclose(np.median(difference), turned, atol=0.05)
    assert given.results.slide.max() < 1e-3 and given.results.placement_error.max() < 1e-3
    assert np.degrees(given.results.yaw_error.max()) < 0.5


def test_trajectory_of_the_feet_changes_no_pose(walker_library):
    plan = way(10)
    straight, given = walk(walker_library, plan, None), walk(walker_library, plan, beside(plan))
    inner = slice(20, -20)
    positions = [in_world(walker_library.source, motion).positions[inner] for motion in (straight, given)]
    assert np.abs(positions[0] - positions[1])[:, 1:].max() < 0.02


def test_root_weights_ask_for_the_trajectorys_velocity(walker_library):
    plan = way(10)
    slow = beside(plan)
    slow = replace(slow, positions=plan.positions[0] + 0.5 * (slow.positions - plan.positions[0]))
    scene = crowd(walker_library.source, [plan])
    for trajectory, share in ((None, 1.0), (slow, 0.5)):
        agents = [replace(scene.agents[0], root_trajectory=trajectory)]
        options = EngineOptions(root_weight=0.5)
        steps = prepare_steps(walker_library, agents, scene, options=options)
        goals = root_goals(steps.setup, agents)
        own = np.flatnonzero(~steps.setup.segments.stands)[2:-3]
        if trajectory is None:
            full = np.linalg.norm(goals.velocities[own], axis=1)
        assert_allclose(np.linalg.norm(goals.velocities[own], axis=1), share * full, rtol=0.02)


def test_footsteps_that_a_turned_root_puts_out_of_reach_are_the_headings_fault(walker_library):
    plan = way(10)
    scene = crowd(walker_library.source, [plan], reach=0.05)
    agents = (replace(scene.agents[0], root_trajectory=beside(plan, turned=np.pi / 2)),)
    _, problems = animate_crowd(replace(scene, agents=agents))
    missed = [problem.message for problem in problems if "footstep(s) are" in problem.message]
    assert missed and all("the root trajectory /Root faces 90 degrees off the feet there" in text for text in missed)
