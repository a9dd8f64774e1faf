"""[P]'s functional: the force that physics cannot explain, and how uncomfortable the legs are (2.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.samples import Samples, instant_shares
from usdfoot.physics.spline import hermite_basis

__all__ = ["Forces", "cross", "leg_forces", "sample_costs", "segment_energies", "spline_samples"]

NARROW = 1e-6
"""Two legs whose directions differ by a smaller sine press along one line."""
NEAREST = 1e-9
"""Smallest distance of the centre of mass from a support [m]."""


@dataclass(frozen=True, kw_only=True)
class Forces:
    """Forces per unit mass at M instants."""

    residuals: FloatArray
    """What the legs cannot give of a - g: [P]'s external force [m/s^2], shape (M, 3)."""
    pushes: FloatArray
    """[P]'s F' of the leg that pushes most, 0 if none does [m/s^2], shape (M,)."""
    planes: IntArray
    """Instants at which both legs push: the residual stands on the plane of both, shape (P,)."""


def spline_samples(samples: Samples, controls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre of mass and its acceleration at the samples [m, m/s^2], shape (S N, 3) each.

    Args:
        samples: N instants of S segments.
        controls: Begin position, begin velocity, end position, end velocity of the segments, shape (S, 4, 3).
    """
    instants = samples.times.shape[1]
    basis = hermite_basis(instant_shares(instants), np.ones(instants))[[0, 2]]  # (2, N, 4), segments of 1 s
    durations = instants * samples.intervals[:, None, None]
    scaled = controls.copy()
    scaled[:, 1::2] *= durations
    positions, accelerations = basis[0] @ scaled, basis[1] @ scaled / durations**2
    return positions.reshape(-1, 3), accelerations.reshape(-1, 3)


def leg_forces(
    supports: FloatArray, standing: BoolArray, *, positions: FloatArray, accelerations: FloatArray, gravity: float
) -> Forces:
    """The part of a - g that legs which only push cannot give ([P] 2.4.1).

    What they can give is a cone: nothing in flight, the ray K from the support to the centre of mass in single stance,
    in double stance the plane sector between both rays. The residual leads from the nearest point of the cone: [P]'s
    F' with its constraint F' > 0, and in double stance the component out of the plane and beyond the triangle.

    Args:
        supports: Points of support [m], shape (M, 2, 3).
        standing: Which feet stand, shape (M, 2).
        positions: Centre of mass [m], shape (M, 3).
        accelerations: [m/s^2], shape (M, 3).
        gravity: [m/s^2].
    """
    wanted = accelerations + np.array([0.0, gravity, 0.0])
    across = positions[:, None] - supports
    distances = np.sqrt(np.einsum("mli,mli->ml", across, across)) + NEAREST
    directions = across / distances[..., None]
    pushes = np.einsum("mli,mi->ml", directions, wanted)
    cosines = np.einsum("mi,mi->m", directions[:, 0], directions[:, 1])
    shares = pushes - cosines[:, None] * pushes[:, ::-1]  # both legs' parts of the force in their plane, times sin^2
    normals = cross(across[:, 0], across[:, 1])
    areas = np.sqrt(np.einsum("mi,mi->m", normals, normals))
    apart = areas > NARROW * distances[:, 0] * distances[:, 1]
    planes = np.flatnonzero(standing.all(axis=1) & (shares > 0.0).all(axis=1) & apart)
    normals = normals[planes] / areas[planes, None]
    pushes = np.where(standing, np.maximum(pushes, 0.0), 0.0)
    leg = pushes[:, 1] > pushes[:, 0]
    rays = np.where(leg[:, None], directions[:, 1], directions[:, 0])
    push = np.maximum(pushes[:, 0], pushes[:, 1])
    residuals = wanted - push[:, None] * rays
    residuals[planes] = np.einsum("mi,mi->m", normals, wanted[planes])[:, None] * normals
    return Forces(residuals=residuals, pushes=push, planes=planes)


def sample_costs(samples: Samples, controls: FloatArray, *, gravity: float, comfort: float) -> FloatArray:
    """[P]'s integrand |residual| + k (l - l_nom)^2 [m/s^2] (2.4.2), the comfort term as the mean of the standing legs.

    Shape (M,).
    """
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(
        samples.stance.supports,
        samples.stance.standing,
        positions=positions,
        accelerations=accelerations,
        gravity=gravity,
    )
    stretches = np.linalg.norm(positions[:, None] - samples.stance.anchors, axis=-1) - samples.stance.nominal_lengths
    return np.linalg.norm(forces.residuals, axis=1) + comfort * np.sum(samples.stance.leg_shares * stretches**2, axis=1)


def segment_energies(samples: Samples, controls: FloatArray, *, gravity: float, comfort: float) -> FloatArray:
    """[P]'s E of each segment: its integrand summed over the instants, shape (S,)."""
    costs = sample_costs(samples, controls, gravity=gravity, comfort=comfort)
    return samples.intervals * costs.reshape(samples.times.shape).sum(axis=1)


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products (M, 3), much quicker than numpy's for few vectors."""
    ax, ay, az = first.T
    bx, by, bz = second.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)
