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
    """[P]'s external force r at one instant, and its derivatives by position x and acceleration a.

    r = Q (a - g) and dr = Q (da + turn dx) + a part across r whose length is tilt |r.dx|.
    """

    residual: wp.vec3d  # r: what the legs cannot give of a - g [m/s^2]
    projector: wp.mat33d  # Q: onto what they cannot give
    turn: wp.float64  # [1/s^2]
    tilt: wp.float64  # [1/m]


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
    """The residual of the force wanted, f = a - g, on the cone of the standing legs, and its derivatives.

    On a ray K at distance d, with F' = f.K: Q = I - K K' and dr = Q da - (F' Q + K r') dx / d. On a plane with normal
    n, e from one support to the other and A the area: Q = n n' and dr = Q da - ((n.(f x e)) n + (f.n)(e x n)) n.dx / A.
    Without a pushing leg r = f. That one leg or both push counts as fixed.

    Args:
        left: Point of support of the left foot [m].
        right: Of the right foot [m].
        stands_left: Whether the left foot stands.
        stands_right: Whether the right foot stands.
        position: Centre of mass [m].
        wanted: a - g [m/s^2].
    """
    zero = wp.float64(0.0)
    force = Force()
    force.turn = zero
    force.tilt = zero
    push = zero
    ray = wp.vec3d(zero, zero, zero)
    across_left = position - left
    across_right = position - right
    distance_left = wp.float64(1.0)
    push_left = zero
    ray_left = ray
    if stands_left:
        distance_left = wp.length(across_left) + NEAREST
        ray_left = across_left / distance_left
        push_left = wp.dot(ray_left, wanted)
    distance_right = wp.float64(1.0)
    push_right = zero
    ray_right = ray
    if stands_right:
        distance_right = wp.length(across_right) + NEAREST
        ray_right = across_right / distance_right
        push_right = wp.dot(ray_right, wanted)
    if stands_left and stands_right:
        cosine = wp.dot(ray_left, ray_right)
        if push_left > cosine * push_right and push_right > cosine * push_left:
            cross = wp.cross(across_left, across_right)
            area = wp.length(cross)
            if area > NARROW * distance_left * distance_right:
                normal = cross / area
                apart = left - right
                force.residual = wp.dot(normal, wanted) * normal
                force.projector = wp.outer(normal, normal)
                force.turn = -wp.dot(normal, wp.cross(wanted, apart)) / area
                force.tilt = wp.length(apart) / area
                return force
    if push_left > zero:
        push = push_left
        ray = ray_left
        force.turn = -push / distance_left
        force.tilt = wp.float64(1.0) / distance_left
    if push_right > push:
        push = push_right
        ray = ray_right
        force.turn = -push / distance_right
        force.tilt = wp.float64(1.0) / distance_right
    force.residual = wanted - push * ray
    force.projector = wp.identity(n=3, dtype=wp.float64) - wp.outer(ray, ray)
    return force
