"""The nearest point of a set of segments."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["project_on_segments"]

CHUNK = 1 << 20
"""Pairs of point and segment looked at in one go, for bounded memory."""


def project_on_segments(segments: FloatArray, points: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """The nearest point of all segments, orthogonal or clamped to an end ([B] 5).

    Args:
        segments: Start and end, H of them, shape (H, 2, 2); a segment may be a point.
        points: Shape (N, 2).

    Returns:
        Segment (N,), the first of equally near ones, fraction along it (N,) and the nearest point itself (N, 2).
    """
    starts, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    squares = np.sum(along**2, axis=1)
    squares = np.where(squares > 0.0, squares, 1.0)
    nearest, fractions = np.empty(len(points), dtype=np.intp), np.empty(len(points))
    step = max(1, CHUNK // len(segments))
    for begin in range(0, len(points), step):
        part = slice(begin, begin + step)
        offset = points[part, None] - starts  # (n, H, 2)
        fraction = np.clip(np.sum(offset * along, axis=-1) / squares, 0.0, 1.0)
        distance = np.sum((offset - fraction[..., None] * along) ** 2, axis=-1)
        nearest[part] = np.argmin(distance, axis=1)
        fractions[part] = np.take_along_axis(fraction, nearest[part, None], axis=1)[:, 0]
    return nearest, fractions, starts[nearest] + fractions[:, None] * along[nearest]
