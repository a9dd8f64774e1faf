"""Legs: the bend of the knee that brings the ankle to its place."""

import numpy as np

from stagecraft.rotation import FloatArray


def solve_leg(
    hip: FloatArray, ankle: FloatArray, forward: FloatArray, bones: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """World rotations of thigh and shank, each shape (T, 3, 3).

    Args:
        hip: hip joint [m], shape (T, 3).
        ankle: ankle joint [m], shape (T, 3), within reach.
        forward: where the knee points, shape (T, 3).
        bones: thigh and shank in the modelling pose [m], in the plane x = constant, shape (3,) each.

    Raises:
        ValueError: if the ankle is out of reach.
    """
    thigh, shank = (float(np.linalg.norm(bone)) for bone in bones)
    leg = ankle - hip
    distance = np.linalg.norm(leg, axis=1)
    if distance.max() >= thigh + shank:
        raise ValueError(f"leg of {thigh + shank:.3f} m must reach {distance.max():.3f} m")
    along = leg / distance[:, None]
    hinge = np.cross(forward, along)
    hinge /= np.linalg.norm(hinge, axis=1, keepdims=True)
    bend = np.arccos((thigh**2 + distance**2 - shank**2) / (2.0 * thigh * distance))
    ahead = np.cross(along, hinge)
    knee = hip + thigh * (np.cos(bend)[:, None] * along + np.sin(bend)[:, None] * ahead)
    return _turn(bones[0], (knee - hip) / thigh, hinge), _turn(bones[1], (ankle - knee) / shank, hinge)


def knee_flexion(thigh: FloatArray, shank: FloatArray, bones: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Angle between thigh and shank, 0 straight [rad], shape (T,)."""
    directions = [
        rotation @ (bone / np.linalg.norm(bone)) for rotation, bone in zip((thigh, shank), bones, strict=True)
    ]
    return np.arccos(np.clip(np.sum(directions[0] * directions[1], axis=1), -1.0, 1.0))


def _turn(bone: FloatArray, along: FloatArray, hinge: FloatArray) -> FloatArray:
    """Rotation that takes `bone` to the direction `along` and the rig's +X to `hinge`, shape (T, 3, 3)."""
    return _frame(along, hinge) @ _frame(bone / np.linalg.norm(bone), np.array([1.0, 0.0, 0.0])).T


def _frame(along: FloatArray, hinge: FloatArray) -> FloatArray:
    return np.stack([hinge, along, np.cross(hinge, along)], axis=-1)
