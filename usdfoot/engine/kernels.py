"""Warp kernels over frames: blend the poses of up to eight examples, place the pelvis over the support foot.

A *frame* here is any (segment, time) pair, an output frame or an instant of the set-up. Positions are relative to the
agent's origin so that float32 is exact to some micrometres.
"""

from __future__ import annotations

import warp as wp

from usdfoot.engine.clock_kernel import ClockArrays, clock_at

__all__ = ["LibraryArrays", "SegmentArrays", "pose_bodies", "slerped"]


@wp.struct
class LibraryArrays:
    """Examples on the device."""

    rotations: wp.array3d(dtype=wp.quatf)  # (E, S, J) joint-local, the pelvis's in the support frame
    alike: wp.array(dtype=wp.bool)  # (J,) whether no two rotations of the joint lie in opposite half spaces
    pelvis_positions: wp.array2d(dtype=wp.vec3f)  # (E, S) support frame
    support_balls: wp.array2d(dtype=wp.vec3f)  # (E, S) support frame
    settles: wp.array(dtype=wp.vec2d)  # (E,) from where the swing ball strikes to its landing, (x, z)
    turns: wp.array(dtype=wp.float64)  # (E,) [rad]
    liftoffs: wp.array(dtype=wp.float64)  # (E,) sample at which the support foot leaves the ground, or the last
    translations: wp.array(dtype=wp.vec3f)  # (J,) rest
    chains: wp.array2d(dtype=wp.int32)  # (2, C) joints below the pelvis down to each ball, padded with -1
    pelvis: wp.int32
    slerps: wp.bool  # whether rotations are slerped one after the other, not summed


@wp.struct
class SegmentArrays:
    """Segments on the device, M of them, and the seams between them, M + 1."""

    examples: wp.array(dtype=wp.vec4i)
    weights: wp.array(dtype=wp.vec4f)
    more_examples: wp.array(dtype=wp.vec4i)  # fifth to eighth; none of them if the first has no weight
    more_weights: wp.array(dtype=wp.vec4f)
    support_sides: wp.array(dtype=wp.int32)  # -1 in a stand
    anchors: wp.array(dtype=wp.float32)  # sample at which the support foot leaves the ground, or the last
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

    Normalised it is the blend, whatever the order; `slerped_rotation`, [B] 4.4's, depends on that of the examples.
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
def slerped(first: wp.quatf, second: wp.quatf, share: wp.float32) -> wp.quatf:
    """Rotation a part of the shorter way from one to another."""
    nearer = second
    if wp.dot(first, second) < 0.0:
        nearer = -second
    return wp.normalize(wp.quat_slerp(first, nearer, share))


@wp.func
def own_rotation(
    rotations: wp.array3d(dtype=wp.quatf), example: int, row: int, fraction: float, joint: int
) -> wp.quatf:
    """An example's rotation between samples `row` and `row` + 1."""
    return wp.normalize(
        rotations[example, row, joint] * (1.0 - fraction) + rotations[example, row + 1, joint] * fraction
    )


@wp.func
def slerped_rotation(
    rotations: wp.array3d(dtype=wp.quatf), segments: SegmentArrays, segment: int, sample: float, joint: int
) -> wp.quatf:
    """A segment's examples' rotations at a sample slerped one after the other, the heaviest first ([B] 4.4)."""
    row = wp.min(int(sample), rotations.shape[1] - 2)
    fraction = sample - float(row)
    examples, others = segments.examples[segment], segments.more_examples[segment]
    weights, more = segments.weights[segment], segments.more_weights[segment]
    result = own_rotation(rotations, examples[0], row, fraction, joint)
    weighed = weights[0]
    for k in range(1, 4):
        if weights[k] > 0.0:
            weighed += weights[k]
            own = own_rotation(rotations, examples[k], row, fraction, joint)
            result = slerped(result, own, weights[k] / weighed)
    for k in range(4):
        if more[0] > 0.0 and more[k] > 0.0:
            weighed += more[k]
            own = own_rotation(rotations, others[k], row, fraction, joint)
            result = slerped(result, own, more[k] / weighed)
    return result


@wp.func
def sampled_rotation(
    library: LibraryArrays, segments: SegmentArrays, segment: int, sample: float, joint: int
) -> wp.quatf:
    """Normalised blend of a segment's examples' rotations at a sample, aligned to the heaviest (the first)."""
    if library.slerps:
        return slerped_rotation(library.rotations, segments, segment, sample, joint)
    rotations = library.rotations
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


@wp.func
def mixed_rotation(
    first: wp.array(dtype=wp.quatf), second: wp.array(dtype=wp.quatf), joint: int, before: float, after: float
) -> wp.quatf:
    """A joint's rotations of two samples, weighed."""
    return first[joint] * before + second[joint] * after


@wp.func
def pelvis_offset(library: LibraryArrays, segments: SegmentArrays, segment: int, sample: float) -> wp.vec3f:
    """Pelvis from the segment's origin such that the blended support ball is where it is in the examples ([B] Eq. 2).

    Once the support foot has left the ground, the pelvis follows the examples' from where it was then.
    """
    side = segments.support_sides[segment]
    offset = sampled_position(library.pelvis_positions, segments, segment, sample)
    if side >= 0:
        anchor = wp.min(sample, segments.anchors[segment])
        turned = sampled_rotation(library, segments, segment, anchor, library.pelvis)
        offset -= sampled_position(library.pelvis_positions, segments, segment, anchor)
        offset += sampled_position(library.support_balls, segments, segment, anchor)
        for c in range(library.chains.shape[1]):
            joint = library.chains[side, c]
            if joint >= 0:
                offset -= wp.quat_rotate(turned, library.translations[joint])
                turned = turned * sampled_rotation(library, segments, segment, anchor, joint)
    return offset


@wp.kernel(enable_backward=False)
def pose_bodies(
    library: LibraryArrays,
    segments: SegmentArrays,
    joints: wp.array(dtype=wp.int32),
    frame_segments: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float64),
    positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Pelvis of each frame, and joint-local rotations of the joints asked for; the others are left alone."""
    frame = wp.tid()
    segment = frame_segments[frame]
    now = clock_at(segments.clocks, segment, times[frame], float(library.rotations.shape[1] - 1))
    next_seam = segments.seams_after[segment]
    place = now.position_window
    window = now.joint_window
    heading = wp.quat_from_axis_angle(wp.vec3f(0.0, 1.0, 0.0), now.yaw)
    offset = pelvis_offset(library, segments, segment, now.sample)
    position = segments.origins[segment] + wp.quat_rotate(heading, offset)
    position[1] = now.ground + offset[1]
    position += place[0] * segments.position_values[segment] + place[1] * segments.position_slopes[segment]
    position += place[2] * segments.position_values[next_seam] + place[3] * segments.position_slopes[next_seam]
    positions[frame] = position
    turn = seam_rotation(segments.joint_values, segments.joint_slopes, segment, next_seam, window, library.pelvis)
    pelvis = sampled_rotation(library, segments, segment, now.sample, library.pelvis)
    pelvis_rotations[frame] = wp.normalize(turn * heading * pelvis)

    examples = segments.examples[segment]
    weights = segments.weights[segment]
    others = segments.more_examples[segment]
    more = segments.more_weights[segment]
    row = wp.min(int(now.sample), library.rotations.shape[1] - 2)
    fraction = now.sample - float(row)
    before = weights * (1.0 - fraction)
    after = weights * fraction
    first0, second0 = library.rotations[examples[0], row], library.rotations[examples[0], row + 1]
    first1, second1 = library.rotations[examples[1], row], library.rotations[examples[1], row + 1]
    first2, second2 = library.rotations[examples[2], row], library.rotations[examples[2], row + 1]
    first3, second3 = library.rotations[examples[3], row], library.rotations[examples[3], row + 1]
    beside_seam = wp.length_sq(window) > 0.0
    for k in range(joints.shape[0]):
        joint = joints[k]
        blended = wp.quatf()
        if library.slerps:
            blended = slerped_rotation(library.rotations, segments, segment, now.sample, joint)
        elif library.alike[joint]:
            blended = mixed_rotation(first0, second0, joint, before[0], after[0])
            if weights[1] > 0.0:
                blended += mixed_rotation(first1, second1, joint, before[1], after[1])
            if weights[2] > 0.0:
                blended += mixed_rotation(first2, second2, joint, before[2], after[2])
            if weights[3] > 0.0:
                blended += mixed_rotation(first3, second3, joint, before[3], after[3])
        else:
            blended = weighted_rotation(library.rotations, examples, row, before, after, joint, first0[joint])
        if more[0] > 0.0 and not library.slerps:
            blended += weighted_rotation(
                library.rotations, others, row, more * (1.0 - fraction), more * fraction, joint, first0[joint]
            )
        if beside_seam:
            blended = (
                seam_rotation(segments.joint_values, segments.joint_slopes, segment, next_seam, window, joint) * blended
            )
        rotations[frame, joint] = wp.normalize(blended)
