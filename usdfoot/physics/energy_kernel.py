"""Warp functions of E and its derivatives: the same as `energy.segment_energies`, softened, for the solver."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.band_kernel import add_block
from usdfoot.physics.force_kernel import acceleration_weights, leg_force, position_weights

__all__ = ["ProblemArrays", "add_agent", "agent_energy"]

INSTANTS = wp.constant(10)
PART = wp.constant(wp.float64(0.1))


@wp.struct
class ProblemArrays:
    """What E depends on beside the unknowns: S segments, M = 10 S instants, K knots."""

    durations: wp.array(dtype=wp.float64)  # (S,) [s]
    standing: wp.array2d(dtype=wp.bool)  # (M, 2)
    supports: wp.array2d(dtype=wp.vec3d)  # (M, 2) [m]
    anchors: wp.array2d(dtype=wp.vec3d)  # (M, 2) [m]
    nominal_lengths: wp.array2d(dtype=wp.float64)  # (M, 2) [m]
    leg_shares: wp.array2d(dtype=wp.float64)  # (M, 2) weight of each leg's comfort
    fixed: wp.array2d(dtype=wp.bool)  # (K, 2) position, velocity
    gravity: wp.float64  # [m/s^2]
    comfort: wp.float64  # [P]'s k [1/(m s^2)]


@wp.func
def blend(weights: wp.vec4d, unknowns: wp.array2d(dtype=wp.vec3d), knot: int) -> wp.vec3d:
    """The spline's value between `knot` and the next."""
    return (
        weights[0] * unknowns[knot, 0]
        + weights[1] * unknowns[knot, 1]
        + weights[2] * unknowns[knot + 1, 0]
        + weights[3] * unknowns[knot + 1, 1]
    )


@wp.func
def instant_share(instant: int) -> wp.float64:
    """Part of the segment passed at an instant."""
    return (wp.float64(instant) + wp.float64(0.5)) * PART


@wp.func
def soft_norm(residual: wp.vec3d, softness: wp.float64) -> wp.float64:
    """Length of a vector, rounded off near zero."""
    return wp.sqrt(wp.dot(residual, residual) + softness * softness)


@wp.func
def agent_energy(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    segment: int,
    segments: int,
    knot: int,
    softness: wp.float64,
) -> wp.float64:
    """E of an agent whose first segment and knot are given."""
    total = wp.float64(0.0)
    for s in range(segments):
        length = problem.durations[segment + s]
        for n in range(INSTANTS):
            m = (segment + s) * INSTANTS + n
            x = instant_share(n)
            position = blend(position_weights(x, length), unknowns, knot + s)
            wanted = blend(acceleration_weights(x, length), unknowns, knot + s)
            wanted[1] = wanted[1] + problem.gravity
            force = leg_force(
                problem.supports[m, 0],
                problem.supports[m, 1],
                problem.standing[m, 0],
                problem.standing[m, 1],
                position,
                wanted,
            )
            cost = soft_norm(force.residual, softness)
            for leg in range(2):
                stretch = wp.length(position - problem.anchors[m, leg]) - problem.nominal_lengths[m, leg]
                cost = cost + problem.comfort * problem.leg_shares[m, leg] * stretch * stretch
            total = total + cost * length * PART
    return total


@wp.struct
class Curvature:
    """Second derivatives of one instant's part of E, and first ones."""

    positions: wp.mat33d  # by the position, twice
    mixed: wp.mat33d  # by the position, then the acceleration
    accelerations: wp.mat33d  # by the acceleration, twice
    by_position: wp.vec3d
    by_acceleration: wp.vec3d


@wp.func
def curve_instant(
    problem: ProblemArrays, m: int, position: wp.vec3d, wanted: wp.vec3d, lasting: wp.float64, softness: wp.float64
) -> Curvature:
    """Derivatives of E at an instant that stands for the time `lasting` [s].

    The norm |r| becomes the square r.r / |r|, as in iteratively reweighted least squares.
    """
    force = leg_force(
        problem.supports[m, 0], problem.supports[m, 1], problem.standing[m, 0], problem.standing[m, 1], position, wanted
    )
    pull = lasting / soft_norm(force.residual, softness)
    turned = wp.transpose(force.by_position) * pull
    bent = wp.transpose(force.by_acceleration) * pull
    curve = Curvature()
    curve.positions = turned * force.by_position
    curve.mixed = turned * force.by_acceleration
    curve.accelerations = bent * force.by_acceleration
    curve.by_position = turned * force.residual
    curve.by_acceleration = bent * force.residual
    for leg in range(2):
        across = position - problem.anchors[m, leg]
        distance = wp.max(wp.length(across), wp.float64(1.0e-9))
        direction = across / distance
        share = wp.float64(2.0) * problem.comfort * problem.leg_shares[m, leg] * lasting
        curve.positions = curve.positions + wp.outer(direction, direction) * share
        curve.by_position = curve.by_position + direction * (share * (distance - problem.nominal_lengths[m, leg]))
    return curve


@wp.func
def squared(curve: Curvature, moved: wp.vec4d, bent: wp.vec4d, a: int, b: int) -> wp.mat33d:
    """Second derivatives by two of a segment's four controls."""
    return (
        (moved[a] * moved[b]) * curve.positions
        + (moved[a] * bent[b]) * curve.mixed
        + (bent[a] * moved[b]) * wp.transpose(curve.mixed)
        + (bent[a] * bent[b]) * curve.accelerations
    )


@wp.func
def add_segment(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    bands: wp.array2d(dtype=wp.float64),
    gradients: wp.array(dtype=wp.float64),
    segment: int,
    knot: int,
    softness: wp.float64,
):
    """Adds the Hessian and gradient of one segment's part of E, summed up before they are stored."""
    length = problem.durations[segment]
    row = 6 * knot
    zero = wp.mat33d()
    block00 = zero
    block10 = zero
    block11 = zero
    block20 = zero
    block21 = zero
    block22 = zero
    block30 = zero
    block31 = zero
    block32 = zero
    block33 = zero
    for n in range(INSTANTS):
        x = instant_share(n)
        moved = position_weights(x, length)
        bent = acceleration_weights(x, length)
        position = blend(moved, unknowns, knot)
        wanted = blend(bent, unknowns, knot)
        wanted[1] = wanted[1] + problem.gravity
        curve = curve_instant(problem, segment * INSTANTS + n, position, wanted, length * PART, softness)
        for a in range(4):
            if problem.fixed[knot + a // 2, a % 2]:
                moved[a] = wp.float64(0.0)
                bent[a] = wp.float64(0.0)
            part = moved[a] * curve.by_position + bent[a] * curve.by_acceleration
            for i in range(3):
                gradients[row + 3 * a + i] = gradients[row + 3 * a + i] + part[i]
        block00 = block00 + squared(curve, moved, bent, 0, 0)
        block10 = block10 + squared(curve, moved, bent, 1, 0)
        block11 = block11 + squared(curve, moved, bent, 1, 1)
        block20 = block20 + squared(curve, moved, bent, 2, 0)
        block21 = block21 + squared(curve, moved, bent, 2, 1)
        block22 = block22 + squared(curve, moved, bent, 2, 2)
        block30 = block30 + squared(curve, moved, bent, 3, 0)
        block31 = block31 + squared(curve, moved, bent, 3, 1)
        block32 = block32 + squared(curve, moved, bent, 3, 2)
        block33 = block33 + squared(curve, moved, bent, 3, 3)
    add_block(bands, row + 0, row + 0, block00)
    add_block(bands, row + 3, row + 0, block10)
    add_block(bands, row + 3, row + 3, block11)
    add_block(bands, row + 6, row + 0, block20)
    add_block(bands, row + 6, row + 3, block21)
    add_block(bands, row + 6, row + 6, block22)
    add_block(bands, row + 9, row + 0, block30)
    add_block(bands, row + 9, row + 3, block31)
    add_block(bands, row + 9, row + 6, block32)
    add_block(bands, row + 9, row + 9, block33)


@wp.func
def add_agent(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    bands: wp.array2d(dtype=wp.float64),
    gradients: wp.array(dtype=wp.float64),
    segment: int,
    segments: int,
    knot: int,
    softness: wp.float64,
):
    """Sets the Hessian and gradient of an agent's E."""
    for row in range(6 * knot, 6 * (knot + segments + 1)):
        gradients[row] = wp.float64(0.0)
        for d in range(12):
            bands[row, d] = wp.float64(0.0)
    for s in range(segments):
        add_segment(problem, unknowns, bands, gradients, segment + s, knot + s, softness)
