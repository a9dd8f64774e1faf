"""Meshes read together are those read one by one."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from tests.scenes import new_stage
from usdfoot.bridge.tokens import Schema
from usdfoot.readers import mesh_triangles
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.terrain import read_terrain

BAD = {
    3: ([], [], "is an empty mesh (0 points, 0 faces)"),
    5: ([(0, 0, 0), (1, 0, 0), (0, 0, 1)], [(0, 1, 9)], "has faces that do not match its points"),
    6: ([(0, 0, 0), (1, 0, 0), (0, np.inf, 1)], [(0, 1, 2)], "has points that are not finite"),
    9: ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)], "has only faces without area"),
    11: ([(0, 0, 0)], [()], "has only faces without area"),
}
"""What is wrong with some of the meshes, by number."""


def add_mesh(stage, number, random):
    """A mesh of polygons with three to seven corners, some concave, some holes, somewhere, perhaps inside out."""
    mesh = UsdGeom.Mesh.Define(stage, f"/World/Ground/M{number:02d}")
    counts = random.integers(3, 8, size=random.integers(1, 5))
    points = random.normal(size=(counts.sum(), 3))
    faces = [
        (np.arange(count) + start).tolist() for count, start in zip(counts, np.cumsum(counts) - counts, strict=True)
    ]
    if number in BAD:
        points, faces, _ = BAD[number]
    elif random.random() < 0.5:
        mesh.CreateHoleIndicesAttr([0, 77] if len(faces) > 1 else [77])
    mesh.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, point)) for point in points]))
    mesh.CreateFaceVertexCountsAttr([len(face) for face in faces])
    mesh.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
    mesh.AddTranslateOp().Set(Gf.Vec3d(*random.normal(size=3)))
    mesh.AddRotateYOp().Set(random.uniform(0.0, 360.0))
    mesh.AddScaleOp().Set(Gf.Vec3f(random.choice([-1.0, 1.0]), 1.0, 1.0))
    if random.random() < 0.3:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    if random.random() < 0.3:
        mesh.GetPrim().CreateAttribute("usdfoot:terrain:walkable", Sdf.ValueTypeNames.Bool).Set(False)


@pytest.fixture(scope="module")
def stage():
    stage = new_stage()
    stage.DefinePrim("/World/Ground").AddAppliedSchema(Schema.TERRAIN)
    random = np.random.default_rng(4)
    for number in range(14):
        add_mesh(stage, number, random)
    return stage


def read(stage, chosen="/World/Ground"):
    only = Usd.Stage.OpenMasked(stage.GetRootLayer(), Usd.StagePopulationMask([chosen]))
    return read_terrain(only, collect_prims(only), read_stage_info(only).units)


def test_many_meshes_are_what_each_is_alone(stage):
    whole, problems = read(stage)
    paths = [str(prim.GetPath()) for prim in stage.GetPrimAtPath("/World/Ground").GetChildren()]
    assert {problem.severity for problem in problems} == {"error"}
    assert list(whole.meshes) == [path for number, path in enumerate(paths) if number not in BAD]
    assert [(problem.where, problem.message.partition(". ")[0]) for problem in problems] == [
        (paths[number], f"{paths[number]}: {what}") for number, (_, _, what) in BAD.items()
    ]
    points = triangles = 0
    for mesh, path in enumerate(whole.meshes):
        alone, _ = read(stage, path)
        count, size = len(alone.triangles), len(alone.points)
        assert_array_equal(whole.triangles[triangles : triangles + count], alone.triangles + points)
        assert_array_equal(whole.points[points : points + size], alone.points)
        assert_array_equal(whole.mesh_indices[triangles : triangles + count], mesh)
        assert whole.walkable[mesh] == alone.walkable[0]
        points, triangles = points + size, triangles + count
    assert (points, triangles) == (len(whole.points), len(whole.triangles))


@pytest.mark.parametrize("at_once", [1, 40])
def test_a_few_at_once_are_the_same(stage, monkeypatch, at_once):
    whole, problems = read(stage)
    monkeypatch.setattr(mesh_triangles, "_AT_ONCE", at_once)
    parts, same = read(stage)
    assert (parts.meshes, problems) == (whole.meshes, same)
    for name in ("points", "triangles", "mesh_indices", "walkable"):
        assert_array_equal(getattr(parts, name), getattr(whole, name))
