"""The default solver as a Warp kernel, one thread an agent."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.band_kernel import solve_band
from usdfoot.physics.comfort_kernel import settle_agent
from usdfoot.physics.energy_kernel import ProblemArrays, add_agent

__all__ = ["WorkArrays", "minimise_agent", "solve_agent", "solve_agents"]

LEAST_DAMPING = wp.constant(wp.float64(1.0e-9))
MOST_DAMPING = wp.constant(wp.float64(1.0e6))
FIRST_SOFTNESS = wp.constant(wp.float64(0.1))
LAST_SOFTNESS = wp.constant(wp.float64(0.01))
"""The norm of the force is rounded off below these, one after the other [m/s^2]."""
COARSE = wp.constant(wp.float64(1.0e-3))
"""Relative decrease of E in a step at which an agent has converged, before the last softness."""


@wp.struct
class WorkArrays:
    """What changes while K knots are solved."""

    iterations: int  # most steps for each softness; a constant would have Warp unroll the loop
    unknowns: wp.array2d(dtype=wp.vec3d)  # (K, 2) position and velocity of each knot
    trials: wp.array2d(dtype=wp.vec3d)  # (K, 2)
    blocks: wp.array2d(dtype=wp.mat33d)  # (2 K, 4)
    steps: wp.array(dtype=wp.vec3d)  # (2 K,)


@wp.func
def damped(pivot: wp.mat33d, damping: wp.float64, fixed: bool) -> wp.mat33d:
    """A block of the diagonal made larger; one that keeps its unknown, if that is fixed."""
    if fixed:
        return wp.identity(n=3, dtype=wp.float64)
    for i in range(3):
        pivot[i, i] = pivot[i, i] * (wp.float64(1.0) + damping) + LEAST_DAMPING
    return pivot


@wp.func
def minimise_agent(
    problem: ProblemArrays,
    work: WorkArrays,
    segment: int,
    count: int,
    knot: int,
    softness: wp.float64,
    tolerance: wp.float64,
):
    """Lowers an agent's E until a step changes it by less than `tolerance`.

    Reweighted least squares: a step solves (H + damping diag(H)) step = -gradient; the damping falls where E does and
    grows where it does not (Levenberg and Marquardt). E and its derivatives at the end of a step are found at once.

    Args:
        problem: Of all agents.
        work: Of all agents; the unknowns are changed.
        segment: The agent's first.
        count: Its segments; it has a knot more.
        knot: Its first.
        softness: The norm of the force is rounded off below this [m/s^2].
        tolerance: Relative to E.
    """
    damping = wp.float64(1.0e-3)
    energy = add_agent(problem, work.unknowns, work.blocks, work.steps, segment, count, knot, softness)
    going = bool(True)
    for _iteration in range(work.iterations):
        if going:
            for k in range(knot, knot + count + 1):
                for c in range(2):
                    work.blocks[2 * k + c, 0] = damped(work.blocks[2 * k + c, 0], damping, problem.fixed[k, c])
            solved = solve_band(work.blocks, work.steps, 2 * knot, 2 * (knot + count + 1))
            for k in range(knot, knot + count + 1):
                for c in range(2):
                    work.trials[k, c] = work.unknowns[k, c] - work.steps[2 * k + c]
            trial = add_agent(problem, work.trials, work.blocks, work.steps, segment, count, knot, softness)
            if solved and trial < energy:
                for k in range(knot, knot + count + 1):
                    for c in range(2):
                        work.unknowns[k, c] = work.trials[k, c]
                going = energy - trial > tolerance * energy
                energy = trial
                damping = wp.max(wp.float64(0.2) * damping, LEAST_DAMPING)
            else:
                going = damping < MOST_DAMPING and trial - energy > tolerance * energy
                damping = wp.float64(8.0) * damping
                if going:
                    add_agent(problem, work.unknowns, work.blocks, work.steps, segment, count, knot, softness)


@wp.func
def solve_agent(problem: ProblemArrays, work: WorkArrays, segment: int, count: int, knot: int, tolerance: wp.float64):
    """Lowers an agent's E with the norm rounded off less and less."""
    minimise_agent(problem, work, segment, count, knot, FIRST_SOFTNESS, COARSE)
    minimise_agent(problem, work, segment, count, knot, LAST_SOFTNESS, tolerance)


@wp.kernel(enable_backward=False)
def solve_agents(
    problem: ProblemArrays, work: WorkArrays, segments: wp.array(dtype=wp.int32), tolerance: wp.float64, settles: bool
):
    """Lowers every agent's E from its unknowns, or from where its legs are comfortable.

    Args:
        problem: Of all agents.
        work: Of all agents; the unknowns are changed.
        segments: Agent a has segments[a] to segments[a + 1]; a knot more, shape (A + 1,).
        tolerance: Relative to E.
        settles: Whether to begin where the legs are comfortable.
    """
    agent = wp.tid()
    segment = segments[agent]
    count = segments[agent + 1] - segment
    if settles:
        settle_agent(problem, work.unknowns, segment, count, segment + agent)
    solve_agent(problem, work, segment, count, segment + agent, tolerance)
