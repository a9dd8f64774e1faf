"""Foot geometry: where heel and sole are relative to ankle and ball."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.spatial import ConvexHull, QhullError

from usdfoot.analysis.grids import samples_within
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["HEEL_REACH", "ball_height_of_foot", "flat_heels", "heel_offsets", "heels_ahead", "unrest"]

HEEL_REACH = 0.4
"""How far the heel lies behind the ankle, as a fraction of the distance from ankle to ball (design.md section 2)."""

STEEPEST_FOOT = np.radians(50.0)
"""A flat foot whose ball lies more steeply below its ankle has no heel: high heels are below this, metatarsi above."""
STEEPEST_SOLE = np.cos(np.radians(25.0))
"""A facet steeper than this is no sole: the foot has no heel to stand on, and stands as it is posed."""
THINNEST_SOLE = 0.02
"""Less than this part of the way from ankle to ball below the joint is no sole: bones are drawn, not feet."""
CALMEST = 0.15
"""Part of the samples, those in which a foot rests most, that say what is up for it."""
NEARBY = 0.4
"""How long before and after a sample the foot's lowest place is looked for [s]."""
LIFTED = 0.1
"""A foot lifted by this part of its length is as restless as one that turns by 1 rad/s."""


def heels_ahead(ahead: FloatArray, drop: FloatArray, ball_heights: FloatArray) -> FloatArray:
    """How far each heel's point of the sole lies ahead of the ankle of a flat foot, negative behind it [m], any shape.

    A foot steeper than `STEEPEST_FOOT` stands on its toes (birds, dinosaurs): its ankle is no heel. It rests on the pad
    under the ball, which reaches as far back as the ball is high.

    Args:
        ahead: Ball ahead of the ankle [m].
        drop: Ball below the ankle [m].
        ball_heights: Ball above the sole [m].
    """
    return np.where(drop > np.tan(STEEPEST_FOOT) * ahead, ahead - ball_heights, -HEEL_REACH * np.hypot(ahead, drop))


def flat_heels(turns: FloatArray, offsets: FloatArray, ball_heights: FloatArray) -> FloatArray:
    """Heels of flat feet in the ankles' frames: the sole under the ankle, moved back (design.md 2) [m], shape (..., 3).

    Args:
        turns: World rotations of the ankles with the feet flat on level ground, in any heading, shape (..., 4).
        offsets: Balls in the ankles' frames [m], shape (..., 3).
        ball_heights: Balls above the soles [m], shape (...).
    """
    across = quaternion.rotate(turns, offsets)
    reach = heels_ahead(np.linalg.norm(across[..., [0, 2]], axis=-1), -across[..., 1], ball_heights)
    back = planar.direction(planar.yaw_of(across[..., [0, 2]])) * reach[..., None]
    heels = np.stack([back[..., 0], across[..., 1] - ball_heights, back[..., 1]], axis=-1)
    return quaternion.rotate(quaternion.inverse(turns), heels)


def heel_offsets(
    ankles: FloatArray, balls: FloatArray, ankle_rotations: FloatArray, *, ball_heights: FloatArray, rate: float
) -> FloatArray:
    """Heel points of both soles in the frames of the ankle joints.

    The heel is the point of the sole under the ankle, moved back by 0.4 of the distance from ankle to ball. Under and
    back refer to the flat foot: its upward direction is taken from the samples in which the foot is low and hardly
    turns, because rest poses of exported rigs are often a frame of some animation.

    Args:
        ankles: Ankle joints [m], shape (T, 2, 3).
        balls: Ball joints [m], shape (T, 2, 3).
        ankle_rotations: World rotations of the ankle joints, xyzw, continuous in sign, shape (T, 2, 4).
        ball_heights: Ball joints above the sole with the foot flat [m], shape (2,).
        rate: Samples a second [Hz].

    Returns:
        Offsets [m], shape (2, 3).
    """
    inverses = quaternion.inverse(ankle_rotations)
    restless = unrest(ankles, balls, ankle_rotations, rate=rate)
    calm = restless <= np.quantile(restless, CALMEST, axis=0)
    ups = quaternion.rotate(inverses, np.array([0.0, 1.0, 0.0]))
    up = np.stack([np.median(ups[calm[:, side], side], axis=0) for side in range(2)])
    up = up / np.linalg.norm(up, axis=-1, keepdims=True)  # (2, 3)
    ball = np.median(quaternion.rotate(inverses, balls - ankles), axis=0)
    drop = np.sum(ball * up, axis=-1, keepdims=True)
    forward = ball - drop * up
    ahead = np.linalg.norm(forward, axis=-1, keepdims=True)
    forward = forward / np.maximum(ahead, 1e-9)
    return (drop - ball_heights[:, None]) * up + heels_ahead(ahead, -drop, ball_heights[:, None]) * forward


def unrest(ankles: FloatArray, balls: FloatArray, ankle_rotations: FloatArray, *, rate: float) -> FloatArray:
    """How little each foot stands flat: by its height above the lowest nearby and its turning, shape (T, 2)."""
    heights = ankles[..., 1] + balls[..., 1]
    lowest = minimum_filter1d(heights, 2 * samples_within(NEARBY, 1.0 / rate) + 1, axis=0, mode="nearest")
    size = float(np.median(np.linalg.norm(balls - ankles, axis=-1)))
    spin = 2.0 * np.linalg.norm(np.gradient(ankle_rotations, axis=0), axis=-1) * rate  # [rad/s]
    return (heights - lowest) / (LIFTED * size + 1e-9) + spin


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
    is_sole = -sole[1] > STEEPEST_SOLE
    height = -float(sole[:3] @ ball + sole[3]) if is_sole else float(ball[1] - points[:, 1].min())
    length = float(np.linalg.norm(ball - ankle))
    return height if THINNEST_SOLE * length < height < length else None
