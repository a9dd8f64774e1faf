"""The default solver against the paper's: never a higher E, the same from any start."""

import numpy as np
import pytest

from tests.physics.builders import human, walk
from usdfoot.model.contact_table import lay_contacts
from usdfoot.physics.energy import segment_energies
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.greedy import search_unknowns
from usdfoot.physics.heading import lay_headings
from usdfoot.physics.optimise import start_unknowns
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import lay_samples
from usdfoot.physics.solve import optimise_unknowns
from usdfoot.physics.spline import controls_of, lay_knots

PLANS = {
    "walking": walk(8),
    "slow": walk(8, length=0.35),
    "running": walk(8, length=1.3),
    "stairs": walk(8, length=0.5, rise=0.17),
    "leaping": walk(8, lengths=[0.6, 0.6, 0.6, 1.3, 0.6, 0.6, 0.6]),
    "turning": walk(8, length=0.6, turn=0.35),
    "hundred": walk(100, length=0.65, turn=0.05),
}


@pytest.fixture(scope="module")
def problem():
    """[P]'s own problem over all plans at once: one segment a step, constant leg lengths, no run-up."""
    options = PhysicsOptions(parts=1, leg_play=0.0, run_up=0, comfort=100.0, support="print")
    contacts = lay_contacts(list(PLANS.values()))
    knots = lay_knots(contacts)
    samples = lay_samples(lay_footing(contacts, human(), options), knots, lay_headings(contacts), ())
    return samples, knots, start_unknowns(contacts, knots, human()), options


def energies(problem, unknowns):
    samples, knots, _, options = problem
    each = segment_energies(
        samples, controls_of(unknowns, knots.begins), gravity=options.gravity, comfort=options.comfort
    )
    return np.bincount(knots.agents[knots.begins], each)


def test_steps_have_a_segment_and_flights_one_more(problem):
    _, knots, _, _ = problem
    segments = np.bincount(knots.agents[knots.begins])
    flights = [int(np.sum(plan.strike_times[1:] > plan.liftoff_times[:-1])) for plan in PLANS.values()]
    ends = [1] * len(PLANS)  # the last footstep stands on until it lifts off
    strikes = [len(plan) - 1 for plan in PLANS.values()]
    inside = [
        int(np.sum((contacts > plan.strike_times[-1] + 0.02) & (contacts < plan.liftoff_times[-1] - 0.02)))
        for plan in PLANS.values()
        for contacts in [lay_contacts([plan]).strikes]
    ]
    np.testing.assert_array_equal(segments, np.array(strikes) + flights + ends + inside)
    assert len(knots.times) == segments.sum() + len(PLANS)


def test_default_is_never_above_greedy_from_any_start(problem):
    samples, knots, start, options = problem
    random = np.random.default_rng(11)
    scattered = start + random.normal(0.0, 0.3, start.shape) * ~np.repeat(knots.fixed, 3, axis=1)
    found = energies(problem, optimise_unknowns(samples, knots, start, options))
    again = energies(problem, optimise_unknowns(samples, knots, scattered, options))
    np.testing.assert_allclose(again, found, rtol=0.06)  # small local minima at the free ends
    greedy = energies(problem, search_unknowns(samples, knots, start, options))
    begun = energies(problem, start)
    assert (greedy < 0.5 * begun).all()
    for name, mine, other, theirs in zip(PLANS, found, again, greedy, strict=True):
        assert max(mine, other) <= theirs, name


def test_greedy_stops_where_no_single_change_helps():
    options = PhysicsOptions(parts=1, leg_play=0.0, run_up=0)
    contacts = lay_contacts([walk(3)])
    knots = lay_knots(contacts)
    samples = lay_samples(lay_footing(contacts, human(), options), knots, lay_headings(contacts), ())
    problem = samples, knots, start_unknowns(contacts, knots, human()), options
    found = search_unknowns(*problem)
    best = energies(problem, found)[0]
    spans = np.array([np.mean(knots.durations[max(k - 1, 0) : k + 1]) for k in range(len(knots.times))])
    for knot in range(len(knots.times)):
        for column in range(6):
            for sign in (1.0, -1.0):
                moved = found.copy()
                moved[knot, column] += sign * (0.02 if column < 3 else 0.02 / spans[knot])
                assert energies(problem, moved)[0] >= best - 1e-12
