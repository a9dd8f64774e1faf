"""Warp kernels of what is written: boxes around posed characters, and rotations without changes of sign."""
# mypy: disable-error-code="valid-type, no-untyped-def"

from __future__ import annotations

import warp as wp

__all__ = ["box_frames", "keep_signs"]


@wp.func
def to_single(value: wp.float64):
    """Rounded to single precision. A product or sum of two single values comes out as if it were worked out in it."""
    return wp.float64(wp.float32(value))


@wp.func
def joint_axes(rotation: wp.quatf, scale: wp.vec3f):
    """Rows of the matrix that scales, then rotates, rounded where USD's own arithmetic in single precision rounds."""
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    x = wp.float64(rotation[0])
    y = wp.float64(rotation[1])
    z = wp.float64(rotation[2])
    w = wp.float64(rotation[3])
    xx = to_single(x * x)
    yy = to_single(y * y)
    zz = to_single(z * z)
    xy = to_single(x * y)
    yz = to_single(y * z)
    zx = to_single(z * x)
    xw = to_single(x * w)
    yw = to_single(y * w)
    zw = to_single(z * w)
    sx = wp.float64(scale[0])
    sy = wp.float64(scale[1])
    sz = wp.float64(scale[2])
    return wp.mat33d(
        to_single(sx * to_single(one - two * to_single(yy + zz))),
        to_single(sx * (two * to_single(xy + zw))),
        to_single(sx * (two * to_single(zx - yw))),
        to_single(sy * (two * to_single(xy - zw))),
        to_single(sy * to_single(one - two * to_single(zz + xx))),
        to_single(sy * (two * to_single(yz + xw))),
        to_single(sz * (two * to_single(zx + yw))),
        to_single(sz * (two * to_single(yz - xw))),
        to_single(sz * to_single(one - two * to_single(yy + xx))),
    )


@wp.func
def widened(point: wp.vec3f):
    return wp.vec3d(wp.float64(point[0]), wp.float64(point[1]), wp.float64(point[2]))


@wp.func
def narrowed(point: wp.vec3d):
    return wp.vec3f(wp.float32(point[0]), wp.float32(point[1]), wp.float32(point[2]))


@wp.kernel(enable_backward=False)
def box_frames(
    parents: wp.array(dtype=wp.int32),  # (K,) of the Skeleton's joints, -1 = root
    sources: wp.array(dtype=wp.int32),  # (K,) joint of the animation, -1 = rests
    rest_axes: wp.array(dtype=wp.mat33d),  # (K,) joint-local, rows
    rest_places: wp.array(dtype=wp.vec3d),  # (K,)
    translations: wp.array2d(dtype=wp.vec3f),  # (F, J) joint-local, of the animation
    rotations: wp.array2d(dtype=wp.quatf),  # (F, J)
    scales: wp.array(dtype=wp.vec3f),  # (J,)
    prim_axes: wp.array(dtype=wp.mat33d),  # (1,) or (F,) from the Skeleton to the prim, rows
    prim_places: wp.array(dtype=wp.vec3d),  # (1,) or (F,)
    padding: wp.float32,
    axes: wp.array2d(dtype=wp.mat33d),  # (lanes, K) scratch
    places: wp.array2d(dtype=wp.vec3d),  # (lanes, K) scratch
    boxes: wp.array2d(dtype=wp.vec3f),  # (F, 2) lowest and highest corner, widened
):
    """The box around the joints of every frame as UsdSkel works it out, to its last bit; a lane does every so many."""
    lane = wp.tid()
    for frame in range(lane, boxes.shape[0], axes.shape[0]):
        row = wp.min(frame, prim_axes.shape[0] - 1)
        lowest = wp.vec3f(wp.inf, wp.inf, wp.inf)
        highest = -lowest
        for joint in range(parents.shape[0]):
            source = sources[joint]
            parent = parents[joint]
            turn = rest_axes[joint]
            place = rest_places[joint]
            if source >= 0:
                turn = joint_axes(rotations[frame, source], scales[source])
                place = widened(translations[frame, source])
            if parent >= 0:
                place = place * axes[lane, parent] + places[lane, parent]
                turn = turn * axes[lane, parent]
            axes[lane, joint] = turn
            places[lane, joint] = place
            point = narrowed(widened(narrowed(place)) * prim_axes[row] + prim_places[row])
            lowest = wp.min(lowest, point)
            highest = wp.max(highest, point)
        margin = wp.vec3f(padding, padding, padding)
        boxes[frame, 0] = wp.min(boxes[frame, 0], lowest - margin)
        boxes[frame, 1] = wp.max(boxes[frame, 1], highest + margin)


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
