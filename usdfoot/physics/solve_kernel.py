"""The default solver as a Warp kernel, one thread an agent."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.band_kernel import solve_band
from usdfoot.physics.energy_kernel import ProblemArrays, add_agent, agent_energy

__all__ = ["minimise"]

LEAST_DAMPING = wp.constant(wp.float64(1.0e-9))
MOST_DAMPING = wp.constant(wp.float64(1.0e6))


@wp.func
def damped(pivot: wp.mat33d, damping: wp.float64, fixed: bool) -> wp.mat33d:
    """A block of the diagonal made larger; one that keeps its unknown, if that is fixed."""
    if fixed:
        return wp.identity(n=3, dtype=wp.float64)
    for i in range(3):
        pivot[i, i] = pivot[i, i] * (wp.float64(1.0) + damping) + LEAST_DAMPING
    return pivot


@wp.kernel(enable_backward=False)
def minimise(
    problem: ProblemArrays,
    segments: wp.array(dtype=wp.int32),
    softness: wp.float64,
    tolerance: wp.float64,
    iterations: int,
    unknowns: wp.array2d(dtype=wp.vec3d),
    trials: wp.array2d(dtype=wp.vec3d),
    blocks: wp.array2d(dtype=wp.mat33d),
    steps: wp.array(dtype=wp.vec3d),
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
        blocks: For the kernel's use, shape (2 K, 4).
        steps: For the kernel's use, shape (2 K,).
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
            add_agent(problem, unknowns, blocks, steps, segment, count, knot, softness)
            for k in range(knot, knot + count + 1):
                for c in range(2):
                    blocks[2 * k + c, 0] = damped(blocks[2 * k + c, 0], damping, problem.fixed[k, c])
            solved = solve_band(blocks, steps, 2 * knot, 2 * (knot + count + 1))
            for k in range(knot, knot + count + 1):
                for c in range(2):
                    trials[k, c] = unknowns[k, c] - steps[2 * k + c]
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
