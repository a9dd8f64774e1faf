"""Crowds with goals: everyone gets there, nobody treads on anybody (JuPedSim, extra `crowd`)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.planning.terrains import bridge, slab, spiral, storeys, terrain_of
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.planning import crowd as crowd_module
from usdfoot.planning.collisions import feet_of, find_collisions
from usdfoot.planning.crowd import CrowdOptions, plan_crowd
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

FLAT = terrain_of([slab((-8.0, 8.0), (-8.0, 8.0), (0.5, 0.5))])
BLOCK = Obstacle(name="/Block", outline=box_outline((-1.0, -1.0), (1.0, 1.0)), margin=0.2)


def seeker(name: str, start, goal, *, height: float = 0.5, **options) -> Seeker:
    (x, z), (gx, gz) = start, goal
    return Seeker(name=name, start=np.array([x, height, z]), goals=np.array([(gx, height, gz)]), **options)


def scenario(*seekers: Seeker, obstacles=()) -> Scenario:
    return Scenario(seekers=seekers, obstacles=tuple(obstacles), bounds=None)


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


def test_those_who_wedge_before_a_door_come_loose_and_all_arrive():
    places = [(i % 5 - 2, i // 5) for i in range(20)]
    people = [seeker(f"/{x}_{z}", (0.6 * x, -1.5 - 0.6 * z), (0.7 * x, 5.0 - 0.7 * z)) for x, z in places]
    tracks = simulated(*people, obstacles=corridor(1.8, 1.0))
    assert tracks.arrived.all() and tracks.times[-1] < 25.0


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
