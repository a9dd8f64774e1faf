"""The solver's Hessian and gradient, and its steps, as kernels of their own, to be compared with references."""
# mypy: ignore-errors

from __future__ import annotations

import warp as wp

from usdfoot.physics.energy_kernel import ProblemArrays, add_agent
from usdfoot.physics.solve_kernel import WorkArrays, minimise_agent


@wp.kernel(enable_backward=False)
def normal_equations(
    problem: ProblemArrays,
    segments: wp.array(dtype=wp.int32),
    softness: wp.float64,
    unknowns: wp.array2d(dtype=wp.vec3d),
    blocks: wp.array2d(dtype=wp.mat33d),
    gradients: wp.array(dtype=wp.vec3d),
):
    """Hessian (2 K, 4) and gradient (2 K,) of E at the unknowns; agent a has segments[a] to segments[a + 1]."""
    agent = wp.tid()
    first = segments[agent]
    add_agent(problem, unknowns, blocks, gradients, first, segments[agent + 1] - first, first + agent, softness)


@wp.kernel(enable_backward=False)
def descend(problem: ProblemArrays, work: WorkArrays, segments: wp.array(dtype=wp.int32), softness: wp.float64):
    """The solver's steps for one softness."""
    agent = wp.tid()
    first = segments[agent]
    minimise_agent(problem, work, first, segments[agent + 1] - first, first + agent, softness, wp.float64(1.0e-9))
