"""Warp kernels over frames: blend the poses of up to eight examples, place the pelvis over the support foot.

A *frame* here is any (segment, time) pair, an output frame or an instant of the set-up. Positions are relative to the
agent's origin so that float32 is exact to some micrometres.
"""

from __future__ import annotations

import warp as wp

from usdfoot.engine.clock_kernel import ClockArrays

__all__ = ["LibraryArrays", "SegmentArrays", "blend_rotations", "place_pelvis"]


@wp.struct
class LibraryArrays:
    """Examples on the device."""

    rotations: wp.array3d(dtype=wp.quatf)  # (E, S, J) joint-local, the pelvis's in the support frame
    pelvis_positions: wp.array2d(dtype=wp.vec3f)  # (E, S) support frame
    support_balls: wp.array2d(dtype=wp.vec3f)  # (E, S) support frame
    settles: wp.array(dtype=wp.vec2d)  # (E,) of the swing foot, from its strike until it is flat, (x, z)
    turns: wp.array(dtype=wp.float64)  # (E,) [rad]
    flights: wp.array(dtype=wp.float64)  # (E,) before the swing strike [s]
    liftoff: wp.float32  # sample of the support foot's liftoff
    translations: wp.array(dtype=wp.vec3f)  # (J,) rest
    chains: wp.array2d(dtype=wp.int32)  # (2, C) joints below the pelvis down to each ball, padded with -1
    pelvis: wp.int32


@wp.struct
class SegmentArrays:
    """Segments on the device, M of them, and the seams between them, M + 1."""

    examples: wp.array(dtype=wp.vec4i)
    weights: wp.array(dtype=wp.vec4f)
    more_examples: wp.array(dtype=wp.vec4i)  # fifth to eighth; none of them if the first has no weight
    more_weights: wp.array(dtype=wp.vec4f)
    support_sides: wp.array(dtype=wp.int32)  # -1 in a stand
    anchors: wp.array(dtype=wp.float32)  # last sample at which the support foot is on the ground
    seams_after: wp.array(dtype=wp.int32)  # seam at the segment's end; the one at its begin has its own number
    origins: wp.array(dtype=wp.vec3f)  # support ball on the ground, or middle of the feet in a stand
    joint_values: wp.array2d(dtype=wp.vec3f)  # (M + 1, J) half the jump, tan(angle / 4) along the axis
    joint_slopes: wp.array2d(dtype=wp.vec3f)  # (M + 1, J) its rate
    position_values: wp.array(dtype=wp.vec3f)  # (M + 1,) half the jump of the pelvis
    position_slopes: wp.array(dtype=wp.vec3f)
    clocks: ClockArrays


@wp.func
def weighted_rotation(
    rotations: wp.array3d(dtype=wp.quatf),
    examples: wp.vec4i,
    row: int,
    before: wp.vec4f,
    after: wp.vec4f,
    joint: int,
    reference: wp.quatf,
) -> wp.quatf:
    """Sum of four examples' rotations between samples `row` and `row` + 1, signs aligned to the reference.

    `before` and `after` are the weights times the shares of the two samples. The sum is not normalised.
    """
    total = wp.quatf(0.0, 0.0, 0.0, 0.0)
    for k in range(4):
        if before[k] + after[k] > 0.0:
            first = rotations[examples[k], row, joint]
            sign = wp.where(wp.dot(first, reference) < 0.0, -1.0, 1.0)
            total += first * (sign * before[k]) + rotations[examples[k], row + 1, joint] * (sign * after[k])
    return total


@wp.func
def sampled_rotation(
    rotations: wp.array3d(dtype=wp.quatf), segments: SegmentArrays, segment: int, sample: float, joint: int
) -> wp.quatf:
    """Normalised blend of a segment's examples' rotations at a sample, aligned to the heaviest (the first)."""
    row = wp.min(int(sample), rotations.shape[1] - 2)
    fraction = sample - float(row)
    examples = segments.examples[segment]
    weights = segments.weights[segment]
    reference = rotations[examples[0], row, joint]
    before, after = weights * (1.0 - fraction), weights * fraction
    total = weighted_rotation(rotations, examples, row, before, after, joint, reference)
    more = segments.more_weights[segment]
    if more[0] > 0.0:
        others = segments.more_examples[segment]
        before, after = more * (1.0 - fraction), more * fraction
        total += weighted_rotation(rotations, others, row, before, after, joint, reference)
    return wp.normalize(total)


@wp.func
def blended_position(
    positions: wp.array2d(dtype=wp.vec3f), examples: wp.vec4i, weights: wp.vec4f, sample: float
) -> wp.vec3f:
    """Weighted sum of the examples' positions."""
    last = positions.shape[1] - 2
    row = wp.min(int(sample), last)
    fraction = sample - float(row)
    total = wp.vec3f(0.0, 0.0, 0.0)
    for k in range(4):
        if weights[k] > 0.0:
            first = positions[examples[k], row]
            total += weights[k] * (first + fraction * (positions[examples[k], row + 1] - first))
    return total


@wp.func
def sampled_position(
    positions: wp.array2d(dtype=wp.vec3f), segments: SegmentArrays, segment: int, sample: float
) -> wp.vec3f:
    """Weighted sum of a segment's examples' positions at a sample."""
    total = blended_position(positions, segments.examples[segment], segments.weights[segment], sample)
    more = segments.more_weights[segment]
    if more[0] > 0.0:
        total += blended_position(positions, segments.more_examples[segment], more, sample)
    return total


@wp.func
def seam_rotation(
    values: wp.array2d(dtype=wp.vec3f),
    slopes: wp.array2d(dtype=wp.vec3f),
    segment: int,
    after: int,
    window: wp.vec4f,
    joint: int,
) -> wp.quatf:
    """Rotation that carries the seams at both ends of a segment, not normalised; identity beyond their windows."""
    half = window[0] * values[segment, joint] + window[1] * slopes[segment, joint]
    half += window[2] * values[after, joint] + window[3] * slopes[after, joint]
    return wp.quatf(half[0], half[1], half[2], 1.0)


@wp.kernel(enable_backward=False)
def place_pelvis(
    library: LibraryArrays,
    segments: SegmentArrays,
    frame_segments: wp.array(dtype=wp.int32),
    samples: wp.array(dtype=wp.float32),
    yaws: wp.array(dtype=wp.float32),
    ground: wp.array(dtype=wp.float32),
    joint_windows: wp.array(dtype=wp.vec4f),
    position_windows: wp.array(dtype=wp.vec4f),
    positions: wp.array(dtype=wp.vec3f),
    rotations: wp.array(dtype=wp.quatf),
) -> None:
    """Pelvis of each frame such that the blended support ball is where it was in the blended examples ([B] Eq. 2).

    Once the support foot has left the ground, the pelvis follows the examples' from where it was then.
    """
    frame = wp.tid()
    segment = frame_segments[frame]
    sample = samples[frame]
    side = segments.support_sides[segment]
    rotation = sampled_rotation(library.rotations, segments, segment, sample, library.pelvis)
    offset = sampled_position(library.pelvis_positions, segments, segment, sample)
    if side >= 0:
        anchor = wp.min(sample, segments.anchors[segment])
        turned = sampled_rotation(library.rotations, segments, segment, anchor, library.pelvis)
        offset -= sampled_position(library.pelvis_positions, segments, segment, anchor)
        offset += sampled_position(library.support_balls, segments, segment, anchor)
        for c in range(library.chains.shape[1]):
            joint = library.chains[side, c]
            if joint >= 0:
                offset -= wp.quat_rotate(turned, library.translations[joint])
                turned = turned * sampled_rotation(library.rotations, segments, segment, anchor, joint)
    heading = wp.quat_from_axis_angle(wp.vec3f(0.0, 1.0, 0.0), yaws[frame])
    window = position_windows[frame]
    position = segments.origins[segment] + wp.quat_rotate(heading, offset)
    position[1] = ground[frame] + offset[1]
    position += window[0] * segments.position_values[segment] + window[1] * segments.position_slopes[segment]
    next_seam = segments.seams_after[segment]
    position += window[2] * segments.position_values[next_seam] + window[3] * segments.position_slopes[next_seam]
    positions[frame] = position
    seam = seam_rotation(
        segments.joint_values, segments.joint_slopes, segment, next_seam, joint_windows[frame], library.pelvis
    )
    rotations[frame] = wp.normalize(seam * heading * rotation)


@wp.kernel(enable_backward=False)
def blend_rotations(
    library: LibraryArrays,
    segments: SegmentArrays,
    joints: wp.array(dtype=wp.int32),
    frame_segments: wp.array(dtype=wp.int32),
    samples: wp.array(dtype=wp.float32),
    joint_windows: wp.array(dtype=wp.vec4f),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Joint-local rotations of each frame for the joints asked for; the others are left alone."""
    frame = wp.tid()
    segment = frame_segments[frame]
    sample = samples[frame]
    examples = segments.examples[segment]
    weights = segments.weights[segment]
    row = wp.min(int(sample), library.rotations.shape[1] - 2)
    fraction = sample - float(row)
    before = weights * (1.0 - fraction)
    after = weights * fraction
    others = segments.more_examples[segment]
    more = segments.more_weights[segment]
    window = joint_windows[frame]
    beside_seam = wp.length_sq(window) > 0.0
    next_seam = segments.seams_after[segment]
    for k in range(joints.shape[0]):
        joint = joints[k]
        reference = library.rotations[examples[0], row, joint]
        blended = weighted_rotation(library.rotations, examples, row, before, after, joint, reference)
        if more[0] > 0.0:
            blended += weighted_rotation(
                library.rotations, others, row, more * (1.0 - fraction), more * fraction, joint, reference
            )
        if beside_seam:
            blended = (
                seam_rotation(segments.joint_values, segments.joint_slopes, segment, next_seam, window, joint) * blended
            )
        rotations[frame, joint] = wp.normalize(blended)
