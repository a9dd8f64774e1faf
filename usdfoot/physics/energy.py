"""[P]'s functional: the force that physics cannot explain, and how uncomfortable the legs are (2.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.samples import Samples

__all__ = ["FLIGHT", "PLANE", "Forces", "leg_forces", "segment_energies", "spline_samples"]

FLIGHT, LEFT_RAY, RIGHT_RAY, PLANE = 0, 1, 2, 3
"""What the legs' force lies on: nothing, the line of one leg, the plane of both."""
TINY = 1e-9


@dataclass(frozen=True, kw_only=True)
class Forces:
    """Forces per unit mass at samples of any shape (...)."""

    residuals: FloatArray
    """What the legs cannot give of a - g: [P]'s external force [m/s^2], shape (..., 3)."""
    wanted: FloatArray
    """a - g [m/s^2], shape (..., 3)."""
    faces: IntArray
    """One of FLIGHT, LEFT_RAY, RIGHT_RAY, PLANE, shape (...)."""
    directions: FloatArray
    """Unit vectors from the points of support to the centre of mass, shape (..., 2, 3)."""
    distances: FloatArray
    """Their lengths [m], shape (..., 2)."""
    normals: FloatArray
    """Unit normal of the plane of both, shape (..., 3)."""
    areas: FloatArray
    """Length of the cross product of both legs' vectors [m^2], shape (...)."""


def spline_samples(samples: Samples, controls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre of mass and its acceleration at the samples [m, m/s^2], shape (S, N, 3) each.

    Args:
        samples: N instants of S segments.
        controls: Begin position, begin velocity, end position, end velocity of the segments, shape (S, 4, 3).
    """
    values = samples.basis.reshape(len(controls), -1, 4) @ controls  # (S, 2 N, 3)
    values = values.reshape(len(controls), -1, 2, 3)
    return values[:, :, 0], values[:, :, 1]


def leg_forces(
    supports: FloatArray, standing: BoolArray, positions: FloatArray, accelerations: FloatArray, gravity: float
) -> Forces:
    """The part of a - g that legs which only push cannot give.

    What they can give is a cone: nothing in flight, the ray K from the support to the centre of mass in single stance,
    in double stance the plane sector between both rays. The residual is the distance to the cone: [P]'s F' with its
    constraint F' > 0, and in double stance [P]'s component out of the plane and beyond the triangle.

    Args:
        supports: Points of support [m], shape (..., 2, 3).
        standing: Which feet stand, shape (..., 2).
        positions: Centre of mass [m], shape (..., 3).
        accelerations: [m/s^2], shape (..., 3).
        gravity: [m/s^2].
    """
    wanted = accelerations + np.array([0.0, gravity, 0.0])
    across = positions[..., None, :] - supports
    distances = np.sqrt(np.einsum("...i,...i->...", across, across)) + TINY
    directions = across / distances[..., None]
    first, second = across[..., 0, :], across[..., 1, :]
    cross = _cross(first, second)
    areas = np.sqrt(np.einsum("...i,...i->...", cross, cross))
    spread = areas > 1e-6 * distances[..., 0] * distances[..., 1]
    normals = cross / np.where(spread, areas, 1.0)[..., None]
    push = np.einsum("...si,...i->...s", directions, wanted)
    faces = _faces(push, standing, np.einsum("...i,...i->...", directions[..., 0, :], directions[..., 1, :]), spread)
    leg = np.where(faces == RIGHT_RAY, 1, 0)
    ray = np.where(leg[..., None] == 1, directions[..., 1, :], directions[..., 0, :])
    along = np.where(leg == 1, push[..., 1], push[..., 0])
    on_ray = (faces == LEFT_RAY) | (faces == RIGHT_RAY)
    out = np.einsum("...i,...i->...", normals, wanted)
    residuals = np.where(
        (faces == PLANE)[..., None], out[..., None] * normals, wanted - np.where(on_ray, along, 0.0)[..., None] * ray
    )
    return Forces(
        residuals=residuals,
        wanted=wanted,
        faces=faces,
        directions=directions,
        distances=distances,
        normals=normals,
        areas=areas,
    )


def _faces(push: FloatArray, standing: BoolArray, cosine: FloatArray, spread: BoolArray) -> IntArray:
    """The face of the cone nearest to the force wanted, shape (...)."""
    pushes = standing & (push > 0.0)
    left, right = push[..., 0], push[..., 1]
    inside = (left > cosine * right) & (right > cosine * left)  # both legs' shares are positive
    rays = np.where(left >= right, LEFT_RAY, RIGHT_RAY)
    rays = np.where(pushes[..., 0] & pushes[..., 1], rays, pushes[..., 0] + 2 * pushes[..., 1])
    return np.where(standing.all(axis=-1) & inside & spread, PLANE, rays)


def segment_energies(samples: Samples, controls: FloatArray, *, gravity: float, comfort: float) -> FloatArray:
    """[P]'s E of each segment, shape (S,).

    E = sum of (|residual| + k (l - l_nom)^2) dt, the comfort term as the mean of the legs that stand.
    """
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(samples.supports, samples.standing, positions, accelerations, gravity)
    physics = np.linalg.norm(forces.residuals, axis=-1)
    across = positions[..., None, :] - samples.anchors
    stretch = np.linalg.norm(across, axis=-1) - samples.nominal_lengths
    legs = np.maximum(samples.standing.sum(axis=-1), 1)
    discomfort = comfort * np.sum(np.where(samples.standing, stretch**2, 0.0), axis=-1) / legs
    return samples.intervals * (physics + discomfort).sum(axis=-1)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products, much quicker than numpy's for few vectors, shape (..., 3)."""
    ax, ay, az = first[..., 0], first[..., 1], first[..., 2]
    bx, by, bz = second[..., 0], second[..., 1], second[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
