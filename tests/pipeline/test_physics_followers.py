"""Agents with a trajectory that physics moves need no clips at all."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, UsdGeom

from tests.scenes import Units, add_character, new_stage
from usdfoot.bridge.tokens import Agent, Motion, Schema
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate


def scene_with_ways(file, ways):
    """One person a way; ways are functions from times [s] to places (T, 3) [m]."""
    units = Units(meters=0.01, up="Z", rate=24.0)
    stage = new_stage(file, units)
    add_character(stage, "/World/Person", units)
    codes = np.arange(0.0, 6.0 * 24.0 + 1.0, 4.0)
    for name, way in ways.items():
        op = UsdGeom.Xform.Define(stage, f"/World/Way_{name}").AddTranslateOp()
        for code, point in zip(codes.tolist(), units.points(way(codes / 24.0)).tolist(), strict=True):
            op.Set(Gf.Vec3d(*point), code)
        agent = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        agent.AddAppliedSchema(Schema.AGENT)
        agent.CreateRelationship(Agent.TRAJECTORY, custom=False).SetTargets([f"/World/Way_{name}"])
        agent.CreateRelationship(Agent.CHARACTER, custom=False).SetTargets(["/World/Person"])
        agent.CreateAttribute(Agent.MOTION, Sdf.ValueTypeNames.Token, custom=False).Set(Motion.PHYSICS)
    stage.GetRootLayer().Save()
    return file


def straight(times):
    return np.stack([0.0 * times, 0.0 * times, 1.2 * times], axis=1)


def there_and_still(times):
    return np.stack([3.0 + 0.0 * times, 0.0 * times, 1.0 * np.minimum(times, 3.0)], axis=1)


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ways")
    scene = scene_with_ways(folder / "scene.usda", {"Straight": straight, "Stops": there_and_still})
    return scene, animate(scene, folder / "shot")


def test_they_keep_to_their_ways_and_their_feet_to_the_ground(walked):
    _, report = walked
    assert not report.skipped
    agents = json.loads(report.report_file.read_text())["agents"]
    for agent in agents:
        assert agent["trajectory"]["rootDistanceMean"] < 0.1
        assert max(agent["trajectory"]["velocityError"]) < 0.5
    straight_on = next(agent for agent in agents if agent["name"] == "Straight")
    assert_allclose(straight_on["trajectory"]["velocityError"][3:-2], 0.0, atol=0.05)
    assert validate(report.crowd_file).passed


def test_each_walks_as_it_would_alone(walked, tmp_path):
    scene, together = walked
    alone = animate(scene, tmp_path / "alone", agents="Stops", frames=(0, 144))
    ours, theirs = (
        json.loads(report.report_file.read_text())["agents"][-1]["trajectory"] for report in (alone, together)
    )
    assert ours["velocityError"] == theirs["velocityError"]
