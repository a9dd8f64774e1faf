"""Ways to goals by the batch: against Dijkstra over the whole grid, whatever else is asked for."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from tests.planning.terrains import storeys
from usdfoot.model.ground import Ground
from usdfoot.planning.routes import RouteFinder, look_along
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

CELL = 0.15


def finder_in(world: World) -> RouteFinder:
    return RouteFinder(world, step=0.35, headroom=1.8)


def lengths_on_a_grid(world: World, goal: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Of the ways from places (N, 2) that are centres of cells, over all cells of 20 by 20 m with the goal in one."""
    offsets = np.mgrid[-140:141, -140:141].reshape(2, -1).T
    cells = goal[[0, 2]] + CELL * offsets
    free = (clearances(world, cells) >= 2.0 * CELL - 1e-9).reshape(281, 281)
    numbers, rows, columns, lengths = np.arange(free.size).reshape(free.shape), [], [], []
    for x, z in ((0, 1), (1, 0), (1, 1), (1, -1)):
        one = numbers[: 281 - x, max(-z, 0) : 281 - max(z, 0)]
        other = numbers[x:, max(z, 0) : 281 + min(z, 0)]
        both = free.ravel()[one] & free.ravel()[other]
        rows, columns = [*rows, *one[both]], [*columns, *other[both]]
        lengths += [CELL * np.hypot(x, z)] * int(both.sum())
    links = coo_array((lengths, (rows, columns)), shape=(free.size, free.size))
    found = dijkstra(links.tocsr(), directed=False, indices=140 * 281 + 140)
    own = np.rint((places - goal[[0, 2]]) / CELL).astype(int) + 140
    return found[own[:, 0] * 281 + own[:, 1]]


def test_ways_are_as_long_as_by_dijkstra_and_lead_out_of_the_first_window(generator):
    """Around a wall that is longer than what is looked at first, and among boxes."""
    boxes = [box_outline(place, place + 0.7) for place in generator.uniform(-6.0, 6.0, size=(25, 2))]
    outlines = [box_outline((-8.0, 0.0), (8.0, 0.3)), *boxes]
    bounds = box_outline((-10.0, -10.0), (10.0, 10.0))
    world = World(bounds=bounds, obstacles=tuple(Obstacle(name="/Box", outline=outline) for outline in outlines))
    offsets = CELL * generator.integers(-50, 51, size=(40, 2))
    goal = np.array([0.31, 0.0, 1.27])
    starts = np.insert(goal[[0, 2]] + offsets, 1, 0.0, axis=1)
    starts = starts[clearances(world, starts[:, [0, 2]]) >= 2.0 * CELL]
    routes = finder_in(world).find(starts, np.tile(goal, (len(starts), 1)), radius=0.3)
    expected = lengths_on_a_grid(world, goal, starts[:, [0, 2]])
    assert np.isfinite(expected).sum() > 15 and (expected > 15.0).any()
    assert_allclose(look_along(routes, starts).lengths, expected, rtol=1e-6)


@pytest.mark.parametrize("levels", [False, True])
def test_what_is_seen_of_a_way_does_not_depend_on_what_else_is_asked_for(generator, levels):
    ground = Ground(storeys()) if levels else None
    trees = tuple(Obstacle(name="/Tree", outline=box_outline((x, 2.0), (x + 0.4, 2.4))) for x in (-3.0, -1.0, 3.0))
    world = World(ground=ground, obstacles=() if levels else trees)
    goals = np.tile([(2.0, 2.7, 3.0), (1.0, 0.0, 2.0)] if levels else [(1.1, 0.0, 4.0), (-3.0, 0.0, -4.0)], (6, 1))
    starts = np.insert(generator.uniform(0.5, 2.0, size=(12, 2)), 1, 0.0, axis=1)
    places = starts + [0.4, 0.0, -0.3]
    finder = finder_in(world)
    together = finder.extended(finder.find(starts, goals, radius=0.3), places)
    looks = look_along(together, places, ahead=8.0)
    assert (looks.led == 1).all()
    for row in range(len(starts)):
        alone = finder_in(world)
        routes = alone.extended(alone.find(starts[[row]], goals[[row]], radius=0.3), places[[row]])
        own = look_along(routes, places[[row]], ahead=8.0)
        assert own.lengths[0] == looks.lengths[row] and own.aims.tobytes() == looks.aims[row].tobytes()
