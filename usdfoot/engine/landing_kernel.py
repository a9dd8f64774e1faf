"""Where the swing foot of a blended step is going to be planted, seen from the support ball, as Warp functions.

In double precision: close examples take large differences of weights for small ones of the landing.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.kernels import LibraryArrays

__all__ = ["BlendArrays", "as_left", "blend_landing", "keep_tried", "land_blends", "try_example", "turned"]


@wp.struct
class BlendArrays:
    """Blends of N steps of K examples, heaviest first: the best of each so far, and the one tried."""

    examples: wp.array2d(dtype=wp.int32)
    weights: wp.array2d(dtype=wp.float64)
    tried_examples: wp.array2d(dtype=wp.int32)
    tried_weights: wp.array2d(dtype=wp.float64)


@wp.func
def try_example(blends: BlendArrays, step: int, count: int, example: int, weight: wp.float64):
    """Adds an example to the `count` of the blend tried, behind those that weigh as much or more."""
    place = count
    while place > 0 and blends.tried_weights[step, place - 1] < weight:
        blends.tried_weights[step, place] = blends.tried_weights[step, place - 1]
        blends.tried_examples[step, place] = blends.tried_examples[step, place - 1]
        place -= 1
    blends.tried_weights[step, place] = weight
    blends.tried_examples[step, place] = example


@wp.func
def keep_tried(blends: BlendArrays, step: int):
    """Has the blend tried be the best."""
    for k in range(blends.examples.shape[1]):
        blends.examples[step, k] = blends.tried_examples[step, k]
        blends.weights[step, k] = blends.tried_weights[step, k]


@wp.func
def turned(yaw: wp.float64, vector: wp.vec2d) -> wp.vec2d:
    """A vector of the ground, (x, z), turned by a yaw [rad]."""
    cosine = wp.cos(yaw)
    sine = wp.sin(yaw)
    return wp.vec2d(cosine * vector[0] + sine * vector[1], cosine * vector[1] - sine * vector[0])


@wp.func
def as_left(vector: wp.vec2d, side: int) -> wp.vec2d:
    """A vector as if the left foot swung; its own inverse."""
    if side == 1:
        return wp.vec2d(-vector[0], vector[1])
    return vector


@wp.func
def exact_vector(vector: wp.vec3f) -> wp.vec3d:
    """A vector in double precision."""
    return wp.vec3d(wp.float64(vector[0]), wp.float64(vector[1]), wp.float64(vector[2]))


@wp.func
def exact_rotation(rotation: wp.quatf) -> wp.quatd:
    """A quaternion in double precision."""
    x, y, z, w = rotation[0], rotation[1], rotation[2], rotation[3]
    return wp.quatd(wp.float64(x), wp.float64(y), wp.float64(z), wp.float64(w))


@wp.func
def slerped_exactly(first: wp.quatd, second: wp.quatd, share: wp.float64) -> wp.quatd:
    """Rotation a part of the shorter way from one to another; the second where that is all of it."""
    if share >= wp.float64(1.0):
        return second
    nearer = second
    if wp.dot(first, second) < wp.float64(0.0):
        nearer = -second
    return wp.quat_slerp(first, nearer, share)


@wp.func
def mixed_rotation(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    blend: int,
    sample: float,
    joint: int,
) -> wp.quatd:
    """Normalised sum of a blend's examples' rotations at a sample, signs aligned to the heaviest (the first).

    Or, where the library slerps, these one after the other.
    """
    rotations = library.rotations
    row = wp.min(int(sample), rotations.shape[1] - 2)
    fraction = wp.float64(sample - float(row))
    one = wp.float64(1.0)
    reference = rotations[examples[blend, 0], row, joint]
    total = wp.quatd()
    weighed = wp.float64(0.0)
    for k in range(examples.shape[1]):
        weight = weights[blend, k]
        if weight > wp.float64(0.0):
            first = rotations[examples[blend, k], row, joint]
            second = rotations[examples[blend, k], row + 1, joint]
            if library.slerps:
                weighed += weight
                own = wp.normalize(exact_rotation(first) * (one - fraction) + exact_rotation(second) * fraction)
                total = slerped_exactly(total, own, weight / weighed)
            else:
                if wp.dot(first, reference) < 0.0:
                    weight = -weight
                total += exact_rotation(first) * (weight * (one - fraction))
                total += exact_rotation(second) * (weight * fraction)
    return wp.normalize(total)


@wp.func
def mixed_position(
    positions: wp.array2d(dtype=wp.vec3f),
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    blend: int,
    sample: float,
) -> wp.vec3d:
    """Weighted sum of a blend's examples' positions at a sample."""
    row = wp.min(int(sample), positions.shape[1] - 2)
    fraction = wp.float64(sample - float(row))
    total = wp.vec3d()
    for k in range(examples.shape[1]):
        weight = weights[blend, k]
        if weight > wp.float64(0.0):
            first = exact_vector(positions[examples[blend, k], row])
            second = exact_vector(positions[examples[blend, k], row + 1])
            total += weight * (first + fraction * (second - first))
    return total


@wp.func
def mixed_ball(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    blend: int,
    sample: float,
    side: int,
) -> wp.vec3d:
    """Ball of the foot `side` from the pelvis at a sample, in the support frame."""
    offset = wp.vec3d()
    rotation = mixed_rotation(library, examples, weights, blend, sample, library.pelvis)
    for c in range(library.chains.shape[1]):
        joint = library.chains[side, c]
        if joint >= 0:
            offset += wp.quat_rotate(rotation, exact_vector(library.translations[joint]))
            rotation = rotation * mixed_rotation(library, examples, weights, blend, sample, joint)
    return offset


@wp.func
def swing_landing(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    blend: int,
    side: int,
    anchor: float,
) -> wp.vec3d:
    """Ball of the swing foot `side` at a blend's last sample, placed as `pose_bodies` places it, in the support frame.

    `anchor` is the sample at which the support foot leaves the ground.
    """
    last = float(library.rotations.shape[1] - 1)
    landing = mixed_position(library.support_balls, examples, weights, blend, anchor)
    landing -= mixed_ball(library, examples, weights, blend, anchor, 1 - side)
    landing -= mixed_position(library.pelvis_positions, examples, weights, blend, anchor)
    landing += mixed_position(library.pelvis_positions, examples, weights, blend, last)
    landing += mixed_ball(library, examples, weights, blend, last, side)
    return landing


@wp.func
def blend_landing(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    blend: int,
    side: int,
) -> wp.vec2d:
    """Where the swing foot `side` of a blend is planted once it is flat, (x, z) in the heading at the step's end [m].

    As if the left foot swung.
    """
    turn = wp.float64(0.0)
    liftoff = wp.float64(0.0)
    settle = wp.vec2d()
    for k in range(examples.shape[1]):
        weight = weights[blend, k]
        if weight > wp.float64(0.0):
            turn += weight * library.turns[examples[blend, k]]
            liftoff += weight * library.liftoffs[examples[blend, k]]
            settle += weight * library.settles[examples[blend, k]]
    ball = swing_landing(library, examples, weights, blend, side, float(liftoff))
    landing = wp.vec2d(ball[0], ball[2]) + settle
    return as_left(turned(-turn, landing), side)


@wp.kernel(enable_backward=False)
def land_blends(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float64),
    swing_sides: wp.array(dtype=wp.int32),
    landings: wp.array(dtype=wp.vec2d),
):
    """`blend_landing` of every blend, heaviest example first."""
    blend = wp.tid()
    landings[blend] = blend_landing(library, examples, weights, blend, swing_sides[blend])
