"""Plans along paths: what was asked for on level ground, symmetry, treads, levels."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import no_terrain
from tests.planning.terrains import bridge, slab, spiral, terrain_of
from usdfoot.analysis.timing import TimingRule
from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.planning.footholds import find_footholds, find_walls, firm_ends, foot_places, tread_steps
from usdfoot.planning.gait import derive_gait, natural_lengths
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.path import PathOptions, plan_path, plan_paths
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.ways import lay_ways

LEVEL = Ground(terrain_of([slab((-60.0, 60.0), (-60.0, 60.0), (0.0, 0.0))]))
ANGLES = np.linspace(0.0, 2.0 * np.pi, 400)


def straight(length=20.0, **options):
    return WalkingPath(name="/Path", points=np.array([(0.0, 0.0, 0.0), (0.0, 0.0, length)]), **options)


def circle(radius, **options):
    ground = radius * planar.direction(ANGLES)
    return WalkingPath(name="/Circle", points=np.insert(ground, 1, 0.0, axis=1), **options)


def test_speed_step_length_and_width_are_kept_on_a_straight_path():
    plan = plan_path(straight(speed=1.2, step_length=0.6, step_width=0.14), LEVEL)
    middle = slice(5, -5)
    lengths, times = np.diff(plan.positions[:, 2])[middle], np.diff(plan.strike_times)[middle]
    assert_allclose(lengths, 0.6, rtol=0.03)
    assert_allclose(lengths / times, 1.2, rtol=1e-6)
    assert_allclose(np.abs(plan.positions[:, 0]), 0.07, atol=1e-9)
    assert np.all((plan.positions[:, 0] > 0.0) == (plan.sides == 0))


@pytest.mark.parametrize(("starts", "ends"), [(True, True), (False, True), (True, False), (False, False)])
def test_stances_at_start_and_end(starts, ends):
    options = PathOptions(starts_standing=starts, ends_standing=ends, first_side=1)
    plan = plan_path(straight(5.0, start_time=3.0), LEVEL, options=options)
    assert (plan.starts_standing, plan.ends_standing) == (starts, ends)
    assert plan.strike_times[0] == 3.0
    assert plan.sides[2 if starts else 1] == 1
    assert_allclose(plan.positions[0, 2], 0.0, atol=1e-9)
    assert_allclose(plan.positions[-1, 2], 5.0, atol=1e-9)


def test_a_walk_has_double_support_and_a_run_has_flight():
    walk, run = plan_path(straight(speed=1.3), LEVEL), plan_path(straight(speed=3.0), LEVEL)
    overlap = [plan.liftoff_times[6:-6] - plan.strike_times[7:-5] for plan in (walk, run)]
    assert np.all(overlap[0] > 0.05)
    assert np.all(overlap[1] < -0.05)


def test_steps_become_shorter_in_curves_and_on_slopes_both_ways():
    wide, narrow = (np.diff(plan_path(circle(r), LEVEL).strike_times).size / r for r in (6.0, 1.0))
    assert narrow > 1.2 * wide  # steps a metre
    ramp = Ground(terrain_of([slab((-9.0, 9.0), (-1.0, 21.0), (0.0, 6.6))]))
    up = plan_path(straight(), ramp)
    down = plan_path(WalkingPath(name="/Down", points=np.array([(0.0, 6.3, 20.0), (0.0, 0.0, 0.0)])), ramp)
    assert len(up) > 1.3 * len(plan_path(straight(), LEVEL))
    assert len(down) > 1.3 * len(plan_path(straight(), LEVEL))


@pytest.mark.parametrize("speed", [1.3, 3.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_steeper_the_shorter_also_where_it_is_too_steep_to_stand(speed, way):
    lengths = []
    for slope in way * np.tan(np.radians(np.arange(1.0, 50.0, 4.0))):
        ramp = Ground(terrain_of([slab((-9.0, 9.0), (-1.0, 13.0), (-slope, 13.0 * slope))]))
        path = WalkingPath(name="/Up", points=np.array([(0.0, 0.0, 0.0), (0.0, 12.0 * slope, 12.0)]), speed=speed)
        lengths.append(np.diff(plan_path(path, ramp).positions[:, 2])[2:-2].mean())
    assert np.all(np.diff(lengths) <= 0.06 * lengths[-1])  # treads are looked for at every 0.035 of a step
    assert lengths[-1] < 0.4 * lengths[0]


@pytest.mark.parametrize("speed", [1.4, 2.2, 3.0])
def test_who_turns_slows_down_in_time(speed):
    turn = np.linspace(0.0, np.pi, 40)
    arc = np.stack([-np.cos(turn), 0.0 * turn, np.sin(turn)], axis=1)
    hairpin = np.concatenate([[(-1.0, 0.0, -9.0)], arc, [(1.0, 0.0, -9.0)]])
    plan = plan_path(WalkingPath(name="/Hairpin", points=hairpin, speed=speed), LEVEL)
    lengths = np.linalg.norm(np.diff(plan.positions, axis=0), axis=1)[2:-2]
    speeds = lengths / np.diff(plan.strike_times)[2:-2]
    assert speeds.min() < 0.6 * speed
    assert speeds.max() > 0.95 * speed
    braking = np.abs(np.diff(speeds**2)) / (lengths[1:] + lengths[:-1])
    assert braking.max() < 2.0


def test_feet_have_time_to_swing_up_and_down_however_short_the_way():
    def swings(plan):
        return plan.strike_times[2:] - plan.liftoff_times[:-2]

    block = Ground(terrain_of([slab((-9.0, 9.0), (-9.0, 0.6), (0.0, 0.0)), slab((-9.0, 9.0), (0.6, 9.0), (0.3, 0.3))]))
    up = plan_path(straight(1.4, speed=1.9), block)
    rises = up.positions[2:, 1] - up.positions[:-2, 1]
    assert swings(up)[rises > 0.1].min() > 0.5 > 0.39 > swings(plan_path(straight(8.0, speed=1.9), LEVEL)).min()


def test_on_treads_no_step_is_quicker_than_the_quickest_however_short():
    """Stones at odd distances: steps from one to the next are shorter than the path asks for."""
    starts = np.cumsum([0.0, 0.5, 0.42, 0.5, 0.38, 0.5, 0.44, 0.4, 0.5, 0.45])
    stones = Ground(terrain_of([slab((-0.4, 0.4), (z, z + 0.3), (0.1, 0.1)) for z in starts]))
    times = [
        np.diff(plan_path(straight(4.3, speed=0.9, step_length=0.45, quickest_step=quickest), stones).strike_times)[
            2:-1
        ]
        for quickest in (0.0, 0.5)
    ]
    assert times[0].min() < 0.49 and times[1].min() == pytest.approx(0.5)
    assert_allclose(times[1], np.maximum(times[0], 0.5))


def test_a_foot_that_swings_over_a_beam_has_time_for_its_height():
    """A beam 0.16 m high and 0.1 m wide, too narrow to stand on, across the way of a quick walker."""
    level = slab((-5.0, 5.0), (-10.0, 10.0), (0.0, 0.0))
    beam = slab((-5.0, 5.0), (4.0, 4.1), (0.16, 0.16))
    plan, flat = (plan_path(straight(8.0, speed=1.6), Ground(terrain_of(quads))) for quads in ([level, beam], [level]))
    over = 2 + np.flatnonzero((plan.positions[:-2, 2] < 4.0) & (plan.positions[2:, 2] > 4.1))
    swings, plain = (each.strike_times[2:] - each.liftoff_times[:-2] for each in (plan, flat))
    assert len(over) == 2 and plan.positions[:, 1].max() < 1e-9
    assert swings[over - 2].min() > np.median(plain) + 0.12


def test_plans_turn_and_move_with_their_path():
    turn, shift = 1.1, np.array([3.0, 0.0, -2.0])
    path = circle(4.0, speed=1.1)
    moved = WalkingPath(
        name="/Moved", speed=1.1, points=quaternion.rotate(quaternion.yaw_quaternion(turn), path.points) + shift
    )
    plan, other = plan_paths([path, moved], LEVEL)
    turned = quaternion.rotate(quaternion.yaw_quaternion(turn), plan.positions) + shift
    assert_allclose(other.positions, turned, atol=1e-6)
    assert_allclose(planar.wrap_angle(other.yaws - plan.yaws - turn), 0.0, atol=1e-6)
    assert_allclose(other.strike_times, plan.strike_times, atol=1e-9)


@pytest.mark.parametrize("stands", [True, False])
def test_a_plan_in_a_batch_is_the_plan_alone(stands):
    stairs = terrain_of([slab((-60.0, 60.0), (-60.0, 0.4), (0.0, 0.0)), *treads(0.15, 0.3, 5)])
    ground = Ground(stairs)
    paths = [straight(9.0), circle(2.0), straight(2.1, speed=0.8), circle(5.0, speed=2.5)]
    options = PathOptions(starts_standing=stands)
    for path, plan in zip(paths, plan_paths(paths, ground, options=options), strict=True):
        alone = plan_path(path, ground, options=options)
        assert_allclose(plan.positions, alone.positions, atol=1e-7)
        assert_allclose(plan.strike_times, alone.strike_times, atol=1e-7)


def treads(rise, depth, count):
    """Stairs from z = 0.4 upward, the last tread a landing."""
    edges = 0.4 + depth * np.arange(count + 1)
    edges[-1] = 40.0
    return [slab((-9.0, 9.0), (edges[i], edges[i + 1]), ((i + 1) * rise,) * 2) for i in range(count)]


@pytest.mark.parametrize(("rise", "depth"), [(0.15, 0.30), (0.18, 0.28), (0.12, 0.36)])
@pytest.mark.parametrize("downward", [False, True])
def test_on_stairs_one_foot_falls_on_each_tread_and_no_heel_in_a_riser(rise, depth, downward):
    stairs = treads(rise, depth, 6)
    ground = Ground(terrain_of([slab((-9.0, 9.0), (-9.0, 0.4), (0.0, 0.0)), *stairs]))
    points = np.array([(0.0, 0.0, -2.0), (0.0, 0.0, 5.0)])
    plan = plan_path(WalkingPath(name="/Stairs", points=points[::-1] if downward else points), ground)
    on = np.floor((plan.positions[:, 2] - 0.4) / depth)
    for tread in range(5):
        assert np.count_nonzero(on == tread) == 1
    facing = planar.direction(plan.yaws)
    for ahead in (-Proportions().heel, Proportions().toe):
        ends = plan.positions[:, [0, 2]] + ahead * facing
        above = ground.heights(ends, plan.positions[:, 1]).heights - plan.positions[:, 1]
        assert above.max() < 0.02


def test_past_the_corner_of_a_block_no_corner_of_a_sole_is_in_it():
    ground = Ground(
        terrain_of([slab((-9.0, 9.0), (-9.0, 9.0), (0.0, 0.0)), slab((-2.0, 0.0), (-2.0, 0.0), (0.2, 0.2))])
    )
    offsets, body = np.linspace(-0.3, 0.3, 31), Proportions()
    ways = [np.array([(shift - 2.0, 0.0, shift + 2.0), (shift + 2.0, 0.0, shift - 2.0)]) for shift in offsets]
    for plan in plan_paths([WalkingPath(name="/Past", points=way) for way in ways], ground):
        forward, left = planar.direction(plan.yaws), planar.direction(plan.yaws + 0.5 * np.pi)
        for ahead in (-body.heel, body.toe):
            for across in (-body.half_width, body.half_width):
                corners = plan.positions[:, [0, 2]] + ahead * forward + across * left
                inside = (np.abs(corners + 1.0) < 1.0 - 1e-6).all(axis=1)
                assert not (inside & (plan.positions[:, 1] < 0.1)).any()


def climbed(heights, before, sample, side):
    """From the lower foot to the highest that is stepped over or on."""
    feet = [heights[before, 1 - side], heights[sample, side]]
    return max([*feet, *heights[before + 1 : sample].ravel()]) - min(feet)


def twisted(ways, before, sample, side, footholds, body):
    """What feet that cross and far turns cost; samples are those of all ways."""
    width = 0.5 * (footholds.widths[sample, side] + footholds.widths[before, 1 - side])
    turn = ways.headings[sample] - ways.headings[before]
    left = planar.direction(ways.headings[before] + 0.5 * turn + 0.5 * np.pi)
    apart = (1.0 - 2.0 * side) * (ways.points[sample] - ways.points[before]) @ left + width * np.cos(0.5 * turn)
    return (max(-apart, 0.0) / (0.25 * body.foot_length)) ** 2 + (max(abs(turn) - 0.9, 0.0) / 0.9) ** 2


def relative(arcs, wanted, before, sample):
    """How long a step is over how long it should be."""
    return (arcs[sample] - arcs[before]) / (0.5 * (wanted[before] + wanted[sample]))


def test_treads_are_the_cheapest_way_over_samples_and_feet():
    """Against a search over the graph of all steps, edge by edge."""
    ridge = slab((-9.0, 9.0), (1.95, 2.05), (1.3, 1.3))
    ground = Ground(terrain_of([slab((-9.0, 9.0), (-9.0, 0.4), (0.0, 0.0)), *treads(0.17, 0.3, 5), ridge]))
    gait, body = derive_gait(), Proportions()
    bent = WalkingPath(
        name="/Bent", points=np.array([(0.0, 0.0, 0.0), (0.3, 0.0, 0.6), (-0.2, 0.0, 0.9), (0.4, 0.0, 1.6)])
    )
    ways = lay_ways([straight(2.4), bent], [gait, gait], ground)
    footholds = find_footholds(ways, [gait, gait], [body, body], ground=ground)
    ends = firm_ends(ways, footholds, [gait, gait])
    taken = tread_steps(
        ways,
        footholds,
        [gait, gait],
        bodies=[body, body],
        walls=np.full((len(ways.arcs), 2), np.inf),
        ends=ends,
        support=1,
    )
    for way in (0, 1):
        own = slice(int(ways.first[way]), int(ways.first[way + 1]))
        arcs, wanted = ways.arcs[own], gait.step_length * ways.shares[own]
        costs, heights, (start, goal) = footholds.costs[own], footholds.heights[own], ends[way]
        least = max(1, int(0.25 * wanted.min() / arcs[1]))
        best = {(int(start), 1): (0.0, [])}
        for sample in range(start + 1, len(arcs)):
            for side in (0, 1):
                reached = [
                    (
                        best[before, 1 - side][0]
                        + 1e-3
                        + (relative(arcs, wanted, before, sample) - 1.0) ** 2
                        + (climbed(heights, before, sample, side) / (0.22 * body.leg_length)) ** 4
                        + costs[sample, side]
                        * (max(relative(arcs, wanted, before, sample), 1.0) if costs[sample, side] >= 100.0 else 1.0)
                        + twisted(ways, own.start + before, own.start + sample, side, footholds, body),
                        [*best[before, 1 - side][1], sample],
                    )
                    for before in range(start, sample - least + 1)
                    if (before, 1 - side) in best and arcs[sample] - arcs[before] <= 1.7 * gait.step_length
                ]
                if reached:
                    best[sample, side] = min(reached)
        _, steps = min(best[int(goal), side] for side in (0, 1) if (int(goal), side) in best)
        assert_allclose(taken[ways.rows[taken] == way] - ways.first[way], steps)


def test_treads_are_chosen_so_that_no_foot_swings_through_the_corner_of_a_wall():
    corner = slab((0.18, 3.0), (-3.0, -0.18), (0.7, 0.7))
    ground = Ground(terrain_of([slab((-3.0, 3.0), (-3.0, 3.0), (0.0, 0.0)), corner]))
    gait, body = derive_gait(), Proportions()
    points = np.array([(0.0, 0.0, -0.9), (0.0, 0.0, -0.15), (0.03, 0.0, -0.03), (0.15, 0.0, 0.0), (0.9, 0.0, 0.0)])
    ways = lay_ways([WalkingPath(name="/Round", points=points)], [gait], ground)
    footholds, through = find_footholds(ways, [gait], [body], ground=ground), []
    ends = firm_ends(ways, footholds, [gait])
    for walls in (np.full((len(ways.arcs), 2), np.inf), find_walls(ways, ground)):
        treads = tread_steps(ways, footholds, [gait], bodies=[body], walls=walls, ends=ends, support=1)
        treads = np.concatenate([ends[[0, 0], 0], treads])
        sides = np.arange(len(treads)) % 2
        widths, outward = footholds.widths[treads, sides], np.zeros(len(treads))
        places, _ = foot_places(ways.points[treads], ways.headings[treads], sides, widths=widths, toe_out=outward)
        swings = np.linspace(places[:-2], places[2:], 30).reshape(-1, 2)
        through.append((ground.heights(swings, np.ones(len(swings))).heights > 0.1).sum())
    assert through[0] > 0 and through[1] == 0


@pytest.mark.parametrize("speed", [0.9, 1.4, 2.2])
@pytest.mark.parametrize("ground", [LEVEL, Ground(no_terrain())])
def test_on_hairpins_wiggles_and_corners_feet_do_not_cross(speed, ground):
    turn = np.linspace(0.0, np.pi, 30)
    hairpin = [(-0.25, -3.0), *np.stack([-0.25 * np.cos(turn), 0.25 * np.sin(turn)], axis=1), (0.25, -3.0)]
    along = np.linspace(-3.0, 3.0, 200)
    wiggle = np.stack([0.3 * np.sin(4.0 * along), along], axis=1)
    zigzag = [(-2.0, -3.0), (2.0, -2.0), (-2.0, -1.0), (2.0, 0.0)]
    lines = [np.insert(np.array(line), 1, 0.0, axis=1) for line in (hairpin, wiggle, zigzag)]
    paths = [WalkingPath(name=f"/P{i}", points=line, speed=speed) for i, line in enumerate(lines)]
    body = Proportions(leg_length=0.8, foot_length=0.09, heel=0.13, hip_width=0.14)
    for plan in plan_paths(paths, ground, proportions=[body] * 3):
        assert lint_plans([plan], ground, bodies=[body]) == []


def test_levels_are_followed_over_and_under_the_bridge_and_up_the_spiral():
    ground = Ground(bridge())
    over = plan_path(WalkingPath(name="/Over", points=np.array([(0.0, 0.0, -2.0), (0.0, 0.0, 14.0)])), ground)
    assert over.positions[:, 1].max() == pytest.approx(2.0)
    under = plan_path(WalkingPath(name="/Under", points=np.array([(-6.0, 0.0, 6.0), (6.0, 0.0, 6.0)])), ground)
    assert_allclose(under.positions[:, 1], 0.0, atol=1e-9)
    angles = np.linspace(0.1, 2.4 * 2.0 * np.pi, 500)
    stair = WalkingPath(name="/Spiral", points=np.insert(1.5 * planar.direction(angles), 1, 0.0, axis=1))
    plan = plan_path(stair, Ground(spiral(steps=24, rise=0.12)))
    climbs = np.diff(plan.positions[:, 1])
    assert plan.positions[-1, 1] > 0.95 * 2.4 * 24 * 0.12
    assert climbs.min() > -1e-6 and climbs.max() < 0.4


def test_paths_too_short_or_empty_are_refused():
    with pytest.raises(PlanError, match=r"/Path.*zero length"):
        straight(0.0)
    with pytest.raises(PlanError, match=r"/Path.*less than a step"):
        plan_path(straight(0.05), LEVEL)
    with pytest.raises(PlanError, match=r"/Path.*is 1e\+30 m long, more than 100000 m"):
        plan_path(straight(1e30), LEVEL)
    with pytest.raises(PlanError, match=r"/Path.*takes 1e\+07 steps of 1e-06 m, more than 100000. .*stepLength"):
        plan_path(straight(10.0, step_length=1e-6), LEVEL)
    with pytest.raises(PlanError, match="speed is -1"):
        straight(speed=-1.0)
    with pytest.raises(PlanError, match=r"/Path.*takes more than 100000 steps at 1e-05 m/s\. .*speed"):
        plan_path(straight(speed=1e-5), LEVEL)
    assert len(plan_path(straight(0.3), LEVEL)) == 4


def test_who_runs_faster_steps_longer_and_quicker_as_people_do():
    """Their stride frequency is 0.026 v^2 - 0.111 v + 1.398 a second at v m/s (Minetti 1998)."""
    speeds = np.linspace(2.5, 6.0, 36)  # beyond 4 m/s as well, which single leaps do not reach
    lengths = natural_lengths(speeds, TimingRule())
    assert np.all(np.diff(lengths) > 0.0)
    people = 2.0 * np.polyval([0.026, -0.111, 1.398], speeds)
    assert_allclose(speeds / lengths, people, rtol=0.055)
    small = natural_lengths(0.5 * speeds, TimingRule(leg_length=0.25 * TimingRule().leg_length))
    assert_allclose(small, 0.25 * lengths)  # equal Froude numbers


def test_what_is_not_given_follows_from_the_body():
    child, adult = (derive_gait(Proportions(leg_length=leg)) for leg in (0.43, 0.86))
    assert child.step_length == pytest.approx(0.5 * adult.step_length)
    assert child.speed**2 / 0.43 == pytest.approx(adult.speed**2 / 0.86)  # equal Froude numbers
    assert derive_gait(speed=1.0, step_length=0.5).step_time == pytest.approx(0.5)
