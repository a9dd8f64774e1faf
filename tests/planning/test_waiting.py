"""Waiting: plans along paths let obstacles that move pass."""

from dataclasses import replace

import numpy as np
import pytest

from tests.planning.terrains import slab, terrain_of
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.moving import Moving
from usdfoot.planning.path import plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.waiting import find_meetings, let_pass
from usdfoot.planning.world import Obstacle, box_outline

PLAIN, BODY = Ground(terrain_of([slab((-12.0, 12.0), (-12.0, 12.0), (0.0, 0.0))])), Proportions()


def box(middle, half) -> list[Obstacle]:
    return [Obstacle(name="/Box", outline=box_outline(np.subtract(middle, half), np.add(middle, half)))]


def walk(speed: float = 1.3) -> FootstepPlan:
    points = np.linspace((0.0, 0.0, -8.0), (0.0, 0.0, 8.0), 50)
    path = WalkingPath(name="/Way", points=points, speed=speed, step_length=0.0, step_width=0.0, start_time=0.0)
    return plan_path(path, PLAIN, proportions=BODY)


def crossing(speed: float, start: float) -> Moving:
    """A cart that goes to the right over the middle of the way."""
    return Moving(at=lambda time: box((start + speed * time, 0.0), (0.8, 0.5)), end=20.0)


def gate(opens: float) -> Moving:
    """A door in the middle of the way that is shut until a time [s]."""
    return Moving(at=lambda time: box((0.0 if time < opens else 3.0, 0.0), (1.0, 0.1)), end=opens + 1.0)


@pytest.mark.parametrize(
    ("speed", "moving"),
    [
        (1.3, crossing(1.2, -8.0)),
        (1.3, crossing(0.4, -2.5)),
        (3.0, crossing(2.0, -8.0)),
        (1.3, gate(9.0)),
        (3.0, gate(9.0)),
        (1.3, gate(45.0)),
    ],
)
def test_the_same_footsteps_come_later_and_meet_nothing(speed, moving):
    plan = walk(speed)
    assert find_meetings([plan], [BODY], moving)
    later = let_pass(plan, BODY, moving, ground=PLAIN)
    assert later is not None
    kept = common_rows(plan, later)
    assert len(kept) == len(plan)
    faults = lint_plans([later], PLAIN, bodies=[BODY], moving=moving.at)
    assert [fault.message for fault in faults] == []
    delays = later.strike_times[kept] - plan.strike_times
    assert np.all(np.diff(delays) > -1e-9) and delays[0] == 0.0 < delays[-1]
    swings = [part.strike_times[2:] - part.liftoff_times[:-2] for part in (plan, later)]
    assert swings[1].min() > swings[0].min() - 1e-9, "a swing is no quicker than they were"


def common_rows(plan: FootstepPlan, later: FootstepPlan) -> np.ndarray:
    """Footsteps of a plan that are in another one."""
    apart = np.linalg.norm(later.positions[:, None] - plan.positions, axis=2)
    return np.flatnonzero((apart < 1e-9).any(axis=1))


@pytest.mark.parametrize("opens", [9.0, 45.0])
def test_who_stands_long_does_so_on_both_feet_and_sets_out_with_half_a_step(opens):
    plan = walk()
    later = let_pass(plan, BODY, gate(opens), ground=PLAIN)
    assert len(later) == len(plan) + 2 and np.all(np.diff(later.sides) != 0)
    together = later.liftoff_times[:-1] - later.strike_times[1:]
    stood = int(np.argmax(together[1:-1])) + 1
    step = np.diff(plan.positions[5:7, 2])[0]
    assert together[stood] > 1.0 and np.abs(np.diff(later.positions[stood : stood + 2, 2]))[0] < 1e-6
    np.testing.assert_allclose(np.diff(later.positions[stood + 1 : stood + 4, 2]), 0.5 * step, atol=1e-6)
    assert np.sort(together[1:-1])[-2] < 0.5, "and nowhere else"


def test_nobody_waits_longer_than_it_has_to():
    opens = 9.0
    later = let_pass(walk(), BODY, gate(opens), ground=PLAIN)
    through = later.strike_times[np.argmax(later.positions[:, 2] > 0.0)]
    assert opens - 0.1 < through < opens + 1.0


def test_a_short_wait_is_made_up_of_slower_steps():
    plan, moving = walk(), crossing(1.2, -8.0)
    delays = let_pass(plan, BODY, moving, ground=PLAIN).strike_times - plan.strike_times
    assert 0.5 < delays[-1] <= 1.5 and np.diff(delays).max() < 0.11


def test_who_meets_nothing_is_not_named_and_who_cannot_wait_has_no_plan():
    plan = walk()
    beside, ahead = replace(plan, name="/Beside"), Moving(at=lambda time: box((0.0, 9.0 - time), (0.4, 0.6)), end=22.0)
    moved = replace(beside, positions=plan.positions + [4.0, 0.0, 0.0])
    met = find_meetings([moved, plan], [BODY, BODY], ahead)
    assert list(met) == [1] and met[1][0] == "/Box" and 5.0 < met[1][1] < 10.0
    assert let_pass(plan, BODY, ahead, ground=PLAIN) is None
