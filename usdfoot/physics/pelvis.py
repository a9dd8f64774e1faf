"""Pelvis: to the side of where the centre of mass would carry it, since people's trunk bends off the standing leg."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.heading import heading_of
from usdfoot.physics.optimise import ComMotion
from usdfoot.physics.rhythm import Rhythm

__all__ = ["hung_pelvises", "pelvis_sways"]

LIST = 0.07
"""The hip of the swinging leg sinks by this; the shoulders stay level, so the trunk is bent and leans by half of it off
the foot on the ground (Frigo et al. 2003) [rad]."""
TRUNK_SHARE = 0.678 * 0.626 * (0.818 - 0.530) / 0.491
"""Mass of head, arms and trunk as a part of the body's, times the height of their centre above the hips as a part of
the leg (Winter 2009, Table 4.1 and Figure 4.1)."""


def hung_pelvises(com: ComMotion, *, agents: IntArray, times: FloatArray, offsets: FloatArray) -> FloatArray:
    """Pelvis joints that hang on the centre of mass, world [m], shape (F, 3).

    Args:
        com: The optimised motion.
        agents: Whose, shape (F,).
        times: [s], shape (F,).
        offsets: Added in the body's frame [m], shape (F, 3) or (3,).
    """
    sample = com.evaluate(agents, times)
    rhythm = com.rhythm(agents, times, heading_of(sample.orientations))
    across = com.biped.pelvis + offsets + pelvis_sways(com.biped, rhythm)
    return sample.positions + quaternion.rotate(sample.orientations, across)


def pelvis_sways(biped: PhysicsBiped, rhythm: Rhythm) -> FloatArray:
    """How far the pelvis moves to the side of the standing leg, body's frame [m], shape (F, 3).

    The trunk leans the other way, and the centre of mass of both stays where it is. Only people are known to do so.
    """
    aside = 0.5 * LIST * TRUNK_SHARE * biped.maximal_length if biped.humanlike else 0.0
    return aside * rhythm.lean[:, None] * np.array([1.0, 0.0, 0.0])
