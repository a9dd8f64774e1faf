"""Warp kernel over agents: mixes their steps with the root's examples in turn, each from where the last one landed."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.correction_kernel import TRIES, heading_change
from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, as_left, blend_landing, keep_tried, try_example, turned
from usdfoot.spaces.corner_kernel import SpaceArrays, adjoin_corners, corners_of, find_corners, way_inside
from usdfoot.spaces.root_weight import REPLACEMENTS
from usdfoot.spaces.root_weight_kernel import (
    Corners,
    find_beta,
    find_given_up,
    find_largest,
    is_inside,
    mean_corner,
    replaces_corner,
    weigh_corners,
)

__all__ = ["MixOptions", "MixedStep", "RootedStep", "mix_in_turn"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

WIDTH = 8
"""Examples of a step: three around the footstep, five of the root."""
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
HALF = wp.constant(wp.float64(0.5))
SLACK = wp.constant(wp.float64(1e-6))
"""A landing this far outside an edge, in barycentric coordinates, still is between its examples."""
LIMITED = wp.constant(wp.float64(1e-6))
"""A foot that has to stand farther from its footstep than this [m] is limited."""

RootExamples = wp.types.vector(length=WIDTH - 3, dtype=wp.int32)
RootWeights = wp.types.vector(length=WIDTH - 3, dtype=wp.float64)


@wp.struct
class RootedStep:
    """A step with a root weight; vectors in left-swing coordinates."""

    support: wp.int32  # contact
    swing_side: wp.int32
    space: wp.int32
    start: wp.float64  # heading at the step's start [rad]
    end: wp.float64  # and at its end
    wanted: wp.float64  # lambda4
    epsilon: wp.float64  # replacement distance [m]
    reach: wp.float64  # of IK [m]
    longest: wp.float64  # step [m]
    corners: wp.vec3i  # examples around the footstep as planned
    bias: wp.vec2d  # from their mean landing to where their blend lands [m]
    hull_distance: wp.float64  # of the footstep [m]
    roots: RootExamples
    root_weights: RootWeights


@wp.struct
class MixOptions:
    """How steps are mixed."""

    by_features: bool
    closest: bool
    tolerance: wp.float64  # lambda4 is the largest within this distance [m]; below 0 as wanted
    corrections: wp.int32
    near: wp.float64  # a landing this near to where it should be is left [m]
    landing_scale: wp.float64  # [m]
    departure_scale: wp.float64  # [m]


@wp.struct
class MixedStep:
    """What became of a step; vectors in left-swing coordinates."""

    root_weight: wp.float64
    beta: wp.float64
    expected: wp.vec2d  # from where the closed form says it lands to the footstep [m]
    missed: wp.vec2d  # from where it lands as measured to the footstep [m]
    move: wp.vec2d  # from the footstep to where the foot is planted instead [m], 0 up to beta
    hull_distance: wp.float64  # of the footstep [m]
    limited: bool  # whether the foot has to stand farther off than IK or the leg reach


@wp.func
def set_landing(coordinates: wp.array2d(dtype=wp.float64), step: int, landing: wp.vec2d, scale: wp.float64):
    """Has a step be compared with examples at another landing [m]."""
    for axis in range(2):
        coordinates[step, axis] = landing[axis] / scale


@wp.func
def land_mix(
    own: RootedStep,
    corners: wp.vec3i,
    shares: wp.vec3d,
    root_weight: wp.float64,
    library: LibraryArrays,
    blends: BlendArrays,
    step: int,
) -> wp.vec2d:
    """Where three examples, which weigh 1 - lambda4 together, land with the root's, as if the left foot swung [m]."""
    for corner in range(3):
        try_example(blends, step, corner, corners[corner], (ONE - root_weight) * shares[corner])
    for k in range(WIDTH - 3):
        try_example(blends, step, 3 + k, own.roots[k], root_weight * own.root_weights[k])
    return blend_landing(library, blends.tried_examples, blends.tried_weights, step, own.swing_side)


@wp.func
def replace_corners(own: RootedStep, spaces: SpaceArrays, examples: wp.vec3i, landing: wp.vec2d) -> wp.vec3i:
    """Examples around a landing, those near root examples replaced by them ([B] Algorithm 1, lines 1 to 14)."""
    found = examples
    corners = corners_of(spaces, examples)
    for corner in range(3):
        replaced = bool(False)
        for k in range(REPLACEMENTS):
            other = spaces.landings[own.roots[k]]
            if not replaced and replaces_corner(corners, corner, other, landing, own.epsilon):
                corners[corner] = other
                found[corner] = own.roots[k]
                replaced = bool(True)
    return found


@wp.func
def move_corners(
    own: RootedStep,
    coordinates: wp.array2d(dtype=wp.float64),
    spaces: SpaceArrays,
    options: MixOptions,
    step: int,
    corners: wp.vec3i,
    asked: wp.vec2d,
    stays: bool,
) -> wp.vec3i:
    """Examples around a landing: those that adjoin the ones before if it `stays` with them, else others chosen anew."""
    set_landing(coordinates, step, asked, options.landing_scale)
    if stays and options.by_features:
        return adjoin_corners(spaces, own.space, corners, asked, coordinates, step)
    found = find_corners(spaces, own.space, asked, coordinates, step, options.by_features)
    return replace_corners(own, spaces, found.examples, asked)


@wp.func
def find_root_weight(
    own: RootedStep, around: Corners, options: MixOptions, beta: wp.float64, root: wp.vec2d, wanted: wp.vec2d
) -> wp.float64:
    """lambda4 as wanted, or as much of it as plants the foot within the tolerance."""
    if options.tolerance < ZERO:
        return own.wanted
    most = wp.float64(1.0)
    if options.closest:
        shares = weigh_corners(around, wanted)
        offset = mean_corner(around, shares) - wanted
        most = find_largest(around, shares, root, options.tolerance, offset, True)
    elif wp.length(root - wanted) > options.tolerance:
        most = beta + (wp.float64(1.0) - beta) * options.tolerance / wp.length(root - wanted)
    return wp.min(own.wanted, most)


@wp.func
def within_hull(spaces: SpaceArrays, space: int, beta: wp.float64, landing: wp.vec2d, root: wp.vec2d) -> wp.float64:
    """Beta, or less where the space ends: as much as leaves what the rest of the mix has to land on in the hull."""
    most = beta / wp.max(ONE - beta, LIMITED)
    times = way_inside(spaces, space, landing, landing - root, most)
    return wp.where(times < most, times / (ONE + times), beta)


@wp.func
def mix_step(
    own: RootedStep,
    coordinates: wp.array2d(dtype=wp.float64),
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
    planned: wp.vec2d,
    wanted: wp.vec2d,
) -> MixedStep:
    """The mix whose measured landing is nearest to the one the closed form says.

    Beta is that of the footstep as planned, in the examples around it: so the share of the footstep given up depends
    on lambda4 alone, not on which examples a moved support chooses. The rest of the mix has to land at
    p = (t - lambda4 r) / (1 - lambda4) for the whole to land at t: between the planned examples where nothing was
    moved, else between others. What a blend of poses lands beside the blend of the landings is measured and corrected.
    Examples with which that comes nearer by half each time are kept, and in the second half of the corrections those
    there are: landings go on across an edge to those that adjoin, but not to others that are chosen.
    """
    result = MixedStep()
    bias = own.bias
    corners = replace_corners(own, spaces, own.corners, planned - bias)
    around = corners_of(spaces, corners)
    root = land_mix(own, corners, wp.vec3d(), ONE, library, blends, step)
    result.beta = find_beta(around, weigh_corners(around, planned - bias), root - bias)
    nearest = wanted
    if own.hull_distance > ZERO or not is_inside(around, wanted - bias, SLACK):
        set_landing(coordinates, step, wanted - bias, options.landing_scale)
        found = find_corners(spaces, own.space, wanted - bias, coordinates, step, options.by_features)
        result.hull_distance = found.hull_distance
        corners = found.examples
        around = corners_of(spaces, corners)
        nearest = mean_corner(around, weigh_corners(around, wanted - bias)) + bias
    if wp.length(wanted - planned) > ZERO:
        result.beta = within_hull(spaces, own.space, result.beta, nearest - bias, root - bias)
    for corner in range(3):
        around[corner] = around[corner] + bias
    root_weight = find_root_weight(own, around, options, result.beta, root, wanted)
    given_up = find_given_up(root_weight, result.beta)
    rest = wp.max(ONE - root_weight, LIMITED)
    target = nearest + given_up * (root - nearest)
    if options.closest:
        target = nearest
    asked = (target - root_weight * root) / rest - bias
    asked_before = wp.vec2d()
    change_before = wp.vec2d()
    distance = wp.float64(wp.inf)
    tries = wp.int32(0)
    least = wp.float64(wp.inf)
    for round_ in range(1 + options.corrections):
        if least > options.near:
            if round_ > 0 or not is_inside(corners_of(spaces, corners), asked, SLACK):
                corners = move_corners(own, coordinates, spaces, options, step, corners, asked, tries > 0)
            around = corners_of(spaces, corners)
            shares = weigh_corners(around, asked)
            aim = target - rest * (asked - mean_corner(around, shares))
            missed = aim - land_mix(own, corners, shares, root_weight, library, blends, step)
            if wp.length(missed) < least:
                least = wp.length(missed)
                result.expected = wanted - aim
                result.missed = result.expected + missed
                result.move = aim - nearest + given_up * (nearest - wanted)
                keep_tried(blends, step)
            change = missed / rest
            if tries > 0:
                change = heading_change(change, change_before, asked - asked_before)
            asked_before = asked
            change_before = missed / rest
            asked += change
            tries += 1
            others = options.by_features and tries >= TRIES and 2 * round_ < options.corrections
            if others and wp.length(missed) > HALF * distance:
                tries = 0
            distance = wp.length(missed)
    result.root_weight = root_weight
    if given_up <= ZERO or wp.length(result.move) <= options.near:
        result.move = wp.vec2d()
    return result


@wp.func
def beyond_reach(left: wp.vec2d, stride: wp.vec2d, reach: wp.float64, longest: wp.float64) -> wp.vec2d:
    """How far a landing has to fall short of its footstep, as `reach.beyond_reach` has it [m]."""
    beyond_ik = left * wp.max(wp.float64(1.0) - reach / wp.max(wp.length(left), wp.float64(1e-12)), ZERO)
    beyond_leg = stride * wp.max(wp.float64(1.0) - longest / wp.max(wp.length(stride), wp.float64(1e-12)), ZERO)
    if wp.length(beyond_leg) > wp.length(beyond_ik):
        return beyond_leg
    return beyond_ik


@wp.kernel(enable_backward=False)
def mix_in_turn(
    firsts: wp.array(dtype=wp.int32),  # first step of each agent, and their number (A + 1,)
    steps: wp.array(dtype=RootedStep),  # in order of agents and time (N,)
    spaces: SpaceArrays,
    library: LibraryArrays,
    options: MixOptions,
    planned: wp.array(dtype=wp.vec2d),  # contacts as planned, (x, z) [m] (C,)
    positions: wp.array(dtype=wp.vec2d),  # the same, changed to where the feet are planted
    coordinates: wp.array2d(dtype=wp.float64),  # scaled landings and features of the steps (N, D), changed with those
    blends: BlendArrays,
    mixed: wp.array(dtype=MixedStep),  # (N,)
):
    """Mixes the steps of each agent, and plants their feet where those that give up their footstep land."""
    agent = wp.tid()
    for step in range(firsts[agent], firsts[agent + 1]):
        own = steps[step]
        support = own.support
        side = own.swing_side
        stride = positions[support + 1] - positions[support]
        wanted = as_left(turned(-own.end, stride), side)
        departure = as_left(turned(-own.start, positions[support - 1] - positions[support]), side)
        last = coordinates.shape[1]
        for axis in range(2):
            coordinates[step, last - 2 + axis] = departure[axis] / options.departure_scale
        foreseen = as_left(turned(-own.end, planned[support + 1] - planned[support]), side)
        result = mix_step(own, coordinates, spaces, library, blends, options, step, foreseen, wanted)
        move = turned(own.end, as_left(result.move, side))
        left = turned(own.end, as_left(result.missed, side)) + move
        excess = beyond_reach(left, stride + move, own.reach, own.longest)
        result.limited = wp.max(wp.abs(excess[0]), wp.abs(excess[1])) > LIMITED
        if result.limited:
            move -= excess
        positions[support + 1] = positions[support + 1] + move
        mixed[step] = result
