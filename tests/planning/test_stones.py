"""Ways over stepping stones: the best there is, or how far one leads ([P] Figure 13)."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import Delaunay

from tests.engine.plans import no_terrain
from tests.planning.terrains import slab, terrain_of
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.crossing_graph import HEADINGS
from usdfoot.planning.crossings import Stance, Stones, stance_at
from usdfoot.planning.faults import LintLimits
from usdfoot.planning.lint import lint_steps
from usdfoot.planning.path import plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach
from usdfoot.planning.stone_tops import given_stones, stones_on
from usdfoot.planning.stones import find_crossing, plan_crossings, plan_stones

REACH = Reach(
    outline=np.array([(-0.05, -0.3), (0.5, -0.3), (0.5, 0.9), (-0.05, 0.9)]),
    comfortable=np.array([0.12, 0.6]),
    spread=np.array([0.17, 0.34]),
    rise=0.35,
    turn=np.radians(45.0),
    apart=0.09,
)


def stones_at(points, height: float = 0.0) -> Stones:
    places = np.insert(np.asarray(points, dtype=float), 1, height, axis=1)
    return Stones(name="/Stones", positions=places, normals=np.tile([0.0, 1.0, 0.0], (len(places), 1)))


def straight(count: int = 6) -> np.ndarray:
    side = np.where(np.arange(count) % 2, -0.06, 0.06)
    return np.column_stack([side, 0.6 * np.arange(1, count + 1)])


def turned(stance: Stance, yaw: float) -> Stance:
    ground = planar.rotate(np.array(yaw), stance.positions[:, [0, 2]])
    return Stance(positions=np.insert(ground, 1, 0.0, axis=1), yaw=stance.yaw + yaw)


def test_even_stones_are_all_stepped_on_in_order():
    goal = stance_at(np.array([0.0, 0.0, 4.2]), 0.0, REACH)
    crossing = find_crossing(stones_at(straight()), stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH)
    assert crossing.footholds.tolist() == [-1, -1, 0, 1, 2, 3, 4, 5, -1, -1]
    assert np.all(np.diff(crossing.sides) != 0)
    assert crossing.sides[2] == 0, "the first stone lies on the left"
    assert_allclose(crossing.yaws, 0.0, atol=1e-9)


def step_costs(landings: np.ndarray, foot: int, rise: float) -> np.ndarray:
    """How uncomfortable steps are, infinite out of reach; landings (x, z) are as the step's end sees them."""
    own = landings * (1.0 if foot == 0 else -1.0, 1.0)
    costs = 1.0 + np.sum(((own - REACH.comfortable) / REACH.spread) ** 2, axis=1) + (rise / (0.5 * REACH.rise)) ** 2
    inside = Delaunay(REACH.outline).find_simplex(own, tol=1e-9) >= 0
    possible = inside & (abs(rise) <= REACH.rise) & (np.hypot(*own.T) >= REACH.apart) & (own[:, 0] >= 0.0)
    return np.where(possible, costs, np.inf)


def test_it_is_the_cheapest_of_all_ways(generator):
    """Against every sequence of at most four of five stones, turns and all, tried one after the other."""
    stones = stones_at(generator.uniform([-0.6, 0.3], [0.6, 1.5], size=(5, 2)))
    start, goal = stance_at(np.zeros(3), 0.0, REACH), stance_at(np.array([0.1, 0.0, 1.9]), 0.0, REACH)
    crossing = find_crossing(stones, start, goal, reach=REACH)
    yaws = np.arange(HEADINGS) * 2.0 * np.pi / HEADINGS
    turns = planar.wrap_angle(yaws[None] - yaws[:, None])
    turning = np.where(np.abs(turns) <= REACH.turn + 1e-9, (turns / REACH.turn) ** 2, np.inf)

    def cost_of(way: tuple[int, ...], side: int) -> float:
        """Least cost over all headings of standing on `side`, then stepping on the stones of the way and the goal."""
        costs = np.where(np.arange(HEADINGS) == 0, 0.0, np.inf)
        place = start.positions[side]
        sides = [(side + number) % 2 for number in range(1, len(way) + 2)]
        targets = [*(stones.positions[stone] for stone in way), goal.positions[sides[-1]]]
        for foot, target in zip(sides, targets, strict=True):
            landings = planar.rotate(-yaws, np.tile((target - place)[[0, 2]], (HEADINGS, 1)))
            steps = step_costs(landings, foot, target[1] - place[1])
            across = planar.rotate(-(yaws - 0.5 * turns), (target - place)[[0, 2]])[..., 0] * (1.0, -1.0)[foot]
            uncrossed = np.where(across >= -1e-9, turning, np.inf)
            costs, place = np.min(costs[:, None] + uncrossed, axis=0) + steps, target
        return float(costs[0])

    ways = [way for length in range(5) for way in itertools.permutations(range(5), length)]
    assert crossing.cost == pytest.approx(min(cost_of(way, side) for way in ways for side in (0, 1)))


def test_the_way_turns_with_the_stones(generator):
    stones = stones_at(generator.uniform([-0.5, 0.2], [0.5, 2.6], size=(14, 2)))
    start, goal = stance_at(np.zeros(3), 0.0, REACH), stance_at(np.array([0.0, 0.0, 3.0]), 0.0, REACH)
    one = find_crossing(stones, start, goal, reach=REACH)
    around = stones_at(planar.rotate(np.array(0.7), stones.positions[:, [0, 2]]))
    other = find_crossing(around, turned(start, 0.7), turned(goal, 0.7), reach=REACH)
    assert other.footholds.tolist() == one.footholds.tolist()
    assert other.cost == pytest.approx(one.cost)
    assert_allclose(other.yaws, one.yaws + 0.7, atol=1e-9)


def test_a_plan_stands_at_both_ends_and_steps_only_on_stones():
    goal = stance_at(np.array([0.0, 0.0, 4.2]), 0.0, REACH)
    stones = stones_at(straight())
    plan = plan_stones(stones, stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH, name="/Plan")
    assert plan.starts_standing and plan.ends_standing and plan.name == "/Plan"
    assert_allclose(plan.positions[2:-2], stones.positions, atol=1e-12)
    slow, quick = (
        plan_stones(stones, stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH, speed=speed) for speed in (0.4, 0.8)
    )
    assert_allclose(np.diff(slow.strike_times[2:]), 2.0 * np.diff(quick.strike_times[2:]))


@pytest.mark.parametrize("seed", range(8))
def test_no_step_crosses_the_legs_as_lint_sees_them(seed):
    """Neither before nor after headings are averaged."""
    stones = stones_at(np.random.default_rng(seed).uniform([-0.9, 0.2], [0.9, 3.4], size=(40, 2)))
    start, goal = stance_at(np.zeros(3), 0.0, REACH), stance_at(np.array([0.0, 0.0, 3.8]), 0.4, REACH)
    plan = plan_stones(stones, start, goal, reach=REACH)
    limits = LintLimits(crossing=1e-6)
    assert not [fault for fault in lint_steps(plan, Proportions(), limits=limits) if fault.kind == "crossing"]


def test_it_sets_out_from_a_stand_as_along_a_path():
    stones, goal = stones_at(straight()), stance_at(np.array([0.0, 0.0, 4.2]), 0.0, REACH)
    plan = plan_stones(stones, stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH)
    line = WalkingPath(name="/Line", points=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 4.2]]))
    path = plan_path(line, Ground(no_terrain()))
    swings = [one.strike_times[2] - one.liftoff_times[0] for one in (plan, path)]
    assert swings[0] == pytest.approx(swings[1], abs=0.1), "not in half the time"
    assert plan.liftoff_times[0] == pytest.approx(path.liftoff_times[0], abs=0.05)


@pytest.mark.parametrize("leaps", [False, True])
def test_between_stones_in_pairs_it_strides_and_only_leaps_if_it_may(leaps):
    """Pairs of stones side by side, 0.84 m from pair to pair, walked by short legs, to whom that is a long step."""
    body = Proportions(leg_length=0.7)
    stones = stones_at([(side, 0.84 * pair) for pair in (1, 2, 3) for side in (0.1, -0.1)])
    start, goal = (stance_at(np.array([0.0, 0.0, z]), 0.0, REACH) for z in (0.0, 0.84 * 4))
    plan = plan_stones(stones, start, goal, reach=replace(REACH, leaps=leaps), body=body)
    flights = plan.strike_times[1:] - plan.liftoff_times[:-1]
    assert (flights.max() > 0.0) == leaps
    assert not lint_steps(plan, body)


def test_many_plans_made_together_are_those_of_each_alone(generator):
    """Over the same stones, from and to anywhere, one that has no way among them."""
    stones = stones_at(generator.uniform([-0.9, 0.2], [0.9, 3.4], size=(50, 2)))
    starts = [stance_at(np.array([0.1 * number - 0.2, 0.0, 0.0]), 0.2 * number, REACH) for number in range(5)]
    goals = [stance_at(np.array([0.2 - 0.1 * number, 0.0, 3.8]), 0.1 * number, REACH) for number in range(4)]
    goals.insert(2, stance_at(np.array([0.0, 0.0, 9.0]), 0.0, REACH))
    speeds, names = [0.0, 0.5, 0.0, 0.9, 0.0], [f"/Plan_{number}" for number in range(5)]
    plans = plan_crossings(stones, starts, goals, reach=REACH, speeds=speeds, names=names)
    for start, goal, speed, name, plan in zip(starts, goals, speeds, names, plans, strict=True):
        if isinstance(plan, PlanError):
            with pytest.raises(PlanError) as caught:
                plan_stones(stones, start, goal, reach=REACH, speed=speed, name=name)
            assert str(caught.value) == str(plan)
            continue
        alone = plan_stones(stones, start, goal, reach=REACH, speed=speed, name=name)
        for field in ("sides", "positions", "orientations", "strike_times", "liftoff_times"):
            assert getattr(plan, field).tobytes() == getattr(alone, field).tobytes(), (name, field)
    assert [isinstance(plan, PlanError) for plan in plans] == [False, False, True, False, False]


def test_where_there_is_no_way_the_error_says_how_far_one_leads():
    gap = np.delete(straight(10), [4, 5], axis=0)
    goal = stance_at(np.array([0.0, 0.0, 6.6]), 0.0, REACH)
    with pytest.raises(PlanError, match=r"4 of 8 footholds ends at foothold 3 .*4\.2. m before the goal.*1\.8. m from"):
        find_crossing(stones_at(gap), stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH)


def wide_ground(*, gate: bool) -> Stones:
    """17,000 footholds in 24 m by 7 m, cut in two by a ditch with a bridge 5 m off the straight way, or without."""
    places = np.stack(np.meshgrid(np.arange(-12.0, 12.0, 0.1), np.arange(0.0, 7.0, 0.1)), axis=-1).reshape(-1, 2)
    ditch = (places[:, 1] > 2.0) & (places[:, 1] < 4.0)
    return stones_at(places[~ditch | (gate & (np.abs(places[:, 0] - 5.0) < 0.3))])


@pytest.mark.parametrize(
    ("start", "help_is"),
    [
        ((0.0, 3.0, 0.0), "3.00 m lower. .*stand the agent on the ground"),
        ((0.0, 0.0, -3.0), "stand the agent nearer"),
    ],
)
def test_where_no_foothold_is_reached_the_error_says_where_to_stand(start, help_is):
    goal = stance_at(np.array([0.0, 0.0, 4.2]), 0.0, REACH)
    with pytest.raises(PlanError, match=rf"over 0 of 6 footholds ends at the start .*{help_is}"):
        find_crossing(stones_at(straight()), stance_at(np.array(start), 0.0, REACH), goal, reach=REACH)


def test_of_very_many_footholds_only_those_near_the_way_are_searched():
    start, goal = stance_at(np.array([-1.0, 0.0, 0.5]), 0.0, REACH), stance_at(np.array([-1.0, 0.0, 6.0]), 0.0, REACH)
    stones = wide_ground(gate=True)
    crossing = find_crossing(stones, start, goal, reach=REACH)
    assert_allclose(crossing.positions[2:-2], stones.positions[crossing.footholds[2:-2]])
    over = crossing.positions[(crossing.positions[:, 2] > 2.0) & (crossing.positions[:, 2] < 4.0)]
    assert len(over) >= 2 and np.all(np.abs(over[:, 0] - 5.0) < 0.3), "over the bridge"
    shortest = 2.0 * np.hypot(6.0, 1.5) + 2.5
    assert crossing.cost < 1.35 * shortest / 0.6, "steps are comfortable, turns and all"


def test_of_very_many_footholds_the_error_says_how_far_a_way_leads():
    start, goal = stance_at(np.array([-1.0, 0.0, 0.5]), 0.0, REACH), stance_at(np.array([-1.0, 0.0, 6.0]), 0.0, REACH)
    stones = wide_ground(gate=False)
    with pytest.raises(PlanError, match=r"of \d+ footholds, the most promising of 12240, ends .* 2\.00 m from"):
        find_crossing(stones, start, goal, reach=REACH)


def test_a_stone_too_high_is_not_stepped_on():
    places = np.insert(straight(3), 1, [0.0, 0.5, 0.0], axis=1)
    stones = Stones(name="/Stones", positions=places, normals=np.tile([0.0, 1.0, 0.0], (3, 1)))
    goal = stance_at(np.array([0.0, 0.0, 2.4]), 0.0, REACH)
    with pytest.raises(PlanError, match=r"1 of 3 footholds.*0\.50 m higher\. .*add footholds at heights between"):
        find_crossing(stones, stance_at(np.zeros(3), 0.0, REACH), goal, reach=REACH)


def test_footholds_given_beside_an_edge_or_in_the_air_are_avoided_where_others_are_near():
    """Of each pair of points the wrong one lies better; alone it is stepped on, and lint names it."""
    terrain = terrain_of([slab((-0.3, 0.3), (-1.0, 6.0), (0.0, 0.0))])
    good, wrong = np.insert(straight(), 1, 0.0, axis=1), np.insert(straight(), 1, 0.0, axis=1)
    good[:, 2] += 0.15
    wrong[::2, 0], wrong[1::2, 1] = 0.29, 0.2  # the sole over the edge; in the air
    start, goal = (stance_at(np.array([0.0, 0.0, z]), 0.0, REACH) for z in (0.0, 4.35))
    body = Proportions()
    stones = given_stones("/Points", np.concatenate([wrong, good]), None, terrain=terrain, body=body)
    assert find_crossing(stones, start, goal, reach=REACH).footholds[2:-2].min() >= 6
    alone = given_stones("/Points", wrong, None, terrain=terrain, body=body)
    assert find_crossing(alone, start, goal, reach=REACH).footholds[2:-2].max() < 6


def test_footholds_given_lie_in_the_terrain_or_on_their_normals():
    terrain = terrain_of([slab((-1.0, 1.0), (-1.0, 1.0), (0.0, 0.4))])
    places, body = np.array([(0.0, 0.2, 0.0), (0.0, 2.0, 0.0)]), Proportions()
    laid = given_stones("/Points", places, None, terrain=terrain, body=body).normals
    assert_allclose(laid, [np.array([0.0, 2.0, -0.4]) / np.hypot(2.0, 0.4), (0.0, 1.0, 0.0)], atol=1e-9)
    own = np.array([(0.0, 0.8, 0.6), (0.6, 0.8, 0.0)])
    assert_allclose(given_stones("/Points", places, own, terrain=terrain, body=body).normals, own)


def test_bad_stones_are_refused():
    with pytest.raises(PlanError, match="/Stones: has no footholds"):
        stones_at(np.zeros((0, 2)))
    with pytest.raises(PlanError, match="foothold 1 is not finite"):
        stones_at([(0.0, 0.0), (np.nan, 0.0)])


def test_footholds_of_meshes_are_on_walkable_level_tops_under_nothing():
    terrain = terrain_of(
        [
            slab((-0.2, 0.2), (0.0, 0.4), (0.3, 0.3)),  # a stone
            slab((1.0, 1.4), (0.0, 0.4), (0.0, 0.4)),  # 45 degrees steep
            slab((2.0, 2.4), (0.0, 0.4), (0.3, 0.3)),  # under a roof
            slab((1.9, 2.5), (-0.1, 0.5), (2.0, 2.0)),  # the roof, not walkable
        ],
        walkable=[True, True, True, False],
    )
    body = Proportions()
    stones = stones_on(terrain, body=body, spacing=0.1)
    assert len(stones.positions) == 9, "a grid of 0.1 m with its middle at the stone's, the foot's width from its edge"
    assert np.all(np.abs(stones.positions - [0.0, 0.3, 0.2]) <= [0.2 - body.half_width, 1e-9, 0.2 - body.half_width])
    with pytest.raises(PlanError, match=r"/Ground_0: is 0\.4 m by 0\.4 m, too large"):
        stones_on(terrain, body=body, spacing=0.0002)
