"""Warp functions and kernel of root velocities: the influences of gradient bands."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["BandArrays", "ask_bands", "find_influence", "find_influences"]

wp.set_module_options({"enable_backward": False})

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
HALF = wp.constant(wp.float64(wp.HALF_PI))


@wp.struct
class BandArrays:
    """The bands of a root velocity space, as `RootVelocitySpace` has them."""

    constants: wp.array2d(dtype=wp.float64)
    slopes: wp.array3d(dtype=wp.float64)
    bearings: wp.array2d(dtype=wp.float64)
    polar: bool
    slowest: wp.float64


@wp.func
def ask_bands(bands: BandArrays, velocity: wp.vec2d) -> wp.vec3d:
    """What bands are asked for a velocity: bearing, how much it counts, speed; Cartesian x, 0, z."""
    if not bands.polar:
        return wp.vec3d(velocity[0], ZERO, velocity[1])
    speed = wp.length(velocity)
    counted = wp.min(speed / (wp.float64(0.5) * bands.slowest), ONE)
    return wp.vec3d(wp.atan2(velocity[0], velocity[1]), counted, speed)


@wp.func
def find_influence(bands: BandArrays, vertex: int, asked: wp.vec3d) -> wp.float64:
    """Influence of a vertex, which is done with as soon as one band leaves it nothing."""
    least = wp.float64(1.0e30)
    band = wp.int32(0)
    while band < bands.constants.shape[1] and least > ZERO:
        along = asked[0]
        if bands.polar:
            beyond = wp.abs(wp.abs(asked[0] - bands.bearings[vertex, band]) - wp.float64(2.0) * HALF) - HALF
            along = beyond * asked[1]
        influence = bands.constants[vertex, band]
        influence += along * bands.slopes[0, vertex, band] + asked[2] * bands.slopes[1, vertex, band]
        least = wp.min(least, influence)
        band += wp.int32(1)
    return wp.max(least, ZERO)


@wp.kernel(enable_backward=False)
def find_influences(bands: BandArrays, velocities: wp.array(dtype=wp.vec2d), influences: wp.array2d(dtype=wp.float64)):
    """Influence of every vertex on every velocity."""
    query = wp.tid()
    asked = ask_bands(bands, velocities[query])
    for vertex in range(influences.shape[1]):
        influences[query, vertex] = find_influence(bands, vertex, asked)
