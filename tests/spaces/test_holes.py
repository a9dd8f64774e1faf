"""Holes: found where triangles are large and where legs reach and nobody stepped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.spaces.test_library import mirror_image, random_examples
from usdfoot.errors import UsdfootError
from usdfoot.model.examples import Examples
from usdfoot.spaces.footsteps import build_footstep_space, solve_footsteps
from usdfoot.spaces.holes import HoleOptions, find_holes, triangle_gaps
from usdfoot.spaces.library import build_spaces

SQUARE = np.array([[0.0, -0.5], [0.6, -0.5], [0.6, 0.9], [0.0, 0.9]])
NOWHERE = np.zeros((4, 2))


def examples_at(landings, *, mirrored: bool, flight: bool = False) -> Examples:
    """Walking steps of the left foot with these landings, and of the right foot their images or none."""
    count = len(landings)
    left = replace(
        random_examples(np.random.default_rng(3), count, flight=flight),
        swing_sides=np.zeros(count, dtype=int),
        landings=np.array(landings, dtype=float),
        turns=np.zeros(count),
    )
    if not mirrored:
        return left
    image = mirror_image(left)
    joined = {
        name: np.concatenate([getattr(left, name), getattr(image, name)])
        for name, value in vars(left).items()
        if isinstance(value, np.ndarray)
    }
    return replace(left, styles=left.styles * 2, **joined)


def grid(low, high, spacing):
    axes = [np.arange(a, b + 1e-9, spacing) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


def test_a_gap_in_a_dense_space_is_found_and_nothing_else():
    dense = grid([0.0, -0.5], [0.6, 0.9], 0.1)
    hollow = dense[np.linalg.norm(dense - [0.3, 0.2], axis=1) > 0.25]
    assert find_holes(build_spaces(examples_at(dense, mirrored=True)), SQUARE) == []
    holes = find_holes(build_spaces(examples_at(hollow, mirrored=True)), SQUARE)
    assert 0 < len(holes) < 12
    for hole in holes:
        assert np.linalg.norm(hole.landing - [0.3, 0.2]) < 0.25
        assert (hole.style, hole.flight, hole.side, hole.mirrored) == ("default", False, 0, True)


@pytest.mark.parametrize("gap", [0.15, 0.3])
def test_once_filled_no_triangle_is_too_large_and_all_that_is_reached_is_near(gap):
    forward = np.array([[0.1, 0.5], [0.2, 0.5], [0.1, 0.7], [0.2, 0.8]])
    spaces = build_spaces(examples_at(forward, mirrored=True))
    holes = find_holes(spaces, SQUARE, HoleOptions(gap=gap, most=200))
    filled = build_footstep_space(np.vstack([forward, [hole.landing for hole in holes]]))
    assert triangle_gaps(filled.vertices, filled.triangles).max() <= gap
    reached = np.random.default_rng(1).uniform([0.0, -0.5], [0.6, 0.9], (500, 2))
    assert solve_footsteps(filled, reached).hull_distances.max() < gap
    for hole in holes:
        assert np.linalg.norm(forward - hole.landing, axis=1).min() > 0.2 * gap


def test_feet_that_are_no_images_of_each_other_have_holes_of_their_own():
    left = examples_at(grid([0.0, 0.3], [0.4, 0.8], 0.2), mirrored=False)
    image = mirror_image(left)
    right = replace(image, mirrored=left.mirrored, start_times=left.start_times + 9.0, landings=1.3 * image.landings)
    joined = {
        name: np.concatenate([getattr(left, name), getattr(right, name)])
        for name, value in vars(left).items()
        if isinstance(value, np.ndarray)
    }
    holes = find_holes(build_spaces(replace(left, styles=left.styles * 2, **joined)), SQUARE)
    assert {(hole.side, hole.mirrored) for hole in holes} == {(0, False), (1, False)}


def test_runs_are_filled_between_their_steps_only():
    landings = np.array([[0.1, 0.8], [0.3, 0.8], [0.1, 1.6], [0.3, 1.6]])
    holes = find_holes(build_spaces(examples_at(landings, mirrored=True, flight=True)), SQUARE)
    assert holes and all(hole.flight for hole in holes)
    assert all(0.1 <= hole.landing[0] <= 0.3 and 0.8 <= hole.landing[1] <= 1.6 for hole in holes)


def test_gaps_are_longest_altitudes():
    vertices = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0], [10.0, 0.0]])
    assert_allclose(triangle_gaps(vertices, np.array([[0, 1, 2], [1, 3, 2]])), [4.0, 6.0 * 3.0 / 5.0])


@pytest.mark.parametrize(("options", "message"), [({"gap": 0.0}, "gap: is 0 m"), ({"most": 0}, "most: is 0")])
def test_options_that_mean_nothing_are_refused(options, message):
    with pytest.raises(UsdfootError, match=message):
        HoleOptions(**options)
