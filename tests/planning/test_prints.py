"""Prints on the ground: slopes, and levels that are followed."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.planning.terrains import bridge, slab, spiral, terrain_of
from usdfoot.maths import planar, quaternion
from usdfoot.model.ground import Ground
from usdfoot.planning.prints import lay_prints


def one_by_one(ground, points, near, step_up=0.5):
    """The rule of `Ground.follow` as a walker would apply it, for one way."""
    heights, level = [], near[0]
    for i, point in enumerate(points):
        sample = ground.heights(point[None], np.array([level]), step_up=step_up)
        heights.append(sample.heights[0])
        if sample.hit[0] and (i == 0 or abs(heights[-1] - level) <= step_up):
            level = heights[-1]
    return np.array(heights)


def test_a_way_goes_over_the_bridge_or_under_it():
    ground = Ground(bridge())
    z = np.arange(-1.0, 13.0, 0.1)
    along = np.stack([np.zeros_like(z), z], axis=-1)
    over = ground.follow(along, np.zeros(len(z)), first=np.array([0, len(z)]))
    assert_allclose(over.heights, np.interp(z, [0, 4, 8, 12], [0, 2, 2, 0]), atol=1e-6)
    x = np.arange(-5.0, 5.0, 0.1)
    across = np.stack([x, np.full_like(x, 6.0)], axis=-1)
    under = ground.follow(across, np.zeros(len(x)), first=np.array([0, len(x)]))
    assert_allclose(under.heights, 0.0, atol=1e-9)


@pytest.mark.parametrize("drawn", ["flat", "helix"])
def test_a_spiral_stair_is_climbed_turn_after_turn(drawn):
    ground = Ground(spiral())
    angles = np.arange(0.02, 2.4 * 2.0 * np.pi, 0.05)
    truth = 0.18 * np.floor(angles / (2.0 * np.pi / 12))
    points = 1.5 * planar.direction(angles)
    near = np.zeros(len(angles)) if drawn == "flat" else truth
    sample = ground.follow(points, near, first=np.array([0, len(angles)]))
    assert_allclose(sample.heights, truth, atol=1e-6)


def test_many_ways_at_once_are_what_each_is_alone(generator):
    ground = Ground(spiral())
    angles = np.arange(0.02, 12.0, 0.11)
    ways = [radius * planar.direction(angles) for radius in (1.0, 1.4, 2.0)]
    near = [np.full(len(angles), height) for height in (0.0, 2.2, 10.0)]
    first = len(angles) * np.arange(4)
    together = ground.follow(np.concatenate(ways), np.concatenate(near), first=first).heights
    alone = [one_by_one(ground, way, level) for way, level in zip(ways, near, strict=True)]
    assert_allclose(together, np.concatenate(alone))


def test_behind_a_gap_the_old_level_goes_on():
    floor = slab((-1.0, 1.0), (-9.0, 9.0), (0.0, 0.0))
    banks = [slab((-1.0, 1.0), (-9.0, 0.0), (2.0, 2.0)), slab((-1.0, 1.0), (0.4, 9.0), (2.0, 2.0))]
    ground = Ground(terrain_of([floor, *banks]))
    z = np.arange(-1.0, 2.0, 0.05)
    points = np.stack([np.zeros_like(z), z], axis=-1)
    heights = ground.follow(points, np.full(len(z), 2.0), first=np.array([0, len(z)])).heights
    assert_allclose(heights[(z < -0.01) | (z > 0.41)], 2.0)
    assert_allclose(heights[(z > 0.01) & (z < 0.39)], 0.0)


def test_prints_take_on_height_and_slope_and_keep_their_direction(generator):
    ground = Ground(terrain_of([slab((-9.0, 9.0), (-9.0, 9.0), (0.0, 4.0))]))
    yaws = generator.uniform(-np.pi, np.pi, 20)
    points = generator.uniform(-8.0, 8.0, (20, 2))
    prints = lay_prints(ground, points, yaws, near=np.zeros(20), step_up=9.0)
    slope = 4.0 / 18.0
    assert_allclose(prints.positions[:, 1], (points[:, 1] + 9.0) * slope, atol=1e-6)
    up = quaternion.rotate(prints.orientations, np.array([0.0, 1.0, 0.0]))
    assert_allclose(up, np.tile(np.array([0.0, 1.0, -slope]) / np.hypot(1.0, slope), (20, 1)), atol=1e-6)
    forward = quaternion.rotate(prints.orientations, np.array([0.0, 0.0, 1.0]))
    assert_allclose(planar.wrap_angle(planar.yaw_of(forward[:, [0, 2]]) - yaws), 0.0, atol=1e-9)
