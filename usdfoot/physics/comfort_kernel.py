"""Warp function that says where the optimisation begins: in comfort, whatever physics says."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.energy_kernel import ProblemArrays

__all__ = ["settle_agent"]


@wp.func
def comfortable_place(problem: ProblemArrays, segment: int, segments: int, place: int) -> wp.vec4d:
    """Where the legs hold the centre of mass at an agent's knot, times the weight on them, and that weight.

    The leg stands straight up in its nominal length; of two that stand, the mean by the weight on them.
    """
    total = wp.vec4d()
    for side in range(2):  # the last instant before the knot, the first one after it
        s = place - 1 + side
        if s >= 0 and s < segments:
            m = (segment + s) * problem.instants + (1 - side) * (problem.instants - 1)
            for leg in range(2):
                top = problem.stance.anchors[m, leg]
                load = problem.stance.leg_shares[m, leg]
                height = top[1] + problem.stance.nominal_lengths[m, leg]
                total = total + load * wp.vec4d(top[0], height, top[2], wp.float64(1.0))
    return total


@wp.func
def settle_agent(problem: ProblemArrays, unknowns: wp.array2d(dtype=wp.vec3d), segment: int, segments: int, knot: int):
    """Puts an agent's knots at rest where the legs are most comfortable, but for what is fixed.

    Knots in the air are where the last one before them is that stands, else the first one after them. Where none
    stands all stay as they are.
    """
    first = wp.int32(-1)
    for k in range(segments + 1):
        if first < 0 and comfortable_place(problem, segment, segments, k)[3] > wp.float64(0.0):
            first = k
    if first < 0:
        return
    place = comfortable_place(problem, segment, segments, first)
    for k in range(segments + 1):
        own = comfortable_place(problem, segment, segments, k)
        if own[3] > wp.float64(0.0):
            place = own
        if not problem.fixed[knot + k, 0]:
            unknowns[knot + k, 0] = wp.vec3d(place[0], place[1], place[2]) / place[3]
        if not problem.fixed[knot + k, 1]:
            unknowns[knot + k, 1] = wp.vec3d()
