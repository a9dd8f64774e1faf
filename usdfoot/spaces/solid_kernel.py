"""The corners of tetrahedra, chosen step by step on the device as `solve_tetrahedra` chooses them."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.spaces.root_weight_kernel import Corners, areas_at

__all__ = ["CornerWeights", "SolidArrays", "find_solid", "find_solids", "weights_of"]

SLACK = wp.constant(wp.float64(1e-9))
"""A point this far outside a face, in barycentric coordinates, still is inside."""
BESIDE = wp.constant(wp.float64(1e-7))
"""A point farther than this [m] beside the box around a tetrahedron is not in it."""


@wp.struct
class SolidArrays:
    """The tetrahedra of a library's spaces, end to end; examples are the library's, in left-swing coordinates."""

    points: wp.array(dtype=wp.vec3d)  # (x, z, scaled speed) of every example [m] (E,)
    begins: wp.array(dtype=wp.int32)  # of each space, and the end of the last (S + 1,)
    tetrahedra: wp.array(dtype=wp.vec4i)  # examples
    inverses: wp.array(dtype=wp.mat44d)  # from (x, z, speed, 1) to barycentric coordinates
    lows: wp.array(dtype=wp.vec3d)  # the boxes around them
    highs: wp.array(dtype=wp.vec3d)
    face_begins: wp.array(dtype=wp.int32)  # (S + 1,)
    faces: wp.array(dtype=wp.vec3i)  # of the hull, not upright; examples


@wp.struct
class CornerWeights:
    """Four examples and their blend weights."""

    examples: wp.vec4i
    weights: wp.vec4d


@wp.func
def weights_of(examples: wp.vec3i, weights: wp.vec3d) -> CornerWeights:
    """Three examples; the fourth is the third with no weight."""
    found = CornerWeights()
    for corner in range(3):
        found.examples[corner] = examples[corner]
        found.weights[corner] = weights[corner]
    found.examples[3] = examples[2]
    return found


@wp.func
def is_beside(low: wp.vec3d, high: wp.vec3d, point: wp.vec4d) -> bool:
    """Whether a point lies outside a box."""
    over = wp.vec3d(point[0], point[1], point[2])
    return wp.min(over - low) < -BESIDE or wp.max(over - high) > BESIDE


@wp.func
def on_faces(
    solids: SolidArrays,
    space: int,
    plain: CornerWeights,
    landing: wp.vec2d,
    speed: wp.float64,
) -> CornerWeights:
    """Weights of the hull's face over or under a landing whose speed there is nearest; the plain ones if none is."""
    found = plain
    least = wp.float64(wp.inf)
    for face in range(solids.face_begins[space], solids.face_begins[space + 1]):
        examples = solids.faces[face]
        corners = Corners()
        speeds = wp.vec3d()
        for corner in range(3):
            point = solids.points[examples[corner]]
            corners[corner] = wp.vec2d(point[0], point[1])
            speeds[corner] = point[2]
        areas = areas_at(corners, landing)
        shares = areas / (areas[0] + areas[1] + areas[2])
        away = wp.abs(wp.dot(shares, speeds) - speed)
        if wp.min(shares) >= -SLACK and away < least:
            least = away
            shares = wp.max(shares, wp.vec3d())
            found = weights_of(examples, shares / (shares[0] + shares[1] + shares[2]))
    return found


@wp.func
def find_solid(
    solids: SolidArrays,
    space: int,
    plain: CornerWeights,
    landing: wp.vec2d,
    speed: wp.float64,
) -> CornerWeights:
    """Weights of four examples for a landing in the hull and a scaled root speed [m], as `solve_tetrahedra` has them.

    `plain` are those without a speed.
    """
    point = wp.vec4d(landing[0], landing[1], speed, wp.float64(1.0))
    for t in range(solids.begins[space], solids.begins[space + 1]):
        if not is_beside(solids.lows[t], solids.highs[t], point):
            shares = solids.inverses[t] * point
            if wp.min(shares) >= -SLACK:
                shares = wp.max(shares, wp.vec4d())
                found = CornerWeights()
                found.examples = solids.tetrahedra[t]
                found.weights = shares / (shares[0] + shares[1] + shares[2] + shares[3])
                return found
    return on_faces(solids, space, plain, landing, speed)


@wp.kernel(enable_backward=False)
def find_solids(solids: SolidArrays, points: wp.array(dtype=wp.vec3d), mixed: wp.array(dtype=CornerWeights)):
    """`find_solid` in the first space for (x, z, scaled speed) each [m]; `mixed` has the plain weights at first."""
    query = wp.tid()
    point = points[query]
    mixed[query] = find_solid(solids, 0, mixed[query], wp.vec2d(point[0], point[1]), point[2])
