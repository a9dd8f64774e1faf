"""Warp functions of E and its derivatives: the same as `energy.segment_energies`, softened, for the solver."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.force_kernel import Force, acceleration_weights, leg_force, position_weights
from usdfoot.physics.stance_kernel import StanceArrays

__all__ = ["ProblemArrays", "add_agent", "instant_share"]

NEAREST = wp.constant(wp.float64(1.0e-9))


@wp.struct
class ProblemArrays:
    """What E depends on beside the unknowns: S segments, M instants, K knots."""

    instants: int  # of a segment; a constant would have Warp unroll the loops, which takes twice the time
    durations: wp.array(dtype=wp.float64)  # (S,) [s]
    stance: StanceArrays  # of M instants
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
def instant_share(instant: int, instants: int) -> wp.float64:
    """Part of the segment passed at an instant."""
    return (wp.float64(instant) + wp.float64(0.5)) / wp.float64(instants)


@wp.func
def soft_norm(residual: wp.vec3d, softness: wp.float64) -> wp.float64:
    """Length of a vector, rounded off near zero."""
    return wp.sqrt(wp.dot(residual, residual) + softness * softness)


@wp.func
def force_at(problem: ProblemArrays, m: int, position: wp.vec3d, wanted: wp.vec3d) -> Force:
    """What the standing legs cannot give at an instant."""
    return leg_force(
        problem.stance.supports[m, 0],
        problem.stance.supports[m, 1],
        problem.stance.standing[m, 0],
        problem.stance.standing[m, 1],
        position,
        wanted,
    )


@wp.struct
class Bend:
    """One instant's part of E and how it changes.

    A control with the weights m in position and b in acceleration, and w = b + turn m, has the gradient
    w slope + m drawn. Two of them have the second derivative w w' curve + m m' held.
    """

    energy: wp.float64
    turn: wp.float64  # [1/s^2]
    slope: wp.vec3d
    drawn: wp.vec3d
    curve: wp.mat33d
    held: wp.mat33d


@wp.func
def bend_instant(
    problem: ProblemArrays, m: int, position: wp.vec3d, wanted: wp.vec3d, lasting: wp.float64, softness: wp.float64
) -> Bend:
    """Derivatives of E at an instant that stands for the time `lasting` [s].

    The norm |r| becomes the square r.r / |r|, as in iteratively reweighted least squares.
    """
    force = force_at(problem, m, position, wanted)
    norm = soft_norm(force.residual, softness)
    pull = lasting / norm
    bend = Bend()
    bend.energy = lasting * norm
    bend.turn = force.turn
    bend.slope = pull * force.residual
    bend.drawn = wp.vec3d()
    bend.curve = pull * force.projector
    bend.held = (pull * force.tilt * force.tilt) * wp.outer(force.residual, force.residual)
    for leg in range(2):
        if problem.stance.leg_shares[m, leg] > wp.float64(0.0):
            across = position - problem.stance.anchors[m, leg]
            distance = wp.max(wp.length(across), NEAREST)
            direction = across / distance
            share = problem.comfort * problem.stance.leg_shares[m, leg] * lasting
            stretch = distance - problem.stance.nominal_lengths[m, leg]
            bend.energy = bend.energy + share * stretch * stretch
            share = wp.float64(2.0) * share
            bend.held = bend.held + wp.outer(direction, direction * share)
            bend.drawn = bend.drawn + direction * (share * stretch)
    return bend


@wp.func
def add_segment(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    blocks: wp.array2d(dtype=wp.mat33d),
    gradients: wp.array(dtype=wp.vec3d),
    segment: int,
    knot: int,
    softness: wp.float64,
) -> wp.float64:
    """Adds the Hessian and gradient of one segment's part of E, and gives that part back."""
    length = problem.durations[segment]
    lasting = length / wp.float64(problem.instants)
    energy = wp.float64(0.0)
    matrix = wp.mat33d()
    vector = wp.vec3d()
    h00 = matrix
    h10 = matrix
    h11 = matrix
    h20 = matrix
    h21 = matrix
    h22 = matrix
    h30 = matrix
    h31 = matrix
    h32 = matrix
    h33 = matrix
    g0 = vector
    g1 = vector
    g2 = vector
    g3 = vector
    for n in range(problem.instants):
        m = segment * problem.instants + n
        x = instant_share(n, problem.instants)
        moved = position_weights(x, length)
        bent = acceleration_weights(x, length)
        position = blend(moved, unknowns, knot)
        wanted = blend(bent, unknowns, knot)
        wanted[1] = wanted[1] + problem.gravity
        bend = bend_instant(problem, m, position, wanted, lasting, softness)
        energy = energy + bend.energy
        for a in range(4):
            if problem.fixed[knot + a // 2, a % 2]:
                moved[a] = wp.float64(0.0)
                bent[a] = wp.float64(0.0)
        w = bent + moved * bend.turn
        g0 = g0 + w[0] * bend.slope + moved[0] * bend.drawn
        g1 = g1 + w[1] * bend.slope + moved[1] * bend.drawn
        g2 = g2 + w[2] * bend.slope + moved[2] * bend.drawn
        g3 = g3 + w[3] * bend.slope + moved[3] * bend.drawn
        h00 = h00 + (w[0] * w[0]) * bend.curve + (moved[0] * moved[0]) * bend.held
        h10 = h10 + (w[1] * w[0]) * bend.curve + (moved[1] * moved[0]) * bend.held
        h11 = h11 + (w[1] * w[1]) * bend.curve + (moved[1] * moved[1]) * bend.held
        h20 = h20 + (w[2] * w[0]) * bend.curve + (moved[2] * moved[0]) * bend.held
        h21 = h21 + (w[2] * w[1]) * bend.curve + (moved[2] * moved[1]) * bend.held
        h22 = h22 + (w[2] * w[2]) * bend.curve + (moved[2] * moved[2]) * bend.held
        h30 = h30 + (w[3] * w[0]) * bend.curve + (moved[3] * moved[0]) * bend.held
        h31 = h31 + (w[3] * w[1]) * bend.curve + (moved[3] * moved[1]) * bend.held
        h32 = h32 + (w[3] * w[2]) * bend.curve + (moved[3] * moved[2]) * bend.held
        h33 = h33 + (w[3] * w[3]) * bend.curve + (moved[3] * moved[3]) * bend.held
    row = 2 * knot
    blocks[row, 0] = blocks[row, 0] + h00
    blocks[row, 1] = blocks[row, 1] + h10
    blocks[row, 2] = h20
    blocks[row, 3] = h30
    blocks[row + 1, 0] = blocks[row + 1, 0] + h11
    blocks[row + 1, 1] = h21
    blocks[row + 1, 2] = h31
    blocks[row + 2, 0] = h22
    blocks[row + 2, 1] = h32
    blocks[row + 3, 0] = h33
    gradients[row] = gradients[row] + g0
    gradients[row + 1] = gradients[row + 1] + g1
    gradients[row + 2] = g2
    gradients[row + 3] = g3
    return energy


@wp.func
def add_agent(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    blocks: wp.array2d(dtype=wp.mat33d),
    gradients: wp.array(dtype=wp.vec3d),
    segment: int,
    segments: int,
    knot: int,
    softness: wp.float64,
) -> wp.float64:
    """Sets the Hessian and gradient of E of the agent whose first segment and knot are given, and gives E back."""
    energy = wp.float64(0.0)
    for c in range(2):
        blocks[2 * knot + c, 0] = wp.mat33d()
        blocks[2 * knot + c, 1] = wp.mat33d()
        gradients[2 * knot + c] = wp.vec3d()
    for s in range(segments):
        energy = energy + add_segment(problem, unknowns, blocks, gradients, segment + s, knot + s, softness)
    return energy
