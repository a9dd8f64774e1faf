"""Attributes of USD's own schemas that somebody authored as another type: named with that which is right."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.scenes import Units, add_agent, add_ground, crowd_stage, messages, simple_scene
from usdfoot.bridge.tokens import Agent, Schema
from usdfoot.errors import PlanError, SceneError
from usdfoot.readers.attributes import array_at, axis_of, size_at, value_at
from usdfoot.readers.paths import read_paths
from usdfoot.readers.scene import read_scene
from usdfoot.readers.stage import read_stage_info

_TYPES = Sdf.ValueTypeNames
TEXT, NUMBER, NUMBERS = (_TYPES.String, "x"), (_TYPES.Double, 0.5), (_TYPES.IntArray, [1])


def author(stage, path, kind, value):
    """Authors an attribute as whatever type, as no schema allows and every file may."""
    layer, path = stage.GetRootLayer(), Sdf.Path(path)
    prim = Sdf.CreatePrimInLayer(layer, path.GetPrimPath())
    if path.name in prim.attributes:
        del prim.properties[path.name]
    Sdf.AttributeSpec(prim, path.name, kind).default = value


@pytest.mark.parametrize("wrong", [TEXT, NUMBER, NUMBERS])
@pytest.mark.parametrize(
    ("path", "right"),
    [
        ("Hero/Skeleton.joints", "token[]"),
        ("Hero/Skeleton.bindTransforms", "matrix4d[]"),
        ("Hero/Skeleton.restTransforms", "matrix4d[]"),
        ("Clips/walk.joints", "token[]"),
        ("Clips/walk.translations", "float3[]"),
        ("Clips/walk.scales", "half3[]"),
    ],
)
def test_skeletons_and_clips_of_other_types_are_refused_with_that_which_is_right(path, right, wrong):
    stage = simple_scene()
    author(stage, f"/World/{path}", *wrong)
    with pytest.raises(SceneError, match="no agent can be used") as caught:
        read_scene(stage)
    prim, _, name = path.rpartition(".")
    assert f"/World/{prim}: {name} is of type {wrong[0]}. author it as {right}" in str(caught.value)


def test_samples_of_another_type_are_refused_too():
    stage = simple_scene()
    rotations = "/World/Clips/walk.rotations"
    author(stage, rotations, _TYPES.String, Sdf.ValueBlock())
    stage.GetRootLayer().SetTimeSample(rotations, 0.0, "x")
    with pytest.raises(SceneError, match=r"Clips/walk: rotations is of type string. author it as quatf\[\]"):
        read_scene(stage)


@pytest.mark.parametrize("wrong", [TEXT, NUMBER])
@pytest.mark.parametrize(
    ("name", "right"),
    [("points", "point3f[]"), ("faceVertexCounts", "int[]"), ("faceVertexIndices", "int[]"), ("holeIndices", "int[]")],
)
def test_of_meshes_one_is_left_out_and_the_others_are_ground(name, right, wrong):
    stage = simple_scene()
    add_ground(stage, "/World/Ground", Units())
    add_ground(stage, "/World/Bad", Units())
    author(stage, f"/World/Bad.{name}", *wrong)
    scene = read_scene(stage)
    assert messages(scene) == [f"/World/Bad: {name} is of type {wrong[0]}. author it as {right}"]
    assert scene.crowd.terrain.meshes == ("/World/Ground",)


@pytest.mark.parametrize(
    ("kind", "name", "wrong", "said"),
    [
        ("Cube", "size", TEXT, "size is of type string. author it as double"),
        ("Plane", "width", NUMBERS, r"width is of type int[]. author it as double"),
        ("Plane", "axis", (_TYPES.Token, "W"), "axis is W. author one of X, Y, Z"),
        ("Plane", "axis", NUMBER, "axis is of type double. author it as token"),
    ],
)
def test_solids_to_stand_on(kind, name, wrong, said):
    stage = simple_scene()
    stage.DefinePrim("/World/Solid", kind).AddAppliedSchema(Schema.TERRAIN)
    author(stage, f"/World/Solid.{name}", *wrong)
    assert messages(read_scene(stage)) == [f"/World/Solid: {said}"]


@pytest.mark.parametrize("name", ["points", "primvars:skel:jointIndices", "primvars:skel:geomBindTransform"])
def test_skins_are_left_out_with_a_word(name, caplog):
    stage = simple_scene()
    author(stage, f"/World/Hero/Body.{name}", *TEXT)
    assert len(read_scene(stage).crowd.agents) == 1
    assert f"/World/Hero/Body: {name} is of type string. author it as" in caplog.text


def test_numbers_of_other_precision_stand_for_the_schema_s():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Mesh.Define(stage, "/Mesh")
    author(stage, "/Mesh.points", _TYPES.Double3Array, [Gf.Vec3d(1, 2, 3)])
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Mesh"))
    np.testing.assert_array_equal(array_at(mesh.GetPointsAttr()), [(1.0, 2.0, 3.0)])
    assert value_at(mesh.GetNormalsAttr()) is None and not len(array_at(mesh.GetNormalsAttr()))
    author(stage, "/Mesh.points", *NUMBER)
    assert size_at(mesh.GetPointsAttr()) == 0


@pytest.mark.parametrize(
    ("operation", "wrong", "said"),
    [
        ("translate", TEXT, "xformOp:translate is of type string. author it as double3"),
        ("translate", NUMBER, "xformOp:translate is of type double. author it as double3"),
        ("rotateX", NUMBERS, "xformOp:rotateX is of type int[]. author it as double"),
        ("transform", NUMBER, "xformOp:transform is of type double. author it as matrix4d"),
        ("turn", NUMBER, "xformOp:turn is no operation of USD's. correct xformOpOrder"),
    ],
)
def test_transforms_that_usd_cannot_compute_are_named(tmp_path, operation, wrong, said):
    stage = crowd_stage(tmp_path)
    add_ground(stage, "/World/Ground", Units())
    for path in ("/World/Ground", "/World/Plans/P1"):
        author(stage, f"{path}.xformOp:{operation}", *wrong)
        author(stage, f"{path}.xformOpOrder", _TYPES.TokenArray, [f"xformOp:{operation}"])
    scene = read_scene(stage)
    assert len(scene.crowd.agents) == 2
    assert messages(scene) == [f"/World/Group1/Walker: /World/Plans/P1: {said}", f"/World/Ground: {said}"]


def test_a_transform_of_the_character_that_usd_cannot_compute_is_named():
    stage = simple_scene()
    author(stage, "/World/Hero/Skeleton.xformOp:translate", *TEXT)
    author(stage, "/World/Hero/Skeleton.xformOpOrder", _TYPES.TokenArray, ["xformOp:translate"])
    with pytest.raises(SceneError, match=r"Hero/Skeleton: xformOp:translate is of type string. author it as double3"):
        read_scene(stage)


def test_what_has_no_axis_lies_along_z():
    stage = Usd.Stage.CreateInMemory()
    assert axis_of(UsdGeom.Sphere.Define(stage, "/Ball").GetPrim()) == 2
    cylinder = UsdGeom.Cylinder.Define(stage, "/Post")
    cylinder.CreateAxisAttr("X")
    assert axis_of(cylinder.GetPrim()) == 0


@pytest.mark.parametrize(
    ("name", "wrong"), [("points", TEXT), ("curveVertexCounts", NUMBER), ("type", NUMBERS), ("basis", NUMBERS)]
)
def test_paths_of_other_types_are_refused_and_the_others_go_on(tmp_path, name, wrong):
    stage = crowd_stage(tmp_path)
    curves = UsdGeom.BasisCurves.Define(stage, "/World/Way")
    curves.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (0, 0, 2), (0, 0, 3)])
    curves.CreateCurveVertexCountsAttr([4])
    stage.GetPrimAtPath("/World/Group0/Walker").RemoveProperty("usdfoot:agent:plan")
    add_agent(stage, "/World/Group0/Walker", path="/World/Way")
    author(stage, f"/World/Way.{name}", *wrong)
    scene = read_scene(stage)
    assert len(scene.crowd.agents) == 2
    (message,) = messages(scene)
    assert f"/World/Way: {name} is of type {wrong[0]}. author it as" in message


def test_options_that_are_animated_are_read_at_their_first_sample_with_a_warning(caplog):
    stage = simple_scene()
    weight = stage.GetPrimAtPath("/World/Hero").CreateAttribute(Agent.ROOT_WEIGHT, _TYPES.Float, False)
    for code, value in ((0.0, 0.25), (10.0, 0.75)):
        weight.Set(value, code)
    (agent,) = read_scene(stage).crowd.agents
    assert agent.root_weight == 0.25
    assert f"/World/Hero: {Agent.ROOT_WEIGHT} is animated, the first sample is read" in caplog.text


def test_obstacles_that_cannot_be_read_are_named_by_who_goes_round_them():
    stage = simple_scene()
    curves = UsdGeom.BasisCurves.Define(stage, "/World/Way")
    curves.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (0, 0, 2), (0, 0, 3)])
    curves.CreateCurveVertexCountsAttr([4])
    stage.GetPrimAtPath("/World/Hero").RemoveProperty(Agent.PLAN)
    add_agent(stage, "/World/Hero", path="/World/Way")
    stage.DefinePrim("/World/Box", "Mesh").AddAppliedSchema(Schema.OBSTACLE)
    author(stage, "/World/Box.points", *TEXT)
    assert messages(read_scene(stage)) == ["/World/Box: points is of type string. author it as point3f[]"]


def test_paths_at_infinity_are_refused():
    stage = simple_scene()
    curves = UsdGeom.BasisCurves.Define(stage, "/World/Way")
    curves.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (0, 0, 2), (0, 0, 3)])
    curves.CreateCurveVertexCountsAttr([4])
    curves.AddTranslateOp().Set((np.inf, 0.0, 0.0))
    with pytest.raises(PlanError, match="Way: has points that are not finite"):
        read_paths(curves.GetPrim(), read_stage_info(stage).units)
