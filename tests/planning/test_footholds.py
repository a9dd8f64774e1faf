"""Footholds against asking the ground place by place."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.planning.terrains import slab, terrain_of
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.model.terrain import Terrain
from usdfoot.planning.footholds import ASIDE, BAD, EDGE, HANGING, HANGS, MARGIN, POKES, STEEPEST, find_footholds
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.path import plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.ways import lay_ways

BODIES = [Proportions(), Proportions(leg_length=0.5, foot_length=0.08, heel=0.1, hip_width=0.12)]


def steps_and_a_hole():
    lowest = slab((-3.0, 3.0), (-3.0, -0.2), (0.0, 0.0))
    return [lowest, slab((-3.0, 3.0), (-0.2, 0.5), (0.12, 0.4)), slab((-3.0, 0.6), (0.6, 3.0), (0.45, 0.45))]


def cost_of(ground, body, place, yaw, near):
    """As the docstrings of planning/footholds.py say, one question at a time."""

    def ask(x, z, height):
        found = ground.heights(np.array([(x, z)]), np.array([height]))
        return found.hit[0], found.heights[0], found.normals[0], found.walkable[0]

    _, height, normal, walkable = ask(*place, near)
    if not walkable or normal[1] < np.cos(STEEPEST):
        return BAD, height
    margin, cost = MARGIN * body.foot_length, 0.0
    ends = [(0.0, -body.heel - margin), (0.0, body.toe + margin)]
    corners = [(side * body.half_width, ahead) for side in (-1, 1) for ahead in (-body.heel, body.toe)]
    for across, ahead in ends + corners:
        x = across * np.cos(yaw) + ahead * np.sin(yaw)
        z = ahead * np.cos(yaw) - across * np.sin(yaw)
        hit, level, *_ = ask(place[0] + x, place[1] + z, height)
        above = level - (height - (normal[0] * x + normal[2] * z) / normal[1])
        if hit and above > (EDGE if across else POKES):
            return BAD, height
        if not across and (not hit or above < -HANGS):
            cost += HANGING
    return cost, height


@pytest.mark.parametrize("pick", [None, 3])
def test_footholds_are_what_the_ground_says_place_by_place(pick):
    ground = Ground(terrain_of(steps_and_a_hole()))
    lines = [[(-1.0, 0.0, -2.5), (0.4, 0.4, 2.9)], [(0.3, 0.0, -2.0), (1.0, 0.4, 2.0)]]
    paths = [WalkingPath(name=f"/P{i}", points=np.array(line)) for i, line in enumerate(lines)]
    gaits = [derive_gait(body) for body in BODIES]
    ways = lay_ways(paths, gaits, ground)
    samples = np.arange(0, len(ways.arcs), pick or 1)
    found = find_footholds(ways, gaits, BODIES, ground=ground, samples=samples if pick else None)
    for row, sample in enumerate(samples):
        way = ways.rows[sample]
        for side, outward in ((0, 1.0), (1, -1.0)):
            heading, usual, width = ways.headings[sample], gaits[way].step_width, found.widths[row, side]
            across = 0.5 * outward * np.array([np.cos(heading), -np.sin(heading)])
            yaw = heading + outward * gaits[way].toe_out
            cost, height = cost_of(ground, BODIES[way], ways.points[sample] + width * across, yaw, ways.heights[sample])
            cost += ASIDE * 0.5 * abs(width - usual)
            assert_allclose((found.costs[row, side], found.heights[row, side]), (cost, height), atol=1e-9)
            if width != pytest.approx(usual):
                place = ways.points[sample] + usual * across
                assert cost_of(ground, BODIES[way], place, yaw, ways.heights[sample])[0] == BAD > cost
    assert {0.0, HANGING, BAD} <= set(found.costs.ravel())
    assert len(np.unique(found.widths.round(9))) > 2


@pytest.mark.parametrize("speed", [0.6, 1.1])
@pytest.mark.parametrize("offset", np.linspace(-0.12, 0.12, 9))
def test_along_the_edge_of_a_tread_feet_stand_beside_it(offset, speed):
    treads = [slab((-2.0, 2.0), (-1.5, 0.0), (0.0, 0.0)), slab((-2.0, 2.0), (0.0, 1.5), (0.15, 0.15))]
    ground = Ground(terrain_of(treads))
    points = np.array([(-1.5, 0.15 * (offset > 0.0), offset), (1.5, 0.15 * (offset > 0.0), offset)])
    plan = plan_path(WalkingPath(name="/Along", points=points, speed=speed), ground)
    assert lint_plans([plan], ground, bodies=[Proportions()]) == []
    assert len(plan) > 5


def test_without_terrain_every_place_is_firm():
    path = WalkingPath(name="/P", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 3.0)]))
    empty = np.zeros((0, 3))
    nothing = Terrain(
        meshes=(), points=empty, triangles=empty.astype(int), mesh_indices=np.zeros(0, int), walkable=np.zeros(0, bool)
    )
    ground, gaits = Ground(nothing, fallback_height=0.7), [derive_gait()]
    found = find_footholds(lay_ways([path], gaits, ground), gaits, BODIES[:1], ground=ground)
    assert found.firm.all()
    assert np.all(found.heights == 0.7)
