"""Warp kernel over steps that miss a footstep inside the hull: other examples around it are tried.

A blend lands a little off the blend of its examples' landings. Near the hull's edge, or between examples of very
different poses, the three most like the step may not reach it although three others do.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.engine.correction_kernel import CorrectedStep, CorrectionOptions
from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.landing_kernel import BlendArrays, blend_landing, keep_tried, try_example
from usdfoot.spaces.corner_kernel import SpaceArrays, corners_of
from usdfoot.spaces.neighbour_kernel import NONE, square_distance
from usdfoot.spaces.root_weight_kernel import is_inside, mean_corner, weigh_corners

__all__ = ["retry_each"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

LIKELY = 32
"""How many of the examples most like the step are tried in threes."""
ATTEMPTS = 12
"""How many threes are tried at most."""

_LikelyNumbers = wp.types.vector(length=LIKELY, dtype=wp.float64)
_LikelyIndices = wp.types.vector(length=LIKELY, dtype=wp.int32)
_AttemptCosts = wp.types.vector(length=ATTEMPTS, dtype=wp.float64)
_AttemptTriples = wp.types.matrix(shape=(ATTEMPTS, 3), dtype=wp.int32)


@wp.struct
class Likely:
    """The examples most like a step, the most like first."""

    examples: _LikelyIndices  # of the library
    squares: _LikelyNumbers  # distances in coordinates; NONE where there is no example


@wp.struct
class Attempts:
    """Threes of examples around a footstep, the most like its step first."""

    triples: _AttemptTriples  # examples of the library
    costs: _AttemptCosts  # weighted squares of distances in coordinates; NONE where there is no three


@wp.func
def likely_examples(spaces: SpaceArrays, space: int, wanted: wp.array2d(dtype=wp.float64), step: int) -> Likely:
    """The examples of a space most like a step; of examples equally like it the first."""
    found = Likely()
    for c in range(LIKELY):
        found.squares[c] = NONE
    for example in range(spaces.neighbour_begins[space], spaces.neighbour_begins[space + 1]):
        square = square_distance(spaces.coordinates, example, wanted, step)
        place = int(LIKELY)
        while place > 0 and square < found.squares[place - 1]:
            place -= 1
            if place + 1 < LIKELY:
                found.squares[place + 1] = found.squares[place]
                found.examples[place + 1] = found.examples[place]
        if place < LIKELY:
            found.squares[place] = square
            found.examples[place] = spaces.neighbours[example]
    return found


@wp.func
def likely_triples(spaces: SpaceArrays, likely: Likely, landing: wp.vec2d) -> Attempts:
    """The threes around a landing whose blend is made of what is most like the step."""
    found = Attempts()
    for a in range(ATTEMPTS):
        found.costs[a] = NONE
    for i in range(LIKELY):
        for j in range(i + 1, LIKELY):
            for k in range(j + 1, LIKELY):
                if likely.squares[k] < NONE and likely.squares[i] < found.costs[ATTEMPTS - 1]:
                    triple = wp.vec3i(likely.examples[i], likely.examples[j], likely.examples[k])
                    corners = corners_of(spaces, triple)
                    if is_inside(corners, landing, wp.float64(0.0)):
                        squares = wp.vec3d(likely.squares[i], likely.squares[j], likely.squares[k])
                        cost = wp.dot(weigh_corners(corners, landing), squares)
                        place = int(ATTEMPTS)
                        while place > 0 and cost < found.costs[place - 1]:
                            place -= 1
                            if place + 1 < ATTEMPTS:
                                found.costs[place + 1] = found.costs[place]
                                for c in range(3):
                                    found.triples[place + 1, c] = found.triples[place, c]
                        if place < ATTEMPTS:
                            found.costs[place] = cost
                            for c in range(3):
                                found.triples[place, c] = triple[c]
    return found


@wp.func
def correct_triple(
    library: LibraryArrays,
    spaces: SpaceArrays,
    options: CorrectionOptions,
    step: int,
    side: int,
    wanted: wp.vec2d,
    chosen: wp.vec3i,
    least: wp.float64,
    blends: BlendArrays,
) -> CorrectedStep:
    """The best blend of three examples, kept where it misses by less than `least` [m]; its hull distance is 0."""
    found = CorrectedStep()
    found.missed = wp.vec2d(least, wp.float64(0.0))
    corners = corners_of(spaces, chosen)
    asked = wanted
    for _round in range(1 + options.corrections):
        if wp.length(found.missed) > options.near:
            shares = weigh_corners(corners, asked)
            projected = mean_corner(corners, shares)
            for k in range(blends.examples.shape[1]):
                own = wp.min(k, 2)
                weight = wp.where(k < 3, shares[own], wp.float64(0.0))
                try_example(blends, step, k, chosen[own], weight)
            landed = blend_landing(library, blends.tried_examples, blends.tried_weights, step, side)
            rest = wanted - landed
            if wp.length(rest) < wp.length(found.missed):
                found.missed = rest
                found.bias = landed - projected
                keep_tried(blends, step)
            asked = projected + rest
    return found


@wp.kernel(enable_backward=False)
def retry_each(
    library: LibraryArrays,
    spaces: SpaceArrays,
    options: CorrectionOptions,
    steps: wp.array(dtype=wp.int32),  # those to try again (K,)
    numbers: wp.array(dtype=wp.int32),  # of the space each step asks (N,)
    swing_sides: wp.array(dtype=wp.int32),  # (N,)
    landings: wp.array(dtype=wp.vec2d),  # of the footsteps, in left-swing coordinates [m] (N,)
    coordinates: wp.array2d(dtype=wp.float64),  # scaled landings and features (N, D)
    blends: BlendArrays,
    corrected: wp.array(dtype=CorrectedStep),  # (N,)
):
    """Blends each of `steps` from examples around its footstep, those most like it first, until that lands there."""
    step = steps[wp.tid()]
    wanted = landings[step]
    for axis in range(2):
        coordinates[step, axis] = wanted[axis] / options.landing_scale
    likely = likely_examples(spaces, numbers[step], coordinates, step)
    attempts = likely_triples(spaces, likely, wanted)
    side = swing_sides[step]
    for a in range(ATTEMPTS):
        missed = wp.length(corrected[step].missed)
        if missed > options.choice_near and attempts.costs[a] < NONE:
            chosen = wp.vec3i(attempts.triples[a, 0], attempts.triples[a, 1], attempts.triples[a, 2])
            found = correct_triple(library, spaces, options, step, side, wanted, chosen, missed, blends)
            if wp.length(found.missed) < missed:
                corrected[step] = found
