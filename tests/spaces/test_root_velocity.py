"""Rules of the gradient bands over root velocities, against a naive reference."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tests.strategies import seeds
from usdfoot.spaces.root_velocity import build_root_velocity_space, solve_root_velocities

FAN = np.array([[0.0, 0.0], [0.0, 0.7], [0.0, 1.4], [0.0, 2.1], [0.5, 0.5], [-0.5, 0.5], [0.4, 1.2], [0.0, -0.8]])
"""Idle, walks of three speeds, diagonal ones and one backward [m/s]."""
OPPOSITE = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0]])
kinds = pytest.mark.parametrize("polar", [True, False])


def scattered(seed: int, count: int = 12) -> np.ndarray:
    """Velocities of which no two are near each other; sometimes one stands."""
    generator = np.random.default_rng(seed)
    points = [np.zeros(2)] if seed % 2 else []
    while len(points) < count:
        point = generator.uniform(-2.0, 2.0, 2)
        if np.linalg.norm(point) > 0.1 and all(np.linalg.norm(point - other) > 0.1 for other in points):
            points.append(point)
    return np.array(points)


def naive_polar(velocities: np.ndarray, query: np.ndarray) -> np.ndarray:
    """Johansen's formula as written, for queries that move and lie in front of every pair; alpha = 2."""

    def turn(first: np.ndarray, second: np.ndarray) -> float:
        return float(np.arctan2(first[1] * second[0] - first[0] * second[1], first @ second))

    influences = []
    for i, own in enumerate(velocities):
        best = np.inf
        for j, other in enumerate(velocities):
            if i == j:
                continue
            speeds = np.linalg.norm(own), np.linalg.norm(other), np.linalg.norm(query)
            mean = 0.5 * (speeds[0] + speeds[1])
            still = min(speeds[0], speeds[1]) == 0.0
            between = np.array([0.0 if still else 2.0 * turn(own, other), (speeds[1] - speeds[0]) / mean])
            away = np.array([0.0 if still else 2.0 * turn(own, query), (speeds[2] - speeds[0]) / mean])
            best = min(best, 1.0 - away @ between / (between @ between))
        influences.append(max(best, 0.0))
    return np.array(influences) / sum(influences)


@kinds
@given(seed=seeds)
def test_weights_are_convex_and_their_velocity_error_is_told(polar: bool, seed: int) -> None:
    velocities = scattered(seed)
    queries = np.random.default_rng(seed).uniform(-2.5, 2.5, (50, 2))
    solved = solve_root_velocities(build_root_velocity_space(velocities, polar=polar), queries)
    assert solved.weights.shape == (50, 12) and solved.weights.min() >= 0.0
    assert_allclose(solved.weights.sum(axis=1), 1.0, atol=1e-12)
    assert_allclose(solved.velocities, solved.weights @ velocities, atol=1e-12)
    assert_allclose(solved.errors, np.linalg.norm(solved.weights @ velocities - queries, axis=1), atol=1e-12)


@kinds
@given(seed=seeds)
def test_every_example_is_met_exactly(polar: bool, seed: int) -> None:
    velocities = scattered(seed)
    solved = solve_root_velocities(build_root_velocity_space(velocities, polar=polar), velocities)
    assert_allclose(solved.weights, np.eye(12), atol=1e-9)
    assert solved.errors.max() < 1e-9


def test_in_front_of_all_pairs_the_weights_are_johansens(generator: np.random.Generator) -> None:
    velocities = FAN[:7]  # within 45 degrees of straight ahead
    space = build_root_velocity_space(velocities)
    angles, speeds = generator.uniform(-0.7, 0.7, 100), generator.uniform(0.4, 2.5, 100)
    queries = np.stack([speeds * np.sin(angles), speeds * np.cos(angles)], axis=1)
    expected = [naive_polar(velocities, query) for query in queries]
    assert_allclose(solve_root_velocities(space, queries).weights, expected, atol=1e-9)


@kinds
@pytest.mark.parametrize("velocities", [FAN, FAN[1:], OPPOSITE, OPPOSITE[:2]], ids=["fan", "no idle", "three", "two"])
def test_nothing_jumps_on_circles_and_rays_through_the_examples(polar: bool, velocities: np.ndarray) -> None:
    space = build_root_velocity_space(velocities, polar=polar)
    around = np.linspace(-np.pi, np.pi, 20001)
    for speed in np.unique(np.linalg.norm(velocities, axis=1)):
        circle = speed * np.stack([np.sin(around), np.cos(around)], axis=1)
        weights = solve_root_velocities(space, circle).weights
        assert np.abs(np.diff(weights, axis=0)).max() < 0.005
        assert_allclose(weights[0], weights[-1], atol=1e-9)
    for velocity in velocities[np.linalg.norm(velocities, axis=1) > 0.0]:
        ray = np.linspace(-2.0, 2.0, 20001)[:, None] * velocity  # through the origin and out on the other side
        assert np.abs(np.diff(solve_root_velocities(space, ray).weights, axis=0)).max() < 0.005


@kinds
@given(seed=seeds)
def test_the_mirrored_velocity_has_the_mirrored_examples_weights(polar: bool, seed: int) -> None:
    velocities, mirror = scattered(seed), np.array([-1.0, 1.0])
    queries = np.random.default_rng(seed).uniform(-2.5, 2.5, (30, 2))
    weights = solve_root_velocities(build_root_velocity_space(velocities, polar=polar), queries).weights
    image = solve_root_velocities(build_root_velocity_space(velocities * mirror, polar=polar), queries * mirror)
    assert_allclose(image.weights, weights, atol=1e-9)


@given(angle=st.floats(-np.pi, np.pi))
def test_between_opposite_examples_both_ways_round_are_the_same(angle: float) -> None:
    space = build_root_velocity_space(OPPOSITE[:2])
    queries = np.array([[np.sin(angle), np.cos(angle)], [-np.sin(angle), np.cos(angle)]])
    first, second = solve_root_velocities(space, queries).weights
    assert_allclose(first, second, atol=1e-9)
    assert_allclose(first[0], 1.0 - abs(angle) / np.pi, atol=1e-9)


def test_standing_competes_in_speed_only() -> None:
    space = build_root_velocity_space(np.array([[0.0, 0.0], [0.0, 1.0]]))
    queries = 0.3 * np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-0.6, 0.8]])
    assert_allclose(solve_root_velocities(space, queries).weights, [[0.7, 0.3]] * 4, atol=1e-12)
    assert_allclose(solve_root_velocities(space, np.zeros((1, 2))).weights, [[1.0, 0.0]], atol=1e-12)


def test_one_example_has_all_the_weight() -> None:
    solved = solve_root_velocities(
        build_root_velocity_space(np.array([[0.0, 1.0]])), np.array([[0.0, 0.0], [3.0, 1.0]])
    )
    assert_allclose(solved.weights, 1.0)
    assert_allclose(solved.errors, [1.0, 3.0])


def test_near_duplicates_share_one_example_so_that_nothing_jumps() -> None:
    velocities = np.array([[0.0, 1.0], [0.001, 1.0], [0.0, 1.0], [0.0, 2.0], [0.005, 0.003], [-0.004, 0.0]])
    line = np.linspace([-0.01, 0.9], [0.01, 1.1], 2001)
    space = build_root_velocity_space(velocities)
    weights = solve_root_velocities(space, line).weights
    assert len(space.vertices) == 3
    assert np.abs(np.diff(weights, axis=0)).max() < 0.001
    apart = solve_root_velocities(build_root_velocity_space(velocities, merge_distance=0.0), line).weights
    assert np.abs(np.diff(apart, axis=0)).max() > 0.005


def test_the_cartesian_bands_are_their_formula(generator: np.random.Generator) -> None:
    queries = generator.uniform(-2.0, 2.0, (40, 2))
    weights = solve_root_velocities(build_root_velocity_space(FAN, polar=False), queries).weights
    for query, found in zip(queries, weights, strict=True):
        influences = []
        for i, own in enumerate(FAN):
            others = np.delete(FAN, i, axis=0) - own
            influences.append(max(0.0, min(1.0 - (query - own) @ other / (other @ other) for other in others)))
        assert_allclose(found, np.array(influences) / sum(influences), atol=1e-12)
