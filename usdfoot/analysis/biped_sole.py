"""How high the ball joint stands above the sole, measured on the points of a foot."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from usdfoot.maths.types import FloatArray

__all__ = ["ball_height_of_foot"]


_STEEPEST = np.cos(np.radians(25.0))
"""A facet steeper than this is no sole: the foot has no heel to stand on, and stands as it is posed."""
_THINNEST = 0.02
"""Less than this part of the way from ankle to ball below the joint is no sole: bones are drawn, not feet."""


def ball_height_of_foot(points: FloatArray, ankle: FloatArray, ball: FloatArray) -> float | None:
    """Distance from the ball joint to the plane on which the foot rests [m]; None if the points do not tell.

    A body rests on the facet of its convex hull below its weight, so a tilted foot does not matter: the facet under the
    middle between ankle and ball is the sole.

    Args:
        points: Points of foot and toes [m], +Y roughly up, shape (P, 3).
        ankle: Ankle joint in the same pose [m], shape (3,).
        ball: Ball joint in the same pose [m], shape (3,).
    """
    if len(points) < 4:
        return None
    try:
        equations = ConvexHull(points).equations  # n . x + d <= 0 inside, (H, 4)
    except QhullError:
        return None
    downward = equations[equations[:, 1] < -1e-6]
    if not len(downward):
        return None
    middle = 0.5 * (ankle + ball)
    floors = -(downward[:, 0] * middle[0] + downward[:, 2] * middle[2] + downward[:, 3]) / downward[:, 1]
    sole = downward[np.argmax(floors)]
    is_sole = -sole[1] > _STEEPEST
    height = -float(sole[:3] @ ball + sole[3]) if is_sole else float(ball[1] - points[:, 1].min())
    length = float(np.linalg.norm(ball - ankle))
    return height if _THINNEST * length < height < length else None
