"""Tetrahedra of landing and root speed: exact inside, the landing kept outside, degenerate sets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

from tests.strategies import seeds
from usdfoot.spaces.footsteps import build_footstep_space
from usdfoot.spaces.tetrahedra import TetrahedronSpace, build_tetrahedron_space, solve_tetrahedra


def scattered(seed: int, count: int = 25) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    return generator.uniform(-0.5, 0.5, (count, 2)), generator.uniform(0.3, 2.5, count)


def built(landings: np.ndarray, speeds: np.ndarray) -> TetrahedronSpace:
    return build_tetrahedron_space(build_footstep_space(landings), landings, speeds)


@given(seed=seeds)
def test_inside_landing_and_speed_are_met(seed: int) -> None:
    landings, speeds = scattered(seed)
    shares = np.random.default_rng(seed).dirichlet(np.ones(25), 60)
    solved = solve_tetrahedra(built(landings, speeds), shares @ landings, shares @ speeds)
    assert solved.weights.min() >= 0.0
    assert_allclose(solved.weights.sum(axis=1), 1.0, atol=1e-9)
    assert_allclose(np.einsum("nk,nkd->nd", solved.weights, landings[solved.examples]), shares @ landings, atol=1e-6)
    assert_allclose(np.sum(solved.weights * speeds[solved.examples], axis=1), shares @ speeds, atol=1e-5)


@given(seed=seeds)
def test_too_quick_or_slow_the_landing_is_kept_and_the_speed_nearest(seed: int) -> None:
    landings, speeds = scattered(seed)
    queries = np.random.default_rng(seed).dirichlet(np.full(25, 4.0), 40) @ landings
    space = built(landings, speeds)
    for wanted in (-5.0, 9.0):
        solved = solve_tetrahedra(space, queries, np.full(40, wanted))
        assert_allclose(np.einsum("nk,nkd->nd", solved.weights, landings[solved.examples]), queries, atol=1e-6)
        reached = np.sum(solved.weights * speeds[solved.examples], axis=1)
        nearer = solve_tetrahedra(space, queries, reached + 0.02 * np.sign(wanted))
        again = np.sum(nearer.weights * speeds[nearer.examples], axis=1)
        assert_allclose(again, reached, atol=1e-6)


def test_off_the_ground_hull_the_landing_is_projected() -> None:
    landings, speeds = scattered(1)
    solved = solve_tetrahedra(built(landings, speeds), np.array([[2.0, 0.0]]), np.array([1.0]))
    landed = np.einsum("nk,nkd->nd", solved.weights, landings[solved.examples])
    assert_allclose(landed, solved.projections, atol=1e-6)
    assert_allclose(np.linalg.norm(landed - [[2.0, 0.0]], axis=1), solved.hull_distances, atol=1e-6)


def test_examples_do_not_care_for_their_order() -> None:
    landings, speeds = scattered(2)
    order = np.random.default_rng(3).permutation(25)
    queries, wanted = landings.mean(axis=0) + np.zeros((1, 2)), np.array([1.2])
    first = solve_tetrahedra(built(landings, speeds), queries, wanted)
    second = solve_tetrahedra(built(landings[order], speeds[order]), queries, wanted)
    assert_array_equal(order[second.examples], first.examples)
    assert_allclose(second.weights, first.weights, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3, 8])
@pytest.mark.parametrize("flat", [True, False])
def test_few_examples_or_one_speed_leave_the_triangles(count: int, flat: bool) -> None:
    landings, speeds = scattered(4, count)
    speeds = np.full(count, 1.0) if flat else 2.0 * landings[:, 0]  # in a plane either way
    solved = solve_tetrahedra(built(landings, speeds), landings, speeds)
    assert_allclose(np.einsum("nk,nkd->nd", solved.weights, landings[solved.examples]), landings, atol=1e-9)
    assert solved.examples.shape == (count, 4)
