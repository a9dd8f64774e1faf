"""Footsteps looked for from the root, as in the paper, instead of from the support ball."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, way
from tests.engine.synthesis import synthesise
from tests.engine.walkers import OTHERS, WALKS, library_of
from usdfoot.engine.animate import animate_crowd, prepare_library
from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.landings import blend_landings
from usdfoot.engine.options import FRAMES, SPACES, EngineOptions
from usdfoot.engine.queries import step_queries
from usdfoot.errors import UsdfootError
from usdfoot.maths import planar
from usdfoot.readers.scene import read_scene
from usdfoot.spaces.landings import end_landings

ROOT = EngineOptions(frame="root")
EVEN = way(12, length=0.55, width=0.18, stand_first=0.5, stand_last=0.5)


@pytest.fixture(scope="module")
def rooted():
    """The walker library, prepared to look for footsteps from the root."""
    return prepare_library(library_of([*WALKS, *OTHERS]), ROOT)


@pytest.fixture(scope="module")
def uneven():
    """A plan of long and short steps in turns: no step starts as steps of its length do in the clips."""
    plan = way(12, length=0.5, width=0.18, turn=0.1)
    ahead = 0.08 * np.sin(2.0 * np.arange(12))[:, None] * np.array([0.0, 0.0, 1.0])
    return replace(plan, positions=plan.positions + ahead)


def test_landings_from_the_root_are_those_from_the_support_ball_less_half_a_departure(walker_library):
    examples = walker_library.examples
    apart = end_landings(examples) - end_landings(examples, frame="root")
    assert_allclose(planar.rotate(examples.turns, apart), 0.5 * examples.departures, atol=1e-12)


@pytest.mark.parametrize("corrections", [0, 8])
def test_what_steps_miss_is_measured_from_the_support_ball_all_the_same(walker_library, rooted, uneven, corrections):
    setup = synthesise(rooted, [uneven], options=ROOT).setup
    queries = step_queries(setup, np.flatnonzero(~setup.segments.stands))
    found = correct_steps(setup, rooted.spaces, queries, corrections=corrections)
    landed = blend_landings(walker_library.device, queries.swing_sides, examples=found.examples, weights=found.weights)
    assert_allclose(found.missed, queries.landings - landed, atol=1e-9)
    assert np.linalg.norm(found.missed, axis=1).max() > 0.005


def test_the_roots_error_is_what_steps_miss_that_do_not_start_as_their_clips_do(walker_library, rooted, uneven):
    """Steps that all follow one like them have their root where the clips have it."""
    even, other = (synthesise(rooted, [plan], options=ROOT).landings.blend_error for plan in (EVEN, uneven))
    best = synthesise(walker_library, [uneven]).landings.blend_error
    assert np.median(even) < 0.003 < other.mean()
    assert other.mean() > 10.0 * best.mean()


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("scene", ["walk_flat.usda", "stepping_stones.usda"])
def test_real_footsteps_are_kept_by_ik_that_has_more_to_mend(shared_data, scene, space):
    """Design.md section 5: the root's error leaks into every step."""
    walk = read_scene(shared_data / "scenes" / scene).crowd
    before = {}
    for frame in FRAMES:
        motions, problems = animate_crowd(walk, options=EngineOptions(frame=frame, space=space))
        assert [problem for problem in problems if problem.severity == "error"] == []
        results, before[frame] = motions[0].results, motions[0].results.blend_error
        assert set(results.status) <= {"ok", "outsideHull"}
        assert results.placement_error.max() < 1e-3 and results.slide.max() < 1e-3
    assert before["root"].mean() > 10.0 * before["support"].mean()
    assert before["root"].max() < walk.agents[0].ik_reach


@pytest.mark.parametrize("weights", [{"root_weight": 0.3}, {"root_weight_within": 0.02}])
def test_root_weights_are_refused_as_options(weights):
    with pytest.raises(UsdfootError, match=r"frame: root goes with no root weight but 0\. .* use the frame support"):
        EngineOptions(frame="root", **weights)
    assert EngineOptions(frame="root", root_weight=0.0).root_weight == 0.0


@pytest.mark.parametrize("about", [{"root_weight": 0.3}, {"replace_distance": 0.1}])
def test_of_agents_those_with_root_weights_are_refused_and_the_others_walk(rooted, about):
    scene = crowd(rooted.source, [EVEN, EVEN])
    mixed = replace(scene, agents=(scene.agents[0], replace(scene.agents[1], **about)))
    motions, problems = animate_crowd(mixed, options=ROOT)
    assert [motion.name for motion in motions] == [scene.agents[0].name]
    assert [problem.where for problem in problems if problem.severity == "error"] == [scene.agents[1].source]
    assert "has a root weight or a replaceDistance, with the frame root" in problems[-1].message


def test_agents_walk_whose_root_weights_are_overruled(rooted):
    scene = crowd(rooted.source, [EVEN])
    weighted = replace(scene, agents=(replace(scene.agents[0], root_weight=0.3),))
    motions, _ = animate_crowd(weighted, options=EngineOptions(frame="root", root_weight=0.0))
    assert motions[0].results.placement_error.max() < 1e-3
