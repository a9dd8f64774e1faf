"""The search for the best triple of neighbours as a Warp kernel."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = [
    "CLOSEST",
    "NONE",
    "OCTANTS",
    "SMALLEST_AREA",
    "best_triple",
    "find_triples",
    "nearest_examples",
    "square_distance",
]

OCTANTS = 8
CLOSEST = 3
CANDIDATES = OCTANTS + CLOSEST
INSIDE_TOLERANCE = 1e-10
SMALLEST_AREA = 1e-5
"""Twice the area [m^2] below which a triple counts as collinear."""
NONE = wp.constant(wp.float64(1e30))
"""Squared distance of a candidate that there is not."""

_Numbers = wp.types.vector(length=CANDIDATES, dtype=wp.float64)
_Indices = wp.types.vector(length=CANDIDATES, dtype=wp.int32)


@wp.struct
class Candidates:
    """Examples that compete for one query: the nearest in each octant about the landing, and the nearest of all."""

    examples: _Indices
    squares: _Numbers  # distances in coordinates; NONE where there is no example


@wp.struct
class Triple:
    """Three examples around a landing, -1 where there are none, and its barycentric coordinates."""

    examples: wp.vec3i
    weights: wp.vec3d


@wp.func
def nearest_examples(
    landings: wp.array(dtype=wp.vec2d),
    coordinates: wp.array2d(dtype=wp.float64),
    begin: int,
    end: int,
    landing: wp.vec2d,
    wanted: wp.array2d(dtype=wp.float64),
    query: int,
) -> Candidates:
    """Candidates of one query among the examples from `begin` to `end`; of examples equally near the first."""
    found = Candidates()
    for c in range(CANDIDATES):
        found.squares[c] = NONE
        found.examples[c] = begin
    for e in range(begin, end):
        offset = landings[e] - landing
        octant = 4 * int(offset[0] < wp.float64(0.0)) + 2 * int(offset[1] < wp.float64(0.0))
        octant += int(wp.abs(offset[0]) < wp.abs(offset[1]))
        farthest = wp.max(found.squares[octant], found.squares[CANDIDATES - 1])
        square = wp.float64(0.0)
        for d in range(coordinates.shape[1]):
            difference = coordinates[e, d] - wanted[query, d]
            square += difference * difference
            if square >= farthest:
                break
        if square < found.squares[octant]:
            found.squares[octant] = square
            found.examples[octant] = e
        place = CANDIDATES
        while place > OCTANTS and square < found.squares[place - 1]:
            place -= 1
            if place + 1 < CANDIDATES:
                found.squares[place + 1] = found.squares[place]
                found.examples[place + 1] = found.examples[place]
        if place < CANDIDATES:
            found.squares[place] = square
            found.examples[place] = e
    return found


@wp.func
def best_triple(landings: wp.array(dtype=wp.vec2d), near: Candidates, landing: wp.vec2d) -> Triple:
    """The triple of candidates around a landing with the least weighted squared distance."""
    x = _Numbers()
    z = _Numbers()
    for c in range(CANDIDATES):
        offset = landings[near.examples[c]] - landing
        x[c] = offset[0]
        z[c] = offset[1]
    best = NONE
    found = Triple()
    found.examples = wp.vec3i(-1, -1, -1)
    for i in range(CANDIDATES):
        for j in range(i + 1, CANDIDATES):
            pair = x[i] * z[j] - z[i] * x[j]
            least = wp.min(near.squares[i], near.squares[j])
            for k in range(j + 1, CANDIDATES):
                # The cost is a mean of the squares, so it cannot be less than the least of them.
                if wp.min(least, near.squares[k]) < best:
                    areas = wp.vec3d(x[j] * z[k] - z[j] * x[k], z[i] * x[k] - x[i] * z[k], pair)
                    total = areas[0] + areas[1] + areas[2]
                    areas = areas * wp.sign(total)
                    total = wp.abs(total)
                    inside = wp.min(areas) >= -wp.float64(INSIDE_TOLERANCE) * total
                    if inside and total >= wp.float64(SMALLEST_AREA):
                        squares = wp.vec3d(near.squares[i], near.squares[j], near.squares[k])
                        cost = wp.dot(areas, squares) / total
                        if wp.max(squares) < NONE and cost < best:
                            best = cost
                            found.examples = wp.vec3i(near.examples[i], near.examples[j], near.examples[k])
                            found.weights = wp.max(areas, wp.vec3d())
    shares = found.weights
    found.weights = shares / (shares[0] + shares[1] + shares[2] + wp.float64(1e-300))
    return found


@wp.kernel(enable_backward=False)
def find_triples(
    landings: wp.array(dtype=wp.vec2d),  # (E,)
    coordinates: wp.array2d(dtype=wp.float64),  # (E, D)
    queries: wp.array(dtype=wp.vec2d),  # (N,)
    wanted: wp.array2d(dtype=wp.float64),  # (N, D)
    triples: wp.array(dtype=wp.vec3i),  # (N,) examples, -1 where no triple contains the landing
    weights: wp.array(dtype=wp.vec3d),  # (N,) barycentric coordinates
):
    """The triple of candidates around each landing with the least weighted squared distance."""
    query = wp.tid()
    landing = queries[query]
    near = nearest_examples(landings, coordinates, 0, landings.shape[0], landing, wanted, query)
    found = best_triple(landings, near, landing)
    triples[query] = found.examples
    weights[query] = found.weights


@wp.func
def square_distance(
    coordinates: wp.array2d(dtype=wp.float64), example: int, wanted: wp.array2d(dtype=wp.float64), query: int
) -> wp.float64:
    """Squared distance of an example from a query in coordinates."""
    total = wp.float64(0.0)
    for d in range(coordinates.shape[1]):
        difference = coordinates[example, d] - wanted[query, d]
        total += difference * difference
    return total
