"""Simulating crowds with JuPedSim (extra `crowd`), where that loses people."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.planning.seekers import FLAT, scenario, seeker
from usdfoot.planning.crowd import plan_crowd
from usdfoot.planning.world import Obstacle, box_outline

jupedsim = pytest.importorskip("jupedsim")
import shapely  # noqa: E402

from usdfoot.planning.floors import Floors  # noqa: E402
from usdfoot.planning.places import find_places  # noqa: E402

REAL, OUTSIDE = jupedsim.Simulation, (8.2, -2.0)


class Pushing:
    """JuPedSim, which in thick crowds pushes somebody through a wall and then refuses to go on: here the first."""

    def __init__(self, **options) -> None:
        self._real, self._first, self._is_outside = REAL(**options), -1, False

    def add_agent(self, parameters) -> int:
        identity = self._real.add_agent(parameters)
        self._first = identity if self._first < 0 else self._first
        self.newest = self._real.agent(identity)
        return identity

    def iterate(self, count: int) -> None:
        if self._real.elapsed_time() > 2.0 and not self._is_outside:
            self._is_outside = True
            raise RuntimeError("agent is outside of the walkable area")
        self._real.iterate(count)

    def agent(self, identity: int):
        own = self._real.agent(identity)
        lost = self._is_outside and identity == self._first
        return SimpleNamespace(position=OUTSIDE, target=own.target, model=own.model) if lost else own

    def __getattr__(self, name: str):
        return getattr(self._real, name)


def test_who_is_pushed_through_a_wall_is_put_back_beside_it_and_goes_on(monkeypatch):
    monkeypatch.setattr(jupedsim, "Simulation", Pushing)
    pushed = seeker("/Pushed", (7.3, -4.5), (7.3, 5.0), speed=1.2, radius=0.3)
    other = seeker("/Other", (6.0, -4.5), (6.0, 5.0))
    plans, problems = plan_crowd(scenario(pushed, other), FLAT)
    places = plans[0].positions[:, [0, 2]]
    assert problems == () and [plan.name for plan in plans] == ["/Pushed", "/Other"]
    assert places[:, 0].max() > 7.6, "where it was found"
    assert places[:, 0].max() < 8.0, "inside"
    assert np.linalg.norm(places[-2:].mean(axis=0) - (7.3, 5.0)) < 0.4
    middle = (places[:, 1] > 0.0) & (places[:, 1] < 4.0)
    pace = np.ptp(places[middle, 1]) / np.ptp(plans[0].strike_times[middle])
    assert pace == pytest.approx(1.2, rel=0.1), "as fast as before"


def test_its_body_is_as_wide_and_quick_as_before(monkeypatch):
    made: list[Pushing] = []
    monkeypatch.setattr(jupedsim, "Simulation", lambda **options: made.append(Pushing(**options)) or made[-1])
    (party,), _ = find_places(scenario(seeker("/Pushed", (7.3, -4.5), (7.3, 5.0), speed=1.2, radius=0.3)), FLAT)
    floors = Floors(party)
    floors.slim(np.array([0.2]))
    floors.pace(np.array([0.5]))
    for _ in range(2):
        place = floors.iterate(50)[0]
    model = made[0].newest.model
    assert place[0] < 8.0 and (model.radius, model.desired_speed) == (0.2, 0.6)


def test_round_corners_nobody_is_sent_so_far_that_there_might_be_another_way():
    wall = Obstacle(name="/Wall", outline=box_outline((-6.0, -0.2), (6.5, 0.2)))
    parties, _ = find_places(scenario(seeker("/One", (-4.0, -0.6), (5.5, 4.0)), obstacles=[wall]), FLAT)
    floors = Floors(parties[0])
    floors.steer([0], parties[0].goals)
    assert len(floors.ways[0]) > 2
    way, aim = shapely.LineString(floors.ways[0]), shapely.Point(floors.aims[0])
    assert way.distance(aim) < 1e-9 and 4.0 < way.project(aim) < 8.0
