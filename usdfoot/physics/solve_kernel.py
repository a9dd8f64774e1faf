"""The default solver as a Warp kernel, one thread an agent."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.band_kernel import add_block, solve_band
from usdfoot.physics.force_kernel import acceleration_weights, leg_force, position_weights

__all__ = ["ProblemArrays", "minimise", "normal_equations"]

INSTANTS = wp.constant(10)
PART = wp.constant(wp.float64(0.1))
LEAST_DAMPING = wp.constant(wp.float64(1.0e-9))
MOST_DAMPING = wp.constant(wp.float64(1.0e6))


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


@wp.func
def add_instant(
    problem: ProblemArrays,
    unknowns: wp.array2d(dtype=wp.vec3d),
    bands: wp.array2d(dtype=wp.float64),
    gradients: wp.array(dtype=wp.float64),
    segment: int,
    knot: int,
    instant: int,
    softness: wp.float64,
):
    """Adds the Hessian and gradient of one instant's part of E.

    The norm |r| becomes the square r.r / |r|, as in iteratively reweighted least squares.
    """
    length = problem.durations[segment]
    m = segment * INSTANTS + instant
    x = instant_share(instant)
    moved = position_weights(x, length)
    bent = acceleration_weights(x, length)
    position = blend(moved, unknowns, knot)
    wanted = blend(bent, unknowns, knot)
    wanted[1] = wanted[1] + problem.gravity
    force = leg_force(
        problem.supports[m, 0], problem.supports[m, 1], problem.standing[m, 0], problem.standing[m, 1], position, wanted
    )
    interval = length * PART
    weight = interval / soft_norm(force.residual, softness)
    turned = wp.transpose(force.by_position) * weight
    bent_turned = wp.transpose(force.by_acceleration) * weight
    position_position = turned * force.by_position
    position_acceleration = turned * force.by_acceleration
    acceleration_acceleration = bent_turned * force.by_acceleration
    position_gradient = turned * force.residual
    acceleration_gradient = bent_turned * force.residual
    for leg in range(2):
        across = position - problem.anchors[m, leg]
        distance = wp.max(wp.length(across), wp.float64(1.0e-9))
        direction = across / distance
        share = wp.float64(2.0) * problem.comfort * problem.leg_shares[m, leg] * interval
        position_position = position_position + wp.outer(direction, direction) * share
        position_gradient = position_gradient + direction * (share * (distance - problem.nominal_lengths[m, leg]))
    for a in range(4):
        if problem.fixed[knot + a // 2, a % 2]:
            moved[a] = wp.float64(0.0)
            bent[a] = wp.float64(0.0)
    for a in range(4):
        row = 6 * knot + 3 * a
        part = moved[a] * position_gradient + bent[a] * acceleration_gradient
        for i in range(3):
            gradients[row + i] = gradients[row + i] + part[i]
        by_position = position_position * moved[a] + wp.transpose(position_acceleration) * bent[a]
        by_acceleration = position_acceleration * moved[a] + acceleration_acceleration * bent[a]
        for b in range(a + 1):
            add_block(bands, row, 6 * knot + 3 * b, by_position * moved[b] + by_acceleration * bent[b])


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
        for n in range(INSTANTS):
            add_instant(problem, unknowns, bands, gradients, segment + s, knot + s, n, softness)


@wp.kernel(enable_backward=False)
def normal_equations(
    problem: ProblemArrays,
    segments: wp.array(dtype=wp.int32),
    softness: wp.float64,
    unknowns: wp.array2d(dtype=wp.vec3d),
    bands: wp.array2d(dtype=wp.float64),
    gradients: wp.array(dtype=wp.float64),
):
    """Hessian (6 K, 12) and gradient (6 K,) of E at the unknowns; agent a has segments[a] to segments[a + 1]."""
    agent = wp.tid()
    first = segments[agent]
    add_agent(problem, unknowns, bands, gradients, first, segments[agent + 1] - first, first + agent, softness)


@wp.kernel(enable_backward=False)
def minimise(
    problem: ProblemArrays,
    segments: wp.array(dtype=wp.int32),
    softness: wp.float64,
    tolerance: wp.float64,
    iterations: int,
    unknowns: wp.array2d(dtype=wp.vec3d),
    trials: wp.array2d(dtype=wp.vec3d),
    bands: wp.array2d(dtype=wp.float64),
    steps: wp.array(dtype=wp.float64),
    counts: wp.array(dtype=wp.int32),
):
    """Lowers each agent's E until a step changes it by less than `tolerance`.

    Reweighted least squares: a step solves (H + damping diag(H)) step = -gradient; the damping falls where E does and
    grows where it does not (Levenberg and Marquardt).

    Args:
        problem: Of all agents.
        segments: Agent a has segments[a] to segments[a + 1]; a knot more, shape (A + 1,).
        softness: The norm of the force is rounded off below this [m/s^2].
        tolerance: Relative to E.
        iterations: Most steps.
        unknowns: Position and velocity of each knot, changed in place, shape (K, 2).
        trials: For the kernel's use, shape (K, 2).
        bands: For the kernel's use, shape (6 K, 12).
        steps: For the kernel's use, shape (6 K,).
        counts: Steps of each agent, added to, shape (A,).
    """
    agent = wp.tid()
    segment = segments[agent]
    count = segments[agent + 1] - segment
    knot = segment + agent
    damping = wp.float64(1.0e-3)
    energy = agent_energy(problem, unknowns, segment, count, knot, softness)
    going = bool(True)
    for _iteration in range(iterations):
        if going:
            counts[agent] = counts[agent] + 1
            add_agent(problem, unknowns, bands, steps, segment, count, knot, softness)
            for row in range(6 * knot, 6 * (knot + count + 1)):
                pivot = bands[row, 0]
                bands[row, 0] = pivot * (wp.float64(1.0) + damping) + wp.float64(1.0e-9)
                if pivot == wp.float64(0.0):
                    bands[row, 0] = wp.float64(1.0)
            solved = solve_band(bands, steps, 6 * knot, 6 * (knot + count + 1))
            for k in range(knot, knot + count + 1):
                for c in range(2):
                    row = 6 * k + 3 * c
                    trials[k, c] = unknowns[k, c] - wp.vec3d(steps[row], steps[row + 1], steps[row + 2])
            trial = agent_energy(problem, trials, segment, count, knot, softness)
            if solved and trial < energy:
                for k in range(knot, knot + count + 1):
                    for c in range(2):
                        unknowns[k, c] = trials[k, c]
                going = energy - trial > tolerance * energy
                energy = trial
                damping = wp.max(wp.float64(0.2) * damping, LEAST_DAMPING)
            else:
                going = damping < MOST_DAMPING and trial - energy > tolerance * energy
                damping = wp.float64(8.0) * damping
