"""Rotation matrices about the axes, batched over time: shape (..., 3, 3), column vectors, right-handed."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]


def about_x(angle: FloatArray | float) -> FloatArray:
    """Rotation about +X: takes +Y to +Z, so a positive angle [rad] raises the heel of a foot that faces +Z."""
    return _about(0, angle)


def about_y(angle: FloatArray | float) -> FloatArray:
    """Rotation about +Y: takes +Z to +X, the sense of yaw [rad]."""
    return _about(1, angle)


def about_z(angle: FloatArray | float) -> FloatArray:
    """Rotation about +Z: takes +X to +Y, so a positive angle [rad] raises the left (+X) hip."""
    return _about(2, angle)


def about_axis(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Rotation by `angle` [rad], shape (T,), about one unit `axis`, shape (3,)."""
    return Rotation.from_rotvec(np.asarray(angle)[..., None] * axis).as_matrix()


def between(start: FloatArray, end: FloatArray, fraction: float) -> FloatArray:
    """The part of the way from `start` to `end` given by `fraction`, as a rotation in the axes of `start`."""
    relative = Rotation.from_matrix(np.swapaxes(start, -1, -2) @ end).as_rotvec()
    return Rotation.from_rotvec(relative * fraction).as_matrix()


def to_quaternions(matrices: FloatArray) -> FloatArray:
    """Unit quaternions (xyzw), shape (T, ..., 4), without sign changes along the first axis."""
    flat = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat().reshape(*matrices.shape[:-2], 4)
    flat[0] *= np.where(flat[0, ..., 3:] < 0, -1.0, 1.0)
    flips = np.sign(np.sum(flat[1:] * flat[:-1], axis=-1, keepdims=True))
    flat[1:] *= np.cumprod(np.where(flips == 0, 1.0, flips), axis=0)
    return flat


def apply(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """`matrices` (..., 3, 3) times `vectors` (..., 3)."""
    return np.einsum("...ij,...j->...i", matrices, vectors)


def _about(axis: int, angle: FloatArray | float) -> FloatArray:
    """Rotation about coordinate axis 0, 1 or 2."""
    angle = np.asarray(angle, dtype=np.float64)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., axis, axis] = 1.0
    matrix[..., first, first] = matrix[..., second, second] = np.cos(angle)
    matrix[..., second, first] = np.sin(angle)
    matrix[..., first, second] = -np.sin(angle)
    return matrix
