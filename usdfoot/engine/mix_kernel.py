"""The mix of a footstep's examples with the root's that lands where it has to, as Warp functions.

In steps: a mix is tried, its landing measured, and what it is asked moved by what it missed.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, blend_landing, keep_tried, try_example
from usdfoot.spaces.corner_kernel import SpaceArrays, adjoin_corners, corners_of, find_corners
from usdfoot.spaces.root_weight_kernel import cross, mean_corner, replaces_corner, weigh_corners
from usdfoot.spaces.solid_kernel import CornerWeights, find_solid, weights_of

__all__ = [
    "FARTHEST",
    "REPLACEMENTS",
    "SETTLES",
    "SLOPE",
    "WIDTH",
    "MixAim",
    "MixOptions",
    "RootedStep",
    "TriedMix",
    "land_mix",
    "move_corners",
    "replace_corners",
    "set_landing",
    "settle_mix",
    "try_mix",
]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

WIDTH = 8
"""Examples of a step: three around the footstep, five of the root; four and four in the 3-D space."""
REPLACEMENTS = 3
"""The root's heaviest examples that may replace a corner ([B] Algorithm 1)."""
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
HALF = wp.constant(wp.float64(0.5))
TINY = wp.constant(wp.float64(1e-12))
SETTLES = 8
"""How often at most the slopes of a landing are measured."""
HALVINGS = 10
"""How often at most the way these say is halved."""
SLOPE = 1e-5
"""How far apart queries are asked for that [m]."""
FARTHEST = 2.0
"""Times the miss that a query is moved at most."""

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
    speed: wp.float64  # wanted, scaled, of the root in the 3-D space [m]
    roots: RootExamples
    root_weights: RootWeights


@wp.struct
class MixOptions:
    """How steps are mixed."""

    by_features: bool
    solid: bool  # by tetrahedra of landing and root speed
    closest: bool
    tolerance: wp.float64  # lambda4 is the largest within this distance [m]; below 0 as wanted
    corrections: wp.int32
    near: wp.float64  # a landing this near to where it should be is left [m]
    landing_scale: wp.float64  # [m]
    departure_scale: wp.float64  # [m]


@wp.struct
class MixAim:
    """Where a mix has to land; vectors in left-swing coordinates [m]."""

    root_weight: wp.float64
    rest: wp.float64  # what the corners weigh, never 0
    target: wp.vec2d


@wp.struct
class TriedMix:
    """A mix whose landing was measured; vectors in left-swing coordinates [m]."""

    corners: wp.vec3i
    asked: wp.vec2d  # of the corners
    aim: wp.vec2d  # where it has to land: the target, less what the corners' space ends short of it
    missed: wp.vec2d  # from where it lands to its aim


@wp.func
def set_landing(coordinates: wp.array2d(dtype=wp.float64), step: int, landing: wp.vec2d, scale: wp.float64):
    """Has a step be compared with examples at another landing [m]."""
    for axis in range(2):
        coordinates[step, axis] = landing[axis] / scale


@wp.func
def land_mix(
    own: RootedStep,
    corners: CornerWeights,
    solid: bool,
    root_weight: wp.float64,
    library: LibraryArrays,
    blends: BlendArrays,
    step: int,
) -> wp.vec2d:
    """Where examples, which weigh 1 - lambda4 together, land with the root's, as if the left foot swung [m].

    They are three, in the 3-D space (`solid`) four.
    """
    count = wp.where(solid, 4, 3)
    for corner in range(count):
        try_example(blends, step, corner, corners.examples[corner], (ONE - root_weight) * corners.weights[corner])
    for k in range(WIDTH - count):
        try_example(blends, step, count + k, own.roots[k], root_weight * own.root_weights[k])
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
def try_mix(
    own: RootedStep,
    aim: MixAim,
    corners: wp.vec3i,
    asked: wp.vec2d,
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
) -> TriedMix:
    """The mix whose corners are asked to land somewhere; in the 3-D space those of the tetrahedron there."""
    tried = TriedMix()
    tried.corners = corners
    tried.asked = asked
    around = corners_of(spaces, corners)
    shares = weigh_corners(around, asked)
    inner = mean_corner(around, shares)
    found = weights_of(corners, shares)
    if options.solid:
        found = find_solid(spaces.solids, own.space, found, inner, own.speed)
    tried.aim = aim.target - aim.rest * (asked - inner)
    tried.missed = tried.aim - land_mix(own, found, options.solid, aim.root_weight, library, blends, step)
    return tried


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
def newton_way(missed: wp.vec2d, missed_x: wp.vec2d, missed_z: wp.vec2d) -> wp.vec2d:
    """Where to move a query for its miss to vanish, from the misses `SLOPE` beside it along x and z [m]."""
    along_x = (missed_x - missed) / wp.float64(SLOPE)
    along_z = (missed_z - missed) / wp.float64(SLOPE)
    turn = cross(along_x, along_z)
    way = missed
    if wp.abs(turn) > TINY:
        way = -wp.vec2d(cross(missed, along_z), cross(along_x, missed)) / turn
    return way * wp.min(ONE, wp.float64(FARTHEST) * wp.length(missed) / wp.max(wp.length(way), TINY))


@wp.func
def settle_mix(
    own: RootedStep,
    aim: MixAim,
    nearest: TriedMix,
    coordinates: wp.array2d(dtype=wp.float64),
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
) -> TriedMix:
    """The nearest mix, found by Newton's method where landings turn too sharply for two rounds' misses to tell.

    Examples that land close together may be blended to land several times as far apart as is asked of them. Where the
    miss points back on the way Newton says, the point at which it turns is bracketed: there the slope is the sharp one.
    """
    best = nearest
    here = nearest
    for _ in range(SETTLES):
        if options.corrections > 0 and wp.length(best.missed) > options.near:
            way = wp.vec2d(wp.float64(SLOPE), ZERO)
            corners = move_corners(own, coordinates, spaces, options, step, here.corners, here.asked + way, True)
            beside = try_mix(own, aim, corners, here.asked + way, spaces, library, blends, options, step)
            missed_x = beside.missed
            way = wp.vec2d(ZERO, wp.float64(SLOPE))
            corners = move_corners(own, coordinates, spaces, options, step, here.corners, here.asked + way, True)
            beside = try_mix(own, aim, corners, here.asked + way, spaces, library, blends, options, step)
            way = newton_way(here.missed / aim.rest, missed_x / aim.rest, beside.missed / aim.rest)
            low = wp.float64(0.0)
            high = wp.float64(2.0)
            there = here
            for halving in range(1 + HALVINGS):
                if halving == 0 or wp.length(there.missed) > HALF * wp.length(here.missed):
                    part = HALF * (low + high)
                    asked = here.asked + part * way
                    corners = move_corners(own, coordinates, spaces, options, step, here.corners, asked, True)
                    there = try_mix(own, aim, corners, asked, spaces, library, blends, options, step)
                    if wp.length(there.missed) < wp.length(best.missed):
                        best = there
                        keep_tried(blends, step)
                    if wp.dot(there.missed, here.missed) > ZERO:
                        low = part
                    else:
                        high = part
            here = there
    return best
