"""Feet flat on level ground: as in the rest pose or, where that does not stand, as in mid stance.

Exporters write whatever frame was current as the rest pose, so a foot of it may be in the air or on its toes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["LEVEL", "ahead", "flat_turns", "standing_turns"]

LEVEL = np.radians(10.0)
"""Feet of the rest pose pitched by more against those in mid stance do not stand. CMU's are by 4 degrees."""


def ahead(turns: FloatArray, offset: FloatArray) -> FloatArray:
    """Rotations (..., 4) turned about the vertical so that `offset` (3,), turned by them, points along +Z."""
    direction = quaternion.rotate(turns, offset)
    return quaternion.compose(quaternion.yaw_quaternion(-planar.yaw_of(direction[..., [0, 2]])), turns)


def flat_turns(rest: FloatArray, stances: Sequence[FloatArray], offsets: FloatArray) -> FloatArray | None:
    """World rotations of both ankles with the feet flat and pointing along +Z, shape (2, 4).

    Args:
        rest: Ankles in the rest pose, shape (2, 4).
        stances: Ankles in mid stance, in any heading, shape (N, 4) for each foot.
        offsets: Balls in the ankles' frames, shape (2, 3).

    Returns:
        None if the feet of the rest pose stand level, or nothing tells otherwise.
    """
    flats = standing_turns(rest, stances, offsets)
    pairs = zip(flats, rest, offsets, strict=True)
    differences = [abs(_elevations(flat, offset) - _elevations(turn, offset)) for flat, turn, offset in pairs]
    return flats if max(differences) > LEVEL else None


def standing_turns(rest: FloatArray, stances: Sequence[FloatArray], offsets: FloatArray) -> FloatArray:
    """World rotations of both ankles as the feet stand, pointing along +Z, shape (2, 4).

    A foot that stands is as pitched as most: the mean of those within `LEVEL` of the median. A foot without stances
    stands as in the rest pose. Arguments as of `flat_turns`.
    """
    flats = []
    for turn, stance, offset in zip(rest, stances, offsets, strict=True):
        flat = ahead(turn, offset)
        if len(stance):
            turned = ahead(stance, offset)
            pitches = _elevations(turned, offset)
            usual = np.abs(pitches - np.median(pitches)) <= LEVEL
            flat = quaternion.mean(turned, usual.astype(float))
        flats.append(ahead(flat, offset))
    return np.array(flats)


def _elevations(turns: FloatArray, offset: FloatArray) -> FloatArray:
    """Angle of `offset` (3,), turned by rotations (..., 4), above the horizontal [rad]."""
    rise = quaternion.rotate(turns, offset)[..., 1] / np.linalg.norm(offset)
    return np.arcsin(np.clip(rise, -1.0, 1.0))
