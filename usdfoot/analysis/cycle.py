"""Cycles: clips whose last sample continues with the first, and their repetition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.analysis.motion import joint_kinematics, moved
from usdfoot.maths import planar, quaternion
from usdfoot.maths.splines import spline_shares
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["detect_periods", "repeated"]

WHOLE = 0.02
"""A period this close to a whole number of samples counts as one [samples]."""
ENDS = [0, 1, -2, -1]
"""Samples that tell whether and how a clip goes on."""


def detect_periods(
    clips: Sequence[Clip], skeleton: Skeleton, biped: Biped, *, tolerance: float = 0.4
) -> list[float | None]:
    """Duration of one cycle of each clip [s], None where it is no loop.

    Exporters repeat the first pose at the end, stop one sample short of it, or, where the cycle is no whole number of
    their samples, anywhere in between. So the last pose, moved on at the velocity of the ends by a part of a sample,
    must be the first. Poses are compared by the joints below the pelvis, in the pelvis's heading.

    Args:
        clips: The clips; a clip's `cyclic` True or False overrules the comparison.
        skeleton: Their skeleton.
        biped: Its leg joints.
        tolerance: Largest difference of the poses at the seam, relative to the motion of one sample.
    """
    candidates = [index for index, clip in enumerate(clips) if clip.cyclic is not False and len(clip.rotations) >= 4]
    periods: list[float | None] = [None] * len(clips)
    if candidates:
        poses = _seam_poses([clips[index] for index in candidates], skeleton, biped)
        for index, own in zip(candidates, poses, strict=True):
            periods[index] = _period(clips[index], own, biped, tolerance)
    return periods


def _period(clip: Clip, poses: FloatArray, biped: Biped, tolerance: float) -> float | None:
    """Duration of one cycle [s] of a clip with these poses (4, K, 3) at the seam, None if it is no loop."""
    first, second, before, last = poses
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


def _seam_poses(clips: Sequence[Clip], skeleton: Skeleton, biped: Biped) -> FloatArray:
    """Joints below the pelvis at the first two and last two samples, in the pelvis's heading, shape (C, 4, K, 3)."""
    joints = [biped.pelvis]
    for joint in range(biped.pelvis + 1, len(skeleton.joints)):
        if int(skeleton.parents[joint]) in joints:
            joints.append(joint)
    translations, rotations = [clip.translations[ENDS] for clip in clips], [clip.rotations[ENDS] for clip in clips]
    positions, turned = joint_kinematics(skeleton, translations, rotations, joints=np.array(joints))
    pelvis = turned[:, 0].reshape(len(clips), -1, 4)
    yaws = _turns(pelvis[:, :1], pelvis).ravel()
    poses = positions - positions[:, :1] * np.array([1.0, 0.0, 1.0])
    turned_back = quaternion.rotate(quaternion.yaw_quaternion(-yaws)[:, None], poses)
    return turned_back.reshape(len(clips), len(ENDS), -1, 3)


def _turns(start: FloatArray, end: FloatArray) -> FloatArray:
    """Yaw [rad] of the rotations that turn `start` into `end` (..., 4): their twist about +Y."""
    relative = quaternion.compose(end, quaternion.inverse(start))
    return planar.wrap_angle(2.0 * np.arctan2(relative[..., 1], relative[..., 3]))


def _rms(vectors: FloatArray) -> float:
    """Root mean square length of vectors (K, 3)."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=-1))))


def repeated(clips: Sequence[Clip], skeleton: Skeleton, biped: Biped, *, periods: Sequence[float | None]) -> list[Clip]:
    """Clips with three cycles of each loop, those without a period [s] as they are.

    One cycle comes before and one after a loop's own, each continuing where the last one arrived. Samples fall on the
    clip's own sample times, before and after them at the same rate.
    """
    ends = [clip.translations[ENDS] for clip in clips], [clip.rotations[ENDS] for clip in clips]
    positions, rotations = joint_kinematics(skeleton, *ends, joints=np.array([biped.pelvis]))
    return [
        clip if period is None else _three_cycles(clip, skeleton, period, *_advance(clip, period, *pelvis))
        for clip, period, *pelvis in zip(
            clips, periods, positions.reshape(-1, len(ENDS), 3), rotations.reshape(-1, len(ENDS), 4), strict=True
        )
    ]


def _three_cycles(clip: Clip, skeleton: Skeleton, period: float, turn: FloatArray, shift: FloatArray) -> Clip:
    """The loop with what it was before and will be after, as `_advance` carries it on."""
    samples = period * clip.rate
    count = len(clip.rotations) - (1 if samples < len(clip.rotations) - 0.7 else 0)
    cycle = replace(clip, translations=clip.translations[:count], rotations=clip.rotations[:count])
    parts = [
        moved(cycle, skeleton, positions=planar.rotate(-turn, -shift), yaws=-turn),
        cycle,
        moved(cycle, skeleton, positions=shift, yaws=turn),
    ]
    translations = np.concatenate([part.translations for part in parts])
    rotations = quaternion.continuous(np.concatenate([part.rotations for part in parts]))
    before = round(samples)
    if abs(samples - before) > WHOLE:
        places = (np.arange(3)[:, None] * samples + np.arange(count)).ravel()
        before = int(samples)
        grid = samples + np.arange(-before, int(places[-1] - samples) + 1)
        shares = spline_shares(places, grid)
        translations = np.tensordot(shares, translations, axes=1)
        rotations = quaternion.normalised(np.tensordot(shares, rotations, axes=1))
    return replace(
        clip, start_time=clip.start_time - before / clip.rate, translations=translations, rotations=rotations
    )


def _advance(clip: Clip, period: float, positions: FloatArray, pelvis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Turn [rad] and shift (x, z) [m] that carry the first cycle onto the next.

    Args:
        clip: A loop.
        period: Of its cycle [s].
        positions: Pelvis in the world at its ENDS [m], shape (4, 3).
        pelvis: Its rotations there, shape (4, 4).
    """
    samples, ground = period * clip.rate, positions[:, [0, 2]]
    # Where the cycle ends after the last sample, the pelvis goes on at the mean velocity of both ends.
    part = samples - (len(clip.rotations) - 1)
    turn = _turns(pelvis[0], pelvis[-1])
    turn = turn + part * 0.5 * (_turns(pelvis[0], pelvis[1]) + _turns(pelvis[-2], pelvis[-1]))
    step = 0.5 * (planar.rotate(turn, ground[1] - ground[0]) + ground[-1] - ground[-2])
    return turn, ground[-1] + part * step - planar.rotate(turn, ground[0])
