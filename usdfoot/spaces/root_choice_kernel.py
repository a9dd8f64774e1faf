"""Warp kernel over steps: the root examples of each, and weights that meet its root velocity."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.spaces.gradient_band_kernel import BandArrays, ask_bands, find_influence
from usdfoot.spaces.root_weight_kernel import Corners, is_inside, mean_corner, weigh_corners

__all__ = ["PICKED", "VelocityArrays", "choose_roots"]

wp.set_module_options({"enable_backward": False, "max_unroll": 3})

PICKED = 5
"""Root examples a step is blended from: with the three of its footstep, as many as the kernels take."""
POOL = PICKED + 3
"""Those the bands pick, and the corners of the triangle around the wanted velocity."""
ROUNDS = wp.constant(12)
LONGEST_STEP = wp.constant(wp.float64(2.0))
"""Largest change of an exponent in one round of Newton's method."""
SETTLED = wp.constant(wp.float64(1e-11))
"""Largest change of an exponent after which another round changes nothing."""
SOFTNESS = wp.constant(wp.float64(0.1))
"""Velocities nearer to each other than this [m/s] are hardly told apart."""
MISSED = wp.constant(wp.float64(0.02))
"""What the bands' examples may miss of the wanted velocity [m/s] before the triangle's help."""
SLACK = wp.constant(wp.float64(1e-10))
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))

_Numbers = wp.types.vector(length=POOL, dtype=wp.float64)
_Indices = wp.types.vector(length=POOL, dtype=wp.int32)
_Velocities = wp.types.matrix(shape=(POOL, 2), dtype=wp.float64)


@wp.struct
class VelocityArrays:
    """The vertices of a root velocity space, and the triangles between their velocities."""

    velocities: wp.array(dtype=wp.vec2d)  # of the vertices (V,) [m/s]
    members: wp.array2d(dtype=wp.int32)  # the library's examples each stands for, padded with -1
    triangles: wp.array(dtype=wp.vec3i)  # vertices
    edges: wp.array(dtype=wp.vec3i)  # of the hull, the end twice
    bands: BandArrays
    example_velocities: wp.array(dtype=wp.vec2d)  # of all the library's examples (E,) [m/s]
    example_coordinates: wp.array2d(dtype=wp.float64)  # scaled landings and features (E, D)


@wp.func
def tilt_weights(weights: _Numbers, points: _Velocities, wanted: wp.vec2d) -> _Numbers:
    """Weights nearest to those given whose points' mean is the wanted one, as far as that goes.

    Nearest in relative entropy, so they are w_i exp(u . p_i) over their sum: none becomes negative, those of 0 stay 0
    and they change smoothly with the wish. u is the minimum of the convex log sum_i w_i exp(u . (p_i - p)) +
    softness^2 |u|^2 / 2, whose second term bounds u where p cannot be reached; it leaves softness^2 u to miss.
    It is found by Newton's method.

    Args:
        weights: Not negative, sum 1.
        points: What each of them gives alone.
        wanted: p.
    """
    tilt = wp.vec2d()
    tilted = weights
    rounds = wp.int32(0)
    largest = wp.float64(wp.inf)
    while rounds < ROUNDS and largest > SETTLED:
        rounds += wp.int32(1)
        mean = wp.vec2d()
        spread = SOFTNESS * SOFTNESS * wp.identity(n=2, dtype=wp.float64)
        for k in range(POOL):
            mean += tilted[k] * (points[k] - wanted)
        for k in range(POOL):
            around = points[k] - wanted - mean
            spread += tilted[k] * wp.outer(around, around)
        step = -(wp.inverse(spread) * (mean + SOFTNESS * SOFTNESS * tilt))
        largest = wp.float64(1.0e-12)
        for k in range(POOL):
            if weights[k] > ZERO:
                largest = wp.max(largest, wp.abs(wp.dot(points[k] - wanted - mean, step)))
        tilt += wp.min(ONE, LONGEST_STEP / largest) * step
        highest = wp.float64(-1.0e30)
        for k in range(POOL):
            if weights[k] > ZERO:
                highest = wp.max(highest, wp.dot(points[k] - wanted, tilt))
        total = wp.float64(0.0)
        for k in range(POOL):
            if weights[k] > ZERO:
                tilted[k] = weights[k] * wp.exp(wp.dot(points[k] - wanted, tilt) - highest)
                total += tilted[k]
        tilted = tilted / total
    return tilted


@wp.struct
class Picked:
    """Vertices and weights, heaviest first."""

    vertices: _Indices
    weights: _Numbers


@wp.func
def add_heaviest(picked: Picked, vertex: int, weight: wp.float64) -> Picked:
    """The PICKED + 1 heaviest so far, of equal weights the first that came."""
    place = PICKED + 1
    while place > 0 and picked.weights[place - 1] < weight:
        place -= 1
        if place < PICKED:
            picked.weights[place + 1] = picked.weights[place]
            picked.vertices[place + 1] = picked.vertices[place]
    if place <= PICKED:
        picked.weights[place] = weight
        picked.vertices[place] = vertex
    return picked


@wp.func
def keep_picked(picked: Picked) -> Picked:
    """The PICKED heaviest, sum 1.

    What the next one weighs is taken off all of them, so that none leaves or enters with a jump.
    """
    cut = picked.weights[PICKED]
    total = ZERO
    for k in range(PICKED):
        total += picked.weights[k] - cut
    if total <= ZERO:
        cut = ZERO
        for k in range(PICKED):
            total += picked.weights[k]
    for k in range(POOL):
        if k < PICKED:
            picked.weights[k] = (picked.weights[k] - cut) / total
        else:
            picked.weights[k] = ZERO
        if picked.weights[k] == ZERO:
            picked.vertices[k] = picked.vertices[0]
    return picked


@wp.func
def member_like(
    velocities: VelocityArrays, vertex: int, coordinates: wp.array2d(dtype=wp.float64), step: int
) -> wp.int32:
    """Of the examples a vertex stands for the one most like the wanted step."""
    least = wp.float64(wp.inf)
    nearest = velocities.members[vertex, 0]
    for k in range(velocities.members.shape[1]):
        example = velocities.members[vertex, k]
        if example >= 0:
            square = ZERO
            for d in range(coordinates.shape[1]):
                difference = velocities.example_coordinates[example, d] - coordinates[step, d]
                square += difference * difference
            if square < least:
                least = square
                nearest = example
    return nearest


@wp.func
def velocity_corners(velocities: VelocityArrays, vertices: wp.vec3i) -> Corners:
    corners = Corners()
    for corner in range(3):
        corners[corner] = velocities.velocities[vertices[corner]]
    return corners


@wp.func
def vertices_around(velocities: VelocityArrays, wanted: wp.vec2d) -> wp.vec3i:
    """Vertices of the triangle around a velocity, outside the hull of its nearest edge."""
    for triangle in range(velocities.triangles.shape[0]):
        vertices = velocities.triangles[triangle]
        if is_inside(velocity_corners(velocities, vertices), wanted, SLACK):
            return vertices
    least = wp.float64(wp.inf)
    nearest = wp.vec3i()
    for edge in range(velocities.edges.shape[0]):
        corners = velocity_corners(velocities, velocities.edges[edge])
        distance = wp.length(wanted - mean_corner(corners, weigh_corners(corners, wanted)))
        if distance < least:
            least = distance
            nearest = velocities.edges[edge]
    return nearest


@wp.func
def with_triangle(velocities: VelocityArrays, picked: Picked, blended: wp.vec2d, wanted: wp.vec2d) -> Picked:
    """The blend picked, helped by the triangle around the wanted velocity, or the nearest edge of the hull.

    The more the `blended` velocity, that of the tilted weights, misses the triangle's, the larger is the triangle's
    share: none up to MISSED, and so much that with it no more than MISSED would be missed.
    """
    vertices = vertices_around(velocities, wanted)
    corners = velocity_corners(velocities, vertices)
    shares = weigh_corners(corners, wanted)
    missed = wp.length(blended - mean_corner(corners, shares))
    if missed <= MISSED:
        return picked
    mixed = picked
    for k in range(POOL):
        mixed.weights[k] = picked.weights[k] * MISSED / missed
    for corner in range(3):
        place = PICKED + corner
        for k in range(PICKED + corner):
            if place >= PICKED and mixed.vertices[k] == vertices[corner]:
                place = k
        mixed.vertices[place] = vertices[corner]
        mixed.weights[place] = mixed.weights[place] + (ONE - MISSED / missed) * shares[corner]
    heaviest = Picked()
    for k in range(POOL):
        heaviest = add_heaviest(heaviest, mixed.vertices[k], mixed.weights[k])
    return keep_picked(heaviest)


@wp.func
def examples_like(
    velocities: VelocityArrays, picked: Picked, coordinates: wp.array2d(dtype=wp.float64), step: int
) -> _Indices:
    """Of each vertex picked the example most like a step; the first one's where there is no weight."""
    examples = _Indices()
    for k in range(POOL):
        examples[k] = examples[0]
        if k == 0 or picked.weights[k] > ZERO:
            examples[k] = member_like(velocities, picked.vertices[k], coordinates, step)
    return examples


@wp.func
def velocities_of(velocities: VelocityArrays, examples: _Indices) -> _Velocities:
    found = _Velocities()
    for k in range(POOL):
        found[k] = velocities.example_velocities[examples[k]]
    return found


@wp.func
def nearest_vertex(velocities: VelocityArrays, wanted: wp.vec2d) -> int:
    """The vertex whose velocity is nearest to the wanted one, of equally near ones the first."""
    least = wp.float64(wp.inf)
    nearest = wp.int32(0)
    for vertex in range(velocities.velocities.shape[0]):
        distance = wp.length(velocities.velocities[vertex] - wanted)
        if distance < least:
            least = distance
            nearest = vertex
    return nearest


@wp.kernel(enable_backward=False)
def choose_roots(
    velocities: VelocityArrays,
    queries: wp.array(dtype=wp.vec2d),  # wanted velocities (N,) [m/s]
    coordinates: wp.array2d(dtype=wp.float64),  # scaled landings and features of the steps (N, D)
    meet: bool,
    examples: wp.array2d(dtype=wp.int32),  # (N, PICKED)
    weights: wp.array2d(dtype=wp.float64),  # (N, PICKED)
):
    """Root examples of each step as `find_roots` describes them; their weights are tilted if they `meet`."""
    step = wp.tid()
    wanted = queries[step]
    asked = ask_bands(velocities.bands, wanted)
    picked = Picked()
    for vertex in range(velocities.velocities.shape[0]):
        picked = add_heaviest(picked, vertex, find_influence(velocities.bands, vertex, asked))
    if picked.weights[0] <= ZERO:
        picked.vertices[0] = nearest_vertex(velocities, wanted)
        picked.weights[0] = ONE
    picked = keep_picked(picked)
    chosen = examples_like(velocities, picked, coordinates, step)
    shares = picked.weights
    if meet:
        points = velocities_of(velocities, chosen)
        shares = tilt_weights(picked.weights, points, wanted)
        blended = wp.vec2d()
        for k in range(PICKED):
            blended += shares[k] * points[k]
        if wp.length(blended - wanted) > MISSED:
            picked = with_triangle(velocities, picked, blended, wanted)
            chosen = examples_like(velocities, picked, coordinates, step)
            shares = tilt_weights(picked.weights, velocities_of(velocities, chosen), wanted)
    for k in range(PICKED):
        examples[step, k] = chosen[k]
        weights[step, k] = shares[k]
