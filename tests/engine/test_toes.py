"""Toes: flat in contact, on their way back to the clip's in the air."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engine.plans import way
from tests.engine.walkers import between, in_world
from usdfoot.maths import quaternion

RATE = 60.0


@pytest.mark.parametrize("about", [{"duty": 0.7}, {"step_time": 0.4}, {"length": 1.0, "step_time": 0.35, "duty": 0.4}])
def test_toes_have_the_whole_swing_to_unbend(animate, walker_library, about):
    """In half of it they snapped: 178, 236 and 205 rad/s2."""
    motion = animate([way(9, **about)], rate=RATE)[0]
    toes = motion.rotations[:, list(walker_library.source.biped.balls)].astype(float)
    turns = quaternion.compose(toes[1:], quaternion.inverse(toes[:-1]))
    speeds = quaternion.to_rotation_vector(turns) * RATE
    assert np.linalg.norm(np.diff(speeds, axis=0) * RATE, axis=-1).max() < 160.0


def test_toes_turn_with_the_foot_from_print_to_print(animate, walker_library):
    """Of someone who turns by half a radian a step they do not bend sideways."""
    library = walker_library.source
    motion = animate([way(9, length=0.2, turn=0.5, step_time=0.6)], rate=RATE)[0]
    feet = in_world(library, motion)
    for side in (0, 1):
        contacts, ball, ankle = motion.contacts[side], library.biped.balls[side], library.biped.ankles[side]
        local = quaternion.compose(quaternion.inverse(feet.rotations[:, ankle]), feet.rotations[:, ball])
        flat = walker_library.rig.feet[side]
        rest = quaternion.compose(quaternion.inverse(flat.flat_rotation), flat.toe_rotation)
        bends = quaternion.to_rotation_vector(quaternion.compose(quaternion.inverse(rest), local))
        axis = quaternion.rotate(quaternion.inverse(flat.toe_rotation), np.array([0.0, 1.0, 0.0]))
        for liftoff, strike in zip(contacts.liftoff_times[:-1], contacts.strike_times[1:], strict=True):
            swing = between(feet.times, liftoff, strike)
            assert np.abs(bends[swing] @ axis).max(initial=0.0) < np.radians(12.0)
