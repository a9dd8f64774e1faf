"""The default solver against the paper's: never a higher E, the same from any start."""

import numpy as np
import pytest

from tests.physics.builders import human, walk
from usdfoot.model.contact_table import lay_contacts
from usdfoot.physics.energy import segment_energies
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.greedy import search_unknowns
from usdfoot.physics.optimise import start_unknowns
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.run_up import extend_contacts
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


PAPER = PhysicsOptions(parts=1, leg_play=0.0, run_up=0, comfort=100.0, support="print")
"""[P]'s own problem: one segment a step, constant leg lengths, no run-up."""


@pytest.fixture(scope="module", params=[PAPER, PhysicsOptions()], ids=["paper", "default"])
def problem(request):
    """All plans at once."""
    options = request.param
    contacts = extend_contacts(lay_contacts(list(PLANS.values())), strides=options.run_up)
    footing = lay_footing(contacts, human(), options)
    knots = lay_knots(contacts, footing, parts=options.parts)
    samples = lay_samples(footing, knots, window=options.heading_window)
    return samples, knots, start_unknowns(contacts, knots, human()), options


def scattered(problem, seed, size):
    """The paper's start, moved at random."""
    _, knots, start, _ = problem
    moves = np.random.default_rng(seed).normal(0.0, size, start.shape)
    return start + moves * ~np.repeat(knots.fixed, 3, axis=1)


def energies(problem, unknowns):
    samples, knots, _, options = problem
    each = segment_energies(
        samples, controls_of(unknowns, knots.begins), gravity=options.gravity, comfort=options.comfort
    )
    return np.bincount(knots.agents[knots.begins], each)


def test_steps_have_a_segment_and_flights_one_more():
    contacts = lay_contacts(list(PLANS.values()))
    knots = lay_knots(contacts, lay_footing(contacts, human(), PAPER))
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


@pytest.mark.parametrize("size", [0.0, 0.3, 3.0])
def test_default_is_never_above_greedy_and_the_same_from_any_start(problem, size):
    samples, knots, start, options = problem
    begun = scattered(problem, 11, size)
    unknowns = optimise_unknowns(samples, knots, begun, options=options)
    np.testing.assert_array_equal(unknowns, optimise_unknowns(samples, knots, start, options=options))
    if size < 1.0:  # the paper's search takes long from farther off
        greedy = energies(problem, search_unknowns(samples, knots, begun, options=options))
        assert (greedy < 0.5 * energies(problem, begun)).all()
        for name, mine, theirs in zip(PLANS, energies(problem, unknowns), greedy, strict=True):
            assert mine <= theirs, name


def test_no_other_start_leads_much_lower(problem):
    samples, knots, start, options = problem
    found = energies(problem, optimise_unknowns(samples, knots, start, options=options))
    starts = [start, *(scattered(problem, seed, 0.3) for seed in range(4))]
    others = [optimise_unknowns(samples, knots, begun, options=options, settles=False) for begun in starts]
    lowest = np.min([energies(problem, unknowns) for unknowns in others], axis=0)
    assert (found <= 1.03 * lowest).all()


def test_greedy_stops_where_no_single_change_helps():
    options = PhysicsOptions(parts=1, leg_play=0.0, run_up=0)
    contacts = lay_contacts([walk(3)])
    footing = lay_footing(contacts, human(), options)
    knots = lay_knots(contacts, footing)
    samples = lay_samples(footing, knots, window=options.heading_window)
    problem = samples, knots, start_unknowns(contacts, knots, human()), options
    found = search_unknowns(*problem[:3], options=options)
    best = energies(problem, found)[0]
    spans = np.array([np.mean(knots.durations[max(k - 1, 0) : k + 1]) for k in range(len(knots.times))])
    for knot in range(len(knots.times)):
        for column in range(6):
            for sign in (1.0, -1.0):
                moved = found.copy()
                moved[knot, column] += sign * (0.02 if column < 3 else 0.02 / spans[knot])
                assert energies(problem, moved)[0] >= best - 1e-12
