"""Crowds where it is narrow: passages, doors, and between people who stand (JuPedSim, extra `crowd`)."""

import numpy as np
import pytest

from tests.planning.seekers import FLAT, scenario, seeker
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.foot_table import feet_of
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.world import Obstacle, World, box_outline, clearances


def test_a_way_narrower_than_the_body_is_none():
    pytest.importorskip("jupedsim")
    walls = [
        Obstacle(name="/Left", outline=box_outline((-9.0, -0.1), (-0.15, 0.1))),
        Obstacle(name="/Right", outline=box_outline((0.15, -0.1), (9.0, 0.1))),
    ]
    plans, problems = plan_crowd(scenario(seeker("/A", (0.0, -3.0), (0.0, 3.0)), obstacles=walls), FLAT)
    assert plans == [] and "narrower than its body, 0.50 m, and sideways 0.38 m" in problems[0].message


def test_two_head_on_in_a_passage_get_past_each_other():
    pytest.importorskip("jupedsim")
    walls = [
        Obstacle(name="/Left", outline=box_outline((-9.0, -1.5), (-0.8, 1.5))),
        Obstacle(name="/Right", outline=box_outline((0.8, -1.5), (9.0, 1.5))),
    ]
    there, back = seeker("/There", (0.0, -4.0), (0.0, 4.0)), seeker("/Back", (0.0, 4.0), (0.0, -4.0))
    plans, problems = plan_crowd(scenario(there, back, obstacles=walls), FLAT, options=CrowdOptions(duration=60.0))
    assert problems == ()
    assert len(find_collisions(feet_of(plans, [Proportions()] * 2)).times) == 0


@pytest.mark.parametrize(("width", "length", "people"), [(0.4, 2.0, 1), (0.45, 2.0, 2), (0.62, 2.0, 2), (0.8, 6.0, 4)])
def test_where_it_is_tight_they_go_one_after_the_other_and_sideways_where_a_body_is_too_broad(width, length, people):
    pytest.importorskip("jupedsim")
    half = 0.5 * length
    walls = [
        Obstacle(name="/Left", outline=box_outline((-9.0, -half), (-0.5 * width, half))),
        Obstacle(name="/Right", outline=box_outline((0.5 * width, -half), (9.0, half))),
    ]
    ends = [((0.0, -4.0), (0.0, 4.0)), ((0.0, 4.0), (0.0, -4.0)), ((0.8, -5.0), (0.8, 4.0)), ((0.8, 5.0), (0.8, -4.0))]
    task = scenario(*(seeker(f"/{i}", *way) for i, way in enumerate(ends[:people])), obstacles=walls)
    plans, problems = plan_crowd(task, FLAT, options=CrowdOptions(duration=90.0))
    bodies = [Proportions()] * people
    feet = feet_of(plans, bodies)
    assert problems == () and len(plans) == people and lint_plans(plans, Ground(FLAT), bodies=bodies) == []
    assert len(find_collisions(feet).times) == 0
    assert clearances(World(obstacles=tuple(walls)), feet.positions[:, [0, 2]]).min() >= feet.half_widths[0] - 1e-6
    inside = np.abs(feet.positions[:, 2]) < half
    assert np.all(np.abs(np.sin(feet.yaws[inside])) > 0.8) == (width < 0.5), "toes to the wall, or ahead"
    starts = np.array([feet.strikes[inside & (feet.owners == one)].min() for one in range(people)])
    ends = np.array([feet.liftoffs[inside & (feet.owners == one)].max() for one in range(people)])
    there = np.array([plan.positions[0, 2] < 0.0 for plan in plans])
    for one, other in np.argwhere(there[:, None] & ~there):
        assert ends[one] <= starts[other] or ends[other] <= starts[one], "nobody comes the other way"
    if width < 0.5:
        rows = np.flatnonzero(inside[1:] & inside[:-1])
        across = planar.direction(feet.yaws + 0.5 * np.pi)[rows]
        apart = np.sum((feet.positions[rows + 1] - feet.positions[rows])[:, [0, 2]] * across, axis=1)
        assert np.all(apart * np.where(feet.sides[rows + 1] == 0, 1.0, -1.0) > 2.0 * feet.half_widths[0]), (
            "feet close up"
        )


def corridor(width: float, length: float) -> list[Obstacle]:
    """Walls on either side of a corridor along z."""
    half = 0.5 * length
    return [
        Obstacle(name="/Left", outline=box_outline((-9.0, -half), (-0.5 * width, half))),
        Obstacle(name="/Right", outline=box_outline((0.5 * width, -half), (9.0, half))),
    ]


def both_ways(count: int, length: float) -> list[Seeker]:
    """So many people before either end of a corridor along z who go to the other."""
    rows = [(-1.8 + 1.2 * (i % 4), 0.5 * length + 1.0 + i // 4) for i in range(count)]
    there = [seeker(f"/There_{i}", (x, -z), (x, z + 0.5)) for i, (x, z) in enumerate(rows)]
    return there + [seeker(f"/Back_{i}", (x + 0.1, z), (x + 0.1, -z - 0.5)) for i, (x, z) in enumerate(rows)]


@pytest.mark.parametrize(("width", "length"), [(0.7, 5.0), (0.7, 1.0), (1.0, 5.0), (1.1, 5.0), (1.5, 5.0)])
def test_crowds_from_both_ends_of_a_corridor_all_get_through(width, length):
    pytest.importorskip("jupedsim")
    people = both_ways(8, length)
    task = scenario(*people, obstacles=corridor(width, length))
    plans, problems = plan_crowd(task, FLAT, options=CrowdOptions(duration=120.0))
    assert problems == () and len(plans) == len(people)
    assert len(find_collisions(feet_of(plans, [Proportions()] * len(plans))).times) == 0


@pytest.mark.parametrize("gap", [0.1, 0.4, 0.48, 0.6])
def test_a_gap_between_two_corners_holds_nobody_up(gap):
    pytest.importorskip("jupedsim")
    aside = 0.5 * gap / np.sqrt(2.0)
    walls = [
        Obstacle(name="/Left", outline=box_outline((-3.0, -1.0), (-aside, -aside))),
        Obstacle(name="/Right", outline=box_outline((aside, aside), (3.0, 1.0))),
    ]
    one = seeker("/One", (1.0, -3.0), (-1.0, 3.0))
    plans, problems = plan_crowd(scenario(one, obstacles=walls), FLAT, options=CrowdOptions(duration=60.0))
    assert problems == () and len(plans) == 1
    assert np.hypot(*(plans[0].positions[-1, [0, 2]] - [-1.0, 3.0])) < 0.4


def test_who_queues_before_a_gap_stands_aside_only_if_somebody_comes_the_other_way():
    pytest.importorskip("jupedsim")
    queue = [seeker(f"/There_{i}", (0.0, -1.2 - 0.6 * i), (-2.0 + i, 3.0)) for i in range(5)]
    back = seeker("/Back", (0.0, 1.5), (3.0, -4.0))

    def widest(*people: Seeker) -> float:
        """Farthest to the side that anybody of the queue stands before the gap [m]."""
        plans, problems = plan_crowd(scenario(*people, obstacles=corridor(0.7, 1.0)), FLAT)
        assert problems == ()
        positions = np.concatenate([plan.positions for plan in plans if plan.name.startswith("/There")])
        return float(np.abs(positions[positions[:, 2] < -0.5, 0]).max())

    assert widest(*queue) < 0.5 < 0.8 < widest(*queue, back)


def simulated(*people: Seeker, obstacles):
    """Tracks of people, before they become footsteps."""
    pytest.importorskip("jupedsim")
    from usdfoot.planning.places import find_places
    from usdfoot.planning.simulation import simulate

    (party,), problems = find_places(scenario(*people, obstacles=obstacles), FLAT)
    assert problems == ()
    return simulate(party, duration=60.0)


def test_behind_somebody_slow_people_queue_and_nobody_steps_back():
    slow = seeker("/Slow", (0.0, -1.0), (0.0, 6.0), speed=0.12)
    others = [seeker(f"/{i}", (0.0, -1.6 - 0.6 * i), (0.0, 5.3 - 0.7 * i)) for i in range(4)]
    along = simulated(slow, *others, obstacles=corridor(1.0, 3.0)).points[..., 1]
    assert (np.maximum.accumulate(along, axis=0) - along).max() < 0.4


@pytest.mark.parametrize("shift", [0.0, 0.002])
def test_those_who_wedge_before_a_door_come_loose_and_slip_between_those_who_stand(shift):
    places = [(i % 5 - 2, i // 5) for i in range(20)]
    people = [
        seeker(f"/{x}_{z}", (0.6 * x + shift * (z % 2), -1.5 - 0.6 * z), (0.7 * x, 5.0 - 0.7 * z)) for x, z in places
    ]
    tracks = simulated(*people, obstacles=corridor(1.8, 1.0))
    assert tracks.arrived.all() and tracks.times[-1] < 25.0


def test_who_does_not_get_through_to_its_place_at_a_goal_of_many_has_arrived_among_them():
    people = [seeker(f"/{i}", (-6.0 + 0.7 * (i % 10), -6.0 + 0.7 * (i // 10)), (7.2, 7.2)) for i in range(40)]
    tracks = simulated(*people, obstacles=[])
    assert tracks.arrived.all() and tracks.times[-1] < 60.0 - 1.0, "the corner holds nobody up for ever"
    assert np.linalg.norm(tracks.points[-1] - 7.2, axis=1).max() < 5.0


def test_two_who_meet_where_it_is_tight_turn_their_shoulders_and_pass_without_waiting():
    pytest.importorskip("jupedsim")
    there, back = seeker("/There", (0.0, -4.5), (0.0, 4.5)), seeker("/Back", (0.0, 4.5), (0.0, -4.5))
    (one, other), problems = plan_crowd(scenario(there, back, obstacles=corridor(1.0, 5.0)), FLAT)
    (alone,), _ = plan_crowd(scenario(there, obstacles=corridor(1.0, 5.0)), FLAT)
    assert problems == ()
    assert max(plan.liftoff_times[-1] for plan in (one, other)) < alone.liftoff_times[-1] + 4.0, "nobody waits"
    near = np.abs(one.positions[:, 2]) < 1.0
    assert (
        np.abs(one.yaws[near]).max() > 0.5
        and one.positions[near, 0].mean() < other.positions[np.abs(other.positions[:, 2]) < 1.0, 0].mean()
    ), "shoulders turned, each on its right"
    far = np.abs(np.abs(one.positions[:, 2]) - 3.5) < 0.5
    assert np.abs(one.yaws[far]).max() < 0.4, "and only there"
