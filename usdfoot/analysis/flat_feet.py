"""Feet flat on level ground: as in the rest pose or, where that does not stand, as in mid stance.

Exporters write whatever frame was current as the rest pose, so a foot of it may be in the air or on its toes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["LEVEL", "ahead", "flat_turns", "flattest", "standing_turns"]

LEVEL = np.radians(10.0)
"""Feet of the rest pose pitched by more against those in mid stance do not stand. CMU's are by 4 degrees."""

SAME_PITCH = np.radians(2.0)
"""Feet that stand flat differ by no more in pitch [rad]."""


def ahead(turns: FloatArray, offset: FloatArray) -> FloatArray:
    """Rotations (..., 4) turned about the vertical so that `offset` (3,), turned by them, points along +Z."""
    direction = quaternion.rotate(turns, offset)
    return quaternion.compose(quaternion.yaw_quaternion(-planar.yaw_of(direction[..., [0, 2]])), turns)


def flat_turns(
    rest: FloatArray, stances: Sequence[FloatArray], offsets: FloatArray, *, same_pitch: float = SAME_PITCH
) -> FloatArray | None:
    """World rotations of both ankles with the feet flat and pointing along +Z, shape (2, 4).

    Args:
        rest: Ankles in the rest pose, shape (2, 4).
        stances: Ankles in mid stance, in any heading, shape (N, 4) for each foot.
        offsets: Balls in the ankles' frames, shape (2, 3).
        same_pitch: Feet that stand flat differ by no more in pitch [rad].

    Returns:
        None if the feet of the rest pose stand level, or nothing tells otherwise: neither stances that differ as much
        among themselves do, nor those of which a quarter stands as it, as on stones, where heels are often raised.
    """
    flats = standing_turns(rest, stances, offsets, same_pitch=same_pitch)
    for flat, turn, stance, offset in zip(flats, rest, stances, offsets, strict=True):
        rested, pitches = _elevations(turn, offset), _elevations(stance, offset)
        spread = 4.0 * _closest_half(pitches)[1] if len(stance) else 0.0  # of all, were they spread evenly
        alike = np.count_nonzero(np.abs(pitches - rested) < LEVEL / 2.0)
        if abs(_elevations(flat, offset) - rested) > max(LEVEL, spread) and 4 * alike < len(stance):
            return flats
    return None


def standing_turns(
    rest: FloatArray, stances: Sequence[FloatArray], offsets: FloatArray, *, same_pitch: float = SAME_PITCH
) -> FloatArray:
    """World rotations of both ankles as the feet stand, pointing along +Z, shape (2, 4).

    A foot that stands is as pitched as most: the mean of those within `same_pitch` of the half that is closest
    together, since runners' heels hardly come down. A foot without stances stands as in the rest pose. Arguments as
    of `flat_turns`.
    """
    flats = []
    for turn, stance, offset in zip(rest, stances, offsets, strict=True):
        flat = ahead(turn, offset)
        if len(stance):
            turned = ahead(stance, offset)
            pitches = _elevations(turned, offset)
            middle, width = _closest_half(pitches)
            usual = np.abs(pitches - middle) <= max(width, same_pitch)
            flat = quaternion.mean(turned, usual.astype(float))
        flats.append(ahead(flat, offset))
    return np.array(flats)


def flattest(flats: FloatArray, offsets: FloatArray) -> FloatArray:
    """Both feet pitched as the one whose heel is lower, shape (2, 4).

    Feet of one shape stand on the ground alike: where one is only seen with its heel raised, the other says how far.
    Feet that differ by more than `LEVEL` are left as they are.

    Args:
        flats: Ankles pointing along +Z, as of `standing_turns`, shape (2, 4).
        offsets: Balls in the ankles' frames, of one length, shape (2, 3).
    """
    pitches = np.array([float(_elevations(flat, offset)) for flat, offset in zip(flats, offsets, strict=True)])
    down = pitches.max() - pitches
    if down.max() > LEVEL:
        return flats
    return quaternion.compose(quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), -down), flats)


def _closest_half(values: FloatArray) -> tuple[float, float]:
    """Middle and half the span of the half of the values (N,), two at least, that spans least."""
    ordered = np.sort(values)
    more = max((len(values) + 1) // 2, min(len(values), 2)) - 1
    first = int(np.argmin(ordered[more:] - ordered[: len(values) - more]))
    return 0.5 * (ordered[first] + ordered[first + more]), 0.5 * np.ptp(ordered[first : first + more + 1])


def _elevations(turns: FloatArray, offset: FloatArray) -> FloatArray:
    """Angle of `offset` (3,), turned by rotations (..., 4), above the horizontal [rad]."""
    rise = quaternion.rotate(turns, offset)[..., 1] / np.linalg.norm(offset)
    return np.arcsin(np.clip(rise, -1.0, 1.0))
