"""Warp kernel over agents: mixes their steps with the root's examples in turn, each from where the last one landed."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, as_left, blend_landing, keep_tried, try_example, turned
from usdfoot.spaces.corner_kernel import SpaceArrays, corners_of, find_corners
from usdfoot.spaces.root_weight import REPLACEMENTS
from usdfoot.spaces.root_weight_kernel import (
    Corners,
    find_largest,
    is_inside,
    mean_corner,
    mix_root,
    replaces_corner,
    weigh_corners,
)

__all__ = ["MixOptions", "MixedStep", "RootedStep", "mix_in_turn"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

WIDTH = 8
"""Examples of a step: three around the footstep, five of the root."""
ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
LIMITED = wp.constant(wp.float64(1e-6))
"""A foot that has to stand farther from its footstep than this [m] is limited."""

RootExamples = wp.types.vector(length=WIDTH - 3, dtype=wp.int32)
RootWeights = wp.types.vector(length=WIDTH - 3, dtype=wp.float64)
_Examples = wp.types.vector(length=WIDTH, dtype=wp.int32)
_Weights = wp.types.vector(length=WIDTH, dtype=wp.float64)


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
def land(
    library: LibraryArrays, blends: BlendArrays, step: int, side: int, examples: _Examples, weights: _Weights
) -> wp.vec2d:
    """Where a blend lands, in left-swing coordinates [m], as `blend_landing` has it; leaves it in `blends.tried`."""
    for k in range(WIDTH):
        try_example(blends, step, k, examples[k], weights[k])
    return blend_landing(library, blends.tried_examples, blends.tried_weights, step, side)


@wp.func
def choose_corners(
    own: RootedStep,
    coordinates: wp.array2d(dtype=wp.float64),
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
    wanted: wp.vec2d,
    departure: wp.vec2d,
) -> RootedStep:
    """The step with other corners, where its footstep is not between its own any more, and their bias."""
    last = coordinates.shape[1]
    for axis in range(2):
        coordinates[step, axis] = wanted[axis] / options.landing_scale
        coordinates[step, last - 2 + axis] = departure[axis] / options.departure_scale
    found = find_corners(spaces, own.space, wanted, coordinates, step, options.by_features)
    corners = corners_of(spaces, found.examples)
    shares = weigh_corners(corners, wanted)
    examples = _Examples()
    weights = _Weights()
    for k in range(WIDTH):
        examples[k] = found.examples[wp.min(k, 2)]
        if k < 3:
            weights[k] = shares[k]
    landed = land(library, blends, step, own.swing_side, examples, weights)
    chosen = own
    chosen.corners = found.examples
    chosen.hull_distance = found.hull_distance
    chosen.bias = landed - mean_corner(corners, shares)
    return chosen


@wp.func
def land_roots(own: RootedStep, library: LibraryArrays, blends: BlendArrays, step: int) -> wp.vec2d:
    """Where the blend of the root's examples alone lands as measured [m]."""
    examples = _Examples()
    weights = _Weights()
    for k in range(WIDTH):
        examples[k] = own.roots[wp.min(k, WIDTH - 4)]
        if k < WIDTH - 3:
            weights[k] = own.root_weights[k]
    return land(library, blends, step, own.swing_side, examples, weights)


@wp.func
def mix_step(
    own: RootedStep,
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
    wanted: wp.vec2d,
) -> MixedStep:
    """The mix whose measured landing is nearest to the one the closed form says.

    A blend of poses lands a little off the blend of the landings: the corners' and the root's own blends are measured
    beforehand, what their mix adds is measured here, and all are weighed as if they landed that much elsewhere.
    """
    examples = _Examples()
    corners = corners_of(spaces, own.corners)
    for corner in range(3):
        examples[corner] = own.corners[corner]
        replaced = bool(False)
        for k in range(REPLACEMENTS):
            landing = spaces.landings[own.roots[k]]
            if not replaced and replaces_corner(corners, corner, landing, wanted - own.bias, own.epsilon):
                corners[corner] = landing
                examples[corner] = own.roots[k]
                replaced = bool(True)
    for k in range(WIDTH - 3):
        examples[3 + k] = own.roots[k]
    root_landing = land_roots(own, library, blends, step)
    best = MixedStep()
    shift = wp.vec2d()
    kept = wp.vec2d()
    rest = wp.vec2d()
    gain = wp.float64(1.0)
    least = wp.float64(wp.inf)
    for _ in range(1 + options.corrections):
        if least > options.near:
            around = Corners()
            for corner in range(3):
                around[corner] = corners[corner] + own.bias + shift
            root = root_landing + shift
            shares = weigh_corners(around, wanted)
            lacking = wanted - mean_corner(around, shares)
            root_weight = own.wanted
            if options.tolerance >= ZERO:
                most = find_largest(around, shares, root, options.tolerance, -lacking, options.closest)
                root_weight = wp.min(root_weight, most)
            mix = mix_root(around, shares, root, root_weight, options.closest)
            weights = _Weights()
            for corner in range(3):
                weights[corner] = mix.weights[corner]
            for k in range(WIDTH - 3):
                weights[3 + k] = root_weight * own.root_weights[k]
            missed = wanted - land(library, blends, step, own.swing_side, examples, weights)
            off = missed - (lacking - mix.shift)
            if wp.length(off) < least:
                least = wp.length(off)
                rest = off
                kept = shift
                best.root_weight = root_weight
                best.beta = mix.beta
                best.expected = lacking - mix.shift
                best.missed = missed
                best.move = mix.shift - mix.given_up * lacking
                if mix.given_up <= ZERO or wp.length(best.move) <= options.near:
                    best.move = wp.vec2d()
                keep_tried(blends, step)
            else:
                gain *= HALF
            shift = kept - gain * rest
    return best


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
        moved = wp.length(positions[support] - planned[support]) > ZERO
        moved = moved or wp.length(positions[support - 1] - planned[support - 1]) > ZERO
        if moved and not is_inside(corners_of(spaces, own.corners), wanted - own.bias, ZERO):
            departure = as_left(turned(-own.start, positions[support - 1] - positions[support]), side)
            own = choose_corners(own, coordinates, spaces, library, blends, options, step, wanted, departure)
        result = mix_step(own, spaces, library, blends, options, step, wanted)
        move = turned(own.end, as_left(result.move, side))
        left = turned(own.end, as_left(result.missed, side)) + move
        excess = beyond_reach(left, stride + move, own.reach, own.longest)
        result.limited = wp.max(wp.abs(excess[0]), wp.abs(excess[1])) > LIMITED
        if result.limited:
            move -= excess
        positions[support + 1] = positions[support + 1] + move
        result.hull_distance = own.hull_distance
        mixed[step] = result
