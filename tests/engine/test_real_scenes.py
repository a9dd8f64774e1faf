"""Real clips on real footsteps and on stones, and the project's own person."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engine.plans import mirrored
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
