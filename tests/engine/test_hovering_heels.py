"""Heels that hover in the clips' stances, and those that are meant to be up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.engine.walkers import between, in_world
from usdfoot.engine.contact_feet import unplanted_feet
from usdfoot.engine.feet import settle_heels
from usdfoot.engine.legs import LegRig
from usdfoot.maths import quaternion


def with_raised_heels(library, degrees: float):
    """The library as if its clips' heels were raised by so much more than they are."""
    angle = np.radians(degrees)
    inverses = quaternion.inverse(np.array([foot.flat_rotation for foot in library.rig.feet]))
    forwards = quaternion.rotate(inverses, np.array([0.0, -np.sin(angle), np.cos(angle)]))
    arrays = LegRig()
    for name in LegRig.vars:
        setattr(arrays, name, getattr(library.rig.arrays, name))
    arrays.flat_forwards = wp.array(forwards.astype(np.float32), dtype=wp.vec3f)
    return replace(library, rig=replace(library.rig, arrays=arrays))


def heel_heights(library, motion) -> np.ndarray:
    """Heights of the heels in mid stance of a walk on level ground at 0 [m]."""
    feet = in_world(library.source, motion)
    heights = []
    for side in (0, 1):
        contacts = motion.contacts[side]
        times = zip(contacts.flat_times, contacts.liftoff_times - contacts.flat_times, strict=True)
        middles = [between(feet.times, flat + 0.3 * time, flat + 0.5 * time) for flat, time in times if time > 0.3]
        heights += [feet.heels[middle, side, 1] for middle in middles]
    return np.concatenate(heights)


@pytest.mark.parametrize("degrees", [2.0, 4.0, 6.0])
def test_heels_that_hover_come_down(animate, walker_library, degrees):
    motion = animate([way(9)], rate=120.0, library=with_raised_heels(walker_library, degrees))[0]
    assert heel_heights(walker_library, motion).max() < 1.5e-3


def test_heels_that_are_up_stay_up(animate, walker_library):
    motion = animate([way(9)], rate=120.0, library=with_raised_heels(walker_library, 15.0))[0]
    assert heel_heights(walker_library, motion).min() > 0.03


def test_how_far_heels_come_down_grows_and_fades():
    raises = np.radians([[-3.0, 5.0], [0.0, 1.0], [1.0, 9.0], [8.0, 4.0], [30.0, 12.0]])
    settles = settle_heels(unplanted_feet(7), np.array([1, 2, 3, 4, 6]), raises).settles
    assert_allclose(settles, np.radians([0.0, 0.0, 0.0, 2.0, 6.0, 0.0, 0.0]), atol=1e-12)
