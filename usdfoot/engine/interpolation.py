"""What USD programs see between two samples: every joint interpolated by itself."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.kernels import slerped
from usdfoot.engine.pose_source import Layout, Poses
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["interpolate_poses"]


@wp.kernel
def interpolate(
    joints: wp.array(dtype=wp.int32),
    before: wp.array(dtype=wp.int32),
    after: wp.array(dtype=wp.int32),
    shares: wp.array(dtype=wp.float32),
    positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
    seen_positions: wp.array(dtype=wp.vec3f),
    seen_pelvis_rotations: wp.array(dtype=wp.quatf),
    seen_rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Pelvis and `joints` at a part of the way from one sample to another."""
    row = wp.tid()
    share = shares[row]
    a = before[row]
    b = after[row]
    seen_positions[row] = (1.0 - share) * positions[a] + share * positions[b]
    seen_pelvis_rotations[row] = slerped(pelvis_rotations[a], pelvis_rotations[b], share)
    for k in range(joints.shape[0]):
        joint = joints[k]
        seen_rotations[row, joint] = slerped(rotations[a, joint], rotations[b, joint], share)


def interpolate_poses(layout: Layout, poses: Poses, *, before: IntArray, after: IntArray, shares: FloatArray) -> Poses:
    """Pelvis and legs between samples, other joints unset.

    Args:
        layout: Of the agents.
        poses: The samples.
        before: Sample before each instant, shape (D,).
        after: Sample after it, shape (D,).
        shares: Part of the time between the two, 0..1, shape (D,).
    """
    count = len(before)
    seen = Poses(
        pelvis_positions=wp.empty(count, dtype=wp.vec3f),
        pelvis_rotations=wp.empty(count, dtype=wp.quatf),
        rotations=wp.empty((count, len(layout.skeleton.joints)), dtype=wp.quatf),
    )
    rows = (np.ascontiguousarray(values, dtype=np.int32) for values in (layout.rig.leg_joints, before, after))
    wp.launch(
        interpolate,
        dim=count,
        inputs=[
            *(wp.array(values, dtype=wp.int32, copy=False) for values in rows),
            wp.array(shares.astype(np.float32), dtype=wp.float32, copy=False),
            poses.pelvis_positions,
            poses.pelvis_rotations,
            poses.rotations,
        ],
        outputs=[seen.pelvis_positions, seen.pelvis_rotations, seen.rotations],
    )
    return seen
