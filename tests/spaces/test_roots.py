"""Root examples of steps: their velocity is met inside the examples, without jumps, and examples keep to themselves."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose

from tests.spaces.test_library import mirror_image, random_examples
from tests.strategies import seeds
from usdfoot.model.examples import Examples
from usdfoot.spaces.features import example_features
from usdfoot.spaces.landings import end_landings, left_landings
from usdfoot.spaces.library import FootstepSpaces, build_spaces
from usdfoot.spaces.root_velocity import solve_root_velocities
from usdfoot.spaces.roots import find_roots


def left_examples(generator: np.random.Generator, count: int = 40) -> Examples:
    return replace(random_examples(generator, count), swing_sides=np.zeros(count, dtype=int))


def weigh(
    spaces: FootstepSpaces, examples: Examples, rows: np.ndarray, velocities: np.ndarray, *, meet: bool = True
) -> np.ndarray:
    """Weights of all examples (N, E) for velocities wanted in left-swing coordinates of steps else like `rows`."""
    sides = examples.swing_sides[rows]
    found = find_roots(
        spaces,
        left_landings(velocities, sides),
        end_landings(examples)[rows],
        features=example_features(examples)[rows],
        swing_sides=sides,
        flights=np.zeros(len(rows), dtype=bool),
        styles=["default"] * len(rows),
        meet=meet,
    )
    weights = np.zeros((len(rows), len(examples)))
    np.add.at(weights, (np.arange(len(rows))[:, None], found.examples), found.weights)
    return weights


@given(seed=seeds)
def test_inside_the_examples_the_wanted_velocity_is_met(seed: int) -> None:
    """To 0.1 m/s (design.md section 10), wherever it lies between them and whatever the step is like otherwise."""
    generator = np.random.default_rng(seed)
    examples = left_examples(generator)
    spaces = build_spaces(examples)
    wanted = generator.dirichlet(np.full(40, 0.1), 300) @ spaces.velocities
    weights = weigh(spaces, examples, generator.integers(0, 40, 300), wanted)
    assert weights.min() >= 0.0
    assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    assert np.linalg.norm(weights @ spaces.velocities - wanted, axis=1).max() <= 0.1


@given(seed=seeds)
def test_every_example_keeps_to_itself(seed: int) -> None:
    examples = left_examples(np.random.default_rng(seed), 15)
    spaces = build_spaces(examples, root_merge_distance=0.0)
    moving = np.flatnonzero(np.linalg.norm(spaces.velocities, axis=1) > 0.05)  # who stands has no bearing
    assert_allclose(weigh(spaces, examples, moving, spaces.velocities[moving]), np.eye(15)[moving], atol=1e-6)


def test_no_weight_jumps_on_the_way_from_one_example_to_another(generator: np.random.Generator) -> None:
    examples = left_examples(generator)
    spaces = build_spaces(examples)
    ways = np.linspace(0.0, 1.0, 20001)[:, None]
    for start, end in generator.integers(0, 40, (5, 2)):
        wanted = (1.0 - ways) * spaces.velocities[start] + ways * 1.3 * spaces.velocities[end]  # and out of the hull
        weights = weigh(spaces, examples, np.full(20001, start), wanted)
        assert np.abs(np.diff(weights, axis=0)).max() < 0.03


def test_the_mirrored_velocity_has_the_mirrored_examples(generator: np.random.Generator) -> None:
    examples = left_examples(generator)
    both = _joined(examples, mirror_image(examples))
    spaces = build_spaces(both)
    wanted = generator.uniform(-0.5, 1.5, (60, 2))
    rows = generator.integers(0, 40, 60)
    left, right = weigh(spaces, both, rows, wanted), weigh(spaces, both, rows + 40, wanted)
    assert not left[:, 40:].any() and not right[:, :40].any()
    assert_allclose(right[:, 40:], left[:, :40], atol=1e-9)


def test_without_meeting_it_they_are_the_heaviest_of_the_bands(generator: np.random.Generator) -> None:
    examples = left_examples(generator, 5)
    spaces = build_spaces(examples, root_merge_distance=0.0)
    wanted = generator.dirichlet(np.ones(5), 50) @ spaces.velocities
    bands = solve_root_velocities(next(iter(spaces.spaces.values())).roots, wanted).weights
    assert_allclose(weigh(spaces, examples, np.zeros(50, dtype=int), wanted, meet=False), bands, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_examples_are_enough(count: int, generator: np.random.Generator) -> None:
    examples = left_examples(generator, count)
    spaces = build_spaces(examples)
    weights = weigh(spaces, examples, np.zeros(20, dtype=int), generator.uniform(-1.0, 2.0, (20, 2)))
    assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)


def _joined(first: Examples, second: Examples) -> Examples:
    values = {}
    for field in fields(Examples):
        own, other = getattr(first, field.name), getattr(second, field.name)
        values[field.name] = np.concatenate([own, other]) if isinstance(own, np.ndarray) else own
    return Examples(**{**values, "styles": first.styles + second.styles, "clip_names": first.clip_names})
