"""Jumps between neighbouring segments, in value and rate, for inertialisation (design.md section 7)."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.kernels import SegmentArrays
from usdfoot.engine.pose_source import Poses
from usdfoot.engine.poses import Seams, Setup, pose_frames, segment_origins
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["measure_seams"]

PROBE_TIME = 1.0 / 240.0
"""Distance of the two poses from which the rates on a side of a seam are taken [s]."""
PELVIS_PROBE_TIME = 1.0 / 120.0
"""The same for the pelvis's position, whose single precision is coarser for what it changes [s]."""


@wp.func
def aligned(rotation: wp.quatf, reference: wp.quatf) -> wp.quatf:
    """The sign of `rotation` that lies in the half space of `reference`."""
    if wp.dot(rotation, reference) < 0.0:
        return -rotation
    return rotation


@wp.func
def angular_velocity(before: wp.quatf, after: wp.quatf, time: float) -> wp.vec3f:
    """Mean angular velocity between two close rotations [rad/s]."""
    turn = aligned(after, before) * wp.quat_inverse(before)
    return wp.vec3f(turn[0], turn[1], turn[2]) * (2.0 / time)


@wp.kernel(enable_backward=False)
def joint_jumps(
    rotations: wp.array2d(dtype=wp.quatf),
    rows: wp.array(dtype=wp.int32),
    probe_time: float,
    values: wp.array2d(dtype=wp.vec3f),
    slopes: wp.array2d(dtype=wp.vec3f),
) -> None:
    """Half of each joint's jump as tan(angle / 4) along its axis, and half of the jump of its rate in that measure."""
    seam, joint = wp.tid()
    first = 4 * seam
    before = rotations[first, joint]
    left = rotations[first + 1, joint]
    right = aligned(rotations[first + 2, joint], left)
    after = rotations[first + 3, joint]
    turn = right * wp.quat_inverse(left)
    scale = 1.0 / (1.0 + turn[3])
    row = rows[seam]
    values[row, joint] = wp.vec3f(turn[0], turn[1], turn[2]) * scale
    velocity = angular_velocity(right, after, probe_time) - angular_velocity(before, left, probe_time)
    slopes[row, joint] = 0.25 * velocity


def measure_seams(setup: Setup, arrays: SegmentArrays, *, seams: IntArray | None = None) -> Seams:
    """Jumps at the seams before segments `seams` (all by default), from poses just before, at and just after them.

    Args:
        setup: All segments.
        arrays: The same from `device_segments`.
        seams: Segments, shape (N,).
    """
    segments = setup.segments
    count, joints = len(segments), len(setup.skeleton.joints)
    seams = np.flatnonzero(segments.joined) if seams is None else seams
    rows = np.stack([seams - 1, seams - 1, seams, seams], axis=1).ravel()
    sides = np.array([-1.0, 0.0, 0.0, 1.0])
    near, far = (np.ravel(segments.begins[seams][:, None] + time * sides) for time in (PROBE_TIME, PELVIS_PROBE_TIME))
    poses = pose_frames(setup, arrays, rows=rows, times=near, joints=np.arange(joints))
    pelvis = pose_frames(setup, arrays, rows=rows, times=far, joints=np.arange(0)).pelvis_positions.numpy()
    origins = segment_origins(setup) * [1.0, 0.0, 1.0]
    values = wp.zeros((count + 1, joints), dtype=wp.vec3f)
    slopes = wp.zeros((count + 1, joints), dtype=wp.vec3f)
    targets = wp.array(seams.astype(np.int32), dtype=wp.int32, copy=False)
    if seams.size:
        _put_pelvis(poses, setup.library.pelvis)
        wp.launch(
            joint_jumps,
            dim=(len(seams), joints),
            inputs=[poses.rotations, targets, PROBE_TIME],
            outputs=[values, slopes],
        )
    position_values, position_slopes = np.zeros((count + 1, 3)), np.zeros((count + 1, 3))
    before, left, right, after = np.moveaxis(pelvis.reshape(-1, 4, 3).astype(float), 1, 0)
    position_values[seams] = 0.5 * (right - left + origins[seams] - origins[seams - 1])
    position_slopes[seams] = 0.5 * ((after - right) - (left - before)) / PELVIS_PROBE_TIME
    return Seams(
        joint_values=values,
        joint_slopes=slopes,
        position_values=_device_vectors(position_values),
        position_slopes=_device_vectors(position_slopes),
    )


def _device_vectors(vectors: FloatArray) -> wp.array:
    return wp.array(vectors.astype(np.float32), dtype=wp.vec3f, copy=False)


@wp.kernel(enable_backward=False)
def put_pelvis(pelvis_rotations: wp.array(dtype=wp.quatf), pelvis: int, rotations: wp.array2d(dtype=wp.quatf)) -> None:
    """The pelvis's rotation in the world in place of the one in the support frame."""
    frame = wp.tid()
    rotations[frame, pelvis] = pelvis_rotations[frame]


def _put_pelvis(poses: Poses, pelvis: int) -> None:
    wp.launch(
        put_pelvis,
        dim=poses.pelvis_rotations.shape[0],
        inputs=[poses.pelvis_rotations, pelvis],
        outputs=[poses.rotations],
    )
