"""Unit quaternions in xyzw order; batch axes lead, the four components trail: (..., 4)."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray

__all__ = [
    "align_signs",
    "between",
    "compose",
    "continuous",
    "facing",
    "from_axis_angle",
    "from_matrix",
    "from_rotation_vector",
    "inverse",
    "mean",
    "mirror_x",
    "normalised",
    "rotate",
    "slerp",
    "to_matrix",
    "to_rotation_vector",
    "yaw_quaternion",
]


def normalised(quaternions: FloatArray) -> FloatArray:
    """Quaternions scaled to unit length, shape (..., 4)."""
    return quaternions / np.sqrt(np.einsum("...i,...i->...", quaternions, quaternions))[..., None]


def compose(first: FloatArray, second: FloatArray) -> FloatArray:
    """Product first * second: the rotation that applies `second`, then `first`, shape (..., 4)."""
    ax, ay, az, aw = _components(first)
    bx, by, bz, bw = _components(second)
    x = aw * bx + ax * bw + ay * bz - az * by
    product = np.empty((*x.shape, 4), dtype=x.dtype)
    product[..., 0] = x
    product[..., 1] = aw * by - ax * bz + ay * bw + az * bx
    product[..., 2] = aw * bz + ax * by - ay * bx + az * bw
    product[..., 3] = aw * bw - ax * bx - ay * by - az * bz
    return product


def inverse(quaternions: FloatArray) -> FloatArray:
    """Inverse rotations of unit quaternions, shape (..., 4)."""
    return quaternions * np.array([-1.0, -1.0, -1.0, 1.0], dtype=np.asarray(quaternions).dtype)


def rotate(quaternions: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    x, y, z, w = _components(quaternions)
    vx, vy, vz = _components(vectors)
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)  # v + w t + axis x t
    first = vx + w * tx + (y * tz - z * ty)
    turned = np.empty((*first.shape, 3), dtype=first.dtype)
    turned[..., 0] = first
    turned[..., 1] = vy + w * ty + (z * tx - x * tz)
    turned[..., 2] = vz + w * tz + (x * ty - y * tx)
    return turned


def from_axis_angle(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Rotations by angle [rad] (...) about unit axes (..., 3), shape (..., 4)."""
    half = 0.5 * np.asarray(angle, dtype=float)[..., None]
    axis = np.broadcast_to(axis, (*half.shape[:-1], 3))
    return np.concatenate([axis * np.sin(half), np.cos(half)], axis=-1)


def yaw_quaternion(yaw: FloatArray) -> FloatArray:
    """Rotations about +Y by yaw [rad] (...), shape (..., 4)."""
    half = 0.5 * np.asarray(yaw, dtype=float)
    zero = np.zeros_like(half)
    return np.stack([zero, np.sin(half), zero, np.cos(half)], axis=-1)


def from_rotation_vector(vectors: FloatArray) -> FloatArray:
    """Exponential map of rotation vectors [rad] (..., 3), shape (..., 4)."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    scale = 0.5 * np.sinc(0.5 * angle / np.pi)
    return np.concatenate([vectors * scale, np.cos(0.5 * angle)], axis=-1)


def to_rotation_vector(quaternions: FloatArray) -> FloatArray:
    """Logarithm of unit quaternions: the shorter rotation vector [rad], shape (..., 3)."""
    quaternions = np.where(quaternions[..., 3:] < 0.0, -quaternions, quaternions)
    sine = np.linalg.norm(quaternions[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternions[..., 3:])
    scale = np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
    return quaternions[..., :3] * scale


def between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Smallest rotations that turn unit vectors `start` onto unit vectors `end`, shape (..., 4).

    Opposite vectors turn by pi about an arbitrary perpendicular axis.
    """
    start, end = np.broadcast_arrays(start, end)
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    quaternions = np.concatenate([np.cross(start, end), 1.0 + cosine], axis=-1)
    helper = np.where(np.abs(start[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    perpendicular = np.cross(start, helper)
    turned = np.concatenate([perpendicular, np.zeros_like(cosine)], axis=-1)
    return normalised(np.where(cosine < -1.0 + 1e-12, turned, quaternions))


def facing(forward: FloatArray, up: FloatArray) -> FloatArray:
    """Rotations that turn +Z into forward, seen along up, and +Y into up, shape (N, 4).

    Args:
        forward: Not along up, shape (N, 3).
        up: Not zero, shape (N, 3).
    """
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    left = np.cross(up, forward)
    left = left / np.linalg.norm(left, axis=1, keepdims=True)
    return from_matrix(np.stack([left, up, np.cross(left, up)], axis=-1))


def align_signs(quaternions: FloatArray, reference: FloatArray) -> FloatArray:
    """Quaternions with the sign that lies in the half space of `reference`, shape (..., 4)."""
    dot = np.sum(quaternions * reference, axis=-1, keepdims=True)
    return np.where(dot < 0.0, -quaternions, quaternions)


def continuous(quaternions: FloatArray) -> FloatArray:
    """Quaternions (T, ..., 4) with signs flipped so that none changes sign along the first axis."""
    opposite = np.einsum("...i,...i->...", quaternions[1:], quaternions[:-1]) < 0.0
    if not opposite.any():
        return quaternions
    flips = np.cumprod(np.where(opposite, -1.0, 1.0), axis=0)[..., None]
    return np.concatenate([quaternions[:1], quaternions[1:] * flips], axis=0)


def slerp(start: FloatArray, end: FloatArray, fraction: FloatArray) -> FloatArray:
    """Spherical interpolation from start to end (..., 4) along the shorter arc; fraction (...) in 0..1."""
    relative = to_rotation_vector(compose(inverse(start), end))
    return compose(start, from_rotation_vector(relative * np.asarray(fraction)[..., None]))


def mean(quaternions: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted mean rotation over the first axis by the largest eigenvector (Markley et al. 2007).

    Args:
        quaternions: Shape (K, ..., 4).
        weights: Non-negative, shape (K,).

    Returns:
        Unit quaternions, shape (..., 4), independent of the signs of the input.
    """
    moments = np.einsum("k,k...i,k...j->...ij", weights, quaternions, quaternions)
    _, vectors = np.linalg.eigh(moments)
    return vectors[..., :, -1]


def mirror_x(quaternions: FloatArray) -> FloatArray:
    """Rotations reflected in the plane x = 0, shape (..., 4)."""
    return quaternions * np.array([1.0, -1.0, -1.0, 1.0], dtype=np.asarray(quaternions).dtype)


def to_matrix(quaternions: FloatArray) -> FloatArray:
    """Rotation matrices (column vectors), shape (..., 3, 3)."""
    columns = [rotate(quaternions, np.eye(3)[i]) for i in range(3)]
    return np.stack(columns, axis=-1)


def from_matrix(matrices: FloatArray) -> FloatArray:
    """Unit quaternions of rotation matrices (column vectors) (..., 3, 3), shape (..., 4), w >= 0."""
    m = np.asarray(matrices, dtype=float)
    # Four times the outer product of the quaternion with itself; its longest row is the safest (Bar-Itzhack 2000).
    trace = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    product = np.empty((*m.shape[:-2], 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        product[..., i, i] = 1.0 + 2.0 * m[..., i, i] - trace
        product[..., i, j] = product[..., j, i] = m[..., i, j] + m[..., j, i]
        product[..., i, 3] = product[..., 3, i] = m[..., k, j] - m[..., j, k]
    product[..., 3, 3] = 1.0 + trace
    longest = np.argmax(np.diagonal(product, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(product, longest[..., None, None], axis=-2)[..., 0, :]
    row = normalised(row)
    return np.where(row[..., 3:] < 0.0, -row, row)


def _components(values: FloatArray) -> tuple[FloatArray, ...]:
    """Views of the last axis, much quicker than moving it."""
    values = np.asarray(values)
    return tuple(values[..., index] for index in range(values.shape[-1]))
