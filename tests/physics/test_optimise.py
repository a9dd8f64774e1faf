"""The optimised centre of mass obeys physics and follows the plan's symmetries."""

from dataclasses import replace

import numpy as np
import pytest

from tests.physics.builders import human, plan_of, walk
from usdfoot.maths import planar, quaternion
from usdfoot.physics.heading import OrientationScript
from usdfoot.physics.optimise import optimise_com
from usdfoot.physics.options import PhysicsOptions

LEAPS = walk(9, lengths=[0.6, 0.6, 0.6, 1.3, 0.6, 1.1, 0.6, 0.6])


def path(motion, agent=0, count=200):
    times = np.linspace(motion.contacts.starts[agent], motion.contacts.ends[agent], count)
    return motion.evaluate(np.full(count, agent), times)


@pytest.fixture(scope="module")
def leaping():
    return optimise_com([LEAPS], human())


def flights(motion):
    """Liftoff and strike of all flights inside the motion."""
    contacts = motion.contacts
    liftoffs, strikes = contacts.liftoffs[:-1], contacts.strikes[1:]
    flying = (strikes > liftoffs + 1e-9) & (strikes < contacts.ends[0])
    return list(zip(liftoffs[flying], strikes[flying], strict=True))


def test_flight_is_a_parabola(leaping):
    assert len(flights(leaping)) == 2
    for liftoff, strike in flights(leaping):
        times = np.linspace(liftoff + 1e-3, strike - 1e-3, 20)
        sample = leaping.evaluate(np.zeros(20, dtype=int), times)
        np.testing.assert_allclose(sample.accelerations, np.tile([0.0, -9.81, 0.0], (20, 1)), atol=0.01 * 9.81)


def test_a_leap_is_anticipated_by_a_dip(leaping):
    for liftoff, strike in flights(leaping):
        for begin, end, edge in ((liftoff - 0.5, liftoff, liftoff), (strike, strike + 0.5, strike)):
            heights = leaping.evaluate(np.zeros(50, dtype=int), np.linspace(begin, end, 50)).positions[:, 1]
            at_edge = leaping.evaluate(np.zeros(1, dtype=int), np.array([edge])).positions[0, 1]
            assert heights.min() < at_edge - 0.03
            assert heights.min() < min(heights[0], heights[-1]) - 0.01
    walking = path(optimise_com([walk(9)], human())).positions[:, 1]
    assert np.ptp(walking) < 0.06


def test_a_body_rests_before_its_motion_and_after_it(leaping):
    times = leaping.spline.knots.times
    ends = leaping.spline.evaluate(np.zeros(2, dtype=int), times[[0, -1]])[0]
    positions, velocities, accelerations = leaping.spline.evaluate(np.zeros(2, dtype=int), times[[0, -1]] + [-2.0, 2.0])
    np.testing.assert_allclose(positions, ends, atol=1e-12)
    assert not velocities.any() and not accelerations.any()


def test_path_and_velocity_are_continuous_in_time(leaping):
    knots = leaping.spline.knots
    inner = knots.times[1:-1]
    zero = np.zeros(len(inner), dtype=int)
    before, after = (leaping.evaluate(zero, inner + step) for step in (-1e-7, 1e-7))
    np.testing.assert_allclose(before.positions, after.positions, atol=1e-5)
    np.testing.assert_allclose(before.velocities, after.velocities, atol=1e-4)
    assert np.ptp(knots.durations) > 0.05


def test_walking_needs_hardly_any_force_from_outside():
    steps = optimise_com([walk(10)], human()).steps
    real = slice(1, 11)
    assert (steps.force_imbalance[real] < 0.05 * 9.81).all()
    assert (steps.clamp_time == 0.0).all()
    assert (steps.jump_height == 0.0).all()


def test_agents_solved_together_move_as_alone():
    plans = [walk(6), walk(9, length=1.2), walk(5, turn=0.3), walk(2)]
    together = optimise_com(plans, human())
    for index, plan in enumerate(plans):
        alone = optimise_com([plan], human())
        np.testing.assert_allclose(path(together, index).positions, path(alone).positions, atol=1e-9)
        assert together.energies[index] == pytest.approx(alone.energies[0])


def moved_plan(plan, yaw, shift, later):
    positions = plan.positions.copy()
    positions[:, [0, 2]] = planar.rotate(np.array(yaw), plan.positions[:, [0, 2]])
    return replace(
        plan,
        positions=positions + shift,
        orientations=quaternion.compose(quaternion.yaw_quaternion(np.array(yaw)), plan.orientations),
        strike_times=plan.strike_times + later,
        liftoff_times=plan.liftoff_times + later,
    )


def test_turning_and_shifting_the_plan_turns_and_shifts_the_path():
    plan, yaw, shift = walk(6, turn=0.2), 2.0, np.array([3.0, 1.0, -7.0])
    here, there = path(optimise_com([plan], human())), path(optimise_com([moved_plan(plan, yaw, shift, 5.0)], human()))
    expected = quaternion.rotate(quaternion.yaw_quaternion(np.array(yaw)), here.positions) + shift
    np.testing.assert_allclose(there.positions, expected, atol=2e-4)
    turned = quaternion.compose(quaternion.yaw_quaternion(np.array(yaw)), here.orientations)
    np.testing.assert_allclose(np.abs(np.sum(there.orientations * turned, axis=1)), 1.0, atol=1e-9)


def test_the_mirror_image_of_a_plan_has_the_mirror_image_of_the_path():
    plan = walk(6, turn=0.2, width=0.2)
    image = replace(
        plan,
        sides=1 - plan.sides,
        positions=plan.positions * [-1.0, 1.0, 1.0],
        orientations=quaternion.mirror_x(plan.orientations),
    )
    here, there = path(optimise_com([plan], human())), path(optimise_com([image], human()))
    np.testing.assert_allclose(there.positions, here.positions * [-1.0, 1.0, 1.0], atol=2e-4)


def test_the_body_sways_towards_the_standing_foot():
    plan = walk(10, width=0.3)
    motion = optimise_com([plan], human())
    middles = 0.5 * (plan.strike_times[1:-1] + plan.strike_times[2:])
    aside = motion.evaluate(np.zeros(len(middles), dtype=int), middles).positions[:, 0]
    assert (aside * plan.positions[1:-1, 0] > 0.0).all()


def test_a_script_turns_the_body_and_the_optimum_knows():
    plan = walk(6, width=0.3)
    sideways = OrientationScript(times=np.zeros(1), rotations=quaternion.yaw_quaternion(np.array([np.pi / 2])))
    wide = replace(human(), hips=np.array([[0.25, -0.05, 0.0], [-0.25, -0.05, 0.0]]))
    free, scripted = optimise_com([plan], wide), optimise_com([plan], wide, scripts=[sideways])
    np.testing.assert_allclose(path(scripted).orientations, np.tile(sideways.rotations, (200, 1)), atol=1e-12)
    assert np.abs(path(free).positions - path(scripted).positions).max() > 0.01


def test_body_heading_is_the_moving_mean_of_the_feet():
    plan = walk(12, turn=0.6)
    orientations = path(optimise_com([plan], human())).orientations
    yaws = np.unwrap(2.0 * np.arctan2(orientations[:, 1], orientations[:, 3]))
    assert np.diff(yaws).min() > 0.0
    assert yaws[-1] - yaws[0] == pytest.approx(0.6 * 11, abs=0.7)  # past half a turn, without a jump


def test_standing_motions_begin_and_end_at_rest():
    motion = optimise_com([walk(5, starts_standing=True, ends_standing=True)], human())
    ends = path(motion).velocities[[0, -1]]
    np.testing.assert_allclose(ends, 0.0, atol=1e-12)


def test_lower_gravity_and_a_crouch_are_felt():
    earth, moon = (optimise_com([LEAPS], human(), PhysicsOptions(gravity=g)) for g in (9.81, 1.62))
    liftoff, strike = flights(moon)[0]
    middle = moon.evaluate(np.zeros(1, dtype=int), np.array([0.5 * (liftoff + strike)]))
    assert middle.accelerations[0, 1] == pytest.approx(-1.62, abs=0.05)
    assert earth.steps.jump_height.max() > 3.0 * moon.steps.jump_height.max() > 0.0
    low = optimise_com([walk(6)], replace(human(), nominal_length=0.7))
    high = optimise_com([walk(6)], human())
    drop = path(high).positions[:, 1].mean() - path(low).positions[:, 1].mean()
    assert drop == pytest.approx(0.12, abs=0.03)


@pytest.mark.parametrize("scale", [0.3, 2.0])
def test_bodies_of_other_sizes_move_alike(scale):
    small = replace(
        human(),
        **{name: scale * getattr(human(), name) for name in ("hips", "pelvis", "ankles", "heel", "toe")},
        nominal_length=scale * human().nominal_length,
        maximal_length=scale * human().maximal_length,
    )
    plan, clock = walk(6), np.sqrt(scale)
    scaled = replace(
        plan,
        positions=scale * plan.positions,
        strike_times=clock * plan.strike_times,
        liftoff_times=clock * plan.liftoff_times,
    )
    here = path(optimise_com([plan], human()))
    there = path(optimise_com([scaled], small, PhysicsOptions(heading_window=0.6 * clock)))
    np.testing.assert_allclose(there.positions / scale, here.positions, atol=2e-3)


def impossible(name):
    """Plans no body can walk, and the figure that says so."""
    plan = walk(6)
    strikes, liftoffs = plan.strike_times.copy(), plan.liftoff_times.copy()
    if name == "leap":
        return replace(walk(6, lengths=[0.6, 0.6, 5.0, 0.6, 0.6]), strike_times=strikes, liftoff_times=liftoffs)
    if name == "long steps":
        return replace(walk(6, length=2.5), strike_times=strikes, liftoff_times=liftoffs)
    if name == "in the air":
        strikes[3:] += 10.0
        liftoffs[3:] += 10.0
    return replace(plan, strike_times=strikes, liftoff_times=liftoffs)


@pytest.mark.parametrize(
    ("name", "figure", "least"),
    [
        ("leap", "force_imbalance", 9.81),
        ("leap", "overstretch", 1.0),
        ("long steps", "overstretch", 0.3),
        ("long steps", "clamp_time", 0.05),
        ("in the air", "force_imbalance", 3.0),
        ("in the air", "jump_height", 1.0),
    ],
)
def test_what_physics_forbids_is_moved_and_reported(name, figure, least):
    motion = optimise_com([impossible(name)], human())
    assert np.isfinite(path(motion).positions).all()
    assert getattr(motion.steps, figure).max() > least


def test_footprints_on_one_spot_give_a_stand():
    plan = walk(6)
    plan = plan_of(np.zeros((6, 3)), strikes=plan.strike_times, liftoffs=plan.liftoff_times)
    motion = optimise_com([plan], human())
    assert np.ptp(path(motion).positions, axis=0).max() < 0.05
    assert np.isfinite(motion.energies).all()


def test_steps_of_no_time_share_a_knot():
    plan = walk(6)
    strikes, liftoffs = plan.strike_times.copy(), plan.liftoff_times.copy()
    strikes[3:] -= strikes[3] - strikes[2] - 1e-4
    liftoffs[1] = strikes[3] - 1e-5
    liftoffs[2:] = np.maximum(liftoffs[2:] - 0.5, strikes[2:] + 0.2)
    liftoffs[:-2] = np.minimum(liftoffs[:-2], strikes[2:] - 1e-5)
    motion = optimise_com([replace(plan, strike_times=strikes, liftoff_times=liftoffs)], human())
    assert motion.spline.knots.durations.min() > 0.009
    assert np.isfinite(path(motion).positions).all()
