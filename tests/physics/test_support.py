"""Where the weight changes feet, where feet press and how they roll, as people's do."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.builders import human, walk
from usdfoot.model.contact_table import lay_contacts
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.leg_kernel import BACKWARD
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.spline import lay_knots
from usdfoot.physics.support import find_stance

CONTACT = 5
"""In the middle of the plans; of the left foot."""


def laid(plan, **options):
    contacts = lay_contacts([plan])
    return contacts, lay_footing(contacts, human(), PhysicsOptions(**options))


def own_knots(contacts, footing):
    """The knots nearest the strikes of footsteps within the plan, and these contacts."""
    knots = lay_knots(contacts, footing)
    rows = np.flatnonzero(contacts.steps >= 0)[2:-2]
    apart = np.abs(knots.times[:, None] - contacts.strikes[rows])
    return knots.times[apart.argmin(axis=0)], rows


def stance_over(footing, begin, end):
    """The left leg over a time in 201 instants, of a body that faces ahead."""
    times = np.linspace(begin, end, 201)
    return find_stance(
        footing, agents=np.zeros(201, dtype=int), times=times, bodies=np.tile([0.0, 0.0, 0.0, 1.0], (201, 1))
    )


def test_a_walk_has_its_knots_when_half_of_the_weight_is_on_either_foot():
    contacts, footing = laid(walk(8))
    knots, rows = own_knots(contacts, footing)
    assert (knots > contacts.strikes[rows] + 0.02).all()
    stance = find_stance(
        footing,
        agents=np.zeros(len(knots), dtype=int),
        times=knots,
        bodies=np.tile([0.0, 0.0, 0.0, 1.0], (len(knots), 1)),
    )
    np.testing.assert_allclose(stance.leg_shares[:, 0], stance.leg_shares[:, 1], atol=1e-9)


@pytest.mark.parametrize(
    ("length", "support"), [(0.7, "print"), (1.3, "smooth"), (1.3, "print")], ids=["print", "run", "run print"]
)
def test_knots_are_at_the_strikes_of_runs_and_where_feet_press_as_in_the_paper(length, support):
    contacts, footing = laid(walk(8, length=length), support=support)
    knots, rows = own_knots(contacts, footing)
    np.testing.assert_allclose(knots, contacts.strikes[rows], atol=1e-12)


def test_a_walking_foot_presses_from_heel_to_toe_on_the_ball_once_its_heel_is_off():
    contacts, footing = laid(walk(8))
    row, biped = footing.rows.numpy()[CONTACT], human()
    begin, end = row["begin"], row["end"]
    stance = stance_over(footing, begin, end)
    assert (stance.contacts[:, 0] == CONTACT).all()
    along = stance.supports[:, 0, 2] - contacts.positions[CONTACT, 2]  # from the ball, ahead
    np.testing.assert_allclose(along[[0, -1]], [biped.heel, biped.toe], atol=1e-9)
    steps = np.diff(along)
    assert (steps > 0.0).all()
    assert steps.max() < 1.5 * (biped.toe - biped.heel) / len(steps)
    at_heel_off = find_stance(
        footing, agents=np.zeros(1, int), times=np.array([begin + 0.606 * (end - begin)]), bodies=np.eye(4)[3:]
    )
    np.testing.assert_allclose(at_heel_off.supports[0, 0, 2], contacts.positions[CONTACT, 2], atol=1e-9)


def pitches(plan):
    """Of the left foot over a contact, positive with the toes up [rad], from where its ankle is, shape (201,)."""
    contacts, footing = laid(plan)
    stance, biped = stance_over(footing, contacts.strikes[CONTACT], contacts.liftoffs[CONTACT]), human()
    ankles = stance.anchors[:, 0] + biped.hips[0] - contacts.positions[CONTACT]
    about_heel = np.abs(np.hypot(ankles[:, 1], ankles[:, 2]) - np.hypot(*biped.ankles[0, 1:])) > 1e-9
    pivots = np.where(about_heel, biped.heel, 0.0)
    return np.arctan2(ankles[:, 1], ankles[:, 2] - pivots) - np.arctan2(biped.ankles[0, 1], biped.ankles[0, 2] - pivots)


def test_a_foot_that_steps_back_rolls_as_little_as_the_one_drawn_and_the_other_way_round():
    ahead, back = pitches(walk(8, length=0.4)), pitches(walk(8, length=-0.4))
    assert np.abs(ahead).max() > 0.2
    np.testing.assert_allclose(back, BACKWARD * ahead[::-1], atol=1e-9)


def test_backward_the_heel_carries_on_after_the_ball_so_that_walks_do_not_fly():
    strikes = 0.5 * np.arange(8)
    times = {"strikes": strikes, "liftoffs": strikes + 0.43}  # of the balls: neither is down for 14 % of a step
    for length, flies in ((-0.4, False), (0.4, True)):
        contacts, footing = laid(walk(8, length=length, **times))
        row, following = footing.rows.numpy()[[CONTACT, CONTACT + 1]]
        assert (row["leaps"] > 0.0) == flies
        assert (row["end"] > following["begin"]) != flies
        if not flies:
            assert row["end"] == pytest.approx(contacts.liftoffs[CONTACT] + 0.118 * 0.43)


def test_legs_of_who_stands_at_the_begin_or_end_keep_their_longest_comfortable_length():
    plan = walk(8, starts_standing=True, ends_standing=True)
    footing = laid(plan)[1]
    walking = stance_over(footing, plan.strike_times[4], plan.liftoff_times[4])
    assert (walking.contacts[:, 0] == 4).all()
    longest = walking.nominal_lengths[:, 0].max()
    begin = stance_over(footing, 0.0, 0.7 * plan.liftoff_times[0])
    end = stance_over(footing, plan.strike_times[6] + 0.85 * np.ptp([plan.strike_times[6], plan.liftoff_times[6]]), 9.0)
    for stance in (begin, end):
        np.testing.assert_allclose(stance.nominal_lengths[:, 0], longest, atol=1e-4)
