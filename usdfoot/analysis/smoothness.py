"""Smoothness: how fast joints turn, and how abruptly that changes (design.md section 10)."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.splines import build_splines
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["angular_jerks", "angular_jumps", "angular_speeds", "body_joints", "clip_rotations"]


def angular_speeds(rotations: FloatArray, rate: float) -> FloatArray:
    """Angular speed from each sample to the next [rad/s], shape (F - 1, ...).

    Args:
        rotations: Unit quaternions xyzw, shape (F, ..., 4).
        rate: Samples a second [Hz].
    """
    return np.linalg.norm(_angular_velocities(rotations, rate), axis=-1)


def angular_jerks(rotations: FloatArray, rate: float) -> FloatArray:
    """Size of the second difference of the angular velocity [rad/s3], shape (F - 3, ...); empty below four samples.

    Args:
        rotations: Unit quaternions xyzw, shape (F, ..., 4).
        rate: Samples a second [Hz].
    """
    return np.linalg.norm(np.diff(_angular_velocities(rotations, rate), n=2, axis=0), axis=-1) * rate**2


def angular_jumps(rotations: FloatArray, rate: float) -> FloatArray:
    """Change of the angular velocity at each inner sample, root mean square over the joints [rad/s], shape (F - 2,).

    Args:
        rotations: Unit quaternions xyzw, shape (F, J, 4).
        rate: Samples a second [Hz].
    """
    jumps = np.diff(_angular_velocities(rotations, rate), axis=0)
    return np.sqrt(np.mean(np.sum(jumps**2, axis=-1), axis=-1))


def body_joints(skeleton: Skeleton, biped: Biped) -> IntArray:
    """The pelvis and all joints below it.

    Joints above it stay at rest. What hangs on those beside it is no body (3ds Max's footsteps, controls of IK): it
    goes along with joints of the body, or its own turns say nothing once those above it rest.
    """
    return np.array([j for j in range(len(skeleton.joints)) if biped.pelvis in (j, *skeleton.ancestors(j))])


def clip_rotations(clip: Clip, skeleton: Skeleton, biped: Biped, *, rate: float) -> FloatArray:
    """Joint-local rotations of a clip at another rate, the pelvis's in the clip's world, shape (F, J, 4).

    They lie on C2 splines through the clip's samples: chords would smooth the motion at a lower rate and have kinks at
    a higher one.

    Args:
        clip: Clip; only its range is sampled.
        skeleton: Its skeleton.
        biped: Names the pelvis.
        rate: Samples a second [Hz].
    """
    start = clip.times[0] if clip.range_start is None else max(clip.range_start, clip.times[0])
    end = clip.times[-1] if clip.range_end is None else min(clip.range_end, clip.times[-1])
    count = int(np.floor((end - start) * rate + 1e-6)) + 1
    rotations = clip.rotations.copy()
    joint = int(skeleton.parents[biped.pelvis])
    while joint >= 0:
        rotations[:, biped.pelvis] = quaternion.compose(rotations[:, joint], rotations[:, biped.pelvis])
        joint = int(skeleton.parents[joint])
    samples = quaternion.continuous(rotations).reshape(len(rotations), -1)
    runs, first = np.zeros(count, dtype=np.intp), np.array([0, len(samples)])
    splines = build_splines(samples, first=first, starts=clip.times[:1], rates=np.array([clip.rate]))
    times = np.minimum(start + np.arange(count) / rate, clip.times[-1])
    return quaternion.normalised(splines.at(runs, times).reshape(count, -1, 4))


def _angular_velocities(rotations: FloatArray, rate: float) -> FloatArray:
    turns = quaternion.compose(quaternion.inverse(rotations[:-1]), rotations[1:])
    return quaternion.to_rotation_vector(turns) * rate
