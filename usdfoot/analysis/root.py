"""Root motion: whether a clip travels, and the travel given back to clips that run in place.

In a clip that runs in place the stance foot slides backward: its velocity is minus the root's (design.md section 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from usdfoot.analysis.motion import FootMotion, foot_motion, moved
from usdfoot.analysis.signals import fine_times
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["RootMotion", "detect_root_motion", "restored"]


@dataclass(frozen=True, kw_only=True)
class RootMotion:
    """Travel missing from a clip; zero where it is in the samples already."""

    in_place: bool
    """Whether the clip runs in place."""
    velocity: FloatArray
    """Missing planar velocity of the root, in the frame of the clip's samples, (x, z) [m/s], shape (2,)."""
    yaw_rate: float
    """Missing turning [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class _LowFeet:
    """Samples of both balls with how likely each belongs to a stance."""

    positions: FloatArray
    """(x, z) [m], shape (M, 2)."""
    velocities: FloatArray
    """[m/s], shape (M, 2)."""
    yaw_rates: FloatArray
    """Of the direction from ankle to ball [rad/s], shape (M,)."""
    weights: FloatArray
    """Shape (M,)."""
    fastest: float
    """95th percentile of the balls' speed [m/s]."""


def detect_root_motion(clip: Clip, skeleton: Skeleton, biped: Biped) -> RootMotion:
    """Travel missing from a clip, from the commonest velocity of its low feet.

    Args:
        clip: The clip; `clip.root_motion` travel or inPlace overrules the detection.
        skeleton: Its skeleton.
        biped: Its leg joints.
    """
    none = RootMotion(in_place=False, velocity=np.zeros(2), yaw_rate=0.0)
    if clip.root_motion == "travel":
        return none
    motion = foot_motion(clip, skeleton, biped)
    feet = _low_feet(motion)
    slip = _commonest(feet.velocities, feet)
    drift = (motion.pelvis[-1] - motion.pelvis[0])[[0, 2]] / (motion.times[-1] - motion.times[0])
    slips = np.linalg.norm(slip) > max(0.1 * feet.fastest, 0.125 * biped.maximal_leg_length)
    if clip.root_motion == "auto" and not (slips and np.linalg.norm(drift) < 0.3 * np.linalg.norm(slip)):
        return none
    near = np.exp(-np.sum((feet.velocities - slip) ** 2, axis=1) / (0.2 * feet.fastest + 1e-9) ** 2)
    yaw_rate = -_weighted_median(feet.yaw_rates, feet.weights * near)
    yaw_rate = yaw_rate if abs(yaw_rate) > 0.2 else 0.0
    turning = yaw_rate * np.stack([feet.positions[:, 1], -feet.positions[:, 0]], axis=1)
    return RootMotion(in_place=True, velocity=-_commonest(feet.velocities + turning, feet), yaw_rate=yaw_rate)


def _low_feet(motion: FootMotion) -> _LowFeet:
    """Fine samples of both balls, weighted by how low and level they move."""
    rate = (len(motion.times) - 1) / (motion.times[-1] - motion.times[0])
    grid = fine_times(motion.times[0], len(motion.times), rate, 120.0)
    spline = CubicSpline(motion.times, motion.balls)
    positions, velocities = spline(grid), spline(grid, 1)  # (N, 2, 3)
    forward = (motion.balls - motion.ankles)[..., [0, 2]]
    yaws = CubicSpline(motion.times, np.unwrap(planar.yaw_of(forward), axis=0))
    fastest = float(np.quantile(np.linalg.norm(velocities, axis=-1), 0.95))
    low, high = np.quantile(positions[..., 1], [0.05, 0.95], axis=0)
    heights = (positions[..., 1] - low) / np.maximum(high - low, 1e-6)
    level = velocities[..., 1] / max(fastest, 1e-6)
    weights = np.exp(-((np.maximum(heights, 0.0) / 0.2) ** 2) - (level / 0.1) ** 2)
    return _LowFeet(
        positions=positions[..., [0, 2]].reshape(-1, 2),
        velocities=velocities[..., [0, 2]].reshape(-1, 2),
        yaw_rates=yaws(grid, 1).reshape(-1),
        weights=weights.reshape(-1),
        fastest=fastest,
    )


def _commonest(velocities: FloatArray, feet: _LowFeet) -> FloatArray:
    """Mode of weighted planar velocities (M, 2), by a kernel density on the samples and mean shift, shape (2,)."""
    width = 0.06 * feet.fastest + 1e-6
    stride = max(1, len(velocities) // 600)
    centres = velocities[::stride]
    density = _kernel(centres, velocities, width) @ feet.weights
    mode = centres[np.argmax(density)]
    for _ in range(8):
        pull = _kernel(mode[None], velocities, width)[0] * feet.weights
        mode = pull @ velocities / max(pull.sum(), 1e-12)
    return mode


def _kernel(centres: FloatArray, velocities: FloatArray, width: float) -> FloatArray:
    """Gaussian kernel between (C, 2) and (M, 2), shape (C, M)."""
    squares = np.sum((centres[:, None] - velocities[None]) ** 2, axis=-1)
    return np.exp(-0.5 * squares / width**2)


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Weighted median of values (M,)."""
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, 0.5 * share[-1])])


def restored(
    clip: Clip, skeleton: Skeleton, yaw_rate: float, velocities: FloatArray, *, origin_time: float
) -> Clip:
    """The clip with its travel given back; the pose at `origin_time` stays where it is.

    Args:
        clip: A clip that runs in place, T samples.
        skeleton: Its skeleton.
        yaw_rate: Turning to add [rad/s].
        velocities: Root velocity in the frame of the clip's samples (x, z) [m/s], shape (T, 2) or (2,).
        origin_time: Time at which nothing is added [s].
    """
    yaws = yaw_rate * (clip.times - origin_time)
    ground = planar.rotate(yaws, np.broadcast_to(velocities, (len(yaws), 2)))
    path = np.zeros_like(ground)
    path[1:] = np.cumsum(0.5 * (ground[1:] + ground[:-1]), axis=0) / clip.rate
    start = [np.interp(origin_time, clip.times, path[:, axis]) for axis in range(2)]
    return moved(clip, skeleton, path - np.array(start), yaws)
