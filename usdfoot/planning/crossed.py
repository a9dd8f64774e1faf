"""Crossed feet: how far a foot comes down on its own side of the other, in the search over stones as in lint."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT

__all__ = ["apart_midway"]


def apart_midway(
    offsets: FloatArray, swing_sides: IntArray, *, yaws_before: FloatArray, turns: FloatArray
) -> FloatArray:
    """How far swing feet come down on their own side of the support foot [m], negative: crossed, shape (...).

    Seen in the heading midway through the turn, in which steps are compared with those of the clips.

    Args:
        offsets: From the support foot to where the swing foot comes down (x, z) [m], shape (..., 2).
        swing_sides: 0 = left, 1 = right, shape (...).
        yaws_before: Headings of the support feet [rad], shape (...).
        turns: From these to the headings of the swing feet [rad], shape (...).
    """
    across = planar.rotate(-(yaws_before + 0.5 * turns), offsets)[..., 0]
    return np.asarray(np.where(swing_sides == LEFT, across, -across))
