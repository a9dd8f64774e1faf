"""Interactive mode keeps what was executed and stays near the optimum of the whole plan."""

from dataclasses import replace

import numpy as np
import pytest

from tests.physics.builders import human, walk
from usdfoot.physics.interactive import WINDOW, optimise_step
from usdfoot.physics.optimise import optimise_com

FIELDS = ("sides", "positions", "orientations", "strike_times", "liftoff_times", "root_weights")


def tail(plan, newest):
    rows = slice(max(0, newest + 1 - WINDOW), newest + 1)
    return replace(plan, **{name: getattr(plan, name)[rows] for name in FIELDS})


def executed(plan):
    """Positions of every step as it was executed, and of the whole plan's optimum, and the jumps between the steps."""
    whole = optimise_com([plan], human())
    motion, distances, jumps = None, [], []
    zero = np.zeros(20, dtype=int)
    for newest in range(2, len(plan)):
        following = optimise_step(tail(plan, newest), human(), before=motion)
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
