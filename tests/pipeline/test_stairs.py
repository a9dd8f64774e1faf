"""Up and down the stairs of stages/ and a slope, along paths and after a trajectory: all figures are kept to."""

import pytest
from pxr import Gf, Usd, UsdGeom

from usdfoot.bridge.tokens import Agent, Schema
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.lint import lint_scene
from usdfoot.pipeline.validate import validate

UP = [(0.0, 0.0, 0.1), (0.0, 0.3, 1.8), (0.0, 0.6, 3.4)]
PAUSES = {0: (0.0, 3.3), 48: (0.0, 2.0), 90: (0.0, 2.0), 117: (-0.1, 1.28), 180: (-0.1, 1.28), 234: (-0.6, 0.1)}
"""Time codes and places (x, z) of one who rests twice on the way down, and goes on diagonally."""


def new_stage(file, assets):
    """A stage in metres, 30 codes a second, with references by name."""
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(30.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    for name, asset in assets.items():
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(asset))
    return stage


def define_walker(stage, name, points):
    curve = UsdGeom.BasisCurves.Define(stage, f"/World/Way_{name}")
    curve.CreateTypeAttr("linear")
    curve.CreatePointsAttr([Gf.Vec3f(*point) for point in points])
    curve.CreateCurveVertexCountsAttr([len(points)])
    define_agent(stage, name, Agent.PATH, curve)


@pytest.fixture
def scene(stages, tmp_path):
    """Three people who cross the stairs: one up, one down, and one who pauses."""
    assets = {"Terrain": "terrain_stairs.usda", "Motion": "clips.usdc", "Character": "human.usdc"}
    stage = new_stage(tmp_path / "stairs.usda", {name: stages / asset for name, asset in assets.items()})
    for name, points, side in (("Up", UP, 0.4), ("Down", UP[::-1], -0.4)):
        define_walker(stage, name, [(x + side, y, z) for x, y, z in points])
    track = UsdGeom.Xform.Define(stage, "/World/Track")
    place = track.AddTranslateOp()
    for code, (x, z) in PAUSES.items():
        place.Set(Gf.Vec3d(x, 0.0, z), code)
    define_agent(stage, "Pauses", Agent.TRAJECTORY, track)
    stage.Save()
    return tmp_path / "stairs.usda"


def define_agent(stage, name, goes_by, along):
    agent = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
    agent.AddAppliedSchema(Schema.AGENT)
    for relation, target in (
        (goes_by, along.GetPath()),
        (Agent.CHARACTER, "/World/Character"),
        (Agent.CLIPS, "/World/Motion/Clips"),
    ):
        agent.CreateRelationship(relation, custom=False).SetTargets([target])


def test_stairs_up_and_down(scene, tmp_path):
    assert lint_scene(scene).clean
    report = animate(scene, tmp_path / "shot")
    assert {status for results in report.results.values() for status in results.status} == {"ok"}
    validation = validate(report.crowd_file)
    over = {
        (agent.name, figure.name): figure.value
        for agent in validation.agents
        for figure in agent.figures
        if not figure.passed
    }
    assert validation.passed, over


def test_a_few_steps_up_a_slope(stages, tmp_path):
    """Who stands there, facing up, has the heels down: knees straight on level ground would be too short."""
    stage = new_stage(tmp_path / "slope.usda", {"Motion": stages / "clips.usdc", "Character": stages / "human.usdc"})
    mesh = UsdGeom.Mesh.Define(stage, "/World/Terrain")
    mesh.CreatePointsAttr([(-9.0, -3.6, -9.0), (-9.0, 3.6, 9.0), (9.0, 3.6, 9.0), (9.0, -3.6, -9.0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    define_walker(stage, "Up", [(0.0, 0.0, 0.0), (0.0, 0.2, 0.5)])
    stage.Save()
    validation = validate(animate(tmp_path / "slope.usda", tmp_path / "shot").crowd_file)
    assert validation.passed, [figure for agent in validation.agents for figure in agent.figures if not figure.passed]
