"""Plans from trajectories: they keep to them, and to each other's distance."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.planning.terrains import bridge, slab, terrain_of
from usdfoot.errors import PlanError
from usdfoot.importers.pedestrians import import_pedestrians
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.model.terrain import no_terrain
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.foot_table import feet_of
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.presences import INSTANT
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.trajectories import TrajectoryOptions, plan_trajectories

LEVEL = Ground(terrain_of([slab((-60.0, 60.0), (-60.0, 60.0), (0.0, 0.0))]))


def line(start, velocity, *, duration=8.0, begin=0.0, name="/Line", spacing=0.4):
    times = np.arange(0.0, duration + 1e-9, spacing)
    return RootTrajectory(
        name=name, times=begin + times, positions=np.array(start) + times[:, None] * np.array(velocity)
    )


def roots(plan, times):
    """Middle of consecutive footsteps, at the strike of the later one, straight between."""
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    return np.stack([np.interp(times, plan.strike_times[1:], middles[:, i]) for i in range(3)], axis=1)


@pytest.mark.parametrize("speed", [0.4, 0.9, 1.4, 1.9, 3.0])
def test_a_steady_walk_is_kept_to_a_centimetre(speed):
    velocity = speed * np.array([np.sin(0.7), 0.0, np.cos(0.7)])
    path = line((1.0, 0.0, -2.0), velocity, begin=2.0)
    (plan,) = plan_trajectories([path], LEVEL)
    times = np.linspace(3.0, 8.5, 50)
    across = planar.rotate(np.float64(-0.7), (roots(plan, times) - path.positions[0])[:, [0, 2]])
    assert_allclose(across[:, 0], 0.0, atol=0.01)
    assert_allclose(across[:, 1], speed * (times - 2.0), atol=0.03)
    assert not plan.starts_standing and not plan.ends_standing
    flight = plan.liftoff_times[2:-2] < plan.strike_times[3:-1]
    assert flight.all() == (speed > 2.1)


def test_who_runs_and_brakes_to_a_walk_flies_as_long_as_it_runs():
    """In the last step of the run the body goes as fast as in the one before it, whatever follows."""
    speeds = np.concatenate([np.full(30, 3.4), np.linspace(3.4, 0.8, 6), np.full(40, 0.8)])
    places = np.concatenate([[0.0], np.cumsum(0.1 * speeds)])
    positions = np.stack([np.zeros_like(places), np.zeros_like(places), places], axis=1)
    brakes = RootTrajectory(name="/Brakes", times=0.1 * np.arange(len(places)), positions=positions)
    for smoothing in (0.05, 0.1, 0.3):
        (plan,) = plan_trajectories([brakes], LEVEL, options=TrajectoryOptions(smoothing_time=smoothing))
        assert lint_plans([plan], LEVEL, bodies=[Proportions()]) == []
        steps = np.diff(plan.positions[:, 2]) / np.diff(plan.strike_times)
        assert ((plan.liftoff_times[:-1] < plan.strike_times[1:]) | (steps < 2.2)).all()


def test_who_stands_does_not_step_and_who_stops_stands_side_by_side():
    still = RootTrajectory(
        name="/Still", times=np.array([0.0, 9.0]), positions=np.array([(0.0, 0.0, 0.0)] * 2), rest_yaw=0.3
    )
    walk = line((5.0, 0.0, 0.0), (0.0, 0.0, 1.2), duration=4.0)
    stop = RootTrajectory(
        name="/Stop",
        times=np.append(walk.times, walk.times[-1] + np.array([1.0, 5.0])),
        positions=np.concatenate([walk.positions, walk.positions[-1:], walk.positions[-1:]]),
    )
    standing, stopping = plan_trajectories([still, stop], LEVEL)
    assert len(standing) == 2 and standing.starts_standing and standing.ends_standing
    assert_allclose(standing.yaws, [0.4, 0.2], atol=0.01)  # toes out
    assert stopping.ends_standing
    apart = stopping.positions[-1] - stopping.positions[-2]
    assert abs(apart[2]) < 0.03 and abs(apart[0]) == pytest.approx(Proportions().step_width, rel=0.2)


def test_people_crowded_into_centimetres_who_burst_apart_have_plans(shared_data, monkeypatch):
    """As from a file whose unit is given wrong: standing feet left before they stood, which refused everybody."""
    for module in ("presences", "near_feet", "feet_apart"):  # all feet are near all others
        monkeypatch.setattr(f"usdfoot.planning.{module}.INSTANT", 6.0 * INSTANT)
    people, _ = import_pedestrians(shared_data / "people/crowds_zara01.txt", unit="0.001", rate=25.0)
    plans = plan_trajectories(people, LEVEL)
    assert len(plans) == len(people)


def test_plans_do_not_depend_on_how_many_curves_are_made_at_once(monkeypatch):
    paths = [line((index, 0.0, 0.4 * index), (0.3 - 0.1 * index, 0.0, 1.0), name=f"/Line{index}") for index in range(5)]
    whole = plan_trajectories(paths, LEVEL)
    monkeypatch.setattr("usdfoot.planning.root_curves.BATCH", 1)
    monkeypatch.setattr("usdfoot.planning.root_curves.KEPT", 1)
    for plan, other in zip(plan_trajectories(paths, LEVEL), whole, strict=True):
        assert plan.name == other.name and plan.sides.tolist() == other.sides.tolist()
        assert_allclose(plan.positions, other.positions, atol=1e-9)
        assert_allclose(plan.strike_times, other.strike_times, atol=1e-9)


def test_levels_are_followed():
    over = line((0.0, 0.0, -2.0), (0.0, 0.0, 1.2), duration=13.0, name="/Over")
    under = line((-6.0, 0.0, 6.0), (1.2, 0.0, 0.0), duration=10.0, name="/Under")
    up, flat = plan_trajectories([over, under], Ground(bridge()))
    assert up.positions[:, 1].max() == pytest.approx(2.0)
    assert_allclose(flat.positions[:, 1], 0.0, atol=1e-6)


@pytest.mark.parametrize("slant", [0.0, 0.15, 0.3])
def test_on_stairs_soles_keep_off_the_edges_of_treads(slant):
    """Nobody's track says where the treads are; corners of soles that go up at a slant come down in edges first."""
    treads = [slab((-3.0, 3.0), (0.34 * i, 0.34 * (i + 1)), (0.16 * i, 0.16 * i)) for i in range(1, 8)]
    stairs = Ground(
        terrain_of([slab((-3.0, 3.0), (-4.0, 0.34), (0.0, 0.0)), *treads, slab((-3.0, 3.0), (2.72, 7.0), (1.12, 1.12))])
    )
    walks = [line((x, 0.0, -3.0), (0.7 * slant, 0.0, 0.7), duration=12.0, name=f"/{x:g}") for x in (-2.0, -0.9)]
    plans = plan_trajectories(walks, stairs)
    assert min(plan.positions[-1, 1] for plan in plans) == pytest.approx(1.12)
    faults = lint_plans(plans, stairs, bodies=[Proportions()] * 2)
    assert [fault for fault in faults if fault.kind == "obstructed"] == []


def test_people_who_walk_into_each_other_are_kept_apart():
    pairs = [
        line((0.0, 0.0, -5.0), (0.0, 0.0, 1.2), name="/A"),
        line((0.03, 0.0, 5.0), (0.0, 0.0, -1.2), name="/B"),
        line((0.15, 0.0, -5.3), (0.0, 0.0, 1.2), name="/C"),
        RootTrajectory(name="/D", times=np.array([0.0, 8.0]), positions=np.array([(0.0, 0.0, 2.0)] * 2)),
    ]
    bodies = [Proportions()] * len(pairs)
    for apart, count in ((False, True), (True, False)):
        plans = plan_trajectories(pairs, LEVEL, options=TrajectoryOptions(apart=apart))
        assert bool(len(find_collisions(feet_of(plans, bodies)).depths)) == count


def test_nobody_collides_on_different_levels():
    both = [line((0.0, height, 4.2), (0.0, 0.0, 0.9), duration=3.0, name=f"/{height}") for height in (0.0, 2.0)]
    plans = plan_trajectories(both, Ground(bridge()), options=TrajectoryOptions(apart=False))
    assert plans[1].positions[0, 1] == pytest.approx(2.0)
    assert not len(find_collisions(feet_of(plans, [Proportions()] * 2)).depths)


def test_a_square_full_of_students_walks_without_stepping_on_feet(shared_data, monkeypatch):
    """Nor between the instants at which feet are compared."""
    everyone, _ = import_pedestrians(shared_data / "people" / "students001.txt", unit="m", rate=25.0)
    plans = plan_trajectories(everyone, LEVEL)
    assert len(plans) == 415
    for module in ("presences", "near_feet"):
        monkeypatch.setattr(f"usdfoot.planning.{module}.INSTANT", 0.5 * INSTANT)
    assert not len(find_collisions(feet_of(plans, [Proportions()] * len(plans))).depths)


def test_someone_who_goes_on_for_millions_of_seconds_is_named_before_any_memory_is_taken():
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    people = [
        RootTrajectory(name=name, times=np.array([0.0, end]), positions=places)
        for name, end in (("a", 9.0), ("b", 5e6))
    ]
    with pytest.raises(PlanError, match=r"^b: goes on from 0 to 5e\+06 s.*each may take 666667 s"):
        plan_trajectories(people, Ground(no_terrain(), fallback_height=0.0))


@pytest.mark.parametrize(("speed", "is_still"), [(0.2, True), (1.2, False)])
def test_who_hardly_moves_where_the_track_begins_and_ends_stands_there(speed, is_still):
    (plan,) = plan_trajectories([line((0.0, 0.0, 0.0), (0.0, 0.0, speed))], LEVEL)
    assert plan.starts_standing == plan.ends_standing == is_still


@pytest.mark.parametrize("speed", [0.3, 0.6])
def test_who_goes_sideways_takes_short_steps(speed):
    times = np.linspace(0.0, 8.0, 241)
    positions = np.stack([speed * times, np.zeros(241), np.zeros(241)], axis=1)
    trajectory = RootTrajectory(name="/T", times=times, positions=positions, yaws=np.zeros(241))
    (plan,) = plan_trajectories([trajectory], LEVEL)
    aside = np.abs(np.diff(plan.positions[:, 0]))
    assert aside.max() < 0.8
    assert np.abs(roots(plan, plan.strike_times[1:])[:, 0] - speed * plan.strike_times[1:]).max() < 0.2


@pytest.mark.parametrize("speed", [0.02, 0.05, 0.1, 0.14])
def test_who_creeps_shuffles_after_it_instead_of_leaping_in_the_end(speed):
    """In a jam people are carried a metre or two at less than one would call walking."""
    times = np.linspace(0.0, 24.0, 241)
    places = np.cumsum(np.where((times > 4.0) & (times < 19.0), speed, 1.2) * 0.1)
    track = RootTrajectory(name="/Creeps", times=times, positions=np.stack([0 * times, 0 * times, places], axis=1))
    (plan,) = plan_trajectories([track], LEVEL)
    creeping = np.arange(5.0, 18.0, 0.1)
    assert np.abs(roots(plan, creeping)[:, 2] - np.interp(creeping, times, places)).max() < 0.2
    steps = np.flatnonzero((plan.strike_times > 6.0) & (plan.strike_times < 18.0))
    assert len(steps) <= 2.0 * 12.0 * speed / 0.12 + 2
    assert not lint_plans([plan], LEVEL, bodies=[Proportions()])
    assert np.all(plan.liftoff_times[:-2] < plan.strike_times[2:] - 0.2)  # swings take time


def test_who_turns_slowly_on_the_spot_steps_round():
    times = np.linspace(0.0, 60.0, 601)
    track = RootTrajectory(
        name="/Turns", times=times, positions=np.zeros((601, 3)), yaws=np.radians(2.5) * times, rest_yaw=0.0
    )
    (plan,) = plan_trajectories([track], LEVEL)
    mean = np.unwrap(planar.midway_yaw(plan.yaws[1:], plan.yaws[:-1]))
    turned = np.interp(times, plan.strike_times[1:], mean)
    assert np.abs(turned - track.yaws).max() < np.radians(40.0)
    assert 8 <= len(plan) <= 16


def test_who_is_jostled_stands():
    times = np.linspace(0.0, 20.0, 201)
    sways = 0.05 * np.sin(2.0 * np.pi * times / 1.2)  # up to 0.26 m/s
    track = RootTrajectory(
        name="/Sways",
        times=times,
        positions=np.stack([0 * times, 0 * times, sways], axis=1),
        yaws=np.zeros(201),
    )
    (plan,) = plan_trajectories([track], LEVEL, options=TrajectoryOptions(smoothing_time=0.0))
    assert len(plan) <= 4
