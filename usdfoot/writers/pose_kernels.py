"""Warp kernels of what is written: boxes around posed characters, and rotations without changes of sign."""
# mypy: disable-error-code="valid-type, no-untyped-def"

from __future__ import annotations

import warp as wp

__all__ = ["box_frames", "keep_signs"]


@wp.kernel(enable_backward=False)
def box_frames(
    parents: wp.array(dtype=wp.int32),  # (J,) nearest joint above; -1 = at rest, the joint stays at its `places`
    translations: wp.array(dtype=wp.vec3f),  # (J,) joint-local
    places: wp.array(dtype=wp.vec3f),  # (J,) of joints at rest
    turns: wp.array(dtype=wp.quatf),  # (J,) of joints at rest
    radii: wp.array(dtype=wp.float32),  # (J,) of the ball around each joint, negative = leave it out
    pelvis: wp.int32,
    pelvis_positions: wp.array(dtype=wp.vec3f),  # (F,)
    pelvis_rotations: wp.array(dtype=wp.quatf),  # (F,)
    rotations: wp.array2d(dtype=wp.quatf),  # (F, J) joint-local
    to_prim: wp.quatf,
    positions: wp.array2d(dtype=wp.vec3f),  # (F, J) scratch
    frames: wp.array2d(dtype=wp.quatf),  # (F, J) scratch
    boxes: wp.array2d(dtype=wp.vec3f),  # (F, 2) lowest and highest corner
):
    """Forward kinematics of one frame, and the box around the balls of its joints in axes turned by `to_prim`."""
    frame = wp.tid()
    lowest = wp.vec3f(1.0e30, 1.0e30, 1.0e30)
    highest = -lowest
    for joint in range(parents.shape[0]):
        parent = parents[joint]
        if joint == pelvis:
            positions[frame, joint] = pelvis_positions[frame]
            frames[frame, joint] = pelvis_rotations[frame]
        elif parent < 0:
            positions[frame, joint] = places[joint]
            frames[frame, joint] = turns[joint]
        else:
            above = frames[frame, parent]
            positions[frame, joint] = positions[frame, parent] + wp.quat_rotate(above, translations[joint])
            frames[frame, joint] = above * rotations[frame, joint]
        if radii[joint] >= 0.0:
            place = wp.quat_rotate(to_prim, positions[frame, joint])
            reach = wp.vec3f(radii[joint], radii[joint], radii[joint])
            lowest = wp.min(lowest, place - reach)
            highest = wp.max(highest, place + reach)
    boxes[frame, 0] = lowest
    boxes[frame, 1] = highest


@wp.kernel(enable_backward=False)
def keep_signs(
    first: wp.array(dtype=wp.int32),  # (A + 1,) first frame of each agent, then F
    rotations: wp.array2d(dtype=wp.quatf),  # (F, J)
):
    """Turns the sign of every rotation to that of the frame before, for one joint of one agent."""
    agent, joint = wp.tid()
    before = rotations[first[agent], joint]
    for frame in range(first[agent] + 1, first[agent + 1]):
        rotation = rotations[frame, joint]
        if wp.dot(rotation, before) < 0.0:
            rotation = -rotation
            rotations[frame, joint] = rotation
        before = rotation
