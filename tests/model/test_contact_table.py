"""Contacts on the ground: footsteps where they are meant, and feet that come down elsewhere on what carries them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.plans import slope, stairs, way
from usdfoot.model.contact_table import lay_contacts, lay_on_ground
from usdfoot.model.ground import Ground

FOOT = np.array([0.15, 0.15])
DOWN, UP = stairs(-0.2, 0.4), stairs(0.2, 0.4)


def laid(terrain, place):
    """Height at which the first foot of a level walk along +Z stands if it comes down at a place instead."""
    table = lay_contacts([way()])
    first, positions = int(np.argmax(table.steps == 0)), table.positions.copy()
    positions[first] = place
    moved = replace(table, positions=positions)
    found = lay_on_ground(moved, Ground(terrain), planned=table.positions, foot_lengths=FOOT)
    return found.positions[first, 1]


@pytest.mark.parametrize(
    ("terrain", "place", "height"),
    [
        (DOWN, (0.0, 0.0, 0.4), -0.2),  # heel and ball on the tread below
        (DOWN, (0.0, 0.0, 0.3), 0.0),  # the ball over the edge, the heel on the tread above
        (DOWN, (0.0, -0.2, 0.3), 0.0),
        (UP, (0.0, 0.0, 0.3), 0.2),  # the heel over the edge: it may stay in the air
        (slope(0.0, -0.6), (0.0, 0.0, 0.2), -0.12),  # a heel up the slope is on no other tread
        (slope(0.0, 0.6), (0.0, 0.0, 0.2), 0.12),
        (slope(0.0, -2.0), (0.0, 0.0, 0.1), 0.1),  # too steep to stand on: as high as the heel's ground
        (slope(0.0, 0.0, walkable=False), (0.0, 0.2, 0.2), 0.2),  # what does not carry is not stepped down to
        (slope(0.0, 0.0, walkable=False), (0.0, -0.2, 0.2), 0.0),  # but no foot is inside it
        (slope(0.0, 0.0), (0.0, 0.5, 0.2), 0.5),  # too far below
    ],
)
def test_a_foot_that_comes_down_elsewhere_stands_on_what_carries_it_and_never_in_the_ground(terrain, place, height):
    assert laid(terrain, place) == pytest.approx(height, abs=1e-9)


def test_footsteps_stand_where_they_are_meant():
    table = lay_contacts([way()])
    above = replace(table, positions=table.positions + [0.0, 0.04, 0.0])
    for walkable in (True, False):
        ground = Ground(slope(0.0, 0.0, walkable=walkable))
        found = lay_on_ground(above, ground, planned=above.positions, foot_lengths=FOOT)
        assert np.abs(found.positions[table.steps >= 0, 1]).max() < 1e-9
    far = replace(table, positions=table.positions + [0.0, 0.06, 0.0])
    found = lay_on_ground(far, ground, planned=far.positions, foot_lengths=FOOT)
    assert (found.positions[table.steps >= 0, 1] == 0.06).all()
