"""Warp kernel over agents: mixes their steps with the root's examples in turn, each from where the last one landed."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.correction_kernel import TRIES, heading_change
from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, as_left, keep_tried, turned
from usdfoot.engine.mix_kernel import (
    MixAim,
    MixOptions,
    RootedStep,
    TriedMix,
    land_mix,
    move_corners,
    replace_corners,
    set_landing,
    settle_mix,
    try_mix,
)
from usdfoot.spaces.corner_kernel import SpaceArrays, corners_of, find_corners, way_inside
from usdfoot.spaces.root_weight_kernel import (
    Corners,
    find_beta,
    find_given_up,
    find_largest,
    is_inside,
    mean_corner,
    weigh_corners,
)
from usdfoot.spaces.solid_kernel import weights_of

__all__ = ["MixedStep", "mix_in_turn"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
HALF = wp.constant(wp.float64(0.5))
SLACK = wp.constant(wp.float64(1e-6))
"""A landing this far outside an edge, in barycentric coordinates, still is between its examples."""
LIMITED = wp.constant(wp.float64(1e-6))
"""A foot that has to stand farther from its footstep than this [m] is limited."""


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
def find_root_weight(
    own: RootedStep, around: Corners, options: MixOptions, beta: wp.float64, root: wp.vec2d, wanted: wp.vec2d
) -> wp.float64:
    """lambda4 as wanted, or as much of it as plants the foot within the tolerance."""
    if options.tolerance < ZERO:
        return own.wanted
    most = wp.float64(1.0)
    if options.closest and not options.solid:
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


@wp.struct
class PlannedMix:
    """A step as planned; vectors in left-swing coordinates."""

    corners: wp.vec3i  # examples around its footstep
    root: wp.vec2d  # where the root's examples land ([B] Eq. 3), measured on their blend [m]
    beta: wp.float64


@wp.func
def plan_mix(
    own: RootedStep,
    coordinates: wp.array2d(dtype=wp.float64),
    spaces: SpaceArrays,
    library: LibraryArrays,
    blends: BlendArrays,
    options: MixOptions,
    step: int,
    planned: wp.vec2d,
) -> PlannedMix:
    """Beta in the examples around the footstep as planned, in the 3-D space in all of its hull."""
    plain = PlannedMix()
    footstep = planned - own.bias
    plain.corners = replace_corners(own, spaces, own.corners, footstep)
    plain.root = land_mix(own, weights_of(plain.corners, wp.vec3d()), options.solid, ONE, library, blends, step)
    if options.solid:
        plain.corners = find_corners(spaces, own.space, footstep, coordinates, step, False).examples
        plain.beta = within_hull(spaces, own.space, ONE, footstep, plain.root - own.bias)
    else:
        around = corners_of(spaces, plain.corners)
        plain.beta = find_beta(around, weigh_corners(around, footstep), plain.root - own.bias)
    return plain


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
    plain = plan_mix(own, coordinates, spaces, library, blends, options, step, planned)
    result.beta = plain.beta
    root = plain.root
    corners = plain.corners
    around = corners_of(spaces, corners)
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
    aim = MixAim()
    aim.root_weight = find_root_weight(own, around, options, result.beta, root, wanted)
    aim.rest = wp.max(ONE - aim.root_weight, LIMITED)
    given_up = find_given_up(aim.root_weight, result.beta)
    aim.target = nearest
    if not options.closest:
        aim.target = nearest + given_up * (root - nearest)
    asked = (aim.target - aim.root_weight * root) / aim.rest - bias
    asked_before = wp.vec2d()
    change_before = wp.vec2d()
    distance = wp.float64(wp.inf)
    tries = wp.int32(0)
    best = TriedMix()
    best.missed = wp.vec2d(wp.float64(wp.inf), ZERO)
    for round_ in range(1 + options.corrections):
        if wp.length(best.missed) > options.near:
            if round_ > 0 or not is_inside(corners_of(spaces, corners), asked, SLACK):
                corners = move_corners(own, coordinates, spaces, options, step, corners, asked, tries > 0)
            tried = try_mix(own, aim, corners, asked, spaces, library, blends, options, step)
            if wp.length(tried.missed) < wp.length(best.missed):
                best = tried
                keep_tried(blends, step)
            change = tried.missed / aim.rest
            if tries > 0:
                change = heading_change(change, change_before, asked - asked_before)
            asked_before = asked
            change_before = tried.missed / aim.rest
            asked += change
            tries += 1
            others = options.by_features and tries >= TRIES and 2 * round_ < options.corrections
            if others and wp.length(tried.missed) > HALF * distance:
                tries = 0
            distance = wp.length(tried.missed)
    best = settle_mix(own, aim, best, coordinates, spaces, library, blends, options, step)
    result.expected = wanted - best.aim
    result.missed = result.expected + best.missed
    result.move = best.aim - nearest + given_up * (nearest - wanted)
    result.root_weight = aim.root_weight
    if given_up <= ZERO or wp.length(result.move) <= options.near:
        result.move = wp.vec2d()
    return result


@wp.func
def beyond_reach(left: wp.vec2d, displacement: wp.vec2d, reach: wp.float64, longest: wp.float64) -> wp.vec2d:
    """How far a landing has to fall short of its footstep, as `reach.beyond_reach` has it [m]."""
    beyond_ik = left * wp.max(wp.float64(1.0) - reach / wp.max(wp.length(left), wp.float64(1e-12)), ZERO)
    beyond_leg = displacement * wp.max(
        wp.float64(1.0) - longest / wp.max(wp.length(displacement), wp.float64(1e-12)), ZERO
    )
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
        displacement = positions[support + 1] - positions[support]
        wanted = as_left(turned(-own.end, displacement), side)
        departure = as_left(turned(-own.start, positions[support - 1] - positions[support]), side)
        last = coordinates.shape[1]
        for axis in range(2):
            coordinates[step, last - 2 + axis] = departure[axis] / options.departure_scale
        foreseen = as_left(turned(-own.end, planned[support + 1] - planned[support]), side)
        result = mix_step(own, coordinates, spaces, library, blends, options, step, foreseen, wanted)
        move = turned(own.end, as_left(result.move, side))
        left = turned(own.end, as_left(result.missed, side)) + move
        excess = beyond_reach(left, displacement + move, own.reach, own.longest)
        result.limited = wp.max(wp.abs(excess[0]), wp.abs(excess[1])) > LIMITED
        if result.limited:
            move -= excess
        positions[support + 1] = positions[support + 1] + move
        mixed[step] = result
