"""Paths that go round obstacles and ground nobody can walk on."""

import re
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from tests.engine.plans import no_terrain
from tests.planning.terrains import slab, terrain_of
from usdfoot.errors import PlanError
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.bypass import go_round
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.path import PathOptions, plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle, box_outline

ROOF = [slab((-1.0, 1.0), (-1.5, 0.0), (0.0, 2.4)), slab((-1.0, 1.0), (0.0, 1.5), (2.4, 0.0))]
"""58 degrees up and down again, 2 m wide."""


def ground(*, width: float) -> Ground:
    return Ground(terrain_of([slab((-width, width), (-6.0, 6.0), (0.0, 0.0)), *ROOF]))


def path(*points) -> WalkingPath:
    return WalkingPath(name="/Path", points=np.array(points, dtype=float))


STRAIGHT = path((0.2, 0.0, -5.0), (0.2, 0.0, 5.0))


def test_a_path_over_a_steep_roof_goes_round_it_if_asked_and_lints_clean():
    open_ground = ground(width=6.0)
    over = plan_path(STRAIGHT, open_ground, options=PathOptions(around=False))
    assert "steep" in {fault.kind for fault in lint_plans([over], open_ground, bodies=[Proportions()])}
    around = plan_path(STRAIGHT, open_ground, options=PathOptions(around=True))
    assert lint_plans([around], open_ground, bodies=[Proportions()]) == []
    led = go_round(STRAIGHT, open_ground, body=Proportions())
    corners = np.array([(0.2, -5.0), (1.0, -1.5), (1.0, 1.5), (0.2, 5.0)])
    shortest = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    assert shortest < led.length < shortest + 2.0, "it leaves the line only where it must"


def test_the_way_round_keeps_off_the_rims_and_rounds_its_corners_outside():
    led = go_round(STRAIGHT, ground(width=6.0), body=Proportions()).points[:, [0, 2]]
    past = np.maximum(np.abs(led) - (1.0, 1.5), 0.0)
    assert np.linalg.norm(past[np.abs(led[:, 1]) < 2.0], axis=1).min() > 0.3


@pytest.mark.parametrize("speed", [0.6, 1.3])
def test_no_foot_swings_through_the_corner_of_a_block_that_the_way_leads_round(speed):
    """A corridor of half a metre between the block and the end of the world."""
    ends, heights = (-0.52, -0.2, 0.1, 0.44), (0.6, 0.42, 0.22)
    block = [slab((-0.52, 0.64), pair, (top, top)) for pair, top in zip(pairwise(ends), heights, strict=True)]
    small = Ground(terrain_of([slab((-1.0, 1.0), (-1.0, 1.0), (0.0, 0.0)), *block]))
    over = WalkingPath(name="/Path", points=np.array([(0.04, 0.0, -0.88), (0.04, 0.0, 0.9)]), speed=speed)
    plan = plan_path(over, small, options=PathOptions(around=True))
    assert lint_plans([plan], small, bodies=[Proportions()]) == []
    swings = np.linspace(plan.positions[:-2], plan.positions[2:], 20)[..., [0, 2]].reshape(-1, 2)
    assert small.heights(swings, np.full(len(swings), 9.0)).heights.max() < 0.5


def test_a_path_on_good_ground_is_as_drawn():
    beside = path((3.0, 0.0, -5.0), (3.0, 0.0, 5.0))
    assert_array_equal(go_round(beside, ground(width=6.0), body=Proportions()).points, beside.points)


def test_a_path_across_dead_ends_does_not_turn_back_in_them():
    """A court walled by slopes on its line: one could walk in from this side, but not out on that one."""
    slopes = [slab((-3.0, 3.0), (1.5, 2.0), (0.0, 2.0)), slab((-3.0, 3.0), (2.0, 2.5), (2.0, 0.0))]
    sides = [np.array([(x, 0.0, -2.5), (x, 0.0, 2.5), (x + 0.4, 2.0, 2.5), (x + 0.4, 2.0, -2.5)]) for x in (-3.0, 2.6)]
    court = Ground(terrain_of([slab((-6.0, 6.0), (-6.0, 6.0), (0.0, 0.0)), *slopes, *sides]))
    led = go_round(STRAIGHT, court, body=Proportions())
    assert np.diff(led.points[:, 2]).min() > -0.01, "it leaves the line before the court"
    plan = plan_path(STRAIGHT, court, options=PathOptions(around=True))
    assert lint_plans([plan], court, bodies=[Proportions()]) == []


def test_a_path_that_crosses_itself_goes_round_on_its_loop_too():
    angles = np.linspace(-0.5 * np.pi, 3.5 * np.pi, 161)
    loops = np.stack([3.5 + 2.0 * np.cos(angles), 0.0 * angles, 2.0 * np.sin(angles)], axis=-1)
    eight = np.where(np.arange(161)[:, None] <= 80, loops, loops * (-1.0, 1.0, 1.0) + (3.0, 0.0, 0.0))
    led = go_round(path(*eight), ground(width=6.0), body=Proportions())
    assert led.length > 0.9 * path(*eight).length


def test_where_there_is_no_way_round_place_and_slope_are_named():
    with pytest.raises(PlanError, match=r"/Path: leads over ground of 58 degrees at \(0\.20, .* no way round"):
        go_round(STRAIGHT, ground(width=1.0), body=Proportions())
    with pytest.raises(PlanError, match=r"/Path: ends over ground of 58 degrees at \(0\.20, 1\.20, -0\.75\) m"):
        go_round(path((0.2, 0.0, -5.0), (0.2, 0.0, -0.75)), ground(width=6.0), body=Proportions())


def test_a_circle_that_is_all_too_steep_is_refused_as_such():
    angles = np.linspace(0.0, 2.0 * np.pi, 60)
    z = 0.3 * np.cos(angles) - 0.75
    circle = path(*np.stack([0.3 * np.sin(angles), 1.6 * (z + 1.5), z], axis=1))
    with pytest.raises(PlanError, match=r"58 degrees at \(0\.00, 1\.68, -0\.45\) m.*--no-around") as begins:
        go_round(circle, ground(width=1.0), body=Proportions())
    assert str(begins.value).startswith("/Path: begins over ground of 58 degrees")


def test_who_is_told_to_move_an_end_can_begin_and_end_there():
    roofs = [slab((-6.0, 6.0), (-1.5, 0.0), (0.0, 2.4)), slab((-6.0, 6.0), (0.0, 1.5), (2.4, 0.0))]
    ridge = Ground(terrain_of([slab((-6.0, 6.0), z, (0.0, 0.0)) for z in ((-6.0, -1.5), (1.5, 6.0))] + roofs))
    for points in (((0.2, 0.0, -5.0), (0.2, 1.2, -0.75)), ((-0.3, 1.76, 0.4), (0.2, 0.0, 5.0))):
        with pytest.raises(PlanError, match=r"too steep to stand: people do on 35\. move that end to \(") as told:
            go_round(path(*points), ridge, body=Proportions())
        place = re.search(r"move that end to \((\S+), (\S+), (\S+)\) m, or", str(told.value)).groups()
        moved = [*points]
        moved[-1 if " ends " in str(told.value) else 0] = tuple(map(float, place))
        assert lint_plans([plan_path(path(*moved), ridge)], ridge, bodies=[Proportions()]) == []


def test_a_wall_in_the_way_is_called_a_wall():
    rest = [slab((-6.0, 6.0), (-6.0, 0.0), (0.0, 0.0)), slab((-6.0, 6.0), (0.04, 6.0), (1.0, 1.0))]
    terrace = Ground(terrain_of([*rest, slab((-6.0, 6.0), (0.0, 0.04), (0.0, 1.0))]))
    with pytest.raises(PlanError, match=r"leads up a wall of 1\.00 m at \(0\.20, .* and there is no way round"):
        go_round(path((0.2, 0.0, -3.0), (0.2, 1.0, 3.0)), terrace, body=Proportions())


@pytest.mark.parametrize("offset", [0.0, 0.01, 0.02, 0.03])
def test_a_wall_that_slants_a_little_is_no_stair_and_stairs_that_do_are(offset):
    """Height maps have walls a sample wide, and a grid's cells may have their centres in them."""

    def faces(rise):
        top = [slab((-1.0, 1.0), (0.04, 1.0), (rise, rise)), slab((-1.0, 1.0), (1.0, 1.04), (rise, 0.0))]
        return Ground(
            terrain_of([slab((-6.0, 6.0), (-6.0, 6.0), (0.0, 0.0)), slab((-1.0, 1.0), (0.0, 0.04), (0.0, rise)), *top])
        )

    line = path((0.2, 0.0, -3.0 + offset), (0.2, 0.0, 3.0))
    led = go_round(line, faces(0.6), body=Proportions())
    assert np.abs(led.points[:, 0]).max() > 1.0
    assert lint_plans([plan_path(line, faces(0.6))], faces(0.6), bodies=[Proportions()]) == []
    assert_array_equal(go_round(line, faces(0.2), body=Proportions()).points, line.points)


def block(x, z) -> Obstacle:
    corners = box_outline(np.array([x[0], z[0]]), np.array([x[1], z[1]]))
    return Obstacle(name="/Block", outline=corners, heights=(0.0, 1.0))


def test_a_path_through_an_obstacle_goes_round_it_and_lint_names_it_where_the_path_is_kept_to():
    obstacles = [block((-1.0, 0.9), (-0.5, 0.5))]
    for terrain in (no_terrain(), terrain_of([slab((-6.0, 6.0), (-6.0, 6.0), (0.0, 0.0))])):
        flat = Ground(terrain)
        led = plan_path(STRAIGHT, flat, obstacles=obstacles)
        assert lint_plans([led], flat, bodies=[Proportions()], obstacles=obstacles) == []
        assert led.positions[:, 0].max() < 1.7, "by the nearer side, an elbow away"
        through = plan_path(STRAIGHT, flat, options=PathOptions(around=False), obstacles=obstacles)
        faults = lint_plans([through], flat, bodies=[Proportions()], obstacles=obstacles)
        assert {fault.kind for fault in faults} == {"obstacle"}
        assert all("the obstacle /Block" in fault.message for fault in faults)
        inside = np.abs(through.positions[:, 2]) < 0.5
        assert set(np.flatnonzero(inside)) <= {fault.footstep for fault in faults}


def test_a_path_between_obstacles_with_room_for_a_body_is_as_drawn():
    flat, sides = Ground(no_terrain()), [block((-2.0, -0.1), (-0.5, 0.5)), block((0.5, 2.0), (-0.5, 0.5))]
    between = plan_path(STRAIGHT, flat, obstacles=sides)
    assert_array_equal(between.positions, plan_path(STRAIGHT, flat).positions)
    overhead = Obstacle(name="/Bridge", outline=sides[0].outline + (0.5, 0.0), heights=(2.5, 3.0))
    corners = box_outline(np.array([-2.0, 0.35]), np.array([2.0, 0.42]))
    kerb = Obstacle(name="/Kerb", outline=corners, heights=(0.0, 0.1))
    over = plan_path(STRAIGHT, flat, obstacles=[overhead])
    assert_array_equal(over.positions, between.positions)
    stepped = lint_plans([between], flat, bodies=[Proportions()], obstacles=[kerb])
    assert not any("body" in fault.message for fault in stepped), "one steps over it"


def test_a_path_into_the_side_of_a_platform_goes_round_it_not_below_it():
    platform = slab((-1.0, 1.0), (-1.0, 1.0), (0.7, 0.7))
    floor = Ground(terrain_of([slab((-3.0, 3.0), (-6.0, 6.0), (0.0, 0.0)), platform]))
    below = plan_path(STRAIGHT, floor, options=PathOptions(around=False))
    faults = lint_plans([below], floor, bodies=[Proportions()])
    assert {fault.message for fault in faults} == {"has only 0.70 m of room above it"}
    assert {fault.footstep for fault in faults} == set(np.flatnonzero(np.abs(below.positions[:, 2]) < 1.0))
    assert lint_plans([plan_path(STRAIGHT, floor)], floor, bodies=[Proportions()]) == []


def test_a_path_up_a_wall_goes_round_by_the_stair_and_one_that_cannot_is_as_drawn_or_refused():
    wall = [slab((-1.0, 1.0), (-1.0, 1.0), (0.6, 0.6)), slab((-1.0, 1.0), (1.0, 1.5), (0.3, 0.3))]
    open_ground = Ground(terrain_of([slab((-3.0, 3.0), (-3.0, 3.0), (0.0, 0.0)), *wall]))
    over = path((0.0, 0.0, -2.5), (0.0, 0.0, 2.5))
    assert lint_plans([plan_path(over, open_ground)], open_ground, bodies=[Proportions()]) == []
    narrow = ground(width=1.0)
    kept = [plan_path(STRAIGHT, narrow, options=options).positions for options in (None, PathOptions(around=False))]
    assert_array_equal(*kept)
    with pytest.raises(PlanError, match="no way round"):
        plan_path(STRAIGHT, narrow, options=PathOptions(around=True))
