"""Trajectories with known truth become footsteps that keep to them, and motions whose feet stay."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, no_terrain
from tests.engine.walkers import WALKS, library_of
from tests.planning.terrains import slab, terrain_of
from usdfoot.engine.animate import animate_agents, prepare_library
from usdfoot.engine.follow_options import FollowOptions
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.model.trajectory import RootTrajectory, sample_trajectory
from usdfoot.planning.follow import Following, follow_trajectories
from usdfoot.planning.proportions import proportions_of

TIMES = np.arange(0.0, 9.01, 0.1)
ORIGIN = np.array([2.0, 0.0, -3.0])


def at_velocities(times, velocities, *, name="velocities", yaws=None):
    """The trajectory that velocities (x, z), in the heading if there are yaws, lead along from the origin."""
    world = velocities if yaws is None else planar.rotate(yaws, velocities)
    moved = np.cumsum(0.5 * (world[1:] + world[:-1]) * np.diff(times)[:, None], axis=0)
    positions = ORIGIN + np.insert(np.concatenate([np.zeros((1, 2)), moved]), 1, 0.0, axis=1)
    return RootTrajectory(name=name, times=times, positions=positions, yaws=yaws, rest_yaw=0.0)


def forward(speeds, *, name="forward", times=TIMES, yaws=None):
    """A trajectory at speeds (K,) along +Z, or along its headings."""
    speeds = np.broadcast_to(np.asarray(speeds, dtype=float), times.shape)
    velocities = np.stack([np.zeros_like(speeds), speeds], axis=1)
    return at_velocities(times, velocities, name=name, yaws=yaws)


def follow(walkers, trajectories, *, terrain=None, options=None):
    found = follow_trajectories(
        walkers.examples,
        walkers.spaces,
        trajectories,
        style=walkers.style,
        body=proportions_of(walkers.source.skeleton, walkers.source.biped),
        ground=Ground(terrain or no_terrain()),
        options=options,
    )
    assert len(found) == len(trajectories)
    return found


def follow_one(walkers, trajectory, **about) -> Following:
    (found,) = follow(walkers, [trajectory], **about)
    assert isinstance(found, Following), found
    return found


TRUTHS = {
    "straight": forward(1.3),
    "circle": forward(1.0, yaws=0.6 * TIMES),
    "stop and go": forward(np.where((TIMES > 3.0) & (TIMES < 5.5), 0.0, 1.2)),
    "walk to run and back": forward(np.interp(TIMES, [0, 3, 4.5, 6, 7.5], [1.2, 1.2, 2.8, 2.8, 1.2])),
    "slow shuffle": forward(0.12),
    "start": forward(np.interp(TIMES, [1.5, 2.5], [0.0, 1.4])),
    "turn on the spot": forward(0.0, yaws=np.interp(TIMES, [2.0, 5.0], [0.0, np.pi])),
    "backward": forward(-0.6, yaws=np.zeros_like(TIMES)),
    "sideways": at_velocities(TIMES, np.tile([0.2, 0.0], (len(TIMES), 1)), yaws=np.zeros_like(TIMES)),
}


@pytest.fixture(scope="module")
def followed(walkers):
    """All truths at once."""
    return dict(zip(TRUTHS, follow(walkers, list(TRUTHS.values())), strict=True))


@pytest.mark.parametrize("name", TRUTHS)
def test_root_keeps_to_the_trajectory(followed, name):
    found = followed[name]
    assert found.plan.start == TIMES[0]
    assert found.plan.strike_times[-1] < TIMES[-1] <= found.plan.end < TIMES[-1] + 1.0
    assert found.distances.mean() < 0.03 and found.distances.max() < 0.15
    assert found.velocity_errors.mean() < 0.06


def test_who_walks_on_at_the_end_finishes_the_last_contact(followed):
    plan = followed["straight"].plan
    contacts = plan.liftoff_times - plan.strike_times
    assert contacts[-1] == pytest.approx(contacts[-3], rel=0.05)


def test_motions_of_all_stand_and_land_on_their_footsteps(walkers, followed):
    scene = crowd(walkers.source, [found.plan for found in followed.values()])
    motions = animate_agents(walkers, scene.agents, scene, options=EngineOptions())
    for motion, (name, trajectory) in zip(motions, TRUTHS.items(), strict=True):
        assert set(motion.results.status) <= {"ok", "outsideHull"}, name
        assert motion.results.slide.max() < 1e-3 and motion.results.placement_error.max() < 1e-3
        wanted = sample_trajectory(trajectory, motion.times)
        assert np.linalg.norm((motion.root_positions - wanted)[:, [0, 2]], axis=1).mean() < 0.1, name


def test_steady_walk_is_that_of_the_clip_with_its_speed(walkers):
    plan = follow_one(walkers, forward(1.1)).plan  # one of the walks has steps of 0.55 m in 0.5 s
    assert_allclose(np.diff(plan.strike_times), 0.5, atol=0.01)
    assert_allclose(np.diff(plan.positions[:, 2]), 0.55, atol=0.01)
    assert_allclose(np.abs(np.diff(plan.positions[:, 0])), 0.18, atol=0.06)  # 0.09, 0.18 and 0.28 m are averaged
    assert_allclose(plan.positions[:-1, 0] + plan.positions[1:, 0], 2.0 * ORIGIN[0], atol=1e-3)


def test_velocities_are_met_exactly_between_the_examples(walkers):
    found = follow_one(walkers, forward(1.35))
    assert found.velocity_errors.max() < 0.01 and found.distances.max() < 0.01


def test_circle_faces_along_itself(followed):
    plan = followed["circle"].plan
    headings = plan.yaws[:-1] + 0.5 * planar.wrap_angle(np.diff(plan.yaws))
    assert np.abs(planar.wrap_angle(headings - 0.6 * plan.strike_times[1:])).max() < 0.12


def test_stop_stands_with_both_feet_side_by_side(followed):
    plan = followed["stop and go"].plan
    waits = plan.liftoff_times[:-1] - plan.strike_times[1:]
    rest = int(np.argmax(waits))
    assert waits[rest] > 1.0 and 2.5 < plan.strike_times[rest + 1] < 4.5
    between = np.abs(plan.positions[rest + 1] - plan.positions[rest])
    assert between[2] < 0.1 and 0.08 < between[0] < 0.3
    middle = 0.5 * (plan.positions[rest + 1] + plan.positions[rest])
    stop = sample_trajectory(TRUTHS["stop and go"], np.array([4.5]))[0]
    assert np.linalg.norm(middle - stop) < 0.08


def test_turn_on_the_spot_takes_small_steps_and_ends_as_it_shall(followed):
    plan = followed["turn on the spot"].plan
    assert plan.starts_standing and plan.ends_standing
    assert np.linalg.norm((plan.positions - ORIGIN)[:, [0, 2]], axis=1).max() < 0.2
    assert np.abs(planar.wrap_angle(np.diff(plan.yaws))).max() <= FollowOptions().outward_turn + 1e-9
    last = plan.yaws[-1] + 0.5 * planar.wrap_angle(plan.yaws[-2] - plan.yaws[-1])
    assert abs(planar.wrap_angle(last - np.pi)) < 0.1


def test_walk_becomes_a_run_with_flights_and_a_walk_again(followed):
    plan = followed["walk to run and back"].plan
    flights = plan.strike_times[1:] - plan.liftoff_times[:-1] > 0.03
    speeds = np.interp(plan.strike_times[1:], TIMES, [0.0] * len(TIMES)) + np.interp(
        plan.strike_times[1:], [0, 3, 4.5, 6, 7.5], [1.2, 1.2, 2.8, 2.8, 1.2]
    )
    assert flights[speeds > 2.6].all() and not flights[speeds < 1.4].any()


def test_standing_trajectory_is_two_feet_from_start_to_end(walkers):
    plan = follow_one(walkers, forward(0.0)).plan
    assert len(plan) == 2 and plan.starts_standing and plan.ends_standing
    assert_allclose(plan.positions.mean(axis=0), ORIGIN, atol=1e-9)


def test_coarse_samples_with_jitter_are_walked_smoothly(walkers):
    generator = np.random.default_rng(5)
    times = np.arange(0.0, 12.0, 0.4)
    way = np.stack([0.2 * times, np.zeros_like(times), 1.2 * times], axis=1)
    given = way + generator.normal(scale=0.03, size=way.shape) * (1.0, 0.0, 1.0)
    found = follow_one(walkers, RootTrajectory(name="tracked", times=times, positions=given))
    roots = 0.5 * (found.plan.positions[1:] + found.plan.positions[:-1])
    true = np.stack([0.2 * found.plan.strike_times[1:], 1.2 * found.plan.strike_times[1:]], axis=1)
    assert np.linalg.norm(roots[:, [0, 2]] - true, axis=1).mean() < 0.03
    assert 0.005 < found.smoothing[0] < 0.05
    steps = np.linalg.norm(np.diff(found.plan.positions, axis=0), axis=1)
    rough = follow_one(
        walkers,
        RootTrajectory(name="tracked", times=times, positions=given),
        options=FollowOptions(smoothing_time=0.0),
    )
    assert rough.smoothing == (0.0, 0.0)
    assert np.std(steps) < np.std(np.linalg.norm(np.diff(rough.plan.positions, axis=0), axis=1))


def test_rests_despite_jitter(walkers):
    generator = np.random.default_rng(3)
    times = np.arange(0.0, 10.0, 0.4)
    positions = ORIGIN + generator.normal(scale=0.015, size=(len(times), 3)) * (1.0, 0.0, 1.0)
    assert len(follow_one(walkers, RootTrajectory(name="rests", times=times, positions=positions)).plan) <= 4


def test_footsteps_turn_and_shift_with_the_trajectory(walkers):
    given = TRUTHS["stop and go"]
    turned = planar.rotate(np.float64(2.2), given.positions[:, [0, 2]])
    moved = RootTrajectory(
        name=given.name, times=given.times + 7.0, positions=np.insert(turned + (5.0, -1.0), 1, 0.0, axis=1)
    )
    plan, other = (follow_one(walkers, trajectory).plan for trajectory in (given, moved))
    assert_allclose(other.strike_times, plan.strike_times + 7.0, atol=1e-6)
    expected = planar.rotate(np.float64(2.2), plan.positions[:, [0, 2]]) + (5.0, -1.0)
    assert_allclose(other.positions[:, [0, 2]], expected, atol=1e-6)


def test_agents_do_not_depend_on_each_other(walkers, followed):
    alone = follow_one(walkers, TRUTHS["circle"]).plan
    assert np.array_equal(alone.positions, followed["circle"].plan.positions)
    assert np.array_equal(alone.strike_times, followed["circle"].plan.strike_times)


def test_footsteps_lie_on_the_terrain(walkers):
    hill = terrain_of([slab((-5, 5), (-5, 0), (0.0, 0.0)), slab((-5, 5), (0, 10), (0.0, 1.5))])
    plan = follow_one(walkers, forward(1.1), terrain=hill).plan
    assert_allclose(plan.positions[:, 1], 0.15 * np.maximum(plan.positions[:, 2], 0.0), atol=1e-6)
    uphill = plan.positions[:, 2] > 0.01
    assert uphill.any() and (~uphill).any()
    normal = np.array([0.0, 1.0, -0.15]) / np.hypot(1.0, 0.15)
    assert_allclose(plan.normals[uphill], np.tile(normal, (uphill.sum(), 1)), atol=1e-6)
    assert_allclose(plan.normals[~uphill], np.tile([0.0, 1.0, 0.0], ((~uphill).sum(), 1)), atol=1e-6)


@pytest.mark.parametrize("speed", [0.8, 1.3, 2.4])
@pytest.mark.parametrize("downward", [False, True])
def test_flat_trajectories_go_over_stairs_with_whole_soles_on_the_treads(walkers, speed, downward):
    """A floor goes on below the stairs, which are higher than one step; who starts on top starts there."""
    edges = np.array([-60.0, -1.0, -0.7, -0.4, -0.1, 0.2, 60.0])
    heights = 0.15 * np.arange(6)[:: -1 if downward else 1]
    treads = [slab((-9, 9), tuple(edges[i : i + 2]), (heights[i],) * 2) for i in range(6)]
    terrain = terrain_of([slab((-60, 60), (-60, 60), (0.0, 0.0)), *treads])
    plan = follow_one(walkers, forward(speed), terrain=terrain).plan
    stands_on = heights[np.searchsorted(edges, plan.positions[:, 2]) - 1]
    assert_allclose(plan.positions[:, 1], stands_on, atol=1e-6)
    body = proportions_of(walkers.source.skeleton, walkers.source.biped)
    facing = planar.direction(plan.yaws)
    for ahead in (-body.heel - 0.019, body.toe + 0.019):
        ends = plan.positions[:, 2] + ahead * facing[:, 1]
        assert np.all(heights[np.searchsorted(edges, ends) - 1] - stands_on < 0.031)


def test_without_terrain_footsteps_lie_at_the_trajectorys_height(walkers):
    given = forward(1.1)
    stairs = RootTrajectory(name="up", times=given.times, positions=given.positions + (0.0, 4.0, 0.0))
    assert_allclose(follow_one(walkers, stairs).plan.positions[:, 1], 4.0)


def test_what_cannot_be_followed_is_said_and_the_others_go_on(walkers):
    car, walk, blink = forward(12.0, name="/Car"), forward(1.2), forward(1.2, name="/Blink", times=TIMES[:4])
    lost, found, short = follow(walkers, [car, walk, blink])
    assert isinstance(lost, PlanError) and "it goes 12 m/s" in str(lost) and str(lost).startswith("/Car: cannot be")
    assert isinstance(found, Following)
    assert isinstance(short, PlanError) and "/Blink: lasts 0.3 s, less than a step" in str(short)


def test_feet_do_not_cross_on_a_jittery_way(walkers):
    generator = np.random.default_rng(11)
    times = np.arange(0.0, 12.0, 0.4)
    way = np.stack([np.zeros_like(times), np.zeros_like(times), 1.1 * times], axis=1)
    given = way + generator.normal(scale=0.06, size=way.shape) * (1.0, 0.0, 1.0)
    plan = follow_one(walkers, RootTrajectory(name="wild", times=times, positions=given)).plan
    headings = plan.yaws[:-1] + 0.5 * planar.wrap_angle(np.diff(plan.yaws))
    across = planar.rotate(-headings, np.diff(plan.positions, axis=0)[:, [0, 2]])[:, 0]
    assert np.min(np.where(plan.sides[1:] == 0, across, -across)) > 0.0


def test_one_walk_stops_and_stands_as_well_as_it_can():
    library = prepare_library(library_of(WALKS[7:8]), EngineOptions())
    names = ("straight", "stop and go", "turn on the spot", "backward")
    found = dict(zip(names, follow(library, [TRUTHS[name] for name in names]), strict=True))
    assert found["straight"].distances.max() < 0.01
    waits = found["stop and go"].plan.liftoff_times[:-1] - found["stop and go"].plan.strike_times[1:]
    assert waits.max() > 1.0 and found["stop and go"].distances.mean() < 0.1
    assert len(found["turn on the spot"].plan) == 2
    assert isinstance(found["backward"], PlanError)  # it cannot, and does not go forward instead
    plans = [found[name].plan for name in names[:3]]
    scene = crowd(library.source, plans)
    for motion in animate_agents(library, scene.agents, scene, options=EngineOptions()):
        assert set(motion.results.status) <= {"ok", "outsideHull"} and motion.results.slide.max() < 1e-3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"smoothing_time": -1.0}, "smoothing_time: is -1 s. must be 0 to 3600 s"),
        ({"leave_distance": 0.0}, "leave_distance: is 0.0. must be above 0"),
        ({"hurry": 0.5}, "hurry: is 0.5. must be 1 or more"),
    ],
)
def test_options_out_of_range_are_named(changes, message):
    with pytest.raises(ValueError, match="must") as caught:
        FollowOptions(**changes)
    assert str(caught.value) == message
