"""Cycles: clips whose last sample continues with the first, and their repetition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from usdfoot.analysis.motion import moved, partial_kinematics
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["detect_period", "repeated"]

WHOLE = 0.02
"""A period this close to a whole number of samples counts as one [samples]."""


def detect_period(clip: Clip, skeleton: Skeleton, biped: Biped, *, tolerance: float = 0.4) -> float | None:
    """Duration of one cycle [s], or None where the clip is no loop.

    Exporters repeat the first pose at the end, stop one sample short of it, or, where the cycle is no whole number of
    their samples, anywhere in between. So the last pose, moved on at the velocity of the ends by a part of a sample,
    must be the first. Poses are compared by the joints below the pelvis, in the pelvis's heading.

    Args:
        clip: The clip; `clip.cyclic` True or False overrules the comparison.
        skeleton: Its skeleton.
        biped: Its leg joints.
        tolerance: Largest difference of the poses at the seam, relative to the motion of one sample.
    """
    if clip.cyclic is False or len(clip.rotations) < 4:
        return None
    first, second, before, last = _seam_poses(clip, skeleton, biped)
    velocity = 0.5 * (second - first + last - before)  # a sample
    gap, step = first - last, _rms(velocity)
    part = float(np.sum(gap * velocity) / max(np.sum(velocity**2), 1e-12))
    part = round(part) if abs(part - round(part)) < 5.0 * WHOLE else part
    period = (len(clip.rotations) - 1 + min(max(part, 0.0), 1.0)) / clip.rate
    if clip.cyclic:
        return period
    closes = _rms(gap - part * velocity) < tolerance * step and 0.0 <= part <= 1.0
    moves = step * clip.rate > 0.1 * biped.maximal_leg_length
    return period if closes and moves and period > 0.25 else None


def _seam_poses(clip: Clip, skeleton: Skeleton, biped: Biped) -> FloatArray:
    """Joints below the pelvis at the first two and last two samples, in the pelvis's heading, shape (4, K, 3)."""
    joints = [biped.pelvis]
    for joint in range(biped.pelvis + 1, len(skeleton.joints)):
        if int(skeleton.parents[joint]) in joints:
            joints.append(joint)
    ends = replace(clip, translations=clip.translations[[0, 1, -2, -1]], rotations=clip.rotations[[0, 1, -2, -1]])
    positions, rotations = partial_kinematics(skeleton, ends, np.array(joints))
    yaws = _turns(rotations[:1, 0], rotations[:, 0])
    poses = positions - positions[:, :1] * np.array([1.0, 0.0, 1.0])
    return quaternion.rotate(quaternion.yaw_quaternion(-yaws)[:, None], poses)


def _turns(start: FloatArray, end: FloatArray) -> FloatArray:
    """Yaw [rad] of the rotations that turn `start` into `end` (..., 4): their twist about +Y."""
    relative = quaternion.compose(end, quaternion.inverse(start))
    return planar.wrap_angle(2.0 * np.arctan2(relative[..., 1], relative[..., 3]))


def _rms(vectors: FloatArray) -> float:
    """Root mean square length of vectors (K, 3)."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))


def repeated(clip: Clip, skeleton: Skeleton, biped: Biped, period: float) -> Clip:
    """Three cycles of a loop, one before and one after its own, each continuing where the last one arrived.

    Samples fall on the clip's own sample times, before and after them at the same rate.
    """
    samples = period * clip.rate
    count = len(clip.rotations) - (1 if samples < len(clip.rotations) - 0.7 else 0)
    cycle = replace(clip, translations=clip.translations[:count], rotations=clip.rotations[:count])
    turn, shift = _advance(clip, skeleton, biped, samples)
    parts = [moved(cycle, skeleton, planar.rotate(-turn, -shift), -turn), cycle, moved(cycle, skeleton, shift, turn)]
    translations = np.concatenate([part.translations for part in parts])
    rotations = quaternion.continuous(np.concatenate([part.rotations for part in parts]))
    before = round(samples)
    if abs(samples - before) > WHOLE:
        places = (np.arange(3)[:, None] * samples + np.arange(count)).ravel()
        before = int(samples)
        grid = samples + np.arange(-before, int(places[-1] - samples) + 1)
        translations = CubicSpline(places, translations)(grid)
        rotations = quaternion.normalised(CubicSpline(places, rotations)(grid))
    return replace(
        clip, start_time=clip.start_time - before / clip.rate, translations=translations, rotations=rotations
    )


def _advance(clip: Clip, skeleton: Skeleton, biped: Biped, samples: float) -> tuple[FloatArray, FloatArray]:
    """Turn [rad] and shift (x, z) [m] that carry the first cycle onto the next, from the pelvis."""
    positions, rotations = partial_kinematics(skeleton, clip, np.array([biped.pelvis]))
    ground, pelvis = positions[:, 0][:, [0, 2]], rotations[:, 0]
    # Where the cycle ends after the last sample, the pelvis goes on at the mean velocity of both ends.
    part = samples - (len(clip.rotations) - 1)
    turn = _turns(pelvis[0], pelvis[-1])
    turn = turn + part * 0.5 * (_turns(pelvis[0], pelvis[1]) + _turns(pelvis[-2], pelvis[-1]))
    step = 0.5 * (planar.rotate(turn, ground[1] - ground[0]) + ground[-1] - ground[-2])
    return turn, ground[-1] + part * step - planar.rotate(turn, ground[0])
