"""Interactive mode keeps what was executed and stays near the optimum of the whole plan."""

from dataclasses import replace

import numpy as np
import pytest

from tests.physics.builders import human, walk
from usdfoot.model.contact_table import lay_contacts
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.interactive import StepOptimiser
from usdfoot.physics.optimise import optimise_com, solve_motion, start_unknowns
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.run_up import extend_contacts
from usdfoot.physics.spline import lay_knots
from usdfoot.physics.step_room import WINDOW

FIELDS = ("sides", "positions", "orientations", "strike_times", "liftoff_times", "root_weights")


def tail(plan, newest):
    rows = slice(max(0, newest + 1 - WINDOW), newest + 1)
    return replace(plan, **{name: getattr(plan, name)[rows] for name in FIELDS})


def executed(plan):
    """Positions of every step as it was executed, and of the whole plan's optimum, and the jumps between the steps."""
    whole = optimise_com([plan], human())
    stepper, motion, distances, jumps = StepOptimiser(human()), None, [], []
    zero = np.zeros(20, dtype=int)
    for newest in range(2, len(plan)):
        following = stepper.optimise_step(tail(plan, newest), before=motion)
        seam = np.full(1, plan.strike_times[newest - 1])
        if motion is not None:
            before, after = (each.evaluate(np.zeros(1, dtype=int), seam) for each in (motion, following))
            jumps.append(
                np.abs(np.concatenate([before.positions - after.positions, before.velocities - after.velocities]))
            )
        motion = following
        begin = plan.strike_times[newest - 1] if newest > 2 else plan.strike_times[0]
        times = np.linspace(begin, plan.strike_times[newest] - 1e-6, 20)
        apart = motion.evaluate(zero, times).positions - whole.evaluate(zero, times).positions
        distances.append(np.linalg.norm(apart, axis=1).max())
    return np.array(distances), np.array(jumps)


@pytest.mark.parametrize(
    ("plan", "farthest"),
    [
        (walk(9), 0.02),
        (walk(9, turn=0.25), 0.02),
        (walk(9, length=1.3), 0.03),
        (walk(9, lengths=[0.6, 0.6, 0.7, 0.5, 0.6, 0.75, 0.6, 0.5]), 0.08),
    ],
    ids=["walking", "turning", "running", "uneven"],
)
def test_steps_optimised_one_by_one_are_near_the_optimum_of_the_whole(plan, farthest):
    distances, jumps = executed(plan)
    assert distances.max() < farthest
    np.testing.assert_allclose(jumps, 0.0, atol=1e-9)


def step_by_tables(plan, newest, before):
    """The same problem laid out as whole plans are: all footsteps so far, solved from the step before the newest on."""
    options = PhysicsOptions(tolerance=1e-3)
    so_far = replace(plan, **{name: getattr(plan, name)[: newest + 1] for name in FIELDS})
    contacts = extend_contacts(lay_contacts([so_far]), strides=options.run_up)
    begin = np.flatnonzero(contacts.steps >= 0)[-2]
    contacts = replace(contacts, starts=contacts.strikes[begin : begin + 1])
    footing = lay_footing(contacts, human(), options)
    knots = lay_knots(contacts, footing, parts=options.parts, longest_segment=options.longest_segment)
    start = start_unknowns(contacts, knots, human())
    position, velocity, _ = before.spline.evaluate(np.zeros(1, dtype=int), knots.times[:1])
    start[0] = np.concatenate([position[0], velocity[0]])
    knots = replace(knots, fixed=knots.fixed | (np.arange(len(knots.times)) == 0)[:, None])
    return solve_motion(contacts, footing, knots, start=start, biped=human(), options=options)


@pytest.mark.parametrize(
    "plan",
    [
        walk(7, turn=0.25, rise=0.1),
        walk(7, length=-0.4),
        walk(7, lengths=[0.6, 0.6, 1.4, 0.6, 0.6, 0.6]),
        walk(6, starts_standing=True, ends_standing=True),
    ],
    ids=["stairs", "backward", "leap", "standing"],
)
def test_the_last_footsteps_alone_give_what_the_whole_table_gives(plan):
    stepper = StepOptimiser(human())
    motion = stepper.optimise_step(tail(plan, 2))
    for newest in range(3, len(plan)):
        expected = step_by_tables(plan, newest, motion)
        motion = stepper.optimise_step(tail(plan, newest), before=motion)
        np.testing.assert_allclose(motion.spline.knots.times, expected.spline.knots.times, atol=1e-12)
        np.testing.assert_allclose(motion.spline.controls, expected.spline.controls, atol=1e-6)
        times = expected.spline.knots.times
        both = [each.evaluate(np.zeros(len(times), dtype=int), times).orientations for each in (motion, expected)]
        np.testing.assert_allclose(*both, atol=1e-9)
        np.testing.assert_allclose(motion.energies, expected.energies)


def test_what_a_step_gave_back_stays_when_the_next_is_optimised():
    plan, stepper = walk(7, turn=0.25), StepOptimiser(human())
    first = stepper.optimise_step(tail(plan, 3), before=stepper.optimise_step(tail(plan, 2)))
    times = np.linspace(*first.spline.knots.times[[0, -1]], 30)
    zero = np.zeros(30, dtype=int)
    kept = first.evaluate(zero, times)
    stepper.optimise_step(tail(plan, 4), before=first)
    again = first.evaluate(zero, times)
    np.testing.assert_array_equal(again.positions, kept.positions)
    np.testing.assert_array_equal(again.orientations, kept.orientations)


def test_a_step_with_many_knots_finds_room():
    plan = walk(7)
    options = PhysicsOptions(longest_segment=0.02)
    few, many = StepOptimiser(human()), StepOptimiser(human(), options)
    motion = many.optimise_step(tail(plan, 3), before=few.optimise_step(tail(plan, 2)))
    assert len(motion.spline.knots.times) > 100
    assert np.isfinite(motion.spline.positions).all()


def test_a_foot_that_stays_on_is_solved_without_a_repeated_stride():
    plan = walk(4)
    liftoffs = plan.liftoff_times.copy()
    liftoffs[3] = plan.strike_times[3] + 3.0 * (plan.strike_times[3] - plan.strike_times[1])
    stuck = replace(plan, liftoff_times=liftoffs)
    stepper = StepOptimiser(human())
    begun = stepper.optimise_step(tail(plan, 2))
    motion = stepper.optimise_step(tail(stuck, 3), before=begun)
    expected = step_by_tables(stuck, 3, begun)
    np.testing.assert_allclose(motion.spline.controls, expected.spline.controls, atol=1e-6)
