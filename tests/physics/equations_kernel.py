"""The solver's Hessian and gradient as a kernel of their own, to be compared with references."""
# mypy: ignore-errors

from __future__ import annotations

import warp as wp

from usdfoot.physics.energy_kernel import ProblemArrays, add_agent


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
