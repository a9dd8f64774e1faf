"""Cornering: who runs takes corners no faster than it could; walkers are left alone."""

import numpy as np
import pytest

from tests.planning.seekers import FLAT, scenario, seeker
from usdfoot.model.ground import Ground
from usdfoot.planning.crowd import plan_crowd
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle, box_outline

pytest.importorskip("jupedsim")
from usdfoot.planning.cornering import BRAKE, EARLY, SWERVE, Corners

BEND = np.array([[0.0, 0.0], [0.0, 10.0], [10.0, 10.0]])


def pace_at(*, place: tuple[float, float], way: np.ndarray = BEND, speed: float = 4.0) -> float:
    """Speed [m/s] of who has long been there."""
    corners = Corners([seeker("/A", (0.0, 0.0), (10.0, 10.0), speed=speed)])
    return speed * float(corners.paces(np.array([place]), [way], elapsed=100.0)[0])


def test_who_runs_brakes_before_a_right_angle() -> None:
    slow = 0.5 * SWERVE / np.sin(0.25 * np.pi)
    assert pace_at(place=(0.0, 9.9)) == pytest.approx(slow)
    assert pace_at(place=(0.0, 10.0 - EARLY - 1.0)) == pytest.approx(np.sqrt(slow**2 + 2.0 * BRAKE))
    assert pace_at(place=(0.0, 1.0)) == pytest.approx(4.0)


def test_two_corners_close_together_are_one_turn_back() -> None:
    back = np.array([[0.0, 0.0], [0.0, 10.0], [0.5, 10.0], [0.5, 0.0]])
    assert pace_at(place=(0.3, 10.0), way=back) == pytest.approx(0.5 * SWERVE)


def test_it_speeds_up_gradually_and_stops_gradually() -> None:
    corners = Corners([seeker("/A", (0.0, 0.0), (10.0, 10.0), speed=4.0)])
    before = 4.0 * corners.paces(np.array([[0.0, 9.9]]), [BEND], elapsed=0.1)[0]
    after = 4.0 * corners.paces(np.array([[0.1, 10.0]]), [BEND[1:]], elapsed=0.1)[0]
    assert after == pytest.approx(before + 0.1 * BRAKE)
    assert pace_at(place=(9.9, 10.0)) == pytest.approx(0.5 * SWERVE)


def test_walkers_turn_as_they_like() -> None:
    assert pace_at(place=(0.0, 9.9), speed=1.4) == 1.4


def test_a_runner_goes_round_the_end_of_a_wall_without_cutting_it() -> None:
    wall = Obstacle(name="wall", outline=box_outline(np.array([-0.2, -9.0]), np.array([0.2, 4.0])))
    (plan,), _ = plan_crowd(scenario(seeker("/A", (-2.0, -7.0), (2.0, -7.0), speed=3.8), obstacles=(wall,)), FLAT)
    faults = lint_plans([plan], Ground(FLAT), bodies=[Proportions()], obstacles=[wall])
    assert not [fault.message for fault in faults if fault.kind == "obstacle"]
    lengths, times = np.linalg.norm(np.diff(plan.positions, axis=0), axis=1), np.diff(plan.strike_times)
    assert (lengths / np.maximum(times, 0.1)).max() > 3.0, "it runs"
