"""Blends corrected on the device, against the spaces asked on the host."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from numpy.testing import assert_allclose, assert_array_equal

from tests.engine.plans import way
from tests.engine.synthesis import synthesise
from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.landings import blend_landings
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.poses import device_library
from usdfoot.engine.queries import step_queries
from usdfoot.spaces.landings import end_landings, left_landings
from usdfoot.spaces.library import solve_steps


@pytest.fixture(scope="module")
def asked(walker_library):
    """A setup, and queries of its steps for landings in the hulls and off them."""
    steps = synthesise(walker_library, [way(12, length=0.55, turn=0.05), way(12, length=0.9, step_time=0.4, duty=0.4)])
    queries = step_queries(steps.setup, np.flatnonzero(~steps.setup.segments.stands))
    noise = np.random.default_rng(1).uniform(-0.3, 0.3, (40, *queries.landings.shape))
    rows = np.tile(np.arange(len(queries.landings)), 40)
    return steps.setup, replace(queries[rows], landings=queries.landings[rows] + noise.reshape(-1, 2))


@pytest.mark.parametrize("space", ["neighbours", "delaunay"])
def test_uncorrected_they_are_what_the_spaces_answer(walker_library, asked, space):
    setup, queries = asked
    setup = replace(setup, options=EngineOptions(space=space))
    found = correct_steps(setup, walker_library.spaces, queries, corrections=0)
    answer = solve_steps(
        walker_library.spaces,
        queries.landings,
        swing_sides=queries.swing_sides,
        flights=queries.flights,
        styles=queries.styles,
        features=queries.features if space == "neighbours" else None,
    )
    assert (answer.hull_distances > 0.01).any() and (answer.hull_distances == 0.0).any()
    assert_allclose(found.hull_distances, answer.hull_distances, atol=1e-12)
    dense, other = np.zeros((2, len(queries.landings), len(setup.examples)))
    rows = np.arange(len(dense))[:, None]
    np.add.at(dense, (rows, found.examples), found.weights)
    np.add.at(other, (rows, answer.examples), answer.weights)
    assert_allclose(dense, other, atol=1e-9)


def test_slerped_blends_land_near_those_of_sums_and_are_corrected_as_well(walker_library, asked):
    """Design.md section 7: under 2 mm apart."""
    setup, queries = asked
    slerps = device_library(setup.examples, setup.rig, pelvis=setup.pelvis, slerps=True)
    found = correct_steps(setup, walker_library.spaces, queries, corrections=8)
    landed = [
        blend_landings(library, queries.swing_sides, examples=found.examples, weights=found.weights)
        for library in (setup.library, slerps)
    ]
    assert 1e-5 < np.linalg.norm(landed[0] - landed[1], axis=1).max() < 2e-3
    again = correct_steps(replace(setup, library=slerps), walker_library.spaces, queries, corrections=8)
    landed = blend_landings(slerps, queries.swing_sides, examples=again.examples, weights=again.weights)
    assert_allclose(landed + again.missed, queries.landings, atol=1e-6)
    inside = again.hull_distances == 0.0
    assert np.linalg.norm(again.missed[inside], axis=1).mean() < 1e-3


def test_what_they_miss_is_measured_and_grows_less_with_each_correction(walker_library, asked):
    setup, queries = asked
    spaces, before = walker_library.spaces, np.inf
    for corrections in range(6):
        found = correct_steps(setup, spaces, queries, corrections=corrections)
        assert_array_equal(np.diff(found.weights, axis=1) <= 0.0, True)
        landed = blend_landings(setup.library, queries.swing_sides, examples=found.examples, weights=found.weights)
        assert_allclose(found.missed, queries.landings - landed, atol=1e-12)
        blended = np.einsum("nk,nkd->nd", found.weights, end_landings(walker_library.examples)[found.examples])
        assert_allclose(left_landings(landed - blended, queries.swing_sides), found.biases, atol=1e-9)
        missed = np.linalg.norm(found.missed, axis=1)
        assert np.all(missed <= before)
        before = missed
    inside = found.hull_distances == 0.0
    assert np.median(missed[inside]) < setup.options.choice_tolerance


def test_a_walk_that_gets_next_to_nothing_of_a_run_lands_as_before(asked):
    setup, _ = asked
    examples, left = setup.examples, setup.examples.swing_sides == 0
    flights = examples.durations - examples.support_liftoffs
    walks, run = np.flatnonzero(left & (flights < 0.0))[:-1], np.flatnonzero(left & (flights > 0.02))[0]
    pairs = np.stack([walks[:-1], walks[1:]], axis=1)
    blends = np.column_stack([pairs, np.full(len(pairs), run)])
    assert len(blends) > 3
    before, after = (
        blend_landings(
            setup.library, np.zeros(len(blends), dtype=int), examples=blends, weights=np.tile(weights, (len(blends), 1))
        )
        for weights in ([0.6, 0.4, 0.0], [0.6 - 1e-6, 0.4, 1e-6])
    )
    assert_allclose(after, before, atol=1e-5)


def test_where_a_blend_misses_other_examples_around_the_footstep_are_tried(walker_library, asked):
    setup, queries = asked
    settles, noise = setup.library.settles, np.random.default_rng(2)
    astray = settles.numpy().copy()
    astray[::6] += noise.uniform(-0.06, 0.06, astray[::6].shape)  # blends with these land where nobody expects
    setup.library.settles = wp.array(astray, dtype=wp.vec2d)
    try:
        found = correct_steps(setup, walker_library.spaces, queries, corrections=8)
        landed = blend_landings(setup.library, queries.swing_sides, examples=found.examples, weights=found.weights)
    finally:
        setup.library.settles = settles
    assert_allclose(found.missed, queries.landings - landed, atol=1e-12)
    missed = np.linalg.norm(found.missed, axis=1)[found.hull_distances == 0.0]
    assert np.mean(missed > setup.options.choice_tolerance) < 0.04  # of the first examples chosen alone 0.056
