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
