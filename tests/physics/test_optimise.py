"""The optimised centre of mass obeys physics and follows the plan's symmetries."""

import numpy as np

from tests.physics.builders import human, walk
from usdfoot.physics.optimise import optimise_com


def path(motion, agent=0, count=200):
    times = np.linspace(motion.contacts.starts[agent], motion.contacts.ends[agent], count)
    return motion.evaluate(np.full(count, agent), times)


def test_flight_is_a_parabola():
    motion = optimise_com([walk(9, lengths=[0.6, 0.6, 0.6, 1.3, 0.6, 1.1, 0.6, 0.6])], human())
    contacts = motion.contacts
    takeoffs, strikes = contacts.liftoffs[:-1], contacts.strikes[1:]
    flights = np.flatnonzero((strikes > takeoffs) & (strikes < contacts.ends[0]))
    assert len(flights) == 2
    for flight in flights:
        times = np.linspace(takeoffs[flight] + 1e-3, strikes[flight] - 1e-3, 20)
        sample = motion.evaluate(np.zeros(20, dtype=int), times)
        np.testing.assert_allclose(sample.accelerations, np.tile([0.0, -9.81, 0.0], (20, 1)), atol=0.01 * 9.81)


def test_agents_solved_together_move_as_alone():
    plans = [walk(6), walk(9, length=1.2), walk(5, turn=0.3)]
    together = optimise_com(plans, human())
    for index, plan in enumerate(plans):
        alone = optimise_com([plan], human())
        np.testing.assert_allclose(path(together, index).positions, path(alone).positions, atol=1e-6)
