"""Crowds on ground with several levels (JuPedSim, extra `crowd`)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.planning.seekers import scenario
from tests.planning.terrains import bridge, slab, spiral, storeys, terrain_of
from usdfoot.model.ground import Ground
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.world import Obstacle, World, box_outline, clearances


def from_to(name: str, start, goal) -> Seeker:
    return Seeker(name=name, start=np.array(start, dtype=float), goals=np.array([goal], dtype=float))


LEVELS = {
    "bridge": (
        bridge(),
        [
            *(from_to(f"/Up_{i}", (i - 0.5, 0.0, -3.0), (i - 0.5, 2.0, 6.0)) for i in range(2)),
            *(from_to(f"/Under_{i}", (-6.0 - i, 0.0, 6.0), (6.0 - i, 0.0, 6.2)) for i in range(3)),
            from_to("/Down", (0.0, 2.0, 5.0), (0.0, 0.0, -5.0)),
        ],
    ),
    "stairs": (
        storeys(),
        [
            *(from_to(f"/Up_{i}", (6.0 + i, 0.0, -0.5), (7.0, 2.7, 5.0 - i)) for i in range(2)),
            *(from_to(f"/Down_{i}", (6.0 + i, 2.7, 5.0), (7.0, 0.0, 1.0 + i)) for i in range(2)),
        ],
    ),
    "spiral": (
        spiral(),
        [from_to("/Up", (0.4, 0.0, 1.4), (0.4, 4.32, 1.4)), from_to("/Down", (0.4, 4.32, 1.4), (0.4, 0.0, 1.4))],
    ),
}


@pytest.mark.parametrize("place", LEVELS)
def test_people_on_several_levels_get_to_that_of_their_goal(place):
    pytest.importorskip("jupedsim")
    terrain, people = LEVELS[place]
    plans, problems = plan_crowd(scenario(*people), terrain, options=CrowdOptions(duration=90.0))
    assert problems == ()
    for plan, one in zip(plans, people, strict=True):
        middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
        assert np.linalg.norm((middles[-1] - one.goals[0])[[0, 2]]) < 1.0
        assert_allclose(middles[[0, -1], 1], [one.start[1], one.goals[0, 1]], atol=0.1)
    faults = lint_plans(plans, Ground(terrain), bodies=[Proportions()] * len(plans))
    assert [fault for fault in faults if fault.kind != "obstructed"] == []


def test_nobody_is_pushed_by_those_above():
    """Under the bridge they go straight on, whoever stands on it."""
    pytest.importorskip("jupedsim")
    under = from_to("/Under", (-5.0, 0.0, 6.0), (5.0, 0.0, 6.0))
    above = [from_to(f"/On_{i}", (x, 2.0, 6.0), (x, 2.0, 6.0)) for i, x in enumerate((-0.5, 0.1, 0.7))]
    (plan, *_), problems = plan_crowd(scenario(under, *above), bridge())
    assert problems == () and np.abs(plan.positions[:, 2] - 6.0).max() < 0.25 and plan.positions[:, 1].max() == 0.0


def test_what_is_on_another_level_is_no_obstacle():
    pytest.importorskip("jupedsim")
    car = Obstacle(name="/Car", outline=box_outline((-3.0, 5.0), (3.0, 7.0)), heights=(0.0, 1.5))
    over = from_to("/Over", (0.0, 2.0, 4.5), (0.0, 2.0, 7.5))
    around = from_to("/Around", (-5.0, 0.0, 6.0), (5.0, 0.0, 6.0))
    (on_it, beside), problems = plan_crowd(scenario(over, around, obstacles=[car]), bridge())
    assert problems == () and np.abs(on_it.positions[:, 0]).max() < 0.5
    assert clearances(World(obstacles=(car,)), beside.positions[:, [0, 2]]).min() > 0.0


@pytest.mark.parametrize(
    ("heights", "said"),
    [
        ((3.0, 3.0), "cannot get to its goal (2.00, 2.00) m, height 3.00 m, from height 0.00 m. there is no way"),
        ((0.8, 0.8), "cannot get to its goal (2.00, 2.00) m, height 0.80 m, from height 0.00 m. there is no way"),
        ((0.0, 5.0), "has its goal (2.00, 2.00) m in an obstacle or off the walkable ground"),
    ],
    ids=["no stairs", "too high a step", "too steep"],
)
def test_ground_that_cannot_be_reached_on_foot_is_no_way_to_a_goal(heights, said):
    pytest.importorskip("jupedsim")
    terrain = terrain_of([slab((-8.0, 8.0), (-8.0, 8.0), (0.0, 0.0)), slab((0.0, 4.0), (0.0, 4.0), heights)])
    one = from_to("/One", (-5.0, 0.0, 0.0), (2.0, 0.5 * sum(heights), 2.0))
    plans, (problem,) = plan_crowd(scenario(one), terrain)
    assert plans == [] and f"/One: {said}" in problem.message
