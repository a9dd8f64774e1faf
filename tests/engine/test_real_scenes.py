"""Real clips on real footsteps and on stones, and the project's own person."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.plans import MIRROR, mirrored, no_terrain, way
from tests.engine.walkers import in_world
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.engine.animate import animate_agents, animate_crowd, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.model.terrain import Terrain
from usdfoot.readers.scene import read_scene


@pytest.mark.parametrize("scene", ["walk_flat.usda", "stepping_stones.usda"])
def test_footsteps_are_kept(shared_data, scene):
    crowd = read_scene(shared_data / "scenes" / scene).crowd
    motions, problems = animate_crowd(crowd)
    assert [problem for problem in problems if problem.severity == "error"] == []
    results = motions[0].results
    assert set(results.status) <= {"ok", "outsideHull"}
    assert results.placement_error.mean() < 1e-3
    assert results.placement_error.max() < 3e-3
    assert results.slide.max() < 1e-3
    assert np.abs(results.yaw_error).max() < np.radians(0.5)
    inside = results.hull_distance < 1e-6
    assert results.blend_error[inside].mean() < 1e-3


@pytest.mark.parametrize("width", [0.12, 0.2])
def test_steps_in_place_are_met_before_ik(shared_data, width):
    """Nobody recorded steps in place: they are blends of walks forward and backward, which land far off their mean."""
    crowd = read_scene(shared_data / "scenes" / "walk_flat.usda").crowd
    plan = way(8, length=0.0, width=width, step_time=0.55, stand_first=0.5, stand_last=0.6)
    crowd = replace(crowd, agents=(replace(crowd.agents[0], plan=plan),), terrain=no_terrain())
    results = animate_crowd(crowd)[0][0].results
    assert results.hull_distance.max() < 1e-6
    assert results.blend_error.max() < 1e-3


@pytest.mark.parametrize("farther", [0.8, 1.0])
def test_before_a_step_too_long_the_support_foot_stays(shared_data, farther):
    """The pelvis comes down as far as the longest step takes, rather than the foot behind being pulled along."""
    crowd = read_scene(shared_data / "scenes" / "walk_flat.usda").crowd
    plan = way(12, length=0.6, width=0.12, step_time=0.55, duty=0.6)
    ahead = np.array([0.0, 0.0, farther]) * (np.arange(12) > 5)[:, None]
    agent = replace(crowd.agents[0], plan=replace(plan, positions=plan.positions + ahead))
    crowd = replace(crowd, agents=(agent,), terrain=no_terrain(), frame_times=np.arange(210) / 30.0)
    results = animate_crowd(crowd)[0][0].results
    assert results.status[6] == "unreachable"
    promised = np.isin(results.status, ["ok", "outsideHull"])
    assert promised[:6].all() and promised[9:].all()
    assert results.placement_error[promised].max() < 1e-3
    assert results.slide[promised].max() < 1e-3


@pytest.mark.parametrize("scene", ["demo", "walk_flat.usda", "stepping_stones.usda"])
def test_a_mirrored_plan_gives_the_mirrored_motion(stages, request, scene):
    """Where a joint is, its partner is in the mirror image, reflected in x = 0, terrain and all.

    Asked of rigs whose left and right bones are equally long to 5 micrometres, whatever axes their joints have: those
    of the recorded people's right thigh are not square, and their rest pose is a frame in which one foot is steeper.
    """
    path = (
        stages / "stepping_stones.usda"
        if scene == "demo"
        else request.getfixturevalue("shared_data") / "scenes" / scene
    )
    crowd = read_scene(path).crowd
    options = EngineOptions()
    library = prepare_library(crowd.libraries[0], options)
    agent = crowd.agents[0]
    image = replace(agent, plan=mirrored(agent.plan))
    behind = replace(crowd, terrain=_mirrored_ground(crowd.terrain))
    before, after = (
        in_world(library.source, animate_agents(library, [each], world, options=options)[0])
        for each, world in ((agent, crowd), (image, behind))
    )
    partners = joint_pairs(library.source.skeleton, library.source.biped)
    apart = after.positions - before.positions[:, partners] * MIRROR
    body = np.arange(len(partners)) >= library.source.biped.pelvis
    assert np.linalg.norm(apart[:, body], axis=-1).max() < 1e-5


def _mirrored_ground(terrain: Terrain) -> Terrain:
    return replace(terrain, points=terrain.points * MIRROR, triangles=terrain.triangles[:, ::-1])
