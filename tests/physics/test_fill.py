"""Steps made for holes: they land there, stand still, keep their events, and are like the clips around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait
from tests.engine.plans import crowd, way
from tests.engine.walkers import WALKS, library_of
from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.world import world_clip
from usdfoot.engine.animate import animate_agents, prepare_library
from usdfoot.physics.animate import animate_all
from usdfoot.physics.fill import fill_library
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.planning.reach import reach_of_biped
from usdfoot.spaces.holes import HoleOptions
from usdfoot.spaces.landings import end_landings, left_landings

RUNS = tuple(Gait(step_length=length, step_time=0.36, duty=0.33, step_width=0.12) for length in (0.9, 1.0, 1.1))


@pytest.fixture(scope="module")
def walks():
    """Steps ahead only."""
    return prepare_library(library_of(WALKS), MotionOptions())


@pytest.fixture(scope="module")
def filled(walks):
    outline = reach_of_biped(walks.source.biped).outline
    return fill_library(walks, outline, name="/Clips/synthetic_", first=7, holes=HoleOptions(gap=0.25))


@pytest.fixture(scope="module")
def synthetic(filled):
    return build_examples(replace(filled.source, clips=filled.clips))


def test_every_hole_gets_a_marked_clip(filled):
    assert len(filled.holes) > 5
    assert len(filled.clips) + len(filled.problems) == len(filled.holes)
    assert len(filled.clips) > 0.8 * len(filled.holes)
    assert filled.clips[0].name == "/Clips/synthetic_007"
    assert all(clip.synthetic and clip.style == "default" and clip.mirror for clip in filled.clips)
    assert filled.filled.clips == (*filled.source.clips, *filled.clips)


def test_no_runs_are_made_from_walks(filled):
    assert not any(hole.flight for hole in filled.holes)
    assert filled.styles_without_runs == ("default",)
    both = prepare_library(library_of((*WALKS, *RUNS)), MotionOptions())
    outline = reach_of_biped(both.source.biped).outline
    assert fill_library(both, outline, name="/Clips/synthetic_", holes=HoleOptions(gap=9.0)).styles_without_runs == ()


def test_the_steps_land_in_the_holes(filled, synthetic):
    examples, problems = synthetic
    assert not problems
    landings = left_landings(end_landings(examples), examples.swing_sides)
    by_clip = {name: number for number, name in enumerate(examples.clip_names)}
    assert np.bincount(examples.clip_indices).tolist() == [4] * len(filled.clips)  # a stride and its image
    numbered = {f"/Clips/synthetic_{number:03d}": hole for number, hole in enumerate(filled.holes, start=7)}
    for clip in filled.clips:
        own = landings[examples.clip_indices == by_clip[clip.name]]
        assert np.linalg.norm(own - numbered[clip.name].landing, axis=1).min() < 0.03


def test_the_events_are_exact_and_the_feet_stand_still(filled):
    for clip in filled.clips:
        world = world_clip(clip, filled.source.skeleton, filled.source.biped)
        assert not world.root_motion.in_place and world.period is None
        for side in (0, 1):
            known = np.isin(clip.events[side].strike_times, world.contacts[side].strike_times)
            assert known.all()
    examples, _ = build_examples(replace(filled.source, clips=filled.clips), mirror=False)
    rows = np.arange(len(examples))
    planted = examples.support_balls[rows[:, None], np.arange(15, 45)]
    assert np.ptp(planted, axis=1)[:, [0, 2]].max() < 0.004
    assert_allclose(planted[..., 1], filled.source.biped.ball_heights.mean(), atol=0.02)


def test_landings_nobody_showed_are_inside_with_the_fill(walks, filled):
    plan = way(8, length=-0.3)
    with_fill = prepare_library(filled.filled, MotionOptions())
    distances = []
    for library in (walks, with_fill):
        scene = crowd(library.source, [plan])
        (motion,) = animate_agents(library, scene.agents, scene, options=MotionOptions())
        distances.append(motion.results.hull_distance[2:-1].max())
        assert motion.results.placement_error.max() < 1e-3
    assert distances[0] > 0.25
    assert distances[1] < 0.02
    assert any(name.startswith("/Clips/synthetic_") for name in motion.results.clips)


def test_a_library_without_holes_stays_as_it_is(walks):
    nowhere = np.zeros((4, 2))
    none = fill_library(walks, nowhere, name="/Clips/synthetic_", holes=HoleOptions(gap=2.0))
    assert none.holes == () and none.filled.clips == walks.source.clips


def test_hybrids_stand_as_their_clips_do():
    source = library_of(WALKS)
    scene = crowd(source, [way(10), way(10)])
    agents = tuple(
        replace(agent, motion=motion) for agent, motion in zip(scene.agents, ("clips", "hybrid"), strict=True)
    )
    blended, carried = animate_all(replace(scene, agents=agents))[0]
    inside = (blended.times > 1.5) & (blended.times < 3.5)
    rows = np.searchsorted(carried.times, blended.times[inside])
    apart = carried.pelvis_positions[rows] - blended.pelvis_positions[inside]
    assert np.abs(apart.mean(axis=0)).max() < 0.005
    assert np.abs(apart).max() > 0.005  # physics bobs, the walker does not
