"""Warp functions of one instant: the spline's weights, the force that physics cannot explain and its derivatives.

The same as `energy.leg_forces`, with Jacobians, for the solver.
"""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["Force", "acceleration_weights", "leg_force", "position_weights"]

NEAREST = wp.constant(wp.float64(1.0e-9))
NARROW = wp.constant(wp.float64(1.0e-6))


@wp.struct
class Force:
    """[P]'s external force at one instant."""

    residual: wp.vec3d  # what the legs cannot give of a - g [m/s^2]
    by_position: wp.mat33d  # its derivative by the centre of mass's position
    by_acceleration: wp.mat33d  # and by its acceleration


@wp.func
def position_weights(x: wp.float64, length: wp.float64) -> wp.vec4d:
    """Weights of begin position, begin velocity, end position, end velocity at the part x of a segment [s]."""
    rest = wp.float64(1.0) - x
    return wp.vec4d(
        rest * rest * (wp.float64(1.0) + wp.float64(2.0) * x),
        length * x * rest * rest,
        x * x * (wp.float64(3.0) - wp.float64(2.0) * x),
        -length * x * x * rest,
    )


@wp.func
def acceleration_weights(x: wp.float64, length: wp.float64) -> wp.vec4d:
    """The same for the acceleration."""
    bend = (wp.float64(6.0) - wp.float64(12.0) * x) / (length * length)
    return wp.vec4d(
        -bend,
        (wp.float64(6.0) * x - wp.float64(4.0)) / length,
        bend,
        (wp.float64(6.0) * x - wp.float64(2.0)) / length,
    )


@wp.func
def leg_force(
    left: wp.vec3d, right: wp.vec3d, stands_left: bool, stands_right: bool, position: wp.vec3d, wanted: wp.vec3d
) -> Force:
    """The residual of the force wanted, a - g, on the cone of the standing legs, and its derivatives.

    On a ray K at distance d, with f = a - g, F' = f.K and r the residual: dr/da = I - K K' and
    dr/dx = (K (F' K - r)' - F' I) / d. Without a pushing leg dr/da = I and dr/dx = 0. On a plane with normal n, e from
    one support to the other and A the area: dr/da = n n', dr/dx = -((n.(f x e)) n + (f.n)(e x n)) n' / A. That one leg
    or both push counts as fixed.

    Args:
        left: Point of support of the left foot [m].
        right: Of the right foot [m].
        stands_left: Whether the left foot stands.
        stands_right: Whether the right foot stands.
        position: Centre of mass [m].
        wanted: a - g [m/s^2].
    """
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    identity = wp.identity(n=3, dtype=wp.float64)
    across_left = position - left
    across_right = position - right
    distance_left = wp.length(across_left) + NEAREST
    distance_right = wp.length(across_right) + NEAREST
    ray_left = across_left / distance_left
    ray_right = across_right / distance_right
    push_left = wp.dot(ray_left, wanted)
    push_right = wp.dot(ray_right, wanted)
    cosine = wp.dot(ray_left, ray_right)
    cross = wp.cross(across_left, across_right)
    area = wp.length(cross)
    force = Force()
    if (
        stands_left
        and stands_right
        and push_left > cosine * push_right
        and push_right > cosine * push_left
        and area > NARROW * distance_left * distance_right
    ):
        normal = cross / area
        apart = left - right
        out = wp.dot(normal, wanted)
        tilt = wp.dot(normal, wp.cross(wanted, apart)) * normal + out * wp.cross(apart, normal)
        force.residual = out * normal
        force.by_acceleration = wp.outer(normal, normal)
        force.by_position = wp.outer(tilt, normal) * (-one / area)
        return force
    push = zero
    distance = one
    ray = wp.vec3d(zero, zero, zero)
    if stands_left and push_left > zero:
        push = push_left
        ray = ray_left
        distance = distance_left
    if stands_right and push_right > push:
        push = push_right
        ray = ray_right
        distance = distance_right
    force.residual = wanted - push * ray
    force.by_acceleration = identity - wp.outer(ray, ray)
    force.by_position = (wp.outer(ray, push * ray - force.residual) - push * identity) * (one / distance)
    return force
