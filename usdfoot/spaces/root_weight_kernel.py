"""The closed form of lambda4 and [B] Algorithm 1 for one step, as Warp functions."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = [
    "Corners",
    "RootMix",
    "areas_at",
    "cross",
    "find_beta",
    "find_given_up",
    "find_largest",
    "is_inside",
    "mean_corner",
    "mix_root",
    "replaces_corner",
    "weigh_corners",
]

wp.set_module_options({"enable_backward": False})

SMALLEST_AREA = wp.constant(wp.float64(1e-9))
"""Twice the area [m^2] below which a triangle is degenerate."""
HALVINGS = wp.constant(40)
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))

Corners = wp.types.matrix(shape=(3, 2), dtype=wp.float64)
"""Landings of a triangle's three examples, (x, z) [m]."""


@wp.struct
class RootMix:
    """A blend of a triangle's corners with the root's examples."""

    weights: wp.vec3d  # lambda_1..3, sum 1 - lambda4
    beta: wp.float64
    given_up: wp.float64
    shift: wp.vec2d  # from the footstep to where the blend lands [m]


@wp.func
def cross(first: wp.vec2d, second: wp.vec2d) -> wp.float64:
    """Twice the signed area of the triangle that two vectors span."""
    return first[0] * second[1] - first[1] * second[0]


@wp.func
def areas_at(corners: Corners, point: wp.vec2d) -> wp.vec3d:
    """Twice the signed areas between a point and the edge opposite each corner."""
    a = corners[0] - point
    b = corners[1] - point
    c = corners[2] - point
    return wp.vec3d(cross(b, c), cross(c, a), cross(a, b))


@wp.func
def is_inside(corners: Corners, point: wp.vec2d, slack: wp.float64) -> bool:
    """Whether a point lies in a triangle of either orientation; never in a degenerate one.

    Its barycentric coordinates may be as little as -slack.
    """
    areas = areas_at(corners, point)
    total = areas[0] + areas[1] + areas[2]
    return wp.abs(total) >= SMALLEST_AREA and wp.min(areas * wp.sign(total)) >= -slack * wp.abs(total)


@wp.func
def mean_corner(corners: Corners, weights: wp.vec3d) -> wp.vec2d:
    """Where the corners land when blended by weights."""
    return weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2]


@wp.func
def weigh_corners(corners: Corners, point: wp.vec2d) -> wp.vec3d:
    """Weights ([B] Eq. 1), not negative, of the point of a triangle nearest to the query; it may be degenerate."""
    areas = areas_at(corners, point)
    total = areas[0] + areas[1] + areas[2]
    if wp.abs(total) >= SMALLEST_AREA and wp.min(areas * wp.sign(total)) >= ZERO:
        return areas / total
    least = wp.float64(wp.inf)
    weights = wp.vec3d()
    for corner in range(3):
        other = (corner + 1) % 3
        along = corners[other] - corners[corner]
        square = wp.dot(along, along)
        fraction = ZERO
        if square > ZERO:
            fraction = wp.clamp(wp.dot(point - corners[corner], along) / square, ZERO, ONE)
        rest = point - corners[corner] - fraction * along
        if wp.dot(rest, rest) < least:
            least = wp.dot(rest, rest)
            weights = wp.vec3d()
            weights[corner] = ONE - fraction
            weights[other] = fraction
    return weights


@wp.func
def replaces_corner(corners: Corners, corner: int, landing: wp.vec2d, query: wp.vec2d, epsilon: wp.float64) -> bool:
    """Whether an example that lands near a corner may take its place ([B] Algorithm 1, line 7)."""
    trial = corners
    trial[corner] = landing
    return wp.length(corners[corner] - landing) <= epsilon and is_inside(trial, query, ZERO)


@wp.func
def find_beta(corners: Corners, weights: wp.vec3d, root: wp.vec2d) -> wp.float64:
    """Largest lambda4 that still lands on the footstep whose barycentric coordinates are `weights` ([B] 5)."""
    areas = areas_at(corners, root)
    total = areas[0] + areas[1] + areas[2]
    if wp.abs(total) < SMALLEST_AREA:
        return ZERO
    beta = ONE
    for corner in range(3):
        share = areas[corner] / total
        if share > ZERO:
            beta = wp.min(beta, weights[corner] / share)
    return beta


@wp.func
def find_given_up(root_weight: wp.float64, beta: wp.float64) -> wp.float64:
    """Share of the way from the footstep to the root's landing that [B]'s q' goes, 0 up to beta."""
    if root_weight <= beta:
        return ZERO
    return wp.min((root_weight - beta) / (ONE - beta), ONE)


@wp.func
def mix_root(corners: Corners, weights: wp.vec3d, root: wp.vec2d, root_weight: wp.float64, closest: bool) -> RootMix:
    """Weights of the corners when the root's examples, which land on `root`, weigh lambda4 ([B] Eq. 4 and 5).

    Up to beta lambda_i = b_i(q) - lambda4 b_i(r), which lands on the footstep q. Above, on the segment to the root's
    landing r, lambda_i = (1 - lambda4) / (1 - beta) (b_i(q) - beta b_i(r)), which misses q by
    (lambda4 - beta) / (1 - beta) |r - q|. A degenerate triangle has beta 0.

    `weights` are the footstep's barycentric coordinates b(q); `closest` says where to land beyond beta.
    """
    mix = RootMix()
    mix.beta = find_beta(corners, weights, root)
    mix.given_up = find_given_up(root_weight, mix.beta)
    areas = areas_at(corners, root)
    total = areas[0] + areas[1] + areas[2]
    coordinates = wp.vec3d()
    if wp.abs(total) >= SMALLEST_AREA:
        coordinates = areas / total
    footstep = mean_corner(corners, weights)
    if closest and mix.given_up > ZERO:
        # What the root's examples leave of the footstep is brought into the triangle.
        rest = ONE - root_weight
        left = footstep - root_weight * root
        if rest > ZERO:
            left = left / rest
        inner = weigh_corners(corners, left)
        mix.weights = rest * inner
        mix.shift = rest * mean_corner(corners, inner) + root_weight * root - footstep
    else:
        used = wp.min(root_weight, mix.beta)
        mix.weights = (ONE - mix.given_up) * wp.max(weights - used * coordinates, wp.vec3d())
        mix.shift = mix.given_up * (root - footstep)
    return mix


@wp.func
def misses(mix: RootMix, offset: wp.vec2d) -> wp.float64:
    """How far from the wanted footstep the foot is planted, `offset` from that to the one the weights give [m]."""
    return wp.length(mix.shift + mix.given_up * offset)


@wp.func
def find_largest(
    corners: Corners, weights: wp.vec3d, root: wp.vec2d, tolerance: wp.float64, offset: wp.vec2d, closest: bool
) -> wp.float64:
    """Largest lambda4 at which the foot is planted within a tolerance [m] of the footstep.

    The closest point gets no nearer again, its distance is convex in lambda4, so it is found by bisection.
    """
    beta = mix_root(corners, weights, root, ZERO, closest).beta
    if not closest:
        way = wp.length(root - mean_corner(corners, weights) + offset)
        if way <= tolerance:
            return ONE
        return beta + (ONE - beta) * tolerance / way
    if misses(mix_root(corners, weights, root, ONE, closest), offset) <= tolerance:
        return ONE
    low = beta
    high = ONE
    for _ in range(HALVINGS):
        middle = wp.float64(0.5) * (low + high)
        if misses(mix_root(corners, weights, root, middle, closest), offset) <= tolerance:
            low = middle
        else:
            high = middle
    return low
