"""Planar rigid transforms of the ground plane: position (x, z) and yaw about +Y, from +Z towards +X."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray

__all__ = ["GROUND_AXES", "circular_mean", "direction", "midway_yaw", "rotate", "wrap_angle", "yaw_of"]

GROUND_AXES = np.array([0, 2])
"""Which components of a position are its point (x, z) of the ground."""


def rotate(yaw: FloatArray, points: FloatArray) -> FloatArray:
    """Ground points (..., 2), as (x, z), turned by yaw [rad] (...)."""
    cosine, sine = np.cos(yaw), np.sin(yaw)
    x, z = points[..., 0], points[..., 1]
    return np.stack([cosine * x + sine * z, cosine * z - sine * x], axis=-1)


def direction(yaw: FloatArray) -> FloatArray:
    """Unit ground vectors (x, z) of yaw [rad]: 0 is +Z, pi/2 is +X, shape (..., 2)."""
    return np.stack([np.sin(yaw), np.cos(yaw)], axis=-1)


def yaw_of(vectors: FloatArray) -> FloatArray:
    """Yaw [rad] of ground vectors (x, z) (..., 2)."""
    return np.arctan2(vectors[..., 0], vectors[..., 1])


def wrap_angle(angles: FloatArray) -> FloatArray:
    """Angles [rad] brought into -pi..pi."""
    return np.remainder(np.asarray(angles) + np.pi, 2.0 * np.pi) - np.pi


def midway_yaw(first: FloatArray, second: FloatArray) -> FloatArray:
    """Yaw halfway on the shorter turn from one to the other [rad]."""
    return first + 0.5 * wrap_angle(second - first)


def circular_mean(angles: FloatArray, *, axis: int = -1) -> FloatArray:
    """Mean of angles [rad] on the circle along `axis`."""
    return np.arctan2(np.sum(np.sin(angles), axis=axis), np.sum(np.cos(angles), axis=axis))
