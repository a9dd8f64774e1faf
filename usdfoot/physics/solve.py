"""The default solver: iteratively reweighted least squares, each step damped as by Levenberg and Marquardt."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray
from usdfoot.model.device import start_warp
from usdfoot.physics.comfort import comfortable_unknowns
from usdfoot.physics.energy_kernel import ProblemArrays
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import Samples
from usdfoot.physics.solve_kernel import minimise
from usdfoot.physics.spline import Knots

__all__ = ["device_problem", "first_segments", "optimise_unknowns"]

SOFTNESSES = (0.1, 0.01)
"""The norm of the force is rounded off below these, one after the other [m/s^2]."""
COARSE = 1e-3
"""Relative decrease of E in a step at which an agent has converged, before the last softness."""
ITERATIONS = 60
"""Most steps for each softness."""


def optimise_unknowns(samples: Samples, knots: Knots, start: FloatArray, options: PhysicsOptions) -> FloatArray:
    """Unknowns (K, 6) that minimise E; agents are independent of each other.

    Only what is fixed is taken from the start (K, 6): E has several minima, a few percent apart, and from far off the
    one that is found may be of a body upside down. So all else begins where the legs are comfortable, and E is the same
    from any start.
    """
    problem = device_problem(samples, knots, options)
    count = len(knots.times)
    best = comfortable_unknowns(samples, knots, start).reshape(count, 2, 3)
    values = _array(best, wp.vec3d)
    work = [
        wp.empty((count, 2), dtype=wp.vec3d, device="cpu"),
        wp.empty((2 * count, 4), dtype=wp.mat33d, device="cpu"),
        wp.empty(2 * count, dtype=wp.vec3d, device="cpu"),
    ]
    segments = first_segments(knots)
    for softness in SOFTNESSES:
        tolerance = options.tolerance if softness == SOFTNESSES[-1] else COARSE
        wp.launch(
            minimise,
            dim=len(knots.starts),
            inputs=[problem, segments, softness, tolerance, ITERATIONS, values, *work],
            device="cpu",
        )
    return best.reshape(count, 6)


def device_problem(samples: Samples, knots: Knots, options: PhysicsOptions) -> ProblemArrays:
    """The problem's arrays for the kernels."""
    start_warp()
    problem = ProblemArrays()
    problem.instants = samples.times.shape[1]
    problem.durations = _array(knots.durations, wp.float64)
    problem.standing = _array(samples.standing, wp.bool)
    problem.supports = _array(samples.supports, wp.vec3d)
    problem.anchors = _array(samples.anchors, wp.vec3d)
    problem.nominal_lengths = _array(samples.nominal_lengths, wp.float64)
    problem.leg_shares = _array(samples.leg_shares, wp.float64)
    problem.fixed = _array(knots.fixed, wp.bool)
    problem.gravity = options.gravity
    problem.comfort = options.comfort
    return problem


def first_segments(knots: Knots) -> wp.array:
    """Index of each agent's first segment, and their number, on the device, shape (A + 1,)."""
    owners = knots.agents[knots.begins]
    return _array(np.searchsorted(owners, np.arange(len(knots.starts) + 1)).astype(np.int32), wp.int32)


def _array(values: np.ndarray, kind: object) -> wp.array:
    """The same memory as an array of Warp, without a copy."""
    return wp.array(np.ascontiguousarray(values), dtype=kind, device="cpu", copy=False)
