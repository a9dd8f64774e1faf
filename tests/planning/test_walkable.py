"""Points kept in rooms."""

import numpy as np
import shapely
from numpy.testing import assert_allclose, assert_array_equal

from usdfoot.planning.walkable import move_inside


def test_who_is_outside_a_room_is_moved_to_where_it_is_nearest_and_nobody_else_is():
    room = shapely.box(0.0, 0.0, 4.0, 3.0).difference(shapely.box(1.0, 1.0, 2.0, 2.0))  # with a pillar
    points = np.random.default_rng(0).uniform(-1.0, 5.0, (200, 2))
    within = shapely.intersects_xy(room, points[:, 0], points[:, 1])
    before = points.copy()
    moved = move_inside(room, points)
    assert within.any() and not within.all()
    assert_array_equal(points, before)
    assert_array_equal(moved[within], points[within])
    distances = shapely.distance(room, shapely.points(points))
    assert_allclose(np.linalg.norm(moved - points, axis=1), distances, atol=1e-12)
    assert shapely.distance(room, shapely.points(moved)).max() <= 1e-12


def test_without_a_room_nobody_is_moved():
    points = np.array([[1.0, 2.0]])
    assert_array_equal(move_inside(shapely.Polygon(), points), points)
