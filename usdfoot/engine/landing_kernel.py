"""Where the swing ball is at the end of a blended step, seen from the support ball at its start, as a Warp kernel."""

from __future__ import annotations

import warp as wp

from usdfoot.engine.kernels import LibraryArrays

__all__ = ["land_swing_balls", "swing_landing"]


@wp.func
def mixed_rotation(
    rotations: wp.array3d(dtype=wp.quatf),
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float32),
    blend: int,
    sample: float,
    joint: int,
) -> wp.quatf:
    """Normalised sum of a blend's examples' rotations at a sample, signs aligned to the heaviest (the first)."""
    row = wp.min(int(sample), rotations.shape[1] - 2)
    fraction = sample - float(row)
    reference = rotations[examples[blend, 0], row, joint]
    total = wp.quatf(0.0, 0.0, 0.0, 0.0)
    for k in range(examples.shape[1]):
        weight = weights[blend, k]
        if weight > 0.0:
            first = rotations[examples[blend, k], row, joint]
            weight *= wp.where(wp.dot(first, reference) < 0.0, -1.0, 1.0)
            total += first * (weight * (1.0 - fraction))
            total += rotations[examples[blend, k], row + 1, joint] * (weight * fraction)
    return wp.normalize(total)


@wp.func
def mixed_position(
    positions: wp.array2d(dtype=wp.vec3f),
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float32),
    blend: int,
    sample: float,
) -> wp.vec3f:
    """Weighted sum of a blend's examples' positions at a sample."""
    row = wp.min(int(sample), positions.shape[1] - 2)
    fraction = sample - float(row)
    total = wp.vec3f(0.0, 0.0, 0.0)
    for k in range(examples.shape[1]):
        if weights[blend, k] > 0.0:
            first = positions[examples[blend, k], row]
            total += weights[blend, k] * (first + fraction * (positions[examples[blend, k], row + 1] - first))
    return total


@wp.func
def mixed_ball(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float32),
    blend: int,
    sample: float,
    side: int,
) -> wp.vec3f:
    """Ball of the foot `side` from the pelvis at a sample, in the support frame."""
    offset = wp.vec3f(0.0, 0.0, 0.0)
    rotation = mixed_rotation(library.rotations, examples, weights, blend, sample, library.pelvis)
    for c in range(library.chains.shape[1]):
        joint = library.chains[side, c]
        if joint >= 0:
            offset += wp.quat_rotate(rotation, library.translations[joint])
            rotation = rotation * mixed_rotation(library.rotations, examples, weights, blend, sample, joint)
    return offset


@wp.func
def swing_landing(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float32),
    blend: int,
    side: int,
    anchor: float,
) -> wp.vec3f:
    """Ball of the swing foot `side` at a blend's last sample, placed as `place_pelvis` places it, in the support frame.

    `anchor` is the last sample at which the support foot stands.
    """
    last = float(library.rotations.shape[1] - 1)
    landing = mixed_position(library.support_balls, examples, weights, blend, anchor)
    landing -= mixed_ball(library, examples, weights, blend, anchor, 1 - side)
    landing -= mixed_position(library.pelvis_positions, examples, weights, blend, anchor)
    landing += mixed_position(library.pelvis_positions, examples, weights, blend, last)
    landing += mixed_ball(library, examples, weights, blend, last, side)
    return landing


@wp.kernel(enable_backward=False)
def land_swing_balls(
    library: LibraryArrays,
    examples: wp.array2d(dtype=wp.int32),
    weights: wp.array2d(dtype=wp.float32),
    swing_sides: wp.array(dtype=wp.int32),
    anchors: wp.array(dtype=wp.float32),
    landings: wp.array(dtype=wp.vec3f),
) -> None:
    """`swing_landing` of every blend."""
    blend = wp.tid()
    landings[blend] = swing_landing(library, examples, weights, blend, swing_sides[blend], anchors[blend])
