"""Orientations of prints from where they point and the ground they lie on."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["print_orientations"]


def print_orientations(forward: FloatArray, normals: FloatArray) -> FloatArray:
    """Rotations that turn +Z into forward, seen along the normal, and +Y into the normal, xyzw, shape (N, 4).

    Args:
        forward: Not along the normals, shape (N, 3).
        normals: Not zero, shape (N, 3).
    """
    up = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    left = np.cross(up, forward)
    left = left / np.linalg.norm(left, axis=1, keepdims=True)
    return quaternion.from_matrix(np.stack([left, up, np.cross(left, up)], axis=-1))
