"""Warp kernel over steps: asks the footstep spaces, measures the landing, and corrects what was asked."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, blend_landing, keep_tried, try_example
from usdfoot.spaces.corner_kernel import SpaceArrays, adjoin_corners, corners_of, find_corners
from usdfoot.spaces.root_weight_kernel import mean_corner, weigh_corners
from usdfoot.spaces.solid_kernel import find_solid, weights_of

__all__ = ["TRIES", "CorrectedStep", "CorrectionOptions", "correct_each", "heading_change"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

TINY = wp.constant(wp.float64(1e-30))
TRIES = wp.constant(3)
"""How often chosen examples are weighed before others are chosen."""


@wp.struct
class CorrectionOptions:
    """How steps are corrected."""

    by_features: bool
    solid: bool  # by tetrahedra of landing and root speed
    corrections: wp.int32
    near: wp.float64  # a landing this near to where it should be is left [m]
    choice_near: wp.float64  # this near, no other examples are chosen [m]
    landing_scale: wp.float64  # [m]


@wp.struct
class CorrectedStep:
    """What became of a step; vectors in left-swing coordinates."""

    missed: wp.vec2d  # from where it lands to the footstep [m]
    bias: wp.vec2d  # from where its examples' landings, weighted, are to where it lands [m]
    hull_distance: wp.float64  # of the footstep [m]


@wp.func
def heading_change(missed: wp.vec2d, missed_before: wp.vec2d, moved: wp.vec2d) -> wp.vec2d:
    """By what to move a query next, which was `moved` since the round before, for two rounds' misses to head for zero.

    Landings that answer a move with more than twice of it would be overdone each time by what they miss alone.
    """
    turn = missed - missed_before
    part = wp.dot(missed, turn) / wp.max(wp.dot(turn, turn), TINY)
    return missed - wp.clamp(part, wp.float64(-1.0), wp.float64(1.0)) * (moved + turn)


@wp.kernel(enable_backward=False)
def correct_each(
    library: LibraryArrays,
    spaces: SpaceArrays,
    options: CorrectionOptions,
    numbers: wp.array(dtype=wp.int32),  # of the space each step asks (N,)
    swing_sides: wp.array(dtype=wp.int32),  # (N,)
    landings: wp.array(dtype=wp.vec2d),  # of the footsteps, in left-swing coordinates [m] (N,)
    speeds: wp.array(dtype=wp.float64),  # wanted, scaled, of the root in the 3-D space (N,)
    coordinates: wp.array2d(dtype=wp.float64),  # scaled landings and features (N, D), changed to what is asked
    blends: BlendArrays,
    corrected: wp.array(dtype=CorrectedStep),  # (N,)
):
    """Blends each step as `correct_steps` describes it."""
    step = wp.tid()
    wanted = landings[step]
    asked = wanted
    chosen = wp.vec3i()
    result = CorrectedStep()
    least = wp.float64(wp.inf)
    rest_before = wp.vec2d()
    asked_before = wp.vec2d()
    near = wp.float64(-1.0)
    distance = wp.float64(0.0)
    for round_ in range(1 + options.corrections):
        if distance > near:
            for axis in range(2):
                coordinates[step, axis] = asked[axis] / options.landing_scale
            if options.solid or round_ % TRIES == 0:
                found = find_corners(spaces, numbers[step], asked, coordinates, step, options.by_features)
                chosen = found.examples
                if round_ == 0:
                    result.hull_distance = found.hull_distance
            elif options.by_features:
                chosen = adjoin_corners(spaces, numbers[step], chosen, asked, coordinates, step)
            corners = corners_of(spaces, chosen)
            shares = weigh_corners(corners, asked)
            projected = mean_corner(corners, shares)
            mixed = weights_of(chosen, shares)
            if options.solid:
                own = numbers[step]
                mixed = find_solid(spaces.solids, own, mixed, projected, speeds[step])
            for k in range(blends.examples.shape[1]):
                try_example(blends, step, k, mixed.examples[k], mixed.weights[k])
            for k in range(3):
                chosen[k] = blends.tried_examples[step, k]
            landed = blend_landing(library, blends.tried_examples, blends.tried_weights, step, swing_sides[step])
            rest = wanted - landed
            distance = wp.length(rest)
            if distance < least:
                least = distance
                result.missed = rest
                result.bias = landed - projected
                keep_tried(blends, step)
            change = rest
            if round_ > 0:
                change = heading_change(rest, rest_before, projected - asked_before)
            asked_before = projected
            rest_before = rest
            asked = projected + change
            near = wp.where((round_ + 1) % TRIES == 0, options.choice_near, options.near)
    corrected[step] = result
