"""Stance: what stands a referenced character upright at its size, below its agent's place and heading."""

from __future__ import annotations

import numpy as np

from usdfoot.bridge.scene import Character
from usdfoot.bridge.tokens import Op
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["stance_matrix", "stance_ops"]

UPRIGHT_TOLERANCE = 1e-7
"""Rotations and scales of a character closer than this to none are left out."""


def stance_ops(character: Character) -> dict[str, list[float]]:
    """Values of the ops by name, in order: a quaternion xyzw and a scale of the axes; none for most characters."""
    ops = {}
    x, y, z, w = character.agent_rotation.tolist()
    if 1.0 - abs(w) > UPRIGHT_TOLERANCE**2 and max(abs(x), abs(y), abs(z)) > UPRIGHT_TOLERANCE:
        ops[Op.ORIENT_STANCE] = [x, y, z, w]
    if abs(character.agent_scale - 1.0) > UPRIGHT_TOLERANCE:
        ops[Op.SCALE_STANCE] = [character.agent_scale] * 3
    return ops


def stance_matrix(character: Character) -> FloatArray:
    """All of them as a matrix (row vectors), shape (4, 4)."""
    matrix, ops = np.eye(4), stance_ops(character)
    if Op.SCALE_STANCE in ops:
        matrix[:3, :3] *= character.agent_scale
    if Op.ORIENT_STANCE in ops:
        matrix[:3, :3] = matrix[:3, :3] @ quaternion.to_matrix(np.array(ops[Op.ORIENT_STANCE])).T
    return matrix
