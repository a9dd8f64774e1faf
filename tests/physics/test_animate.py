"""Crowds whose agents mix clips, physics and both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.plans import crowd, way
from tests.engine.walkers import WALKS, library_of
from usdfoot.model.clip import ClipLibrary
from usdfoot.physics.animate import animate_all
from usdfoot.physics.motion_options import MotionOptions

MOTIONS = ("clips", "physics", "hybrid")


@pytest.fixture(scope="module")
def mixed():
    scene = crowd(library_of(WALKS), [way(6), way(6), way(6)])
    agents = tuple(replace(agent, motion=motion) for agent, motion in zip(scene.agents, MOTIONS, strict=True))
    return animate_all(replace(scene, agents=agents))


def test_agents_mix_sources_in_the_order_of_the_crowd(mixed):
    motions, problems = mixed
    assert [motion.name for motion in motions] == ["agent0", "agent1", "agent2"]
    assert not [problem for problem in problems if problem.severity == "error"]
    assert [motion.results.forces is not None for motion in motions] == [False, True, True]
    assert [bool(motion.results.clips) for motion in motions] == [True, False, True]


def test_every_source_keeps_its_footsteps(mixed):
    for motion in mixed[0]:
        assert motion.results.placement_error.max() < 1e-4
        assert np.nanmax(motion.results.slide) < 1e-4
        assert np.isfinite(motion.rotations).all() and np.isfinite(motion.pelvis_positions).all()


def test_physics_needs_no_clips_and_turns_with_the_plan():
    source = library_of(WALKS)
    bare = ClipLibrary(skeleton=source.skeleton, biped=source.biped, clips=())
    scene = crowd(bare, [way(6)])
    agents = (replace(scene.agents[0], motion="physics"),)
    motions, problems = animate_all(replace(scene, agents=agents), options=MotionOptions())
    assert not problems
    assert motions[0].results.status == ("ok",) * 6
