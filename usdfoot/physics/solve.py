"""The default solver: iteratively reweighted least squares, each step damped as by Levenberg and Marquardt."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray
from usdfoot.physics.energy_kernel import ProblemArrays
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import Samples
from usdfoot.physics.shared_arrays import shared, shared_record
from usdfoot.physics.solve_kernel import WorkArrays, solve_agents
from usdfoot.physics.spline import Knots
from usdfoot.physics.stance_kernel import StanceArrays

__all__ = ["device_problem", "device_work", "first_segments", "optimise_unknowns"]

ITERATIONS = 60
"""Most steps for each softness of the norm."""


def optimise_unknowns(
    samples: Samples, knots: Knots, start: FloatArray, *, options: PhysicsOptions, settles: bool = True
) -> FloatArray:
    """Unknowns (K, 6) that minimise E; agents are independent of each other.

    Only what is fixed is taken from the start (K, 6): E has several minima, a few percent apart, and from far off the
    one that is found may be of a body upside down. So all else begins where the legs are comfortable, and E is the same
    from any start.

    Args:
        samples: Of all segments.
        knots: Of all agents.
        start: Unknowns to begin with.
        options: How to optimise.
        settles: Whether to begin where the legs are comfortable; False = from all of `start`.
    """
    unknowns = start.copy()
    wp.launch(
        solve_agents,
        dim=len(knots.starts),
        inputs=[
            device_problem(samples, knots, options), device_work(unknowns),
            first_segments(knots), options.tolerance, settles,
        ],
        device="cpu",
    )  # fmt: skip
    return unknowns


def device_problem(samples: Samples, knots: Knots, options: PhysicsOptions) -> ProblemArrays:
    """The problem's arrays for the kernels."""
    return shared_record(
        ProblemArrays,
        {
            "instants": samples.times.shape[1],
            "durations": knots.durations,
            "stance": shared_record(StanceArrays, vars(samples.stance)),
            "fixed": knots.fixed,
            "gravity": options.gravity,
            "comfort": options.comfort,
        },
    )


def device_work(unknowns: FloatArray) -> WorkArrays:
    """Room for the kernels to change unknowns (K, 6) in place."""
    count = len(unknowns)
    return shared_record(
        WorkArrays,
        {
            "iterations": ITERATIONS,
            "unknowns": unknowns.reshape(count, 2, 3),
            "trials": np.empty((count, 2, 3)),
            "blocks": np.empty((2 * count, 4, 3, 3)),
            "steps": np.empty((2 * count, 3)),
        },
    )


def first_segments(knots: Knots) -> wp.array:
    """Index of each agent's first segment, and their number, on the device, shape (A + 1,)."""
    owners = knots.agents[knots.begins]
    return shared(np.searchsorted(owners, np.arange(len(knots.starts) + 1)), wp.int32)
