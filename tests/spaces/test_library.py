"""Spaces of a library: styles, gaits, sides, mirror images, neighbours."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import warp as wp
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

from tests.spaces.corners import weigh_triples
from tests.strategies import seeds
from usdfoot.analysis.gaits import has_flight
from usdfoot.errors import ClipError
from usdfoot.model.examples import Examples
from usdfoot.spaces.corner_kernel import SpaceArrays, adjoin_corners
from usdfoot.spaces.features import DOUBT, FeatureScales, StepFeatures, example_features
from usdfoot.spaces.landings import end_landings
from usdfoot.spaces.library import StepWeights, build_spaces, solve_steps
from usdfoot.spaces.mirror_partners import mirror_partners

FLIPPED = ("landings", "departures")
NEGATED = ("landing_yaws", "support_yaws", "departure_yaws", "turns")


def random_examples(
    generator: np.random.Generator, count: int, *, style: str = "default", flight: bool = False
) -> Examples:
    """Examples of one clip with landings of a walk or a run; joints are left out."""
    sides = generator.integers(0, 2, count)
    across = np.where(sides == 0, 1.0, -1.0) * generator.uniform(0.05, 0.3, count)
    durations = generator.uniform(0.4, 0.7, count)
    none = np.zeros((count, 4, 3), dtype=np.float32)
    return Examples(
        clip_names=("/Clip",),
        clip_indices=np.zeros(count, dtype=int),
        mirrored=np.zeros(count, dtype=bool),
        styles=(style,) * count,
        swing_sides=sides,
        start_times=np.cumsum(durations),
        durations=durations,
        flat_times=0.05 * np.ones(count),
        swing_liftoffs=generator.uniform(-0.1, -0.05, count) if flight else generator.uniform(0.05, 0.2, count),
        support_liftoffs=durations * (0.7 if flight else 1.2),
        landings=np.stack([across, generator.uniform(-0.3, 0.9, count)], axis=1),
        landing_heights=generator.uniform(-0.1, 0.1, count),
        landing_yaws=generator.uniform(-0.3, 0.3, count),
        departures=np.stack([across, generator.uniform(-0.9, 0.3, count)], axis=1),
        support_yaws=generator.uniform(-0.3, 0.3, count),
        departure_yaws=generator.uniform(-0.3, 0.3, count),
        turns=generator.uniform(-0.3, 0.3, count),
        rotations=np.zeros((count, 4, 1, 4), dtype=np.float32),
        pelvis_positions=none,
        support_balls=none,
        swing_balls=none,
    )


def mirror_image(examples: Examples) -> Examples:
    changed = {name: getattr(examples, name) * np.array([-1.0, 1.0]) for name in FLIPPED}
    changed |= {name: -getattr(examples, name) for name in NEGATED}
    return replace(examples, mirrored=~examples.mirrored, swing_sides=1 - examples.swing_sides, **changed)


def joined(*parts: Examples) -> Examples:
    """Libraries one after the other, clips renumbered unless they are mirror images of the first."""
    names = [field.name for field in fields(Examples) if field.name != "clip_names"]
    values = {name: [getattr(part, name) for part in parts] for name in names}
    joint = {name: sum(value, ()) if name == "styles" else np.concatenate(value) for name, value in values.items()}
    return Examples(clip_names=parts[0].clip_names, **joint)


def shuffled(examples: Examples, generator: np.random.Generator) -> Examples:
    order = generator.permutation(len(examples))
    names = [field.name for field in fields(Examples) if field.name not in ("clip_names", "styles")]
    changed = {name: getattr(examples, name)[order] for name in names}
    return replace(examples, styles=tuple(examples.styles[i] for i in order), **changed)


def random_steps(generator: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, StepFeatures]:
    sides = generator.integers(0, 2, count)
    across = np.where(sides == 0, 1.0, -1.0) * generator.uniform(0.0, 0.35, count)
    features = StepFeatures(
        durations=generator.uniform(0.4, 0.7, count),
        swing_liftoffs=generator.uniform(0.05, 0.2, count),
        turns=generator.uniform(-0.3, 0.3, count),
        landing_heights=generator.uniform(-0.1, 0.1, count),
        departures=np.stack([across, generator.uniform(-0.9, 0.3, count)], axis=1),
    )
    return np.stack([across, generator.uniform(-0.4, 1.0, count)], axis=1), sides, features


def solve(examples: Examples, landings, sides, *, features=None, flight=False, style="default") -> StepWeights:
    count = len(landings)
    return solve_steps(
        build_spaces(examples),
        landings,
        swing_sides=sides,
        flights=np.full(count, flight),
        styles=[style] * count,
        features=features,
    )


@pytest.mark.parametrize("with_features", [False, True])
def test_mirrored_steps_get_mirrored_examples_with_the_same_weights(
    with_features: bool, generator: np.random.Generator
) -> None:
    originals = random_examples(generator, 40)
    library = shuffled(joined(originals, mirror_image(originals)), generator)
    partners = mirror_partners(library)
    landings, sides, features = random_steps(generator, 300)
    mirrored_features = replace(features, turns=-features.turns, departures=features.departures * [-1.0, 1.0])
    given_features = (features, mirrored_features) if with_features else (None, None)
    straight = solve(library, landings, sides, features=given_features[0])
    mirrored = solve(library, landings * [-1.0, 1.0], 1 - sides, features=given_features[1])
    assert_array_equal(mirrored.examples, partners[straight.examples])
    assert_array_equal(mirrored.weights, straight.weights)
    assert_array_equal(mirrored.hull_distances, straight.hull_distances)
    assert_array_equal(mirrored.projections, straight.projections * [-1.0, 1.0])


@pytest.mark.parametrize("with_features", [False, True])
@pytest.mark.parametrize("mirror", [False, True])
def test_weights_reproduce_landings_with_examples_of_the_side(
    with_features: bool, mirror: bool, generator: np.random.Generator
) -> None:
    library = random_examples(generator, 60)
    library = joined(library, mirror_image(library)) if mirror else library
    landings, sides, features = random_steps(generator, 300)
    solved = solve(library, landings, sides, features=features if with_features else None)
    assert_array_equal(library.swing_sides[solved.examples], np.repeat(sides[:, None], 3, axis=1))
    assert_allclose(solved.weights.sum(axis=1), 1.0, rtol=0, atol=1e-12)
    assert np.all(np.diff(solved.weights, axis=1) <= 0.0) and solved.weights.min() >= 0.0
    blended = np.einsum("nk,nkd->nd", solved.weights, end_landings(library)[solved.examples])
    assert_allclose(blended, solved.projections, rtol=0, atol=1e-9)
    inside = solved.hull_distances == 0.0
    assert 100 < inside.sum() < 300
    assert_array_equal(solved.projections[inside], landings[inside])


def test_synthetic_examples_count_as_far_off_as_those_they_are_blended_from(generator: np.random.Generator) -> None:
    recorded, made = random_examples(generator, 60), random_examples(generator, 25)
    library, synthetic = joined(recorded, made), np.arange(85) >= 60
    spaces = build_spaces(library, synthetic=synthetic)
    solved = solve(recorded, end_landings(made), made.swing_sides, features=example_features(made))
    plain = np.delete(spaces.coordinates, DOUBT, axis=1)
    apart = plain[solved.examples] - plain[60:, None]
    expected = np.sum(solved.weights * np.sum(apart**2, axis=2), axis=1)
    assert_allclose(spaces.coordinates[60:, DOUBT] ** 2, expected, rtol=1e-9)
    assert_array_equal(spaces.coordinates[:60, DOUBT], 0.0)

    landings, sides, features = random_steps(generator, 300)
    inside = solve(recorded, landings, sides, features=features).hull_distances == 0.0
    steps = {"swing_sides": sides, "flights": np.zeros(300, dtype=bool), "styles": ["default"] * 300}
    doubted, trusted = (
        solve_steps(each, landings, features=features, **steps) for each in (spaces, build_spaces(library))
    )
    share, before = (np.mean(synthetic[each.examples[inside]] * each.weights[inside]) for each in (doubted, trusted))
    assert share < 0.5 * before


@given(seeds)
def test_neighbours_are_the_best_triple_of_the_candidates(seed: int) -> None:
    generator = np.random.default_rng(seed)
    library = replace(random_examples(generator, 16), swing_sides=np.zeros(16, dtype=int))
    landings, _, features = random_steps(generator, 10)
    solved = solve(library, landings, np.zeros(10, dtype=int), features=features)
    plain = solve(library, landings, np.zeros(10, dtype=int))
    scales = FeatureScales()
    ends = end_landings(library)
    known, wanted = naive_coordinates(library, ends, scales), naive_coordinates(features, landings, scales)
    for i in range(10):
        rivals = naive_candidates(ends - landings[i], np.sum((known - wanted[i]) ** 2, axis=1))
        best = min(naive_costs(ends[rivals], known[rivals], landings[i], wanted[i]), default=None)
        if best is None:
            assert_array_equal(solved.examples[i], plain.examples[i])
        else:
            squares = np.sum((known[solved.examples[i]] - wanted[i]) ** 2, axis=1)
            assert solved.weights[i] @ squares == pytest.approx(best, rel=1e-9)


def naive_candidates(offsets: np.ndarray, squares: np.ndarray) -> list[int]:
    """The nearest in each octant, named by the signs of x and z and which is larger, and the three nearest of all."""
    best: dict[tuple[bool, bool, bool], int] = {}
    for i in np.argsort(squares):
        x, z = offsets[i]
        best.setdefault((x < 0.0, z < 0.0, abs(x) < abs(z)), int(i))
    return sorted({*best.values(), *(int(i) for i in np.argsort(squares)[:3])})


def naive_coordinates(source: Examples | StepFeatures, landings: np.ndarray, scales: FeatureScales) -> np.ndarray:
    rows = []
    for i, (x, z) in enumerate(landings):
        timing = [source.durations[i] / scales.duration, source.swing_liftoffs[i] / scales.swing_liftoff]
        shape = [source.turns[i] / scales.turn, source.landing_heights[i] / scales.landing_height]
        before = source.departures[i] / scales.departure
        rows.append([x / scales.landing, z / scales.landing, *timing, *shape, *before])
    return np.array(rows)


def naive_costs(points: np.ndarray, known: np.ndarray, query: np.ndarray, wanted: np.ndarray) -> list[float]:
    """Cost of every triple of all examples that contains the query."""
    costs = []
    for a in range(len(points)):
        for b in range(a):
            for c in range(b):
                matrix = np.vstack([points[[a, b, c]].T, np.ones(3)])
                if abs(np.linalg.det(matrix)) > 1e-5:
                    weights = np.linalg.solve(matrix, [*query, 1.0])
                    if weights.min() >= 0.0:
                        costs.append(float(weights @ np.sum((known[[a, b, c]] - wanted) ** 2, axis=1)))
    return costs


@wp.kernel(enable_backward=False)
def adjoin(
    spaces: SpaceArrays,
    given: wp.array(dtype=wp.vec3i),
    landings: wp.array(dtype=wp.vec2d),
    wanted: wp.array2d(dtype=wp.float64),
    found: wp.array(dtype=wp.vec3i),
) -> None:
    """`adjoin_corners` of each query in the first space."""
    query = wp.tid()
    found[query] = adjoin_corners(spaces, 0, given[query], landings[query], wanted, query)


@given(seeds)
def test_beyond_an_edge_the_best_triple_on_its_other_side_follows(seed: int) -> None:
    generator = np.random.default_rng(seed)
    library = replace(random_examples(generator, 16), swing_sides=np.zeros(16, dtype=int))
    landings, _, features = random_steps(generator, 10)
    spaces, scales, ends = build_spaces(library), FeatureScales(), end_landings(library)
    given_triples = np.stack([generator.permutation(16)[:3] for _ in landings])
    known, wanted = naive_coordinates(library, ends, scales), naive_coordinates(features, landings, scales)
    found = wp.empty(len(landings), dtype=wp.vec3i)
    inputs = [
        spaces.device,
        wp.array(given_triples, dtype=wp.vec3i),
        wp.array(landings, dtype=wp.vec2d),
        wp.array(np.insert(wanted, DOUBT, 0.0, axis=1), dtype=wp.float64),
    ]
    wp.launch(adjoin, dim=len(landings), inputs=inputs, outputs=[found])
    triples = found.numpy()
    weights, _ = weigh_triples(ends[triples], landings)
    shares, projections = weigh_triples(ends[given_triples], landings)
    for i in range(10):
        edge = list(given_triples[i, np.argsort(-shares[i], kind="stable")[:2]])
        trials = [naive_costs(ends[[*edge, m]], known[[*edge, m]], landings[i], wanted[i]) for m in range(16)]
        best = min((cost for costs in trials for cost in costs), default=None)
        if np.allclose(projections[i], landings[i], rtol=0.0, atol=1e-12) or best is None:
            assert_array_equal(triples[i], given_triples[i])
        else:
            assert set(edge) <= set(triples[i])
            assert_allclose(weights[i] @ ends[triples[i]], landings[i], atol=1e-9)
            squares = np.sum((known[triples[i]] - wanted[i]) ** 2, axis=1)
            assert weights[i] @ squares == pytest.approx(best, rel=1e-9)


def test_legs_of_unequal_length_have_a_space_each(generator: np.random.Generator) -> None:
    originals = random_examples(generator, 40)
    images = mirror_image(originals)
    library = joined(originals, replace(images, landings=images.landings * [1.0, 0.97]))
    landings, sides, features = random_steps(generator, 200)
    solved = solve(library, landings, sides, features=features)
    inside = solved.hull_distances < 1e-12
    assert inside.mean() > 0.4
    blended = np.einsum("nk,nkd->nd", solved.weights, end_landings(library)[solved.examples])
    assert_allclose(blended[inside], landings[inside], atol=1e-9)


@pytest.mark.parametrize("with_features", [False, True])
def test_order_of_examples_does_not_matter(with_features: bool, generator: np.random.Generator) -> None:
    library = random_examples(generator, 60)
    mixed = shuffled(library, generator)
    landings, sides, features = random_steps(generator, 200)
    straight = solve(library, landings, sides, features=features if with_features else None)
    other = solve(mixed, landings, sides, features=features if with_features else None)
    assert_array_equal(straight.weights, other.weights)
    assert_array_equal(library.start_times[straight.examples], mixed.start_times[other.examples])


def test_neighbours_tell_a_quick_step_from_a_slow_one_to_the_same_spot(generator: np.random.Generator) -> None:
    slow = replace(random_examples(generator, 12), swing_sides=np.zeros(12, dtype=int), durations=np.full(12, 0.9))
    slow = replace(slow, support_liftoffs=np.full(12, 1.1), swing_liftoffs=np.full(12, 0.2))
    quick = replace(slow, durations=np.full(12, 0.4), landings=slow.landings + 0.001)
    library = joined(slow, quick)
    _, _, features = random_steps(generator, 50)
    wanted = replace(features, durations=np.full(50, 0.4), swing_liftoffs=np.full(50, 0.2))
    landings = generator.normal(slow.landings.mean(axis=0), 0.02, (50, 2))
    solved = solve(library, landings, np.zeros(50, dtype=int), features=wanted)
    durations = np.sum(solved.weights * library.durations[solved.examples], axis=1)
    assert_allclose(durations, 0.4, atol=0.05)


def forward(landings: np.ndarray) -> np.ndarray:
    return np.stack([landings[:, 0], np.abs(landings[:, 1])], axis=1)


def test_gaits_do_not_mix_and_a_missing_one_falls_back(generator: np.random.Generator) -> None:
    walk, run = random_examples(generator, 30), random_examples(generator, 30, flight=True)
    run = replace(run, landings=forward(run.landings))
    library = joined(walk, run)
    assert_array_equal(has_flight(library.durations, library.support_liftoffs, library.landings), np.arange(60) >= 30)
    landings, sides, _ = random_steps(generator, 50)
    landings = forward(landings)
    for flight in (False, True):
        solved = solve(library, landings, sides, flight=flight)
        assert np.all((solved.examples >= 30) == flight)
    alone = solve(walk, landings, sides, flight=True)
    assert_array_equal(alone.examples, solve(walk, landings, sides).examples)


def test_slow_jogs_need_a_longer_flight_than_what_is_too_fast_to_walk() -> None:
    """A leg of 0.8 m walks up to sqrt(0.5 g 0.8 m) = 1.98 m/s."""
    durations, contacts = np.full(3, 0.4), 0.4 * np.array([0.99, 0.85, 0.75])
    for speed, flights in ((1.9, [False, False, True]), (2.1, [False, True, True])):
        landings = np.tile([0.0, 0.4 * speed], (3, 1))
        assert_array_equal(has_flight(durations, contacts, landings, leg_length=0.8), flights)


def test_landings_are_seen_in_the_heading_at_the_end(generator: np.random.Generator) -> None:
    library = replace(random_examples(generator, 1), turns=np.array([0.5 * np.pi]), landings=np.array([[0.4, 0.1]]))
    assert_allclose(end_landings(library), [[-0.1, 0.4]], atol=1e-15)


def test_backward_steps_are_walked_even_if_their_balls_show_a_flight(generator: np.random.Generator) -> None:
    run, backward = random_examples(generator, 30, flight=True), random_examples(generator, 8, flight=True)
    library = joined(random_examples(generator, 30), run, replace(backward, landings=backward.landings - [0.0, 1.5]))
    landings, sides, _ = random_steps(generator, 50)
    for flight in (False, True):
        back = solve(library, landings * [1.0, 0.0] - [0.0, 1.2], sides, flight=flight)
        assert np.all((back.examples >= 60) | (back.examples < 30))
        assert np.all((back.examples >= 60).any(axis=1))
    ahead = solve(library, forward(landings), sides, flight=True)
    assert np.all((ahead.examples >= 30) & (ahead.examples < 60))


def test_styles_do_not_mix(generator: np.random.Generator) -> None:
    library = joined(random_examples(generator, 30), random_examples(generator, 30, style="tired"))
    landings, sides, _ = random_steps(generator, 50)
    assert solve(library, landings, sides, style="tired").examples.min() >= 30


def test_unknown_style_is_named_with_those_there_are(generator: np.random.Generator) -> None:
    landings, sides, _ = random_steps(generator, 3)
    with pytest.raises(ClipError, match=r"'angry': no clip shows a step of the (left|right) foot: default"):
        solve(random_examples(generator, 30), landings, sides, style="angry")


def test_no_steps_give_empty_weights(generator: np.random.Generator) -> None:
    solved = solve(random_examples(generator, 5), np.empty((0, 2)), np.empty(0, dtype=int))
    assert solved.examples.shape == (0, 3)


def test_two_examples_are_enough(generator: np.random.Generator) -> None:
    library = replace(random_examples(generator, 2), swing_sides=np.array([0, 1]))
    landings, sides, features = random_steps(generator, 10)
    solved = solve(library, landings, sides, features=features)
    assert_array_equal(solved.examples, np.repeat(sides[:, None], 3, axis=1))
    assert_array_equal(solved.weights[:, 0], 1.0)
