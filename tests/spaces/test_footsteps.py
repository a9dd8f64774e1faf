"""Rules of footstep spaces, against a naive reference."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial import ConvexHull

from tests.strategies import angles, landings, seeds
from usdfoot.maths import planar
from usdfoot.spaces.footsteps import FootstepWeights, build_footstep_space, solve_footsteps


def blended(points: np.ndarray, solved: FootstepWeights) -> np.ndarray:
    return np.einsum("nk,nkd->nd", solved.weights, points[solved.examples])


def queries_around(points: np.ndarray, seed: int, count: int = 60) -> np.ndarray:
    """Queries in and around the points: anywhere, on a point, on the line between two."""
    generator = np.random.default_rng(seed)
    low, high = points.min(axis=0) - 0.3, points.max(axis=0) + 0.3
    pairs = points[generator.integers(0, len(points), (count, 2))]
    between = pairs[:, 0] + generator.uniform(0, 1, (count, 1)) * (pairs[:, 1] - pairs[:, 0])
    return np.concatenate([generator.uniform(low, high, (count, 2)), points, between])


def naive_distance_from_segments(query: np.ndarray, ends: np.ndarray) -> float:
    distances = []
    for start, end in ends:
        along = end - start
        length = along @ along
        fraction = min(max((query - start) @ along / length, 0.0), 1.0) if length > 0 else 0.0
        distances.append(float(np.linalg.norm(query - start - fraction * along)))
    return min(distances)


@given(landings(), seeds)
def test_weights_are_convex_and_reproduce_the_landing(points: np.ndarray, seed: int) -> None:
    space = build_footstep_space(points)
    queries = queries_around(points, seed)
    solved = solve_footsteps(space, queries)
    assert solved.weights.min() >= 0.0
    assert_allclose(solved.weights.sum(axis=1), 1.0, rtol=0, atol=1e-12)
    assert_allclose(blended(points, solved), solved.projections, rtol=0, atol=1e-9)
    inside = solved.simplices >= 0
    assert_array_equal(solved.projections[inside], queries[inside])
    assert_allclose(solved.hull_distances, np.linalg.norm(queries - solved.projections, axis=1), atol=1e-15)


@given(landings(smallest=3), seeds)
def test_inside_the_convex_hull_every_landing_is_reached(points: np.ndarray, seed: int) -> None:
    space = build_footstep_space(points)
    assume(len(space.triangles) > 0)
    hull = ConvexHull(space.vertices)
    queries = queries_around(points, seed)
    depth = -(queries @ hull.equations[:, :2].T + hull.equations[:, 2]).max(axis=1)
    solved = solve_footsteps(space, queries)
    # Slivers lower than 2 cm are dropped at the hull, so the promise starts where none can reach.
    assert solved.hull_distances[depth > 0.02].max(initial=0.0) == 0.0
    assert solved.hull_distances[depth > 0.0].max(initial=0.0) < 0.02
    assert np.all(solved.hull_distances[depth < -1e-9] > 0.0)


def test_every_landing_inside_is_reached_even_without_dropping_slivers(generator: np.random.Generator) -> None:
    points = generator.uniform(-1, 1, (200, 2))
    space = build_footstep_space(points, merge_distance=0.0, minimal_altitude=0.0)
    hull = ConvexHull(points)
    assert_allclose(area_of(space.vertices[space.triangles]), hull.volume, rtol=1e-9)


def area_of(corners: np.ndarray) -> float:
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return float(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum())


@given(landings(), seeds)
def test_order_of_examples_does_not_matter(points: np.ndarray, seed: int) -> None:
    generator = np.random.default_rng(seed)
    order = generator.permutation(len(points))
    queries = queries_around(points, seed)
    straight = solve_footsteps(build_footstep_space(points), queries)
    shuffled = solve_footsteps(build_footstep_space(points[order]), queries)
    assert_array_equal(straight.weights, shuffled.weights)
    assert_array_equal(points[straight.examples], points[order][shuffled.examples])


@given(seeds, angles)
def test_turning_the_library_turns_the_answer(seed: int, angle: float) -> None:
    generator = np.random.default_rng(seed)
    points, queries = generator.uniform(-1, 1, (30, 2)), generator.uniform(-1.5, 1.5, (50, 2))
    yaw, shift = np.array(angle), np.array([3.0, -2.0])
    straight = solve_footsteps(build_footstep_space(points), queries)
    turned = solve_footsteps(
        build_footstep_space(planar.rotate(yaw, points) + shift), planar.rotate(yaw, queries) + shift
    )
    # Merging prefers low x, so only sets without near-duplicates turn exactly.
    distances = np.linalg.norm(points[:, None] - points, axis=-1)[np.triu_indices(30, 1)]
    assume(distances.min() > 0.006)
    assert_allclose(planar.rotate(yaw, straight.projections) + shift, turned.projections, atol=1e-9)
    by_example = [scatter(solved, 30) for solved in (straight, turned)]
    assert_allclose(by_example[0], by_example[1], atol=1e-7)


def scatter(solved: FootstepWeights, count: int) -> np.ndarray:
    table = np.zeros((len(solved.weights), count))
    np.add.at(table, (np.arange(len(table))[:, None], solved.examples), solved.weights)
    return table


@given(landings(smallest=3), seeds)
def test_outside_is_the_nearest_point_of_the_hull(points: np.ndarray, seed: int) -> None:
    space = build_footstep_space(points)
    queries = queries_around(points, seed, count=20)
    solved = solve_footsteps(space, queries)
    for query, distance in zip(queries[solved.simplices < 0], solved.hull_distances[solved.simplices < 0], strict=True):
        expected = naive_distance_from_segments(query, space.vertices[space.edges])
        assert distance == pytest.approx(expected, abs=1e-12)


def test_triangle_is_delaunays(generator: np.random.Generator) -> None:
    points = generator.uniform(-1, 1, (40, 2))
    space = build_footstep_space(points, merge_distance=0.0)
    for corners in space.vertices[space.triangles]:
        a, b, c = corners
        matrix = 2.0 * np.array([b - a, c - a])
        centre = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
        radius = np.linalg.norm(a - centre)
        assert np.linalg.norm(points - centre, axis=1).min() >= radius - 1e-9


def test_one_example_is_always_used() -> None:
    solved = solve_footsteps(build_footstep_space(np.array([[0.2, 0.5]])), np.array([[0.2, 0.5], [0.5, 0.9]]))
    assert_array_equal(solved.examples, 0)
    assert_allclose(solved.hull_distances, [0.0, 0.5])
    assert_allclose(solved.weights.sum(axis=1), 1.0)


def test_two_examples_make_an_edge() -> None:
    points = np.array([[0.2, 0.4], [0.2, 0.8]])
    solved = solve_footsteps(build_footstep_space(points), np.array([[0.2, 0.5], [0.3, 0.7], [0.2, 1.0]]))
    assert_allclose(blended(points, solved), [[0.2, 0.5], [0.2, 0.7], [0.2, 0.8]])
    assert_allclose(solved.hull_distances, [0.0, 0.1, 0.2], atol=1e-15)


def test_collinear_examples_blend_neighbours_only() -> None:
    points = np.array([[0.0, 0.9], [0.0, 0.3], [0.0, 0.6]])
    solved = solve_footsteps(build_footstep_space(points), np.array([[0.1, 0.5]]))
    assert scatter(solved, 3)[0] == pytest.approx([0.0, 1 / 3, 2 / 3])


def test_cocircular_square_leaves_no_gap() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    diagonal = np.linspace(0, 1, 101)
    queries = np.concatenate([np.stack([diagonal, diagonal], 1), np.stack([diagonal, 1 - diagonal], 1)])
    solved = solve_footsteps(build_footstep_space(points), queries)
    assert_array_equal(solved.hull_distances, 0.0)
    assert_allclose(blended(points, solved), queries, atol=1e-15)


def test_near_duplicates_share_a_vertex_and_stay_members() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.003, 0.0], [1.0, 0.004], [0.0, 0.0]])
    space = build_footstep_space(points)
    members = [set(row[row >= 0].tolist()) for row in space.members]
    assert sorted(map(sorted, members)) == [[0, 3, 5], [1, 4], [2]]
    assert_array_equal(space.vertices, points[space.members[:, 0]])


def test_sliver_at_the_hull_is_dropped() -> None:
    points = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, 0.01], [0.0, 1.0]])  # the third is 1 cm inside the hull's edge
    query = np.array([[0.3, 0.001]])
    kept = solve_footsteps(build_footstep_space(points, minimal_altitude=0.0), query)
    dropped = solve_footsteps(build_footstep_space(points), query)
    assert kept.hull_distances[0] == 0.0
    assert 0.0 < dropped.hull_distances[0] < 0.01
    assert scatter(dropped, 4)[0, 0] == 0.0


def test_dense_landings_are_not_eaten_away(generator: np.random.Generator) -> None:
    points = generator.uniform(0.0, 0.3, (1500, 2))  # about 8 mm apart: every triangle is lower than 2 cm
    solved = solve_footsteps(build_footstep_space(points), generator.uniform(0.025, 0.275, (500, 2)))
    assert_array_equal(solved.hull_distances, 0.0)


def test_needle_triangles_stay_exact() -> None:
    points = np.array([[0.0, 0.0], [0.0, 0.006], [1.0, 0.002], [0.5, 0.5]])
    solved = solve_footsteps(build_footstep_space(points), np.array([[0.9, 0.0021], [0.5, 0.3], [0.01, 0.003]]))
    assert_allclose(blended(points, solved), solved.projections, rtol=0, atol=1e-12)


@given(st.integers(0, 20), seeds)
def test_weights_are_continuous_across_edges(angle: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    points = generator.uniform(-1, 1, (25, 2))
    space = build_footstep_space(points, minimal_altitude=0.0)  # convex, or the projection from outside jumps
    line = np.linspace(-1.2, 1.2, 4001)[:, None] * planar.direction(np.array(0.3 * angle))
    tables = scatter(solve_footsteps(space, line), 25)
    corners = space.vertices[space.triangles]
    heights = [2 * area_of(c[None]) / np.linalg.norm(c - np.roll(c, 1, axis=0), axis=1).max() for c in corners]
    step = 2.4 / 4000
    assert np.abs(np.diff(tables, axis=0)).max() <= 1.01 * step / min(heights) + 1e-9
