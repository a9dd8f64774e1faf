"""Hull edges as blends land on them, against blends of many weights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import cKDTree

from tests.builders import Gait
from tests.engine.plans import way
from tests.engine.synthesis import synthesise
from tests.engine.walkers import library_of
from usdfoot.engine.animate import prepare_library
from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.landings import blend_landings
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.queries import step_queries
from usdfoot.spaces.footsteps import solve_footsteps

STEPS = (
    Gait(step_length=0.6, step_width=0.1, rise=0.25, step_time=0.6),
    Gait(step_length=0.6, step_width=0.4, sideways=0.25, step_time=0.6, heel_strike=False),
    Gait(step_length=0.95, step_width=0.3, step_time=0.5),
)


def ask(gaits, count=600):
    """A library of few steps far apart, queries all over the hull of their landings, and what is found for them."""
    library = prepare_library(library_of(gaits), EngineOptions())
    steps = synthesise(library, [way(6, length=0.4)])
    template = step_queries(steps.setup, np.flatnonzero(~steps.setup.segments.stands))
    rows = np.full(count, int(np.flatnonzero(template.swing_sides == 0)[0]))
    space = library.spaces.spaces["default", False, 0]
    corners = space.footsteps.vertices
    shares = np.random.default_rng(3).dirichlet(np.full(len(corners), 0.6), count)
    queries = replace(template[rows], landings=shares @ corners)
    found = correct_steps(steps.setup, library.spaces, queries, corrections=steps.setup.options.corrections)
    return library, space, queries, found


def landed(library, examples, weights):
    """Where blends land, (x, z) [m], shape (N, 2)."""
    order = np.argsort(-weights, axis=1, kind="stable")
    return blend_landings(
        library.device,
        np.zeros(len(examples), dtype=int),
        examples=np.take_along_axis(examples, order, axis=1),
        weights=np.take_along_axis(weights, order, axis=1),
    )


def edge_curve(library, space, pieces=400):
    """Where the blends of the hull's edges land, shape (H * pieces, 2)."""
    ends = space.examples[space.footsteps.members[space.footsteps.edges, 0]]
    shares = np.tile(np.linspace(0.0, 1.0, pieces), len(ends))
    return landed(library, np.repeat(ends, pieces, axis=0), np.stack([1.0 - shares, shares], axis=1))


def test_footsteps_between_an_edge_and_where_its_blends_land_are_outside():
    library, space, queries, found = ask(STEPS)
    assert np.all(solve_footsteps(space.footsteps, queries.landings).hull_distances == 0.0)
    outside, missed = found.hull_distances > 0.0, np.linalg.norm(found.missed, axis=1)
    assert 0.05 < outside.mean() < 0.5
    assert missed[~outside].max() <= EngineOptions().choice_tolerance
    curve = cKDTree(edge_curve(library, space))
    assert_allclose(found.hull_distances[outside], curve.query(queries.landings[outside])[0], atol=1e-3)
    assert_allclose(missed[outside], found.hull_distances[outside], atol=2e-3)
    assert found.hull_distances.max() > 0.01


def test_no_blend_comes_nearer_to_them():
    library, space, queries, found = ask(STEPS)
    outside = found.hull_distances > 1e-3
    weights = np.random.default_rng(4).dirichlet(np.full(len(space.examples), 0.4), 4000)
    blends = cKDTree(landed(library, np.tile(space.examples, (len(weights), 1)), weights))
    assert np.all(blends.query(queries.landings[outside])[0] > found.hull_distances[outside] - 2e-3)


def test_of_two_steps_all_that_their_blends_miss_is_outside():
    _, space, _, found = ask(STEPS[::2])
    assert not len(space.footsteps.triangles)
    missed = np.linalg.norm(found.missed, axis=1)
    far = missed > 2e-3
    assert far.mean() > 0.2
    assert_allclose(found.hull_distances[far], missed[far], atol=1e-3)


@pytest.mark.parametrize("space", ["delaunay", "3d"])
def test_other_spaces_answer_as_before(space):
    library, own, queries, _ = ask(STEPS)
    steps = synthesise(library, [way(6, length=0.4)])
    setup = replace(steps.setup, options=EngineOptions(space=space))
    found = correct_steps(setup, library.spaces, queries, corrections=8)
    assert_allclose(found.hull_distances, solve_footsteps(own.footsteps, queries.landings).hull_distances, atol=1e-12)
