"""Wandering one footstep at a time, routes around obstacles, distances from them ([P] 4.2)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tests.engine.plans import no_terrain
from tests.planning.terrains import bridge, slab, spiral, storeys, terrain_of
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.aims import News
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.habits import Habits
from usdfoot.planning.joining import join_footsteps
from usdfoot.planning.lint import lint_plans, lint_steps
from usdfoot.planning.path import plan_path
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.routes import RouteFinder, look_along
from usdfoot.planning.wander import plan_wander, plan_wanders, wander
from usdfoot.planning.wanderer import WanderOptions
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

SQUARE = box_outline((-5.0, -5.0), (5.0, 5.0))
WALL = Obstacle(name="/Wall", outline=box_outline((-4.0, 1.0), (5.0, 1.4)), margin=0.1)
L_SHAPE = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)])
RADIUS = WanderOptions().radius


def walk(seed: int = 1, world: World | None = None, **options):
    start = np.array([0.0, 0.0, -2.0])
    return plan_wander(world or World(bounds=SQUARE), start, 0.3, generator=np.random.default_rng(seed), **options)


def test_distances_from_a_concave_outline_are_known():
    world = World(obstacles=(Obstacle(name="/L", outline=L_SHAPE, margin=0.25),))
    points = np.array([(1.5, 1.5), (0.5, 0.5), (3.0, 0.5), (3.0, 2.0), (-1.0, -1.0)])
    expected = np.array([0.5, -0.5, 1.0, np.sqrt(2.0), np.sqrt(2.0)]) - 0.25
    assert_allclose(clearances(world, points), expected, atol=1e-12)
    backward = World(obstacles=(Obstacle(name="/L", outline=L_SHAPE[::-1], margin=0.25),), bounds=SQUARE)
    assert_allclose(clearances(backward, points), np.minimum(expected, 5.0 - np.abs(points).max(axis=1)), atol=1e-12)
    assert_array_equal(clearances(World(), points), np.inf)


def test_who_is_level_with_a_corner_but_for_rounding_is_outside():
    outline = np.array([(3.0, 0.1), (-2.9, -0.8), (-2.4, -1.9), (-0.4, -3.0), (1.2, -2.7), (2.8, -1.2)])
    beside = np.stack([np.full(6, -5.0), np.nextafter(outline[:, 1], -np.inf)], axis=1)
    assert clearances(World(obstacles=(Obstacle(name="/Rock", outline=outline),)), beside).min() > 0.0


def distance_from(outline: np.ndarray, point: np.ndarray) -> float:
    """Of a point from a polygon, negative inside, edge by edge."""
    nearest, turns = np.inf, 0.0
    for begin, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        edge = end - begin
        along = np.clip(np.dot(point - begin, edge) / np.dot(edge, edge), 0.0, 1.0)
        nearest = min(nearest, float(np.linalg.norm(point - begin - along * edge)))
        turns += float(planar.wrap_angle(planar.yaw_of(end - point) - planar.yaw_of(begin - point)))
    return -nearest if abs(turns) > np.pi else nearest


def test_distances_among_many_outlines_are_those_of_the_nearest(generator):
    """Against every outline alone, one after the other."""
    places = generator.uniform(-4.0, 4.0, size=(12, 2))
    heights = [(-np.inf, np.inf), (0.0, 0.5), (2.5, 3.0)]
    obstacles = [
        Obstacle(
            name="/L",
            outline=0.3 * L_SHAPE + place,
            margin=0.4 * (index % 2),
            heights=heights[index % len(heights)],
            velocity=(0.5 * (index % 4), -0.2) if index % 5 else None,
        )
        for index, place in enumerate(places)
    ]
    points, ground = generator.uniform(-6.0, 6.0, size=(200, 2)), generator.choice([0.0, 1.0, 4.0], size=200)
    times = generator.uniform(0.0, 3.0, size=200)
    expected = np.array([-distance_from(SQUARE, point) for point in points])
    for obstacle in obstacles:
        lowest, highest = obstacle.heights
        for row, point in enumerate(points):
            if ground[row] + 1.8 > lowest and ground[row] - 0.1 < highest:
                place = point - times[row] * np.array(obstacle.velocity or (0.0, 0.0))
                expected[row] = min(expected[row], distance_from(obstacle.outline, place) - obstacle.margin)
    world = World(bounds=SQUARE, obstacles=tuple(obstacles))
    assert_allclose(clearances(world, points, ground, times=times), expected, atol=1e-12)
    inside = np.abs(points).max(axis=1) < 5.0
    assert expected[inside].min() < -0.4 and expected[inside].max() > 0.4


def test_the_way_around_a_wall_is_as_long_as_geometry_says():
    world = World(bounds=SQUARE, obstacles=(WALL,))
    start, goal = np.array([2.0, 0.0, -1.0]), np.array([2.0, 0.0, 3.0])
    routes = RouteFinder(world, step=0.4, headroom=1.8).find(start[None], goal[None], radius=0.3)
    (length,) = look_along(routes, start[None]).lengths
    corners = np.array([(-4.4, 1.0), (-4.4, 1.4)])  # radius and margin off the end of the wall
    points = [start[[0, 2]], *corners, goal[[0, 2]]]
    shortest = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert shortest - 0.3 < length < 1.083 * shortest + 4.0 * 0.15, "on a grid"


def test_wandering_keeps_clear_of_everything_for_long():
    places = np.random.default_rng(4).uniform(-4.0, 3.5, size=(8, 2))
    places = places[np.linalg.norm(places - [0.0, -2.0], axis=1) > 1.5]
    trees = tuple(Obstacle(name="/Tree", outline=box_outline(place, place + 0.5)) for place in places)
    world = World(bounds=SQUARE, obstacles=trees)
    plan = walk(world=world, steps=150)
    assert len(plan) == 150
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])[:, [0, 2]]
    assert clearances(world, plan.positions[:, [0, 2]]).min() > RADIUS - 0.1
    assert np.ptp(middles, axis=0).min() > 4.0, "it gets about"


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    one, same, other = walk(steps=30), walk(steps=30), walk(2, steps=30)
    assert (
        one.positions.tobytes() == same.positions.tobytes()
        and one.strike_times.tobytes() == same.strike_times.tobytes()
    )
    assert one.positions.tobytes() != other.positions.tobytes()


def test_many_plans_made_together_are_those_of_each_alone():
    """At random, to goals of their own or of others, by levels, past what moves, who cannot start, in any company."""
    ground = Ground(storeys())
    trees = tuple(Obstacle(name="/Tree", outline=box_outline((x, 2.0), (x + 0.4, 2.4))) for x in (-3.0, -1.0, 1.0, 3.0))
    near, far = np.array([1.0, 0.0, 4.0]), np.array([-3.0, 0.0, -4.0])
    flat = World(bounds=SQUARE, obstacles=trees)
    cases = [
        (
            flat,
            [(0.0, 0.0, 0.0), (3.2, 0.0, 2.2), (0.0, 0.0, -3.0), (2.0, 0.0, -1.0)],
            [[], [], [near, far], [near]],
            None,
        ),
        (World(ground=ground), [(2.0, 0.0, 2.0), (2.0, 0.0, 2.5)], [[np.array([2.0, 2.7, 3.0])], []], None),
        (flat, [(0.0, 0.0, -4.0), (0.5, 0.0, -4.5), (1.0, 0.0, -4.0)], [[], [near], [near]], True),
    ]
    for world, starts, goals, moves in cases:

        def later(time: float, world: World = world) -> World:
            return World(bounds=SQUARE, obstacles=(*world.obstacles, cart_at(time, (1.2, 0.0))))

        count, places = len(starts), np.array(starts, dtype=float)
        yaws, speeds = 0.7 * np.arange(count), np.where(np.arange(count) % 2, 1.0, 0.0)
        how = {"steps": 30, "later": later if moves else None}
        names = [f"/Plan_{number}" for number in range(count)]
        generators = [np.random.default_rng(number) for number in range(count)]
        plans = plan_wanders(world, places, yaws, generators=generators, names=names, goals=goals, speeds=speeds, **how)
        for number, plan in enumerate(plans):
            generator, options = np.random.default_rng(number), WanderOptions(speed=float(speeds[number]))
            own = {"generator": generator, "goals": goals[number], "options": options, "name": names[number], **how}
            if isinstance(plan, PlanError):
                with pytest.raises(PlanError, match="too close"):
                    plan_wander(world, places[number], yaws[number], **own)
                continue
            alone = plan_wander(world, places[number], yaws[number], **own)
            for field in ("sides", "positions", "orientations", "strike_times", "liftoff_times"):
                assert getattr(plan, field).tobytes() == getattr(alone, field).tobytes(), (plan.name, field)
        assert sum(isinstance(plan, PlanError) for plan in plans) == (places[:, 0] == 3.2).sum()


def test_goals_are_reached_around_a_wall_and_it_stands_there():
    world = World(bounds=SQUARE, obstacles=(WALL,))
    goal = np.array([2.0, 0.0, 3.0])
    plan = walk(world=world, goals=[np.array([3.0, 0.0, 0.0]), goal], steps=200)
    assert plan.starts_standing and plan.ends_standing
    assert np.linalg.norm(plan.positions[-2:].mean(axis=0) - goal) <= WanderOptions().arrival + 1e-9
    assert clearances(world, plan.positions[:, [0, 2]]).min() > RADIUS - 0.1


def test_a_footstep_is_known_only_from_the_world_sent_before_it():
    """A wall that appears is avoided from the next step on, and not before."""
    goals = [np.array([0.0, 0.0, 4.0])]
    start, free, walled = np.array([0.0, 0.0, -4.0]), World(bounds=SQUARE), World(bounds=SQUARE, obstacles=(WALL,))
    ways = [wander(free, start, 0.0, generator=np.random.default_rng(3), goals=goals) for _ in range(2)]
    before = [[next(way) for _ in range(5)] for way in ways]
    for one, other in zip(*before, strict=True):
        assert_array_equal(one.position, other.position)
    through, around = list(ways[0]), [ways[1].send(walled), *ways[1]]
    points = np.array([step.position for step in around])[:, [0, 2]]
    assert clearances(walled, points).min() > RADIUS - 0.1
    assert len(around) > len(through)
    assert np.linalg.norm(points[-1] - [0.0, 4.0]) < 0.5


def test_goals_can_move_and_where_one_stands_at_the_last_it_takes_another():
    leader = np.array([(2.5 * np.sin(0.15 * t), 0.0, -2.5 * np.cos(0.15 * t)) for t in range(60)])
    way = wander(World(bounds=SQUARE), np.array([0.0, 0.0, -4.0]), 0.0, generator=np.random.default_rng(3))
    footsteps = [next(way)] + [way.send(News(goals=[place])) for place in leader]
    behind = np.linalg.norm(np.array([step.position for step in footsteps[20:]]) - leader[19:], axis=1)
    assert behind.max() < 1.2, "it follows the leader"
    rest = list(way)
    assert len(rest) < 5 and np.linalg.norm(rest[-1].position - leader[-1]) < 0.5, "and stands where that stops"
    home = wander(World(bounds=SQUARE), leader[0], 0.0, generator=np.random.default_rng(3), goals=[leader[0]])
    last = [next(home) for _ in range(4)]
    back = [home.send(News(goals=[np.zeros(3)])), *home]
    assert np.linalg.norm(last[-1].position - leader[0]) < 0.5 and np.linalg.norm(back[-1].position) < 0.5
    plan = join_footsteps([*last, *back], name="/Plan", ends_standing=True)
    assert lint_steps(plan, Proportions()) == []


def test_at_a_goal_that_gets_shut_in_it_waits_as_near_as_it_gets():
    goal = np.array([0.0, 0.0, 4.0])
    box = Obstacle(name="/Box", outline=box_outline((-0.6, 3.4), (0.6, 4.6)))
    shut, free = World(bounds=SQUARE, obstacles=(box,)), World(bounds=SQUARE)
    way = wander(free, np.array([0.0, 0.0, -4.0]), 0.0, generator=np.random.default_rng(3), goals=[goal])
    footsteps = [next(way), *(way.send(shut) for _ in range(60))]
    places = np.array([step.position for step in footsteps[-20:]])[:, [0, 2]]
    assert np.ptp(places[::2], axis=0).max() < 0.05, "on the spot"
    assert clearances(shut, places).min() > 0.1 and np.linalg.norm(places - goal[[0, 2]], axis=1).max() < 1.6
    *_, last = [way.send(free), *way]
    assert np.linalg.norm(last.position - goal) < 0.5, "when it opens"


def test_it_keeps_off_what_crosses_its_way():
    way = wander(World(bounds=SQUARE), np.array([0.0, 0.0, -4.0]), 0.0, generator=np.random.default_rng(3))
    step, least = next(way), np.inf
    for _ in range(40):
        centre = np.array([-4.0 + 0.3 * step.strike_time, 2.0 * np.sin(0.4 * step.strike_time)])
        world = World(
            bounds=SQUARE, obstacles=(Obstacle(name="/Cart", outline=box_outline(centre - 0.4, centre + 0.4)),)
        )
        step = way.send(world)
        least = min(least, float(clearances(world, step.position[None, [0, 2]])[0]))
    assert least > 0.1


def cart_at(time: float, velocity: tuple[float, float] | None) -> Obstacle:
    """A cart that crosses the way from the left at 1.2 m/s."""
    centre = np.array([-5.0 + 1.2 * time, 0.4])
    return Obstacle(name="/Cart", outline=box_outline(centre - (0.9, 0.5), centre + (0.9, 0.5)), velocity=velocity)


@pytest.mark.parametrize("known", ["given", "measured", "given once"])
def test_what_moves_is_avoided_where_it_will_be(known):
    velocity = {"given": (1.2, 0.0), "measured": None, "given once": (1.2, 0.0)}[known]
    bumped = {velocity: 0, (0.0, 0.0): 0}
    for seed in range(6):
        for said in bumped:
            start, goals = np.array([0.1 * seed - 0.3, 0.0, -4.0]), [np.array([0.1 * seed, 0.0, 4.5])]
            world = World(bounds=SQUARE, obstacles=(cart_at(0.0, said),))
            way = wander(world, start, 0.0, generator=np.random.default_rng(seed), goals=goals)
            step, steps = next(way), 0
            while step is not None and steps < 40:
                place, cart = step.position[None, [0, 2]], cart_at(step.strike_time, None)
                bumped[said] += int(clearances(World(obstacles=(cart,)), place)[0] < 0.0)
                told = None if known == "given once" and said != (0.0, 0.0) else cart_at(step.strike_time, said)
                try:
                    step = way.send(told and World(bounds=SQUARE, obstacles=(told,)))
                except StopIteration:
                    break
                steps += 1
    assert bumped[velocity] == 0 < bumped[(0.0, 0.0)]


def test_strikes_as_they_come_are_those_of_the_plan():
    way = wander(World(bounds=SQUARE), np.zeros(3), 0.0, generator=np.random.default_rng(5), start_time=2.0)
    footsteps = [next(way) for _ in range(12)]
    plan = join_footsteps(footsteps, name="/Plan")
    assert_allclose([step.strike_time for step in footsteps], plan.strike_times, atol=1e-9)


def test_who_is_given_a_speed_goes_at_it():
    """With the steps that people take at that speed, not in slow motion."""
    for speed in (0.4, 0.8, 1.3):
        plan = walk(4, World(), options=WanderOptions(speed=speed, wobble=0.0), steps=12)
        lengths, times = np.linalg.norm(np.diff(plan.positions, axis=0), axis=1)[2:], np.diff(plan.strike_times)[2:]
        assert lengths.sum() / times.sum() == pytest.approx(speed, rel=0.1)
        gait = derive_gait(speed=speed)
        assert np.median(times) == pytest.approx(gait.step_time, rel=0.15)
        assert lengths.max() == pytest.approx(gait.step_length, abs=0.03)


def test_short_steps_in_turns_are_not_hurried_to_keep_a_speed():
    options = WanderOptions(speed=2.6)
    quickest = derive_gait(speed=2.6).step_time
    assert np.diff(walk(4, options=options, steps=60).strike_times)[2:].min() > 0.9 * quickest


def test_it_sets_out_from_a_stand_as_along_a_path_with_the_steps_of_its_habits():
    habits = Habits(walk_ratio=0.009, easy_step=0.7)
    body = Proportions(habits=habits)
    line = WalkingPath(name="/Line", points=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 6.0]]))
    path = plan_path(line, Ground(no_terrain()), proportions=body)
    options = WanderOptions(body=body, wobble=0.0)
    plan = plan_wander(World(), np.zeros(3), 0.0, generator=np.random.default_rng(1), steps=10, options=options)
    swings = [one.strike_times[2] - one.liftoff_times[0] for one in (plan, path)]
    assert swings[0] == pytest.approx(swings[1], abs=0.1), "not in half the time"
    assert plan.liftoff_times[0] == pytest.approx(path.liftoff_times[0], abs=0.05)
    assert_allclose(np.diff(plan.positions[2:, 2]), 0.7 * body.leg_length, rtol=1e-6)
    assert_allclose(np.diff(plan.strike_times[3:-1]), np.diff(path.strike_times)[4], rtol=0.06)


def test_it_stays_on_walkable_ground_and_its_heights():
    terrain = terrain_of(
        [slab((-3.0, 3.0), (-3.0, 3.0), (0.0, 0.6)), slab((3.0, 9.0), (-3.0, 3.0), (0.0, 0.6))], walkable=[True, False]
    )
    plan = walk(world=World(ground=Ground(terrain)), steps=80)
    assert np.abs(plan.positions[:, [0, 2]]).max() < 3.0
    assert_allclose(plan.positions[:, 1], 0.1 * (plan.positions[:, 2] + 3.0), atol=1e-6)


@pytest.mark.parametrize(
    ("terrain", "start", "goal"),
    [
        (bridge(), (5.0, 0.0, 5.0), (0.0, 2.0, 6.0)),
        (bridge(), (5.0, 0.0, 6.0), (-5.0, 0.0, 6.0)),
        (storeys(), (2.0, 0.0, 2.0), (2.0, 2.7, 3.0)),
        (spiral(), (0.4, 0.0, 1.4), (0.4, 4.32, 1.4)),
    ],
    ids=["onto the bridge", "below it", "upstairs", "up the spiral"],
)
def test_the_way_leads_over_ramps_and_stairs_to_the_level_of_the_goal(terrain, start, goal):
    ground, generator = Ground(terrain), np.random.default_rng(1)
    goals = [np.array(goal)]
    plan = plan_wander(World(ground=ground), np.array(start), 0.0, generator=generator, goals=goals, steps=80)
    assert plan.ends_standing
    assert_allclose(plan.positions[-2:].mean(axis=0), goal, atol=0.35)
    assert lint_plans([plan], ground, bodies=[Proportions()]) == [], "on the ground, off the edges, no leaps"


FROM_ANYWHERE = {
    "onto the bridge": (bridge(), (-6.0, 6.0, 0.0, 14.0, 0.0), (-0.5, 0.5, 5.0, 7.0, 2.0)),
    "off the bridge": (bridge(), (-0.6, 0.6, 4.2, 7.8, 2.0), (-6.0, 6.0, 0.0, 14.0, 0.0)),
    "upstairs": (storeys(), (0.5, 7.5, -0.5, 5.5, 0.0), (0.5, 7.5, -0.5, 5.5, 2.7)),
    "downstairs": (storeys(), (0.5, 7.5, -0.5, 5.5, 2.7), (0.5, 7.5, -0.5, 5.5, 0.0)),
}


def places_in(area, count, generator):
    (x0, x1, z0, z1, height) = area
    return np.stack(
        [generator.uniform(x0, x1, count), np.full(count, height), generator.uniform(z0, z1, count)], axis=1
    )


@pytest.mark.parametrize("way", list(FROM_ANYWHERE))
def test_from_anywhere_plans_over_ramps_and_stairs_have_no_fault_or_say_why_there_is_none(way, generator):
    terrain, begin, end = FROM_ANYWHERE[way]
    ground, count, body = Ground(terrain), 30, Proportions()
    starts, goals = places_in(begin, count, generator), places_in(end, count, generator)
    generators, names = generator.spawn(count), [f"/Plan_{number}" for number in range(count)]
    yaws = generator.uniform(-np.pi, np.pi, count)
    for aims in ([[goal] for goal in goals], None):
        plans = plan_wanders(
            World(ground=ground), starts, yaws, generators=generators, names=names, goals=aims, steps=120
        )
        made = [plan for plan in plans if not isinstance(plan, PlanError)]
        assert len(made) >= 0.8 * count
        assert all("room" in plan.what or "reached" in plan.what for plan in plans if isinstance(plan, PlanError))
        assert aims is None or all(plan.ends_standing for plan in made), "everybody arrives"
        alone = [fault for fault in lint_plans(made, ground, bodies=[body] * len(made)) if fault.kind != "collision"]
        assert alone == []


def test_stairs_are_climbed_tread_by_tread():
    terrain, start, goal = Ground(storeys()), np.array([9.0, 0.0, -0.6]), np.array([9.0, 2.7, 5.5])
    plan = plan_wander(World(ground=terrain), start, 0.0, generator=np.random.default_rng(1), goals=[goal], steps=60)
    assert_allclose(np.unique(np.diff(plan.positions[:, 1]).round(6)), [0.0, 0.18])
    assert len(plan) < 28, "and not stood on with both feet"


def test_who_cannot_stand_under_something_is_refused_and_goes_round_it():
    ground = Ground(bridge())
    with pytest.raises(PlanError, match=r"start \(0\.00, 2\.50\) m.*a foot has only 1\.\d\d m of room above it"):
        plan_wander(World(ground=ground), np.array([0.0, 0.0, 2.5]), 0.0, generator=np.random.default_rng(1))
    start, far = np.array([-4.0, 0.0, 2.5]), np.array([4.0, 0.0, 2.5])
    plan = plan_wander(World(ground=ground), start, 0.0, generator=np.random.default_rng(1), goals=[far], steps=90)
    assert plan.ends_standing
    assert lint_plans([plan], ground, bodies=[Proportions()]) == []


def test_who_starts_on_an_edge_stands_with_both_feet_beside_it():
    ground = Ground(terrain_of([slab((-4.0, 0.0), (-4.0, 4.0), (0.0, 0.0)), slab((0.0, 4.0), (-4.0, 4.0), (0.2, 0.2))]))
    for place in (-0.1, -0.04, 0.0, 0.04, 0.1):
        for yaw in (0.0, 0.4, 1.2):
            start, generator = np.array([place, 0.2 * (place >= 0.0), 0.0]), np.random.default_rng(1)
            plan = plan_wander(World(ground=ground), start, yaw, generator=generator, steps=4)
            assert np.linalg.norm((plan.positions[:2].mean(axis=0) - start)[[0, 2]]) < 0.35
            assert lint_plans([plan], ground, bodies=[Proportions()]) == []


def test_an_obstacle_below_or_above_is_in_nobodys_way():
    ground = Ground(bridge())
    box = Obstacle(name="/Car", outline=box_outline((-3.0, 5.0), (3.0, 7.0)), heights=(0.0, 1.5))
    goal, generator = np.array([0.0, 2.0, 7.5]), np.random.default_rng(1)
    world = World(ground=ground, obstacles=(box,))
    plan = plan_wander(world, np.array([0.0, 2.0, 4.5]), 0.0, generator=generator, goals=[goal], steps=20)
    assert plan.ends_standing, "over the car on the bridge"
    below = [np.array([4.0, 0.0, 6.0])]
    around = plan_wander(world, np.array([-4.0, 0.0, 6.0]), 0.0, generator=generator, goals=below, steps=80)
    assert clearances(world, around.positions[:, [0, 2]]).min() > RADIUS - 0.1, "around it on the ground"


@pytest.mark.parametrize(("width", "is_sideways"), [(0.5, True), (0.7, False)])
def test_it_side_steps_where_the_only_way_is_narrower_than_its_body(width, is_sideways):
    half = 0.5 * width
    walls = [box_outline((-5.0, 0.0), (-half, 1.5)), box_outline((half, 0.0), (5.0, 1.5))]
    obstacles = tuple(Obstacle(name=f"/Wall_{i}", outline=outline) for i, outline in enumerate(walls))
    world = World(bounds=SQUARE, obstacles=obstacles)
    goal = np.array([1.0, 0.0, 4.0])
    plan = walk(world=world, goals=[goal], steps=200)
    assert plan.ends_standing and np.linalg.norm((plan.positions[-2:].mean(axis=0) - goal)[[0, 2]]) < 0.4
    assert lint_steps(plan, Proportions()) == []
    inside = (plan.positions[:, 2] > 0.1) & (plan.positions[:, 2] < 1.4)
    assert np.all(np.abs(np.sin(plan.yaws[inside])) > 0.9) == is_sideways
    assert np.abs(np.sin(plan.yaws[-3:])).max() < 0.9, "it looks ahead again"
    ends = plan.positions[inside][:, [0, 2]] + np.array([-0.19, 0.0, 0.09])[:, None, None] * planar.direction(
        plan.yaws[inside]
    )
    assert clearances(World(obstacles=obstacles), ends.reshape(-1, 2)).min() > 0.0


def test_a_goal_on_a_level_nothing_leads_to_is_named():
    attic = terrain_of([slab((-5.0, 5.0), (-5.0, 5.0), (0.0, 0.0)), slab((-5.0, 5.0), (-5.0, 5.0), (3.0, 3.0))])
    with pytest.raises(PlanError, match=r"goal \(3\.00, 1\.00\) m, height 3\.00 m: cannot be .* a ramp or stairs"):
        walk(world=World(ground=Ground(attic)), goals=[np.array([3.0, 3.0, 1.0])])


def test_what_cannot_be_is_said():
    world = World(bounds=SQUARE, obstacles=(WALL,))
    closed = World(bounds=SQUARE, obstacles=(Obstacle(name="/Bar", outline=box_outline((-5.0, 1.0), (5.0, 1.4))),))
    with pytest.raises(PlanError, match=r"goal \(0\.00, 1\.20\) m: is within 0\.30 m of the obstacle /Wall"):
        walk(world=world, goals=[np.array([0.0, 0.0, 1.2])])
    with pytest.raises(PlanError, match=r"goal: is at .* three finite numbers"):
        walk(world=world, goals=[np.array([np.nan, 0.0, 0.0])])
    with pytest.raises(PlanError, match=r"goal: is at .* three finite numbers"):
        walk(world=world, goals=[np.zeros(2), np.zeros(2), np.zeros(2)])
    with pytest.raises(PlanError, match="outside the bounds"):
        walk(world=world, goals=[np.array([7.0, 0.0, 0.0])])
    with pytest.raises(PlanError, match="cannot be reached from"):
        walk(world=closed, goals=[np.array([0.0, 0.0, 3.0])])
    with pytest.raises(PlanError, match=r"start .* too close to an obstacle"):
        plan_wander(world, np.array([0.0, 0.0, 1.2]), 0.0, generator=np.random.default_rng(0))
    with pytest.raises(PlanError, match=r"wander: has 1 footstep"):
        walk(steps=1)
