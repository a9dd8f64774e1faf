"""Two-bone inverse kinematics of many limbs at once."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["bend_two_bones"]

STRAIGHT = 0.05
"""Sine of the bend below which the hinge, not the pose, says which way a limb bends."""
SLIGHT = 0.02
"""Change of the bend from which on that matters [rad]; a limb that need not change keeps its pose exactly."""


def bend_two_bones(
    upper: FloatArray, lower: FloatArray, hinge: FloatArray, *, reach: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rotations that bring the end of a limb to a place, the limb staying in its plane.

    A limb that already ends there keeps its pose exactly. One that is about straight, or bent the wrong way, bends
    about the hinge. A place beyond reach is approached along the straight limb.

    Args:
        upper: First bone of the pose [m], shape (..., 3).
        lower: Second bone [m], shape (..., 3).
        hinge: Unit axes about which the second bone turns when the limb bends, shape (..., 3).
        reach: Wanted place of the end, from the begin of the first bone [m], shape (..., 3).

    Returns:
        World rotations (..., 4) to put before those of the first bone, and before those of the second.
    """
    lengths = [np.linalg.norm(bone, axis=-1) for bone in (upper, lower)]
    along, shin = (bone / length[..., None] for bone, length in zip((upper, lower), lengths, strict=True))
    span = np.linalg.norm(reach, axis=-1)
    total, least = lengths[0] + lengths[1], np.abs(lengths[0] - lengths[1])
    wanted = np.clip(span, least + 1e-6 * total, total)
    cosine = (wanted**2 - lengths[0] ** 2 - lengths[1] ** 2) / (2.0 * lengths[0] * lengths[1])
    bend = np.arccos(np.clip(cosine, -1.0, 1.0))
    turned = np.cos(bend)[..., None] * along + np.sin(bend)[..., None] * _sideways(along, shin, hinge, bend)
    second = quaternion.between(shin, turned)
    swung = upper + lengths[1][..., None] * turned
    swung = swung / np.maximum(np.linalg.norm(swung, axis=-1, keepdims=True), 1e-12)
    first = quaternion.between(swung, reach / np.maximum(span, 1e-12)[..., None])
    return first, quaternion.compose(first, second)


def _sideways(along: FloatArray, shin: FloatArray, hinge: FloatArray, bend: FloatArray) -> FloatArray:
    """Unit direction across the first bone to which the second is bent by `bend` [rad], shape (..., 3)."""
    cosine = np.sum(along * shin, axis=-1, keepdims=True)
    across = shin - cosine * along
    now = np.arctan2(np.linalg.norm(across, axis=-1), cosine[..., 0])
    flexion = np.cross(hinge, along)
    flexion = flexion / np.maximum(np.linalg.norm(flexion, axis=-1, keepdims=True), 1e-12)
    lack = np.maximum(STRAIGHT - np.sum(across * flexion, axis=-1), 0.0)
    change = (bend - now) ** 2
    across = across + (lack * change / (change + SLIGHT**2) + 1e-12)[..., None] * flexion
    return across / np.linalg.norm(across, axis=-1, keepdims=True)
