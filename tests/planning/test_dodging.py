"""Dodging: crowds wait for what crosses their way, get out of its way and go round what stays."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("jupedsim")

from tests.planning.seekers import seeker
from tests.planning.terrains import slab, terrain_of
from usdfoot.model.ground import Ground
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.facing import LEAD
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.moving import Moving
from usdfoot.planning.scenario import Scenario
from usdfoot.planning.world import Obstacle, box_outline

PLAIN = terrain_of([slab((-12.0, 12.0), (-12.0, 12.0), (0.0, 0.0))])
CORRIDOR = (
    Obstacle(name="/Left", outline=box_outline(np.array([-12.0, -12.0]), np.array([-2.0, 12.0]))),
    Obstacle(name="/Right", outline=box_outline(np.array([2.0, -12.0]), np.array([12.0, 12.0]))),
)
DOORWAY = (
    Obstacle(name="/Left", outline=box_outline(np.array([-12.0, -0.1]), np.array([-0.9, 0.1]))),
    Obstacle(name="/Right", outline=box_outline(np.array([0.9, -0.1]), np.array([12.0, 0.1]))),
)


def box(name: str, middle, half) -> list[Obstacle]:
    outline = box_outline(np.subtract(middle, half), np.add(middle, half))
    return [Obstacle(name=name, outline=outline, heights=(0.0, 1.5))]


def sliding(time: float) -> list[Obstacle]:
    """A door that is open for three seconds out of ten."""
    opened = float(np.clip(min(time % 10.0, 5.0 - time % 10.0), 0.0, 1.0))
    return box("/Door", (1.9 * opened, 0.0), (0.95, 0.06))


def beam(time: float) -> list[Obstacle]:
    """A beam that turns about its middle."""
    along = 2.5 * np.array([np.sin(0.6 * time), np.cos(0.6 * time)])
    across = 0.04 * np.array([along[1], -along[0]])
    corners = np.array([-along - across, -along + across, along + across, along - across])
    return [Obstacle(name="/Beam", outline=corners, heights=(0.0, 1.5))]


MOVING = {
    "crossing": Moving(at=lambda time: box("/Cart", (-9.0 + time, 0.0), (0.8, 0.5)), end=20.0),
    "head on": Moving(at=lambda time: box("/Cart", (0.0, 10.0 - time), (0.4, 0.6)), end=22.0),
    "parking": Moving(at=lambda time: box("/Cart", (min(-8.0 + 1.5 * time, 0.0), 0.0), (1.2, 0.6)), end=6.0),
    "door": Moving(at=sliding, end=60.0),
    "beam": Moving(at=beam, end=60.0),
}
WALLS = {"head on": CORRIDOR, "door": DOORWAY}


def people() -> list:
    """Three who go one way and three who go the other."""
    there = [seeker(f"/There{i}", (0.9 * i - 0.9, -7.0), (0.9 * i - 0.9, 7.0), height=0.0) for i in range(3)]
    back = [seeker(f"/Back{i}", (0.9 * i - 0.9, 7.5), (0.9 * i - 0.9, -7.5), height=0.0) for i in range(3)]
    return there + back


def planned(walkers, walls=(), moving: Moving | None = None):
    """Plans and problems of a crowd."""
    task = Scenario(seekers=tuple(walkers), obstacles=tuple(walls), bounds=None, moving=moving)
    return plan_crowd(task, PLAIN, options=CrowdOptions(duration=90.0))


def met(plans, walkers, moving: Moving) -> list[str]:
    """What of the plans an obstacle meets."""
    bodies = [walker.body for walker in walkers]
    faults = lint_plans(plans, Ground(PLAIN), bodies=bodies, moving=moving.at)
    return [fault.message for fault in faults if fault.kind == "obstacle"]


@pytest.mark.parametrize("name", MOVING)
def test_nobody_is_met_and_everybody_arrives(name):
    walkers, moving = people(), MOVING[name]
    plans, problems = planned(walkers, WALLS.get(name, ()), moving)
    assert problems == () and len(plans) == len(walkers)
    assert met(plans, walkers, moving) == []


def test_who_does_not_see_it_come_is_met():
    walkers = people()
    assert met(planned(walkers, DOORWAY)[0], walkers, MOVING["door"])


def test_who_stands_in_its_way_gets_out_of_it_and_comes_back():
    walkers = [seeker("/Stands", (0.0, 0.0), (0.0, 0.5), height=0.0)]
    moving = Moving(at=lambda time: box("/Cart", (time - 14.0, 0.2), (0.5, 0.8)), end=28.0)
    (plan,), problems = planned(walkers, moving=moving)
    assert problems == () and met([plan], walkers, moving) == []
    assert np.abs(plan.positions[:, 2]).max() > 1.0
    assert np.linalg.norm(plan.positions[-2:, [0, 2]].mean(axis=0) - (0.0, 0.5)) < 0.4


def test_a_door_that_opens_late_is_waited_for():
    walkers = people()[:2]
    moving = Moving(at=lambda time: sliding(min(max(time - 40.0, 0.0), 2.0)), end=42.0)
    plans, problems = planned(walkers, DOORWAY, moving)
    assert problems == () and met(plans, walkers, moving) == []
    for plan in plans:
        assert plan.strike_times[np.argmax(plan.positions[:, 2] > 0.0)] > 40.0


def test_what_moves_elsewhere_changes_nothing():
    walkers = people()
    far = Moving(at=lambda time: box("/Cart", (11.0, 11.0 - 0.1 * time), (0.3, 0.3)), end=20.0)
    without, _ = planned(walkers)
    beside, _ = planned(walkers, moving=far)
    for one, other in zip(without, beside, strict=True):
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.strike_times, other.strike_times)


def test_lint_sees_a_door_close_on_a_foot_that_stands():
    walkers = [seeker("/Stands", (0.0, 0.0), (0.0, 4.0), height=0.0)]
    plans, _ = planned(walkers)
    last = plans[0].strike_times[-1]
    closing = Moving(at=lambda time: box("/Door", (2.0 if time < last + 0.5 else 0.0, 4.0), (0.9, 0.3)), end=90.0)
    assert met(plans, walkers, closing)
    assert not met([replace(plans[0], liftoff_times=np.minimum(plans[0].liftoff_times, last + 0.4))], walkers, closing)
    assert last > LEAD


def test_it_ends_when_what_stays_on_somebodys_goal_stays_there():
    walkers = [seeker("/Walks", (0.0, -7.0), (0.0, 0.5), height=0.0)]
    (plan,), (told,) = planned(walkers, moving=MOVING["parking"])
    assert met([plan], walkers, MOVING["parking"]) == []
    assert "1 of 1 agents do not get to their goals" in told.message or "does not get to its goal" in told.message
    assert plan.liftoff_times[-1] < 60.0
