"""Ways narrower than a body are none, whatever the shape of the walls beside them (extra `crowd`)."""

import numpy as np
import pytest

shapely = pytest.importorskip("shapely")
pytest.importorskip("jupedsim")
from usdfoot.planning.gaps import without_gaps  # noqa: E402
from usdfoot.planning.passages import find_passages  # noqa: E402

RADIUS = 0.25
ROOM = shapely.box(-8.0, -8.0, 8.0, 8.0)


def boxes(gap: float):
    """A room with two boxes whose corners are so far [m] apart, askew."""
    x, z = gap / np.sqrt(2.0), gap / np.sqrt(2.0)
    return ROOM.difference(shapely.box(-2.0, -2.0, 0.0, 0.0)).difference(shapely.box(x, z, 2.0, 2.0))


@pytest.mark.parametrize("gap", [0.05, 0.2, 0.4, 0.47])
def test_a_gap_between_two_corners_is_closed(gap):
    closed = without_gaps(boxes(gap), RADIUS)
    assert len(closed.interiors) == 1
    assert not shapely.intersects_xy(closed, 0.5 * gap / np.sqrt(2.0), 0.5 * gap / np.sqrt(2.0))
    assert closed.covers(boxes(gap).buffer(-RADIUS)), "bodies are where they were"


@pytest.mark.parametrize("gap", [0.52, 0.8])
def test_a_gap_that_a_body_gets_through_stays(gap):
    assert len(without_gaps(boxes(gap), RADIUS).interiors) == 2


def test_a_door_to_another_room_stays_as_one_polygon_has_to_hold_all_who_are_in_either():
    walls = shapely.union(shapely.box(-8.0, -0.05, -0.2, 0.05), shapely.box(0.2, -0.05, 8.0, 0.05))
    assert shapely.intersects_xy(without_gaps(ROOM.difference(walls), RADIUS), 0.0, 0.0)


def test_rooms_keep_their_corners():
    assert without_gaps(ROOM, RADIUS).equals(ROOM)


def test_a_passage_is_as_wide_as_the_largest_disc_that_gets_through_it():
    level = ROOM.difference(shapely.box(-1.0, -0.28, 0.0, 0.7)).difference(shapely.box(0.56, -1.0, 1.54, 0.0))
    passage = find_passages((level,), RADIUS)[0]
    assert passage.half_width == pytest.approx(0.28, abs=0.01)
