"""Real clips on real footsteps and on stones, and the project's own person."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.plans import mirrored, way
from tests.engine.walkers import in_world
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.engine.animate import animate_agents, animate_crowd, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.model.agent import Agent, Crowd
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


@pytest.mark.parametrize("farther", [0.8, 1.0])
def test_before_a_step_too_long_the_support_foot_stays(shared_data, farther):
    """The pelvis comes down as far as the longest step takes, rather than the foot behind being pulled along."""
    crowd = read_scene(shared_data / "scenes" / "walk_flat.usda").crowd
    plan = way(12, length=0.6, width=0.12, step_time=0.55, duty=0.6)
    ahead = np.array([0.0, 0.0, farther]) * (np.arange(12) > 5)[:, None]
    agent = replace(crowd.agents[0], plan=replace(plan, positions=plan.positions + ahead))
    crowd = replace(crowd, agents=(agent,), terrain=_nothing(), frame_times=np.arange(210) / 30.0)
    results = animate_crowd(crowd)[0][0].results
    assert results.status[6] == "unreachable"
    promised = np.isin(results.status, ["ok", "outsideHull"])
    assert promised[:6].all() and promised[9:].all()
    assert results.placement_error[promised].max() < 1e-3
    assert results.slide[promised].max() < 1e-3


def test_the_mirrored_stepping_stones_give_the_mirrored_motion(stages):
    """On a rig whose sides are alike; the terrain is left out, as it would have to be mirrored too."""
    crowd = read_scene(stages / "stepping_stones.usda").crowd
    options = EngineOptions()
    library = prepare_library(crowd.libraries[0], options)
    agent = crowd.agents[0]
    image = Agent(**{**vars(agent), "plan": mirrored(agent.plan)})
    level = Crowd(**{**vars(crowd), "terrain": _nothing()})
    before, after = (
        in_world(library.source, animate_agents(library, [each], level, options=options)[0]) for each in (agent, image)
    )
    partners = joint_pairs(library.source.skeleton, library.source.biped)
    apart = after.positions - before.positions[:, partners] * [-1.0, 1.0, 1.0]
    assert np.linalg.norm(apart, axis=-1).max() < 1e-5


def _nothing() -> Terrain:
    none = np.zeros(0, dtype=int)
    return Terrain(
        meshes=(), points=np.zeros((0, 3)), triangles=none.reshape(0, 3), mesh_indices=none, walkable=none.astype(bool)
    )
