"""The closed form of lambda4 against the linear system of [B] Eq. 4 and 5, Algorithm 1 and its degenerate cases."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import minimize

from tests.spaces.root_mixes import (
    RootWeighted,
    find_largest_root_weight,
    replace_corners,
    solve_root_weight,
)

both = pytest.mark.parametrize("beyond", ["segment", "closest"])
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def cases(generator: np.random.Generator, count: int = 400) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Triangles that are not slivers, weights inside them, root landings in and around them, and lambda4."""
    corners = generator.uniform(-0.5, 0.5, (4 * count, 3, 2))
    sides = corners - np.roll(corners, 1, axis=1)
    areas = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    corners = corners[areas > 0.02][:count]
    weights = generator.dirichlet(np.ones(3), count)
    return corners, weights, generator.uniform(-0.7, 0.7, (count, 2)), generator.uniform(0.0, 1.0, count)


def root_landing(landings: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.einsum("nk,nkd->nd", weights, landings)


def find_beta(corners: np.ndarray, weights: np.ndarray, roots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """beta as found, and the naive barycentric coordinates of the roots."""
    systems = np.concatenate([np.swapaxes(corners, 1, 2), np.ones((len(corners), 1, 3))], axis=1)
    coordinates = np.linalg.solve(systems, np.column_stack([roots, np.ones(len(roots))])[..., None])[..., 0]
    return solve_root_weight(corners, weights, roots, np.zeros(len(corners))).betas, coordinates


def landed(corners: np.ndarray, solved: RootWeighted, roots: np.ndarray) -> np.ndarray:
    return root_landing(corners, solved.weights) + solved.root_weights[:, None] * roots


def test_up_to_beta_it_solves_the_linear_system(generator: np.random.Generator) -> None:
    corners, weights, roots, wanted = cases(generator)
    betas, _ = find_beta(corners, weights, roots)
    solved = solve_root_weight(corners, weights, roots, wanted * betas)
    for i in range(len(corners)):
        footstep = weights[i] @ corners[i]
        matrix = np.vstack([corners[i].T, np.ones(3)])
        wishes = np.append(footstep - wanted[i] * betas[i] * roots[i], 1.0 - wanted[i] * betas[i])
        assert_allclose(solved.weights[i], np.linalg.solve(matrix, wishes), atol=1e-9)
    assert_array_equal(solved.given_up, 0.0)


def test_beyond_beta_the_linear_system_has_a_negative_weight(generator: np.random.Generator) -> None:
    corners, weights, roots, _ = cases(generator)
    betas, coordinates = find_beta(corners, weights, roots)
    assert np.all((betas >= 0.0) & (betas <= 1.0))
    more = np.minimum(betas + 1e-3, 1.0)
    assert np.all(np.min(weights - more[:, None] * coordinates, axis=1)[betas < 1.0 - 1e-3] < 0.0)


@both
def test_weights_are_convex_and_land_where_they_say(beyond: str, generator: np.random.Generator) -> None:
    corners, weights, roots, wanted = cases(generator)
    solved = solve_root_weight(corners, weights, roots, wanted, beyond=beyond)
    assert solved.weights.min() >= 0.0
    assert_allclose(solved.weights.sum(axis=1) + wanted, 1.0, atol=1e-12)
    assert_allclose(landed(corners, solved, roots), root_landing(corners, weights) + solved.shifts, atol=1e-9)


def test_on_the_segment_the_error_is_known_beforehand(generator: np.random.Generator) -> None:
    corners, weights, roots, wanted = cases(generator)
    solved = solve_root_weight(corners, weights, roots, wanted)
    footsteps = root_landing(corners, weights)
    share = np.maximum(wanted - solved.betas, 0.0) / (1.0 - solved.betas)
    assert_allclose(landed(corners, solved, roots), footsteps + share[:, None] * (roots - footsteps), atol=1e-9)
    assert_allclose(solved.given_up, share, atol=1e-12)


def test_the_closest_point_is_the_best_that_weights_can_give(generator: np.random.Generator) -> None:
    corners, weights, roots, wanted = cases(generator, 25)
    closest = solve_root_weight(corners, weights, roots, wanted, beyond="closest")
    segment = solve_root_weight(corners, weights, roots, wanted)
    lengths = np.linalg.norm(closest.shifts, axis=1)
    assert np.all(lengths <= np.linalg.norm(segment.shifts, axis=1) + 1e-12)
    for i in range(25):
        rest, footstep = 1.0 - wanted[i], weights[i] @ corners[i]

        def distance(shares: np.ndarray, i: int = i, rest: float = rest, footstep: np.ndarray = footstep) -> float:
            return float(np.sum((rest * shares @ corners[i] + wanted[i] * roots[i] - footstep) ** 2))

        whole = {"type": "eq", "fun": lambda shares: shares.sum() - 1.0}
        best = minimize(distance, weights[i], bounds=[(0.0, 1.0)] * 3, constraints=whole, tol=1e-14)
        assert_allclose(lengths[i] ** 2, best.fun, atol=1e-6)


@both
def test_at_one_it_is_the_root_blend_and_at_zero_the_footsteps(beyond: str, generator: np.random.Generator) -> None:
    corners, weights, roots, _ = cases(generator)
    ones, zeros = np.ones(len(corners)), np.zeros(len(corners))
    solved = solve_root_weight(corners, weights, roots, ones, beyond=beyond)
    assert_array_equal(solved.weights, 0.0)
    assert_allclose(root_landing(corners, weights) + solved.shifts, roots, atol=1e-12)
    assert_array_equal(solve_root_weight(corners, weights, roots, zeros, beyond=beyond).weights, weights)


@both
def test_the_error_grows_with_the_root_weight(beyond: str, generator: np.random.Generator) -> None:
    corners, weights, roots, _ = cases(generator)
    errors = [
        np.linalg.norm(
            solve_root_weight(corners, weights, roots, np.full(len(corners), share), beyond=beyond).shifts, axis=1
        )
        for share in np.linspace(0.0, 1.0, 41)
    ]
    assert np.diff(errors, axis=0).min() >= -1e-9


def test_where_all_root_weights_rise_a_chain_of_steps_may_err_less() -> None:
    """Each step starts where the last one landed, which can be to the side that its root's landing is not."""
    misses = np.array([1.0, -0.1, -0.1])
    ways = misses / 0.9 - np.array([0.0, *misses[:-1]])  # from footsteps to the roots' landings, started as planned

    def mean_miss(root_weight: float) -> float:
        point, missed, total = np.zeros((1, 3, 2)), np.zeros((1, 2)), 0.0
        for way in ways:
            root = missed + [[way, 0.0]]
            missed = solve_root_weight(point, np.array([[1.0, 0.0, 0.0]]), root, np.array([root_weight])).shifts
            total += float(np.abs(missed).sum()) / 3.0
        return total

    assert mean_miss(0.9) == pytest.approx(0.4)
    assert mean_miss(0.92) < mean_miss(0.9)


@both
def test_the_largest_root_weight_meets_the_tolerance_and_no_more(beyond: str, generator: np.random.Generator) -> None:
    corners, weights, roots, _ = cases(generator)
    for offset in (0.0, 0.01):
        offsets = np.full((len(corners), 2), offset)
        tolerances = generator.uniform(0.0, 0.3, len(corners))
        largest = find_largest_root_weight(corners, weights, roots, tolerances, offsets=offsets, beyond=beyond)

        def planted(wanted: np.ndarray, offsets: np.ndarray = offsets) -> np.ndarray:
            solved = solve_root_weight(corners, weights, roots, wanted, beyond=beyond)
            return np.linalg.norm(solved.shifts + solved.given_up[:, None] * offsets, axis=1)

        assert np.all(planted(largest) <= tolerances + 1e-9)
        less = largest < 1.0 - 1e-4
        assert 50 < less.sum() < len(corners)
        assert np.all(planted(largest + 1e-4)[less] > tolerances[less])


def test_a_degenerate_triangle_gives_up_at_once() -> None:
    corners = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]])
    weights, roots = np.array([[0.5, 0.5, 0.0], [0.2, 0.3, 0.5]]), np.array([[0.5, 0.4], [0.0, 0.0]])
    solved = solve_root_weight(corners, weights, roots, np.array([0.25, 0.5]))
    assert_array_equal(solved.betas, 0.0)
    assert_allclose(solved.weights, weights * np.array([[0.75], [0.5]]), atol=1e-15)
    assert_allclose(solved.shifts, [[0.0, 0.1], [-0.65, 0.0]], atol=1e-12)


def test_a_root_that_lands_on_the_footstep_never_gives_it_up() -> None:
    weights = np.array([[0.2, 0.5, 0.3]])
    solved = solve_root_weight(SQUARE[None], weights, weights @ SQUARE, np.array([0.9]))
    assert_allclose(solved.betas, 1.0, atol=1e-12)
    assert_allclose(solved.weights, 0.1 * weights, atol=1e-12)


def test_inside_does_not_depend_on_orientation_and_needs_an_area() -> None:
    points = np.array([[0.2, 0.2], [0.2, 0.2], [0.6, 0.6], [0.5, 0.0]])
    corners = np.stack([SQUARE, SQUARE[::-1], SQUARE, np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]])])
    _, chosen = replace_corners(corners, points, corners[:, :1], np.zeros(4))  # a corner for itself
    assert (chosen[:, 0] == 0).tolist() == [True, True, False, False]


def test_corners_give_way_to_the_first_root_example_that_is_near_and_keeps_the_footstep_inside() -> None:
    footstep, epsilon = np.array([[0.1, 0.1]]), np.array([0.3])
    examples = np.array([[[0.15, 0.15], [-0.1, 0.05], [0.9, 0.0], [0.0, 0.95]]])
    corners, chosen = replace_corners(SQUARE[None], footstep, examples, epsilon)
    assert chosen.tolist() == [[1, 2, -1]]  # 0 would leave the footstep outside; the fourth is not looked at
    assert_array_equal(corners[0], [[-0.1, 0.05], [0.9, 0.0], [0.0, 1.0]])


def test_without_epsilon_or_into_a_degenerate_triangle_nothing_is_replaced() -> None:
    footstep, examples = np.array([[0.5, 0.0]]), np.array([[[0.5, 0.0]]])
    for epsilon in (0.0, 5.0):
        corners, chosen = replace_corners(
            np.array([[[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]]), footstep, examples, np.array([epsilon])
        )
        assert chosen[0, 2] == -1
        assert solve_root_weight(corners, np.array([[0.5, 0.5, 0.0]]), footstep, np.zeros(1)).betas[0] > 0.0
