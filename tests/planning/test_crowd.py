"""Crowds with goals: everyone gets there, nobody treads on anybody (JuPedSim, extra `crowd`)."""

import numpy as np
import pytest

from tests.planning.seekers import FLAT, scenario, seeker
from tests.planning.terrains import slab, terrain_of
from usdfoot.errors import PlanError
from usdfoot.model.ground import Ground
from usdfoot.planning import crowd as crowd_module
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.foot_table import feet_of
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

BLOCK = Obstacle(name="/Block", outline=box_outline((-1.0, -1.0), (1.0, 1.0)), margin=0.2)
WALL = Obstacle(name="/Wall", outline=box_outline((-1.0, -3.0), (1.0, 3.0)))


@pytest.fixture(scope="module")
def crossing():
    """Twelve people who cross where a block stands, six each way."""
    pytest.importorskip("jupedsim")
    rows = np.linspace(-2.5, 2.5, 6)
    there = [seeker(f"/There_{i}", (x, -6.0), (x, 6.0), yaw=0.0) for i, x in enumerate(rows)]
    back = [seeker(f"/Back_{i}", (-6.0, z), (6.0, z), yaw=np.pi) for i, z in enumerate(rows)]
    task = scenario(*there, *back, obstacles=[BLOCK])
    return task, *plan_crowd(task, FLAT)


def test_everyone_gets_to_the_goal_and_stands_there(crossing):
    task, plans, problems = crossing
    assert problems == () and [plan.name for plan in plans] == [one.name for one in task.seekers]
    for plan, one in zip(plans, task.seekers, strict=True):
        assert plan.starts_standing and plan.ends_standing
        assert np.linalg.norm(plan.positions[:2].mean(axis=0) - one.start) < 0.05
        assert np.linalg.norm(plan.positions[-2:].mean(axis=0) - one.goals[0]) < 0.4
        assert np.abs(plan.positions[:, 1] - 0.5).max() < 1e-6


def test_nobody_treads_on_anybody_or_into_the_block(crossing):
    task, plans, _ = crossing
    assert len(find_collisions(feet_of(plans, [Proportions()] * len(plans))).times) == 0
    world = World(obstacles=task.obstacles)
    assert min(clearances(world, plan.positions[:, [0, 2]]).min() for plan in plans) > 0.0


def test_people_turn_to_where_they_go_before_they_go(crossing):
    _, plans, _ = crossing
    back = next(plan for plan in plans if plan.name == "/Back_5")
    gone = np.linalg.norm(back.positions[:, [0, 2]] - back.positions[0, [0, 2]], axis=1)
    assert abs(abs(back.yaws[0]) - np.pi) < 0.25, "it looks as its agent does"
    assert np.abs(back.yaws[(gone > 0.5) & (gone < 4.0)] - 0.5 * np.pi).max() < 0.5


def test_the_same_crowd_gives_the_same_bytes(crossing):
    task, plans, _ = crossing
    again, _ = plan_crowd(task, FLAT)
    assert all(a.positions.tobytes() == b.positions.tobytes() for a, b in zip(plans, again, strict=True))


def test_people_with_one_goal_stand_around_it():
    pytest.importorskip("jupedsim")
    around = [(np.cos(angle) * 4.0, np.sin(angle) * 4.0) for angle in np.arange(5) * 2.0 * np.pi / 5.0]
    plans, problems = plan_crowd(scenario(*(seeker(f"/{i}", at, (0.0, 0.0)) for i, at in enumerate(around))), FLAT)
    ends = np.array([plan.positions[-2:].mean(axis=0) for plan in plans])
    apart = np.linalg.norm(ends[:, None] - ends, axis=2) + 9.0 * np.eye(5)
    assert problems == () and apart.min() > 0.4 and np.linalg.norm(ends[:, [0, 2]], axis=1).max() < 1.2


def test_a_goal_of_many_fills_from_the_middle_whoever_comes_first():
    """Nobody has to get past those who stand, though those who start nearest walk slowest."""
    pytest.importorskip("jupedsim")
    starts = [(0.7 * (i % 3) - 0.7, -2.5 - 0.7 * (i // 3)) for i in range(9)]
    people = [seeker(f"/{i}", start, (0.0, 3.0), speed=0.5 + 0.15 * i) for i, start in enumerate(starts)]
    plans, problems = plan_crowd(scenario(*people), FLAT, options=CrowdOptions(duration=60.0))
    assert problems == () and max(plan.liftoff_times[-1] for plan in plans) < 40.0
    ends = np.array([plan.positions[-2:].mean(axis=0) for plan in plans])
    apart = np.linalg.norm(ends[:, None] - ends, axis=2) + 9.0 * np.eye(9)
    assert apart.min() > 0.4 and np.linalg.norm(ends[:, [0, 2]] - (0.0, 3.0), axis=1).max() < 1.4


def test_who_cannot_go_is_named_and_the_rest_goes_on():
    pytest.importorskip("jupedsim")
    island = terrain_of([slab((-8.0, 8.0), (-8.0, 8.0), (0.5, 0.5)), slab((20.0, 24.0), (-2.0, 2.0), (0.5, 0.5))])
    plans, problems = plan_crowd(
        scenario(
            seeker("/Fine", (-4.0, 0.0), (-4.0, 3.0)),
            seeker("/Inside", (0.0, 0.0), (4.0, 0.0)),
            seeker("/Blocked", (3.0, 0.0), (0.5, 0.5)),
            seeker("/Far", (3.0, 2.0), (22.0, 0.0)),
            seeker("/Same", (-4.1, 0.0), (4.0, 4.0)),
            seeker("/Edge", (7.9, 0.0), (4.0, 4.0)),
            seeker("/Off", (90.0, 0.0), (4.0, 4.0)),
            seeker("/Fast", (5.0, -5.0), (5.0, -3.0), speed=12.0),
            obstacles=[BLOCK],
        ),
        island,
    )
    assert [plan.name for plan in plans] == ["/Fine", "/Fast"]
    messages = {problem.where: problem.message for problem in problems}
    assert "in an obstacle or off the walkable ground" in messages["/Inside"]
    assert "has its goal (0.50, 0.50) m in an obstacle" in messages["/Blocked"]
    assert "cannot get to its goal (22.00, 0.00) m" in messages["/Far"]
    assert "starts 0.10 m from /Fine, where their bodies overlap" in messages["/Same"]
    assert "0.10 m from an obstacle or the edge" in messages["/Edge"]
    assert "starts at (90.00, 0.00) m, in an obstacle or off the walkable ground" in messages["/Off"]
    assert "wants to go 12.00 m/s; 5 m/s were taken" in messages["/Fast"]


def test_without_jupedsim_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr(crowd_module, "find_spec", lambda name: None)
    with pytest.raises(PlanError, match=r"needs JuPedSim.*pip install 'usdfoot\[crowd\]'"):
        plan_crowd(scenario(seeker("/A", (0.0, 0.0), (1.0, 0.0))), FLAT)


def test_bad_numbers_are_refused():
    with pytest.raises(PlanError, match=r"/A: has a speed of 0 m/s and a radius of 0\.25 m"):
        seeker("/A", (0.0, 0.0), (1.0, 0.0), speed=0.0)
    with pytest.raises(PlanError, match="/A: has a start, goal, speed or radius that is not finite"):
        seeker("/A", (np.nan, 0.0), (1.0, 0.0))
    pytest.importorskip("jupedsim")
    with pytest.raises(PlanError, match="has no agent with a goal"):
        plan_crowd(scenario(), FLAT)


def test_no_sole_is_in_the_wall_that_somebody_stands_at():
    """Its body has room there, its heels would not."""
    pytest.importorskip("jupedsim")
    task = scenario(seeker("/Thin", (1.12, 0.0), (4.0, 0.0), yaw=0.5 * np.pi, radius=0.12), obstacles=[WALL])
    plans, problems = plan_crowd(task, FLAT)
    faults = lint_plans(plans, Ground(FLAT), bodies=[Proportions()], obstacles=[WALL])
    assert problems == () and faults == [] and np.linalg.norm(plans[0].positions[:2, 0] - 1.12) < 0.2


def test_those_who_do_not_arrive_are_counted_with_where_they_are_and_what_helps():
    pytest.importorskip("jupedsim")
    far = [seeker(f"/Far_{i}", (x, -6.0), (x, 6.0), yaw=0.0) for i, x in enumerate((-2.0, 2.0))]
    task = scenario(*far, seeker("/Near", (0.0, 0.0), (0.0, 1.0), yaw=0.0))
    plans, problems = plan_crowd(task, FLAT, options=CrowdOptions(duration=5.0))
    assert len(plans) == 3, "they are planned as far as they come"
    whole, *each = [problem.message for problem in problems]
    assert whole == ("2 of 3 agents do not get to their goals in 5 s: 2 are on their way; simulate longer (--duration)")
    assert [message.split(":")[0] for message in each] == ["/Far_0", "/Far_1"]
    assert all("does not get to its goal; it stops" in message for message in each)
