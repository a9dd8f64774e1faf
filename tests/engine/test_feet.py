"""What the feet do: stand, roll, swing; on level and uneven ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait
from tests.engine.plans import bumps, moved, slope, stairs, way
from tests.engine.synthesis import synthesise
from tests.engine.walkers import between, in_world, library_of
from tests.planning.terrains import slab, terrain_of
from tests.walker_body import BALL_HEIGHT
from usdfoot.analysis.figures import timing_faults
from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.early_balls import early_heights, still_early
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.slopes import lie_in_slopes
from usdfoot.maths import planar, quaternion
from usdfoot.model.ground import Ground
from usdfoot.planning.prints import print_orientations

RATE = 240.0

PLANS = {
    "walk": way(turn=0.1),
    "from stand to stand": way(stand_first=0.9, stand_last=1.0),
    "run": way(length=1.0, width=0.15, step_time=0.35, duty=0.4),
    "backward": way(length=-0.3, step_time=0.55),
    "to the side": way(length=0.0, sideways=0.1, width=0.3, step_time=0.6),
    "on the spot": way(length=0.0, width=0.18, step_time=0.6),
    "upstairs": way(length=0.4, rise=0.15, step_time=0.6),
}
plans = pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS.keys())


def planted(motion, side: int, number: int) -> tuple[float, float]:
    """From flat to liftoff of a contact [s]."""
    contacts = motion.contacts[side]
    return float(contacts.flat_times[number]), float(contacts.liftoff_times[number])


@plans
def test_the_ball_stands_on_its_footstep_from_flat_to_liftoff(animate, walker_library, plan):
    motion = animate([plan], rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    for side in (0, 1):
        footsteps = plan.positions[plan.sides == side]
        strikes = plan.strike_times[plan.sides == side]
        own = motion.contacts[side]
        for step, strike in zip(footsteps, strikes, strict=True):
            number = int(np.argmin(np.abs(own.strike_times - strike)))
            assert_allclose(own.strike_times[number], strike)
            assert_allclose(own.positions[number], step, atol=1e-9)
            balls = feet.balls[between(feet.times, *planted(motion, side, number)), side]
            assert len(balls) > 3
            assert np.ptp(balls, axis=0).max() < 1e-3
            assert_allclose(balls - step, np.broadcast_to([0.0, BALL_HEIGHT, 0.0], balls.shape), atol=1e-3)


@plans
def test_results_say_what_the_feet_do(animate, plan):
    results = animate([plan], rate=60.0)[0].results
    assert set(results.status) <= {"ok", "outsideHull"}
    assert results.placement_error.max() < 1e-3
    assert results.slide.max() < 1e-3
    assert np.abs(results.yaw_error).max() < np.radians(0.5)


@plans
def test_the_heel_stays_from_strike_to_flat(animate, walker_library, plan):
    motion = animate([plan], rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    for side in (0, 1):
        contacts = motion.contacts[side]
        for strike, flat in zip(contacts.strike_times, contacts.flat_times, strict=True):
            heels = feet.heels[between(feet.times, strike, flat), side]
            if len(heels) > 2:
                assert np.ptp(heels, axis=0).max() < 5e-3


@plans
def test_flat_comes_soon_after_the_strike(animate, plan):
    contacts = animate([plan])[0].contacts
    for side in (0, 1):
        real = np.isin(contacts[side].strike_times, plan.strike_times)
        wait = (contacts[side].flat_times - contacts[side].strike_times)[real]
        duration = (contacts[side].liftoff_times - contacts[side].strike_times)[real]
        assert np.all(wait >= 0.0)
        assert np.all(wait <= np.minimum(0.12, 0.25 * duration) + 1e-9)


@plans
def test_the_foot_points_where_the_print_does(animate, walker_library, plan):
    motion = animate([plan], rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    for side in (0, 1):
        own = plan.sides == side
        for yaw, strike, liftoff in zip(plan.yaws[own], plan.strike_times[own], plan.liftoff_times[own], strict=True):
            middle = int(np.argmin(np.abs(feet.times - 0.5 * (strike + liftoff))))
            forward = (feet.balls - feet.ankles)[middle, side][[0, 2]]
            assert abs(float(planar.wrap_angle(planar.yaw_of(forward) - yaw))) < np.radians(0.5)


@plans
def test_swinging_soles_clear_the_ground(animate, walker_library, plan):
    motion = animate([plan], rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    ground = plan.positions[:, 1].min()
    for side in (0, 1):
        contacts = motion.contacts[side]
        for liftoff, strike in zip(contacts.liftoff_times[:-1], contacts.strike_times[1:], strict=True):
            middle = between(feet.times, liftoff + 0.2 * (strike - liftoff), strike - 0.2 * (strike - liftoff))
            if not middle.any():
                continue
            sole = np.minimum(feet.balls[middle, side, 1] - BALL_HEIGHT, feet.heels[middle, side, 1])
            assert sole.min() - ground >= 0.01


@plans
def test_nothing_sinks_into_the_ground(animate, walker_library, plan):
    motion = animate([plan], rate=60.0)[0]
    feet = in_world(walker_library.source, motion)
    ground = plan.positions[:, 1].min()
    assert feet.balls[..., 1].min() - BALL_HEIGHT - ground > -2e-3
    assert feet.heels[..., 1].min() - ground > -2e-3


def test_feet_leave_the_ground_in_time(animate, walker_library):
    plan = way()
    motion = animate([plan], rate=30.0)[0]
    feet = in_world(walker_library.source, motion)
    for side in (0, 1):
        for liftoff in motion.contacts[side].liftoff_times[:-1]:
            last = int(np.flatnonzero(feet.times <= liftoff + 1e-9)[-1])
            assert np.linalg.norm(feet.balls[last + 2, side] - feet.balls[last, side]) > 1e-3


def flat_footed() -> PreparedLibrary:
    """Short steps that put the whole foot down at once."""
    gaits = [
        Gait(step_length=long, step_width=wide, heel_strike=False, clearance=0.05)
        for long in (0.0, 0.2, 0.4)
        for wide in (0.1, 0.2)
    ]
    return prepare_library(library_of(gaits), EngineOptions())


@pytest.mark.parametrize("length", [0.1, 0.2])
def test_feet_of_drawn_out_steps_do_not_stand_before_they_strike(animate, length):
    """Clips put the whole foot down at once, and slower than they show it hovers over its print."""
    library = flat_footed()
    plan = way(length=length, width=0.15, step_time=0.95)
    motion = animate([plan], library=library, rate=30.0)[0]
    feet = in_world(library.source, motion)
    for side in (0, 1):
        own = plan.sides == side
        faults = timing_faults(
            feet.times,
            feet.balls[:, side],
            strike_times=plan.strike_times[own],
            flat_times=motion.contacts[side].flat_times[-own.sum() :],
            liftoff_times=plan.liftoff_times[own],
        )
        assert not faults.any()


@pytest.mark.parametrize("step_time", [0.5, 0.95])
def test_feet_that_stay_off_their_prints_come_down_softly(animate, step_time):
    """They fell 18 mm in the last frame."""
    library = flat_footed()
    plan = way(length=0.2, width=0.15, step_time=step_time)
    feet = in_world(library.source, animate([plan], library=library, rate=RATE)[0])
    for side in (0, 1):
        for strike in plan.strike_times[plan.sides == side][1:]:
            last = (feet.times > strike - 0.06) & (feet.times < strike)
            assert np.diff(feet.balls[last, side, 1]).min() * RATE > -0.4


def test_balls_that_hover_once_they_are_lifted_are_lifted_more():
    """Falling by themselves they are too fast to stand; lifted over what is there they stop a centimetre high."""
    falling = np.zeros((1, 49, 3))
    falling[0, :, 1] = 0.6 * 0.7 * np.linspace(1.0, 0.0, 49)
    lifted = falling.copy()
    lifted[0, -12:-1, 1] = 0.012
    duration = {"durations": np.array([0.7])}
    assert not still_early(falling, np.zeros((1, 3)), **duration).any()
    missing = still_early(lifted, np.zeros((1, 3)), **duration)[0]
    assert missing[-11:-6].min() > 2e-3 and not missing[:-13].any()


def test_balls_that_hover_come_down_to_where_they_strike():
    """Those that land heel first are over their prints then, and would stand there if they had no way left to fall."""
    duration, landing = 0.8, 0.004
    balls = np.tile([0.0, landing, 0.0], (1, 49, 1))
    heights = early_heights(balls, np.zeros((1, 3)), durations=np.array([duration]))[0]
    left = duration * np.linspace(1.0, 0.0, 49)
    speeds = -np.gradient(heights, duration / 48)
    falling = (left > 0.0) & (left < 1.0 / 15.0)
    assert heights[-1] == pytest.approx(landing)
    assert np.all(speeds[falling] > 0.15)
    assert heights[left > 0.1][-1] > 0.015


def test_balls_that_hover_a_little_above_where_they_would_fall_do_not_stand_there():
    """Seen at 30 frames a second, whenever these begin: 12 mm over its print a ball that hardly moves is planted."""
    duration, count = 0.576, 49
    times = np.linspace(0.0, duration, count)
    left = duration - times
    balls = np.zeros((1, count, 3))
    balls[0, :, 0] = 0.005 * np.minimum(left / 0.1, 1.0) + 2.0 * np.maximum(left - 0.1, 0.0)
    balls[0, :, 1] = np.interp(left, [0.0, 0.042, 0.075, 0.15, duration], [0.0, 0.0115, 0.0132, 0.022, 0.03])
    missing = still_early(balls, np.zeros((1, 3)), durations=np.array([duration]))[0]

    def faults(path):
        found = 0
        for shift in np.linspace(0.0, 1.0 / 30.0, 12, endpoint=False):
            frames = np.arange(-0.3, duration + 0.3, 1.0 / 30.0) + shift
            seen = np.stack([np.interp(frames, times, path[:, axis]) for axis in range(3)], axis=-1)
            known = {name: np.array([-0.2, at]) for name, at in (("strike_times", duration), ("flat_times", duration))}
            found += timing_faults(frames, seen, **known, liftoff_times=np.array([0.0, duration + 0.3]))[1, 1]
        return found

    assert faults(balls[0]) > 0
    assert faults(balls[0] + missing[:, None] * [0.0, 1.0, 0.0]) == 0


def test_legs_pass_each_other(animate, walker_library):
    """Prints on one line: the swinging foot goes around the standing one."""
    plan = way(width=0.0, length=0.55)
    options = EngineOptions()
    motion = animate([plan], options=options, rate=120.0)[0]
    feet = in_world(walker_library.source, motion)
    closest = np.inf
    for side in (0, 1):
        contacts = motion.contacts[side]
        for liftoff, strike in zip(contacts.liftoff_times[:-1], contacts.strike_times[1:], strict=True):
            apart = (feet.balls[:, side] - feet.balls[:, 1 - side])[between(feet.times, liftoff, strike)]
            beside = np.abs(apart[:, 2]) < 0.03
            closest = min(closest, np.abs(apart[beside, 0]).min())
    assert closest > 0.8 * options.foot_spacing


@pytest.mark.parametrize(("tilt_x", "tilt_z"), [(0.0, 0.15), (0.12, 0.0), (-0.08, -0.12)])
def test_soles_lie_on_a_slope(animate, walker_library, tilt_x, tilt_z):
    """The prints know nothing of the slope; pitch and roll come from the ground under them."""
    flat = way(length=0.45)
    heights = flat.positions[:, 0] * tilt_x + flat.positions[:, 2] * tilt_z
    plan = replace(flat, positions=flat.positions + np.array([0.0, 1.0, 0.0]) * heights[:, None])
    motion = animate([plan], terrain=slope(tilt_x, tilt_z), rate=120.0)[0]
    feet = in_world(walker_library.source, motion)
    normal = np.array([-tilt_x, 1.0, -tilt_z]) / np.sqrt(1.0 + tilt_x**2 + tilt_z**2)
    assert set(motion.results.status) <= {"ok", "outsideHull"}
    for side in (0, 1):
        own = plan.sides == side
        for flat_time, liftoff in zip(
            motion.contacts[side].flat_times, motion.contacts[side].liftoff_times, strict=True
        ):
            at = int(np.argmin(np.abs(feet.times - (flat_time + 0.02 * (liftoff - flat_time)))))
            if not (plan.strike_times[own][0] <= flat_time < plan.strike_times[own][-1]):
                continue
            heel = feet.heels[at, side]
            assert abs(heel @ normal) < 0.008
    vertical = feet.balls[..., 1] - tilt_x * feet.balls[..., 0] - tilt_z * feet.balls[..., 2]
    assert vertical.min() > BALL_HEIGHT - 2e-3


@pytest.mark.parametrize("uphill", [0.2, 0.4])
def test_who_stands_on_a_slope_has_the_heels_down(animate, walker_library, uphill):
    flat = way(length=0.3, stand_first=1.0, stand_last=1.0)
    plan = replace(flat, positions=flat.positions + flat.positions[:, 2:] * [0.0, uphill, 0.0])
    motion = animate([plan], terrain=slope(0.0, uphill), rate=30.0)[0]
    feet = in_world(walker_library.source, motion)
    normal = np.array([0.0, 1.0, -uphill]) / np.hypot(1.0, uphill)
    for frame in (feet.times < plan.strike_times[0] + 0.4, feet.times > plan.liftoff_times[-1] - 0.4):
        assert np.abs(feet.heels[frame] @ normal).max() < 0.008


@pytest.mark.parametrize("rise", [0.12, -0.12])
def test_feet_clear_the_edges_of_stairs(animate, walker_library, rise):
    tread = 0.45
    plan = way(6, length=tread, rise=rise, step_time=0.6)
    motion = animate([plan], terrain=stairs(rise, tread), rate=120.0)[0]
    feet = in_world(walker_library.source, motion)
    assert set(motion.results.status) <= {"ok", "outsideHull"}
    assert motion.results.placement_error.max() < 3e-3
    inside = between(feet.times, plan.strike_times[0], plan.strike_times[-1])
    for points, above in ((feet.balls, BALL_HEIGHT), (feet.heels, 0.0)):
        treads = np.maximum(np.floor(points[inside, :, 2] / tread + 0.5), 0.0) * rise
        assert (points[inside, :, 1] - above - treads).min() > -2e-3


@pytest.mark.parametrize("rise", [-0.2, 0.2])
def test_feet_have_time_for_the_height_of_treads(animate, walker_library, rise):
    tread = 0.4
    plan = way(8, length=tread, rise=rise, step_time=0.6)
    motion = animate([plan], terrain=stairs(rise, tread), rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    speeds = np.abs(np.gradient(feet.balls[..., 1], feet.times, axis=0))
    assert speeds.max() < 2.5  # a foot that hurries nowhere on the level comes down at 3.8 m/s, past the edge


def test_feet_do_not_land_hard_whose_heels_come_late_past_an_edge(animate, walker_library):
    """The fall is low, but the heel passes the edge 0.1 s before it stands 3 cm behind it."""
    tread, rise = 0.4, -0.08
    plan = moved(way(8, length=tread, rise=rise, step_time=0.5), shift=(0.0, 0.0, 0.03))
    motion = animate([plan], terrain=stairs(rise, tread), rate=RATE)[0]
    feet = in_world(walker_library.source, motion)
    heights = np.stack([feet.balls[..., 1], feet.heels[..., 1]])
    landings = np.gradient(np.gradient(heights, feet.times, axis=1), feet.times, axis=1)
    for side, strike in zip(plan.sides[2:-1], plan.strike_times[2:-1], strict=True):
        near = between(feet.times, strike - 0.1, strike + 0.02)
        assert landings[:, near, side].max() < 45.0  # the walker's own feet come down with 25 m/s2, these did with 62


def test_a_footstep_beside_the_terrain_is_reported_and_the_others_are_exact(animate):
    plan = way()
    terrain = slope(0.0, 0.0, size=float(plan.positions[-1, 2]) - 0.1)
    results = animate([plan], terrain=terrain)[0].results
    assert results.status[-1] == "offTerrain"
    assert "offTerrain" not in results.status[:-1]
    assert results.placement_error[:-1].max() < 1e-3


def test_ground_that_is_not_walkable_does_not_carry(animate):
    results = animate([way()], terrain=slope(0.0, 0.0, walkable=False))[0].results
    assert set(results.status) == {"offTerrain"}


def test_the_agent_walks_at_the_height_of_its_ground(animate, walker_library):
    low, high = way(), moved(way(), shift=(0.0, 7.5, 0.0))
    first, second = (animate([plan])[0] for plan in (low, high))
    assert_allclose(
        second.root_positions - first.root_positions, np.tile([0.0, 7.5, 0.0], (len(first.times), 1)), atol=1e-9
    )
    assert_allclose(second.pelvis_positions, first.pelvis_positions, atol=1e-5)


def test_the_root_follows_the_footsteps(animate):
    plan = way(turn=0.1)
    motion = animate([plan], rate=60.0)[0]
    for number in range(1, len(plan)):
        at = int(np.argmin(np.abs(motion.times - plan.strike_times[number])))
        middle = 0.5 * (plan.positions[number] + plan.positions[number - 1])
        assert_allclose(motion.root_positions[at], middle, atol=0.02)
    steps = np.diff(motion.root_positions[:-1], axis=0)  # the last sample is held at the last liftoff
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < 0.01
    assert np.abs(np.diff(motion.root_yaws)).max() < 0.02


def test_rotations_are_unit_and_pelvis_entry_repeats(animate, walker_library):
    motion = animate([way()])[0]
    assert_allclose(np.linalg.norm(motion.rotations, axis=-1), 1.0, atol=1e-5)
    pelvis = walker_library.source.biped.pelvis
    assert_allclose(motion.rotations[:, pelvis], motion.pelvis_rotations, atol=1e-6)
    apart = quaternion.to_rotation_vector(
        quaternion.compose(quaternion.inverse(motion.rotations[:-1]), motion.rotations[1:]).astype(float)
    )
    assert np.linalg.norm(apart, axis=-1).max() < 0.5


def test_a_foot_that_leans_with_the_ground_still_points_where_a_level_print_does(animate, walker_library):
    """The ankle leans sideways above the ball; the yaw is that of the line between the two, seen from above."""
    flat = way(length=0.45)
    plan = replace(flat, positions=flat.positions + np.array([0.0, 0.3, 0.0]) * flat.positions[:, :1])
    motion = animate([plan], terrain=slope(0.3, 0.0), rate=120.0)[0]
    feet = in_world(walker_library.source, motion)
    for step in range(2, len(plan) - 2):
        side = plan.sides[step]
        flat_time = motion.contacts[side].flat_times[np.flatnonzero(plan.sides[:step] == side).size]
        forward = (feet.balls - feet.ankles)[np.searchsorted(feet.times, flat_time + 0.02), side]
        assert abs(float(planar.yaw_of(forward[[0, 2]]))) < np.radians(0.5)


def test_feet_stand_on_round_hills_and_point_where_level_prints_do(animate, walker_library):
    """Their soles do not sink in where the ground curves, and rising heels do not turn feet that lean."""
    terrain, level = bumps(0.15, 0.2), way(10, length=0.4)
    ground = Ground(terrain)
    heights = ground.heights(level.positions[:, [0, 2]], 1.0).heights
    plan = replace(level, positions=level.positions + np.array([0.0, 1.0, 0.0]) * heights[:, None])
    motion = animate([plan], terrain=terrain, rate=60.0)[0]
    feet = in_world(walker_library.source, motion)
    assert np.abs(motion.results.yaw_error).max() < np.radians(0.5)
    for side in (0, 1):
        contacts = motion.contacts[side]
        for strike, liftoff in zip(contacts.strike_times, contacts.liftoff_times, strict=True):
            if not plan.strike_times[0] <= strike <= plan.strike_times[-1]:
                continue
            heels = feet.heels[between(feet.times, strike, liftoff), side]
            assert (heels[:, 1] - ground.heights(heels[:, [0, 2]], 1.0).heights).min() > -2e-3


@pytest.mark.parametrize("side", [0, 1])
def test_feet_lean_with_the_ground_as_far_as_ankles_do(animate, walker_library, side):
    """Ground that rises to the left by 45 degrees: the left foot's outer edge is up, the right foot's inner edge."""
    plan = way(length=0.4)
    plan = replace(plan, positions=plan.positions + plan.positions[:, :1] * [0.0, 1.0, 0.0])
    motion = animate([plan], terrain=slope(1.0, 0.0), rate=60.0)[0]
    feet = in_world(walker_library.source, motion)
    contacts = motion.contacts[side]
    frames = between(feet.times, contacts.flat_times[2], contacts.flat_times[2] + 0.1)
    ahead = feet.balls[frames, side] - [0.0, BALL_HEIGHT, 0.0] - feet.heels[frames, side]
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    above = feet.ankles[frames, side] - feet.heels[frames, side]
    above = above - np.sum(above * ahead, axis=1, keepdims=True) * ahead
    lean = np.degrees(np.abs(np.arcsin(np.cross(above, ahead)[:, 1] / np.linalg.norm(above, axis=1))))
    most = (15.0, 35.0)[side]
    assert lean.min() > 0.6 * most and lean.max() < most + 1.0


def test_feet_that_stand_on_a_pad_find_ground_lower_behind_it_than_they_are_long(walker_library):
    """A bird's pad reaches 2 cm back, and the ground behind falls by 2.5."""
    plan = way(length=0.4)
    stones = [slab((-2.0, 2.0), (z - 0.01, z + 0.1), (0.0, 0.0)) for z in plan.positions[:, 2]]
    terrain = terrain_of([slab((-2.0, 2.0), (-2.0, 8.0), (-0.025, -0.025)), *stones])
    layout = synthesise(walker_library, [plan]).planting.layout
    pad = np.array([0.0, -BALL_HEIGHT, -0.02])
    feet = tuple(
        replace(foot, heel_offset=foot.ball_offset + quaternion.rotate(quaternion.inverse(foot.flat_rotation), pad))
        for foot in layout.rig.feet
    )
    frames, on_ground = lie_in_slopes(replace(layout, rig=replace(layout.rig, feet=feet)), Ground(terrain))
    assert on_ground.all()
    assert_allclose(np.linalg.norm(frames, axis=1), 1.0)


@pytest.mark.parametrize("ahead", [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (0.7, 0.7), (0.7, -0.7)])
@pytest.mark.parametrize("degrees", [30, 40, 50, 60])
def test_feet_stand_on_planes_of_any_steepness(animate, walker_library, degrees, ahead):
    """Uphill, downhill, along the slope and askew: no foot turns round, sinks in or snaps."""
    tilt_x, tilt_z = np.tan(np.radians(degrees)) * np.array(ahead)
    normal = np.array([-tilt_x, 1.0, -tilt_z]) / np.sqrt(1.0 + tilt_x**2 + tilt_z**2)
    level = way(length=0.45 * np.cos(np.radians(degrees)))
    rises = level.positions[:, 0] * tilt_x + level.positions[:, 2] * tilt_z
    plan = replace(
        level,
        positions=level.positions + np.array([0.0, 1.0, 0.0]) * rises[:, None],
        orientations=print_orientations(level.yaws, np.tile(normal, (len(rises), 1))),
    )
    motion = animate([plan], terrain=slope(tilt_x, tilt_z), rate=60.0)[0]
    feet = in_world(walker_library.source, motion)
    assert motion.results.placement_error.max() < 1e-3
    assert np.abs(motion.results.yaw_error).max() < np.radians(0.5)
    for points, height in ((feet.balls, BALL_HEIGHT), (feet.heels, 0.0)):
        assert (points @ np.array([-tilt_x, 1.0, -tilt_z])).min() > height - 2e-3
    turned = np.abs(np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1))
    assert np.all(2.0 * np.arccos(np.minimum(turned, 1.0)) < np.radians(20.0))
    planted_frames = [
        between(feet.times, flat, liftoff)
        for flat, liftoff in zip(motion.contacts[0].flat_times, motion.contacts[0].liftoff_times, strict=True)
    ]
    soles = (feet.balls - feet.heels - [0.0, BALL_HEIGHT, 0.0])[np.any(planted_frames, axis=0), 0]
    assert soles[:, 1].max() < np.sin(np.radians(42.0)) * np.linalg.norm(soles, axis=1).max()


@pytest.mark.parametrize("offset", [-0.03, -0.01, 0.01, 0.03])
def test_footsteps_a_little_off_the_terrain_stand_on_it(animate, walker_library, offset):
    flat = way()
    plan = replace(flat, positions=flat.positions + np.array([0.0, offset, 0.0]))
    motion = animate([plan], terrain=slope(0.0, 0.0), rate=120.0)[0]
    assert set(motion.results.status) == {"ok"}
    assert motion.results.placement_error.max() < 1e-3
    feet = in_world(walker_library.source, motion)
    assert min(feet.balls[..., 1].min() - BALL_HEIGHT, feet.heels[..., 1].min()) > -2e-3
    for side in (0, 1):
        assert_allclose(motion.contacts[side].positions[:, 1], 0.0, atol=1e-6)


@pytest.mark.parametrize(("length", "duty"), [(0.55, 0.8), (0.65, 0.8), (0.85, 0.65)])
def test_a_pelvis_comes_down_in_time_for_feet_that_stay_long_behind(animate, length, duty):
    """Not at the last moment: it would fall and bounce with several times gravity."""
    motion = animate([way(9, length=length, step_time=0.5, duty=duty)], rate=60.0)[0]
    falls = np.diff(motion.pelvis_positions[:, 1].astype(float), n=2) * 60.0**2
    assert np.abs(falls).max() < 1.5 * 9.81
