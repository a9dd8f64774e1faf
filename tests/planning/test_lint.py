"""Lint: a good plan has no fault, each kind of fault is found where it was made, and what can be mended is."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.planning.terrains import slab, terrain_of
from usdfoot.errors import PlanError
from usdfoot.maths import quaternion
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.faults import LintLimits
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.mend import mend_plans, mend_times
from usdfoot.planning.prints import print_orientations
from usdfoot.planning.proportions import Proportions

LEVEL = terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (0.0, 0.0))])
BODY = Proportions()


def faults(*plans, terrain=LEVEL, limits=None):
    return lint_plans(plans, Ground(terrain), bodies=[BODY] * len(plans), limits=limits)


def moved(plan, index, offset):
    positions = plan.positions.copy()
    positions[index] += offset
    return replace(plan, positions=positions)


def test_times_that_would_fill_all_memory_are_named():
    plan = way(10)
    late = np.where(np.arange(len(plan)) == len(plan) - 1, 1e7, 0.0)
    stray = replace(plan, strike_times=plan.strike_times + late, liftoff_times=plan.liftoff_times + late)
    with pytest.raises(PlanError, match=f"footstep {len(plan) - 3} of plan 1, .* correct its times"):
        faults(plan, stray)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"length": 0.9, "step_time": 0.4, "duty": 0.4},
        {"turn": 0.4, "length": 0.3},
        {"length": 0.0, "turn": 0.5},
        {"length": -0.4},
        {"sideways": 0.1, "length": 0.2},
        {"stand_first": 0.5, "stand_last": 0.5},
    ],
)
def test_walks_runs_turns_and_stands_are_clean(options):
    assert not faults(way(10, **options))


@pytest.mark.parametrize(
    ("offset", "kind"),
    [
        ((0.0, 0.0, 1.2), "unreachable"),
        ((0.0, 0.1, 0.0), "offGround"),
        ((-0.4, 0.0, 0.0), "crossing"),
        ((19.0, 0.0, 19.0), "offTerrain"),
    ],
)
def test_a_footstep_elsewhere_is_found(offset, kind):
    plan = moved(way(9), 4, offset)
    found = {(fault.footstep, fault.kind) for fault in faults(plan)}
    assert (4, kind) in found
    assert {footstep for footstep, _ in found} <= {4, 5}


@pytest.mark.parametrize(("rise", "word"), [(0.6, "above"), (-0.6, "below")])
def test_what_is_too_low_is_not_told_as_negatively_high(rise, word):
    plan = moved(way(9), 4, (0.0, rise, 0.0))
    told = [fault.message for fault in faults(plan) if (fault.footstep, fault.kind) == (4, "offGround")]
    assert told == [f"is 0.60 m {word} the ground"]
    told = [fault.message for fault in faults(plan) if (fault.footstep, fault.kind) == (4, "unreachable")]
    assert told == [f"is 0.60 m {word} the footstep before it"]


@pytest.mark.parametrize(("step_time", "kinds"), [(0.26, []), (0.175, ["hurried"] * 8)])
def test_walking_steps_quicker_than_gravity_allows_are_found(step_time, kinds):
    plan = way(9, length=0.7, step_time=step_time, duty=0.6)
    found = faults(plan)
    assert [fault.kind for fault in found if fault.severity == "error"] == kinds
    assert all("m/s without flight, faster than anyone walks" in fault.message for fault in found)


def test_steps_are_out_of_reach_by_the_length_of_the_legs():
    plan = way(9, length=0.8, step_time=0.6)
    child = Proportions(leg_length=0.43)
    assert {fault.kind for fault in lint_plans([plan], Ground(LEVEL), bodies=[child])} == {"unreachable"}
    assert not faults(plan)


def test_legs_span_farther_where_the_hips_are_wide():
    plan = way(9, length=0.6, width=0.45, step_time=0.6)
    for hips, kinds in ((0.18, {"unreachable"}), (0.45, set())):
        body = Proportions(leg_length=0.43, hip_width=hips)
        assert {fault.kind for fault in lint_plans([plan], Ground(LEVEL), bodies=[body])} & {"unreachable"} == kinds


def test_soles_that_lie_along_a_slope_have_no_ground_in_them():
    hill = terrain_of([slab((-9.0, 9.0), (-9.0, 9.0), (-6.3, 6.3))])
    plan = way(8)
    raised = replace(plan, positions=plan.positions + 0.7 * plan.positions[:, [2, 2, 2]] * [0.0, 1.0, 0.0])
    normals = np.tile([0.0, 1.0, -0.7], (8, 1)) / np.hypot(1.0, 0.7)
    assert {fault.kind for fault in faults(raised, terrain=hill)} == {"obstructed"}
    assert not faults(replace(raised, orientations=print_orientations(plan.yaws, normals)), terrain=hill)


def test_steep_ground_walls_and_water_are_found():
    plan = way(8, length=0.3)
    slope = slab((-9.0, 9.0), (-1.0, 5.0), (-1.0, 5.0))
    on_slope = replace(plan, positions=plan.positions * [1, 0, 1] + plan.positions[:, [2, 2, 2]] * [0, 1, 0])
    laid = replace(on_slope, orientations=print_orientations(plan.yaws, np.tile([0.0, 0.5**0.5, -(0.5**0.5)], (8, 1))))
    assert {fault.kind for fault in faults(laid, terrain=terrain_of([slope]))} == {"steep"}
    plan = way(8)
    water = terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (0.0, 0.0))], walkable=[False])
    assert {fault.kind for fault in faults(plan, terrain=water)} == {"offTerrain"}
    z = float(plan.positions[4, 2]) - 0.1
    step = terrain_of([slab((-9.0, 9.0), (-9.0, z), (0.15, 0.15)), slab((-9.0, 9.0), (z, 20.0), (0.0, 0.0))])
    heights = np.where(plan.positions[:, 2] < z, 0.15, 0.0)
    down = replace(plan, positions=plan.positions + heights[:, None] * [0.0, 1.0, 0.0])
    assert [(fault.footstep, fault.kind) for fault in faults(down, terrain=step)] == [(4, "obstructed")]
    x, z = plan.positions[4, [0, 2]] + (0.8 * BODY.half_width, -0.9 * BODY.heel)
    block = slab((x, x + 0.02), (z - 0.02, z), (0.15, 0.15))
    beside = terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (0.0, 0.0)), block])
    assert [(fault.footstep, fault.kind) for fault in faults(plan, terrain=beside)] == [(4, "obstructed")], "its corner"


def test_feet_that_swing_over_walls_are_found():
    plan = way(8)
    z = 0.5 * float(plan.positions[2, 2] + plan.positions[4, 2])
    for height, found in ((0.4, []), (0.7, [4, 5])):
        wall = slab((-9.0, 9.0), (z - 0.08, z + 0.08), (height, height))
        over = faults(plan, terrain=terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (0.0, 0.0)), wall]))
        swings = [fault for fault in over if "swings over" in fault.message]
        assert {fault.footstep for fault in swings} >= set(found[:1])
        assert {fault.kind for fault in swings} == ({"obstructed"} if found else set())
        assert all(fault.message.startswith(f"swings over ground {height:.2f} m above") for fault in swings)
    roof = slab((-9.0, 9.0), (z - 0.08, z + 0.08), (2.2, 2.2))
    assert not faults(plan, terrain=terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (0.0, 0.0)), roof]))


def test_flights_nobody_can_make_and_swings_nobody_has_time_for():
    run = way(9, length=0.9, step_time=0.4, duty=0.4)
    long = replace(run, positions=run.positions * [1, 1, 5] - [0, 0, 18])
    assert {fault.kind for fault in faults(long)} == {"flight"}
    strikes = run.strike_times + np.where(np.arange(9) > 4, 1.5, 0.0)
    later = replace(run, strike_times=strikes, liftoff_times=run.liftoff_times + strikes - run.strike_times)
    assert [(fault.footstep, fault.kind) for fault in faults(later)] == [(5, "flight")]
    liftoffs = run.liftoff_times.copy()
    liftoffs[3] = run.strike_times[5] - 0.05
    assert [(fault.footstep, fault.kind) for fault in faults(replace(run, liftoff_times=liftoffs))] == [(5, "hurried")]


def test_feet_of_two_people_in_one_place_are_found_and_set_apart():
    one = way(9)
    other = replace(moved(one, slice(None), (0.03, 0.0, 0.02)), name="/Other")
    found = faults(one, other)
    assert {fault.kind for fault in found} == {"collision"}
    assert {(fault.plan, fault.footstep) for fault in found} == {
        (name, i) for name in (one.name, "/Other") for i in range(9)
    }
    above = moved(other, slice(None), (0.0, 0.6, 0.0))  # a storey higher
    assert {fault.kind for fault in faults(one, above)} == {"offGround"}
    later = replace(other, strike_times=other.strike_times + 60.0, liftoff_times=other.liftoff_times + 60.0)
    assert not faults(one, later)
    depth = max(fault.value for fault in found)
    assert faults(one, other, limits=LintLimits(collision=0.99 * depth))
    assert not faults(one, other, limits=LintLimits(collision=1.01 * depth))
    mended = mend_plans([one, other], Ground(LEVEL), bodies=[BODY] * 2)
    assert not [fault for fault in faults(*mended) if fault.severity == "error"]
    assert np.abs(mended[0].positions - one.positions).max() < 0.4


def test_what_is_good_stays_and_what_hovers_or_crosses_is_mended():
    plan = way(9)
    hill = terrain_of([slab((-20.0, 20.0), (-20.0, 20.0), (-2.0, 2.0))])
    (same,) = mend_plans([plan], Ground(LEVEL), bodies=[BODY])
    assert same is plan and mend_plans([], Ground(LEVEL), bodies=[]) == []
    crossed = moved(plan, 4, (-0.4, 0.0, 0.0))
    for bad, terrain in ((plan, hill), (crossed, LEVEL)):
        assert faults(bad, terrain=terrain)
        assert not faults(*mend_plans([bad], Ground(terrain), bodies=[BODY]), terrain=terrain)
    (laid,) = mend_plans([plan], Ground(hill), bodies=[BODY])
    up = quaternion.rotate(laid.orientations, np.array([0.0, 1.0, 0.0]))
    assert_allclose(up[1:, 2], -0.1 / np.hypot(1.0, 0.1), atol=1e-6)


def test_mending_a_warning_does_not_make_an_error():
    plan = way(9)
    orientations = plan.orientations.copy()
    orientations[4] = [0.0, 1.0, 0.0, 0.0]
    backward = replace(plan, orientations=orientations)
    assert {fault.severity for fault in faults(backward)} == {"warning"}
    (kept,) = mend_plans([backward], Ground(LEVEL), bodies=[BODY])
    assert not [fault for fault in faults(kept) if fault.severity == "error"]


def test_times_are_mended_or_refused():
    plan = way(8)
    draft = PlanDraft(**vars(plan))
    order = np.array([0, 1, 3, 2, 4, 5, 7, 6])
    arrays = {name: value[order] for name, value in vars(draft).items() if name not in ("name", "styles")}
    styles = tuple(f"style{step}" for step in range(8))
    shuffled = replace(draft, **arrays, styles=tuple(styles[step] for step in order))
    with pytest.raises(PlanError):
        FootstepPlan.checked(shuffled)
    assert_allclose(FootstepPlan.checked(mend_times(shuffled)).positions, plan.positions)
    assert mend_times(shuffled).styles == styles
    liftoffs = plan.liftoff_times.copy()
    liftoffs[2], liftoffs[5] = 0.0, 99.0
    mended = FootstepPlan.checked(mend_times(replace(draft, liftoff_times=liftoffs)))
    kept = np.isin(np.arange(8), [2, 5], invert=True)
    assert_allclose(mended.liftoff_times[kept], plan.liftoff_times[kept])
    with pytest.raises(PlanError, match="both left"):
        FootstepPlan.checked(mend_times(replace(draft, sides=np.zeros(8, dtype=int))))
