"""Footprints to look at: a flat outline for each foot, sized after the character."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT

__all__ = ["PRINT_COLORS", "print_extent", "print_outline"]

PRINT_COLORS = ((0.15, 0.45, 0.85), (0.9, 0.45, 0.1))
"""Left and right, linear RGB."""
LIFT = 0.004
"""Height of a print over the ground, against flicker [m]."""
_LEFT_OUTLINE = np.array(
    [
        (0.25, -1.60),
        (0.33, -1.30),
        (0.30, -0.65),
        (0.42, 0.00),
        (0.37, 0.38),
        (0.16, 0.68),
        (-0.10, 0.70),
        (-0.30, 0.50),
        (-0.37, 0.16),
        (-0.33, -0.33),
        (-0.20, -0.83),
        (-0.28, -1.37),
        (-0.15, -1.64),
    ]
)
"""Outline of a left print, (x, z) from the ball over the distance from ankle to ball, clockwise seen from above."""


def print_outline(side: int, size: float) -> FloatArray:
    """Corners [m] in the print's frame, +Z forward and +Y up, counter-clockwise seen from above, shape (13, 3).

    Args:
        side: 0 = left, 1 = right.
        size: Distance from ankle to ball [m].
    """
    outline = _LEFT_OUTLINE[::-1] if side == LEFT else _LEFT_OUTLINE * (-1.0, 1.0)
    return np.insert(outline * size, 1, LIFT, axis=1)


def print_extent(
    positions: FloatArray, orientations: FloatArray, sides: IntArray, *, outlines: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Lowest and highest corner [m] of all prints (N) with outlines of both sides laid out, shape (2, 3)."""
    corners = quaternion.rotate(orientations[:, None], np.stack(outlines)[sides]) + positions[:, None]  # (N, 13, 3)
    return np.stack([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
