"""Cycles: clips whose last sample continues with the first, and their repetition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.analysis.motion import moved, partial_kinematics
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["detect_period", "repeated"]


def detect_period(clip: Clip, skeleton: Skeleton, biped: Biped, *, tolerance: float = 0.5) -> float | None:
    """Duration of one cycle [s], or None where the clip is no loop.

    The last pose is either the first one again (then the cycle is one sample shorter than the clip) or the one just
    before it. Poses are compared by the joints below the pelvis, in the pelvis's heading.

    Args:
        clip: The clip; `clip.cyclic` True or False overrules the comparison.
        skeleton: Its skeleton.
        biped: Its leg joints.
        tolerance: Largest difference of poses and velocities at the seam, relative to the motion of one sample.
    """
    if clip.cyclic is False or len(clip.rotations) < 4:
        return None
    first, second, before, last = _seam_poses(clip, skeleton, biped)
    steps = second - first, last - before
    step = min(_rms(steps[0]), _rms(steps[1]))
    repeats = _rms(last - first) < tolerance * step
    count = len(clip.rotations) - (1 if repeats else 0)
    if clip.cyclic:
        return count / clip.rate
    moving = step * clip.rate > 0.1 * biped.maximal_leg_length
    same_velocity = _rms(steps[0] - steps[1]) < tolerance * step
    continues = _rms(first - last - 0.5 * (steps[0] + steps[1])) < tolerance * step
    long_enough = count / clip.rate > 0.25
    return count / clip.rate if moving and same_velocity and long_enough and (repeats or continues) else None


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

    Sample times of the middle cycle are those of the clip.
    """
    count = round(period * clip.rate)
    cycle = replace(clip, translations=clip.translations[:count], rotations=clip.rotations[:count])
    turn, shift = _advance(clip, skeleton, biped, count)
    back = planar.rotate(-turn, -shift)
    parts = [moved(cycle, skeleton, back, -turn), cycle, moved(cycle, skeleton, shift, turn)]
    return replace(
        clip,
        start_time=clip.start_time - period,
        translations=np.concatenate([part.translations for part in parts]),
        rotations=quaternion.continuous(np.concatenate([part.rotations for part in parts])),
    )


def _advance(clip: Clip, skeleton: Skeleton, biped: Biped, count: int) -> tuple[FloatArray, FloatArray]:
    """Turn [rad] and shift (x, z) [m] that carry the first cycle onto the next, from the pelvis."""
    positions, rotations = partial_kinematics(skeleton, clip, np.array([biped.pelvis]))
    ground, pelvis = positions[:, 0][:, [0, 2]], rotations[:, 0]
    if count < len(clip.rotations):
        turn = _turns(pelvis[0], pelvis[count])
        return turn, ground[count] - planar.rotate(turn, ground[0])
    # The sample after the last is missing: continue with the mean velocity of both ends.
    turn = _turns(pelvis[0], pelvis[-1])
    turn = turn + 0.5 * (_turns(pelvis[0], pelvis[1]) + _turns(pelvis[-2], pelvis[-1]))
    step = 0.5 * (planar.rotate(turn, ground[1] - ground[0]) + ground[-1] - ground[-2])
    return turn, ground[-1] + step - planar.rotate(turn, ground[0])
