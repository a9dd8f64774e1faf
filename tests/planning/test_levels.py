"""Levels: spots of the ground as sheets, and where they join."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.sparse.csgraph import connected_components

from tests.planning.terrains import bridge, slab, spiral, storeys, terrain_of
from usdfoot.model.ground import Ground
from usdfoot.planning.levels import extend_level, split_levels
from usdfoot.planning.spots import Spots, build_spots

TERRAINS = {"bridge": bridge(), "stairs": storeys(), "spiral": spiral()}


def spots_of(terrain, *, cell: float = 0.1, **options) -> Spots:
    lowest, highest = terrain.points.min(axis=0)[[0, 2]], terrain.points.max(axis=0)[[0, 2]]
    shape = tuple(int(count) for count in np.rint((highest - lowest) / cell))
    return build_spots(Ground(terrain), lowest + 0.5 * cell, shape, cell=cell, headroom=1.8, **options)


@pytest.mark.parametrize("name", TERRAINS)
def test_a_level_is_in_one_piece_and_nowhere_above_itself(name):
    spots = spots_of(TERRAINS[name])
    levels = split_levels(spots)
    for level in np.unique(levels):
        own = levels == level
        for covered in (own, extend_level(spots, levels, level)):
            assert len(np.unique(spots.columns[covered])) == covered.sum()
        assert connected_components(spots.only(own).links, directed=False)[0] == 1


@pytest.mark.parametrize("name", TERRAINS)
def test_levels_that_join_have_an_apron_in_common(name):
    spots = spots_of(TERRAINS[name])
    levels = split_levels(spots)
    reach = {int(level): extend_level(spots, levels, level) for level in np.unique(levels)}
    links = spots.links.tocoo()
    pairs = np.unique(np.stack([levels[links.row], levels[links.col]], axis=1), axis=0)
    joined = [(a, b) for a, b in pairs.tolist() if a < b]
    assert joined, "there is something to join"
    for a, b in joined:
        assert (reach[a] & reach[b]).sum() * spots.cell**2 > 0.5, "room for a body or two"


def test_there_is_ground_below_a_bridge_only_where_heads_pass():
    spots = spots_of(bridge())
    middle = np.abs(spots.points[:, 0]) < 0.9
    below = middle & (spots.heights == 0.0) & (spots.points[:, 1] > 0.0) & (spots.points[:, 1] < 12.0)
    assert_allclose([spots.points[below, 1].min(), spots.points[below, 1].max()], [3.6, 8.4], atol=0.06)


def test_stairs_with_slanting_risers_are_walked_on_and_slopes_as_steep_are_not():
    riser, tread = 0.04, 0.28
    stairs = [slab((0.0, 1.0), (i * 0.32, i * 0.32 + tread), (0.2 * i,) * 2) for i in range(4)]
    stairs += [slab((0.0, 1.0), (i * 0.32 + tread, (i + 1) * 0.32), (0.2 * i, 0.2 * i + 0.2)) for i in range(3)]
    flight = spots_of(terrain_of(stairs))
    assert connected_components(flight.links, directed=False)[0] == 1
    assert_allclose(flight.heights.max(), 0.6, atol=1e-6)
    steep = 0.2 / riser * 0.2
    hill = terrain_of([slab((0.0, 1.0), (0.0, 1.0), (0.0, steep)), slab((0.0, 1.0), (1.0, 2.0), (steep, steep))])
    assert spots_of(hill).heights.min() > 0.8 * steep


def test_who_stands_at_a_place_stands_on_the_level_near_it():
    spots = spots_of(bridge())
    found = spots.at(np.array([(0.0, 6.0), (0.0, 6.0), (0.0, 6.0)]), np.array([0.1, 1.9, 1.0]), within=0.3)
    assert_allclose(spots.heights[found[:2]], [0.0, 2.0], atol=1e-9)
    assert found[2] == -1
