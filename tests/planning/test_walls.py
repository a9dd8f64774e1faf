"""Walls: no sole is left in a wall, and nobody is led through its corner."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("jupedsim")
import shapely

from tests.planning.test_feet_apart import crossing
from usdfoot.planning.bumps import find_bumps
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.walkable import Area
from usdfoot.planning.walls import Walls
from usdfoot.planning.world import Obstacle, box_outline

LOW, HIGH = np.array([-9.0, -9.0]), np.array([-0.1, -0.1])


def area(*, levels: int = 1) -> Area:
    free = shapely.box(-10.0, -10.0, 10.0, 10.0).difference(shapely.box(*LOW, *HIGH))
    return Area(levels=(free,) * levels, spots=None, heights=np.zeros((levels, 0)))


def round_the_corner() -> FootTable:
    """Long steps along x = 0 and then along z = 0, whose middle cuts the corner of the wall."""
    feet = crossing(0, people=1)
    along = 1.0 * (feet.numbers - 5.5)
    points = np.stack([np.where(along < 0.0, 0.06, -along), np.where(along < 0.0, along, 0.06)], axis=1)
    positions = np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])
    return replace(feet, positions=positions, yaws=np.where(along < 0.0, 0.0, -0.5 * np.pi))


def depths(feet: FootTable) -> tuple[float, float]:
    """How deep the deepest sole and the deepest body are in the wall [m]."""
    soles, bodies = find_bumps(feet, [Obstacle(name="wall", outline=box_outline(LOW, HIGH))])
    return float(soles.depths.max(initial=0.0)), float(bodies.depths.max(initial=0.0))


def test_bodies_and_soles_are_moved_out_of_the_wall() -> None:
    feet = round_the_corner()
    assert depths(feet)[1] > 0.02
    clear = Walls(area()).keep_feet_off(feet, np.arange(len(feet.owners)))
    assert depths(clear) == (0.0, 0.0)
    assert np.linalg.norm(clear.positions - feet.positions, axis=1).max() < 0.5


def test_only_feet_asked_for_and_those_beside_them_are_moved() -> None:
    feet = round_the_corner()
    clear = Walls(area()).keep_feet_off(feet, np.array([0]))
    assert np.array_equal(clear.positions, feet.positions)


def test_where_there_are_several_levels_feet_stay_where_they_are() -> None:
    feet = round_the_corner()
    clear = Walls(area(levels=2)).keep_feet_off(feet, np.arange(len(feet.owners)))
    assert np.array_equal(clear.positions, feet.positions)
