"""The default solver: iteratively reweighted least squares, each step damped as by Levenberg and Marquardt."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.physics.linear import Residuals, linearise, measure, solve_banded
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import Samples
from usdfoot.physics.spline import Knots

__all__ = ["controls_of", "optimise_unknowns"]

SOFTNESSES = (1.0, 0.3, 0.1, 0.03, 0.01)
"""The norm of the force is rounded off below these, one after the other [m/s^2]."""
ITERATIONS = 12
"""Most steps for each softness."""
TOLERANCE = 1e-5
"""Relative decrease of E at which an agent has converged."""


def optimise_unknowns(
    samples: Samples, knots: Knots, unknowns: FloatArray, options: PhysicsOptions, *, fixed: BoolArray
) -> FloatArray:
    """Unknowns (K, 6) that minimise E, from `unknowns`; all agents at once, each with its own damping.

    Args:
        samples: Of all segments.
        knots: Of all agents.
        unknowns: Position and velocity of each knot, shape (K, 6).
        options: Gravity and comfort.
        fixed: Unknowns that stay, shape (K, 6).
    """
    for softness in SOFTNESSES:
        unknowns = _converge(samples, knots, unknowns, options, fixed, softness)
    return unknowns


def _converge(
    samples: Samples, knots: Knots, unknowns: FloatArray, options: PhysicsOptions, fixed: BoolArray, softness: float
) -> FloatArray:
    agents = len(knots.starts)
    owners = knots.agents[knots.begins]
    damping = np.full(agents, 1e-3)
    active = np.ones(agents, dtype=bool)

    def terms(values: FloatArray) -> Residuals:
        return measure(
            samples, controls_of(values, knots), gravity=options.gravity, comfort=options.comfort, softness=softness
        )

    current = terms(unknowns)
    energies = np.bincount(owners, current.energies, agents)
    for _ in range(ITERATIONS):
        equations = linearise(samples, current, comfort=options.comfort, curvature=0.0)
        step = solve_banded(equations, knots, fixed=fixed, damping=damping)
        trial_unknowns = unknowns + step * active[knots.agents][:, None]
        trial = terms(trial_unknowns)
        trial_energies = np.bincount(owners, trial.energies, agents)
        better = trial_energies < energies
        decrease = energies - trial_energies
        active &= ~(better & (decrease < TOLERANCE * energies)) & (damping < 1e6)
        damping = np.where(better, np.maximum(0.2 * damping, 1e-9), 8.0 * damping)
        unknowns = np.where(better[knots.agents][:, None], trial_unknowns, unknowns)
        if better.all():
            current, energies = trial, trial_energies
        else:
            current = terms(unknowns)
            energies = np.bincount(owners, current.energies, agents)
        if not active.any():
            break
    return unknowns


def controls_of(unknowns: FloatArray, knots: Knots) -> FloatArray:
    """Begin position, begin velocity, end position, end velocity of each segment, shape (S, 4, 3)."""
    pairs = unknowns.reshape(-1, 2, 3)
    return np.concatenate([pairs[knots.begins], pairs[knots.begins + 1]], axis=1)
