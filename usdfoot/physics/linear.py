"""E to second order: residuals, their analytic Jacobians and the block-tridiagonal normal equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpbsv

from usdfoot.errors import UsdfootError
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.physics.energy import FLIGHT, PLANE, RIGHT_RAY, Forces, leg_forces, spline_samples
from usdfoot.physics.samples import Samples
from usdfoot.physics.spline import Knots

__all__ = ["NormalEquations", "Residuals", "force_jacobians", "linearise", "measure", "solve_banded"]

BANDS = 12
"""Rows of a banded matrix in which every knot's six unknowns touch those of the next knot."""


@dataclass(frozen=True, kw_only=True)
class Residuals:
    """E's terms at N instants of S segments."""

    forces: Forces
    """Shape (S, N)."""
    stretches: FloatArray
    """Virtual legs beyond their nominal length, 0 where the foot does not stand [m], shape (S, N, 2)."""
    leg_directions: FloatArray
    """Unit vectors from ankle to hip, 0 where the foot does not stand, shape (S, N, 2, 3)."""
    softened: FloatArray
    """sqrt(|residual|^2 + softness^2) [m/s^2], shape (S, N)."""
    energies: FloatArray
    """E with the softened norm, of each segment, shape (S,)."""


@dataclass(frozen=True, kw_only=True)
class NormalEquations:
    """Hessian and gradient of E, segment by segment; unknowns as in `Knots`: position, then velocity of each knot."""

    hessians: FloatArray
    """Shape (S, 12, 12)."""
    gradients: FloatArray
    """Shape (S, 12)."""


def measure(samples: Samples, controls: FloatArray, *, gravity: float, comfort: float, softness: float) -> Residuals:
    """E's terms for controls (S, 4, 3); `softness` [m/s^2] rounds off the norm of the force, 0 is [P]'s E."""
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(samples.supports, samples.standing, positions, accelerations, gravity)
    softened = np.sqrt(np.einsum("sni,sni->sn", forces.residuals, forces.residuals) + softness**2)
    across = positions[..., None, :] - samples.anchors
    lengths = np.sqrt(np.einsum("snli,snli->snl", across, across))
    stretches = samples.standing * (lengths - samples.nominal_lengths)
    legs = np.maximum(samples.standing.sum(axis=-1), 1)
    discomfort = comfort * np.einsum("snl,snl->sn", stretches, stretches) / legs
    return Residuals(
        forces=forces,
        stretches=stretches,
        leg_directions=across * (samples.standing / np.maximum(lengths, 1e-9))[..., None],
        softened=softened,
        energies=samples.intervals * (softened + discomfort).sum(axis=-1),
    )


def force_jacobians(forces: Forces, supports: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives of the residual force by the centre of mass's position and by its acceleration, (..., 3, 3) each.

    On a ray K at distance d, with f = a - g and r the residual: dr/da = I - K K' and
    dr/dx = -(K r' + (f.K)(I - K K')) / d. On a plane with normal n, e from one support to the other and A the area:
    dr/da = n n' and dr/dx = -((n.(f x e)) n + (f.n)(e x n)) n' / A. In flight dr/da = I. Faces count as fixed.
    """
    identity = np.eye(3)
    faces, wanted = forces.faces, forces.wanted
    plane = faces == PLANE
    leg = (faces == RIGHT_RAY)[..., None]
    ray = np.where(leg, forces.directions[..., 1, :], forces.directions[..., 0, :])
    distance = np.where(leg[..., 0], forces.distances[..., 1], forces.distances[..., 0])
    ray = ray * ((faces != FLIGHT) & ~plane)[..., None]
    axis = np.where(plane[..., None], forces.normals, ray)
    along = np.einsum("...i,...i->...", axis, wanted)
    outer = axis[..., :, None] * axis[..., None, :]
    by_acceleration = np.where(plane[..., None, None], outer, identity - outer)
    apart = supports[..., 0, :] - supports[..., 1, :]
    areas = np.where(plane, forces.areas, 1.0)
    lever = np.einsum("...i,...i->...", forces.normals, np.cross(wanted, apart))
    tilt = lever[..., None] * axis + along[..., None] * np.cross(apart, axis)
    by_plane = -(tilt / areas[..., None])[..., :, None] * axis[..., None, :]
    bent = ray[..., :, None] * forces.residuals[..., None, :] + along[..., None, None] * (identity - outer)
    by_ray = np.where((faces == FLIGHT)[..., None, None], 0.0, -bent / distance[..., None, None])
    return np.where(plane[..., None, None], by_plane, by_ray), by_acceleration


def linearise(samples: Samples, residuals: Residuals, *, comfort: float, curvature: float) -> NormalEquations:
    """Hessian and gradient of the softened E.

    The norm |r| becomes a weighted square, as in iteratively reweighted least squares: weight I / |r|, from which
    `curvature` times r r' / |r|^3 is taken, which makes it the norm's own second derivative at 1.
    """
    segments = len(samples.intervals)
    by_position, by_acceleration = force_jacobians(residuals.forces, samples.supports)
    weights = samples.intervals[:, None] / residuals.softened
    basis = samples.basis
    bend = basis[:, :, 0, None, :, None] * by_position[:, :, :, None, :]
    bend = bend + basis[:, :, 1, None, :, None] * by_acceleration[:, :, :, None, :]  # (S, N, 3, 4, 3)
    bend = bend.reshape(segments, -1, 3, 12)
    force = residuals.forces.residuals
    unit = force / residuals.softened[..., None]
    pull = np.einsum("sni,sniu->snu", unit, bend)
    rows = np.sqrt(weights)[..., None, None] * bend
    radial = np.sqrt(curvature * weights)[..., None] * pull
    legs = np.maximum(samples.standing.sum(axis=-1), 1)
    scale = np.sqrt(2.0 * comfort * samples.intervals[:, None] / legs)[..., None]
    strain = (scale[..., None] * residuals.leg_directions)[:, :, :, None, :] * basis[:, :, None, 0, :, None]
    strain = strain.reshape(segments, -1, 12)
    rows = np.concatenate([rows.reshape(segments, -1, 12), strain], axis=1)
    hessians = rows.transpose(0, 2, 1) @ rows - radial.transpose(0, 2, 1) @ radial
    gradients = np.einsum("s,snu->su", samples.intervals, pull)
    gradients = gradients + np.einsum("sn,snu->su", (scale * residuals.stretches).reshape(segments, -1), strain)
    return NormalEquations(hessians=hessians, gradients=gradients)


def solve_banded(equations: NormalEquations, knots: Knots, *, fixed: BoolArray, damping: FloatArray) -> FloatArray:
    """Step (K, 6) of the unknowns that solves (H + damping diag(H)) step = -gradient.

    Args:
        equations: Of all segments.
        knots: Which knots the segments lie between.
        fixed: Unknowns that keep their values, shape (K, 6).
        damping: Of each agent, shape (A,).

    Raises:
        UsdfootError: If E has no definite second derivative there.
    """
    count = len(knots.times)
    begins = knots.begins
    diagonal, gradient = np.zeros((count, 6, 6)), np.zeros((count, 6))
    hessians = equations.hessians
    diagonal[begins] = hessians[:, :6, :6]
    diagonal[begins + 1] += hessians[:, 6:, 6:]
    gradient[begins] = equations.gradients[:, :6]
    gradient[begins + 1] += equations.gradients[:, 6:]
    coupling = np.zeros((count, 6, 6))
    coupling[begins] = hessians[:, 6:, :6]
    free = ~fixed
    diagonal *= free[:, :, None] & free[:, None, :]
    coupling[:-1] *= free[1:, :, None] & free[:-1, None, :]
    gradient *= free
    main = np.einsum("kii->ki", diagonal)
    main += damping[knots.agents][:, None] * main + np.where(fixed, 1.0, 1e-9)
    step, info = _solve(diagonal, coupling, -gradient)
    if info:
        raise UsdfootError("centre of mass", f"has no definite second derivative at unknown {info}")
    return step


def _solve(diagonal: FloatArray, coupling: FloatArray, right: FloatArray) -> tuple[FloatArray, int]:
    """Solution (K, 6) of the block-tridiagonal system by LAPACK's banded Cholesky; 0 or the unknown it failed at."""
    count = len(diagonal)
    bands = np.zeros((BANDS, count, 6))
    for column in range(6):
        bands[: 6 - column, :, column] = diagonal[:, column:, column].T
        bands[6 - column : BANDS - column, :, column] = coupling[:, :, column].T
    _, solution, info = dpbsv(bands.reshape(BANDS, -1), right.ravel(), lower=1)
    return solution.reshape(count, 6), int(info)
