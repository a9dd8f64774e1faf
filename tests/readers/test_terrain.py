"""Terrain: which meshes, which triangles, which way up."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from tests.scenes import Units, add_character, add_ground, add_mesh, add_plan, new_stage
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.tokens import Terrain as Token
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.terrain import read_terrain
from usdfoot.readers.triangles import cut_polygons

SQUARE = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]


def read(stage):
    return read_terrain(stage, collect_prims(stage), read_stage_info(stage).units)


def normals(terrain):
    a, b, c = (terrain.points[terrain.triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def area(terrain):
    return 0.5 * np.linalg.norm(normals(terrain), axis=1).sum()


@pytest.mark.parametrize("units", [Units(), Units(0.01, "Z"), Units(0.0254, "Y")])
def test_units_and_axes_do_not_matter(units):
    stage = new_stage(None, units)
    add_ground(stage, "/World/Floor", units, size=2.0)
    terrain, problems = read(stage)
    assert terrain.meshes == ("/World/Floor",)
    assert_allclose(terrain.points, [(-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)], atol=1e-6)
    assert np.all(normals(terrain)[:, 1] > 0.0)
    assert area(terrain) == pytest.approx(16.0, rel=1e-6)
    assert problems == ()


def test_a_marked_prim_covers_the_meshes_below_it_and_the_nearest_walkable_wins():
    stage = new_stage()
    for name in ("A", "B", "C"):
        add_mesh(stage, f"/World/Set/{name}/Mesh", SQUARE, [(0, 1, 2, 3)], Units())
    stage.GetPrimAtPath("/World/Set").AddAppliedSchema(Schema.TERRAIN)
    stage.GetPrimAtPath("/World/Set/B").AddAppliedSchema(Schema.TERRAIN)
    stage.GetPrimAtPath("/World/Set").CreateAttribute(Token.WALKABLE, Sdf.ValueTypeNames.Bool, False).Set(False)
    stage.GetPrimAtPath("/World/Set/B").CreateAttribute(Token.WALKABLE, Sdf.ValueTypeNames.Bool, False).Set(True)
    add_ground(stage, "/World/Ground", Units(), terrain=False)
    terrain, _ = read(stage)
    assert terrain.meshes == ("/World/Set/A/Mesh", "/World/Set/B/Mesh", "/World/Set/C/Mesh")
    assert_array_equal(terrain.walkable, [False, True, False])


@pytest.mark.parametrize(
    "path", ["/World/Ground", "/World/my_TERRAIN_01", "/World/Playground/Plane", "/World/Ground/Plane_001"]
)
def test_without_the_schema_names_tell(path):
    stage = new_stage()
    add_mesh(stage, "/World/Wall", SQUARE, [(0, 1, 2, 3)], Units())
    add_mesh(stage, path, SQUARE, [(0, 1, 2, 3)], Units())
    terrain, _ = read(stage)
    assert terrain.meshes == (path,)
    assert_array_equal(terrain.walkable, [True])


@pytest.mark.parametrize("is_marked", [True, False])
def test_proxies_are_no_terrain_beside_what_they_stand_for(is_marked):
    stage = new_stage()
    for purpose in ("proxy", "render"):
        for name in ("Left", "Right"):
            add_mesh(stage, f"/World/Terrain/{purpose}/Ground{name}", SQUARE, [(0, 1, 2, 3)], Units())
        UsdGeom.Imageable(UsdGeom.Xform.Define(stage, f"/World/Terrain/{purpose}")).GetPurposeAttr().Set(purpose)
    if is_marked:
        stage.GetPrimAtPath("/World/Terrain").AddAppliedSchema(Schema.TERRAIN)
    assert read(stage)[0].meshes == ("/World/Terrain/render/GroundLeft", "/World/Terrain/render/GroundRight")
    stage.GetPrimAtPath("/World/Terrain/render").SetActive(False)
    assert read(stage)[0].meshes == ("/World/Terrain/proxy/GroundLeft", "/World/Terrain/proxy/GroundRight")


def test_no_terrain_is_no_error():
    stage = new_stage()
    add_mesh(stage, "/World/Wall", SQUARE, [(0, 1, 2, 3)], Units())
    terrain, problems = read(stage)
    assert terrain.meshes == ()
    assert terrain.triangles.shape == (0, 3)
    assert problems == ()


@pytest.mark.parametrize(
    ("shape", "remedy"),
    [
        ("Cube", "apply UsdfootTerrainAPI to it"),
        ("Sphere", "convert it to a Mesh"),
        ("NurbsPatch", "convert it to a Mesh"),
    ],
)
def test_a_shape_named_ground_is_named_only_where_no_mesh_is_the_ground(shape, remedy):
    """With what helps: marked, cubes and planes are read as they are, as game engines write their floors."""
    stage = new_stage()
    ground = stage.DefinePrim("/World/Ground", shape)
    UsdGeom.Plane.Define(stage, "/World/Lake")
    terrain, (problem,) = read(stage)
    assert not terrain.meshes and problem.severity == "warning" and problem.where == "/World/Ground"
    assert f"a {shape} is no mesh" in problem.message and remedy in problem.message
    ground.AddAppliedSchema("UsdfootTerrainAPI")
    assert bool(read(stage)[0].meshes) == (shape == "Cube")
    ground.RemoveAppliedSchema("UsdfootTerrainAPI")
    add_ground(stage, "/World/Terrain", Units())
    assert read(stage)[1] == ()


def test_shapes_that_are_marked_with_meshes_and_cannot_be_stood_on_are_named_by_type():
    stage = new_stage()
    add_mesh(stage, "/World/Set/Floor", SQUARE, [(0, 1, 2, 3)], Units())
    for path, kind in (("Ball", "Sphere"), ("Hill", "NurbsPatch"), ("Egg", "Sphere"), ("Rail", "BasisCurves")):
        stage.DefinePrim(f"/World/Set/{path}", kind)
    stage.DefinePrim("/World/Dome", "Sphere").AddAppliedSchema(Schema.TERRAIN)
    stage.GetPrimAtPath("/World/Set").AddAppliedSchema(Schema.TERRAIN)
    dome, *others = read(stage)[1]
    assert dome.severity == "error" and "/World/Dome: has UsdfootTerrainAPI but no mesh" in dome.message
    assert [(problem.severity, problem.message) for problem in others] == [
        (
            "warning",
            "/World/Set/Ball: and 1 more are marked as terrain, but feet pass through a Sphere. convert it to a Mesh",
        ),
        ("warning", "/World/Set/Hill: is marked as terrain, but feet pass through a NurbsPatch. convert it to a Mesh"),
    ]


def hide(stage, path, how):
    imageable = UsdGeom.Imageable(stage.GetPrimAtPath(path))
    imageable.GetPurposeAttr().Set("guide") if how == "guide" else imageable.MakeInvisible()


@pytest.mark.parametrize("how", ["guide", "invisible"])
def test_what_is_hidden_below_a_marked_prim_is_no_terrain_and_named(how):
    """Hidden with what marks it, or marked itself, it is meant: as a mesh for the feet alone that nobody sees."""
    stage = new_stage()
    for name in ("Seen", "Old"):
        UsdGeom.Xform.Define(stage, f"/World/Set/{name}")
        add_mesh(stage, f"/World/Set/{name}/Mesh", SQUARE, [(0, 1, 2, 3)], Units())
    marked = UsdGeom.Xform.Define(stage, "/World/Set").GetPrim()
    marked.AddAppliedSchema(Schema.TERRAIN)
    hide(stage, "/World/Set/Old", how)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == ("/World/Set/Seen/Mesh",)
    assert problem.severity == "warning" and problem.where == "/World/Set/Old/Mesh"
    assert "is hidden (invisible or guides), and so left out as ground. show it, or apply" in problem.message
    stage.GetPrimAtPath("/World/Set/Old/Mesh").AddAppliedSchema(Schema.TERRAIN)
    assert len(read(stage)[0].meshes) == 2 and read(stage)[1] == ()
    stage.GetPrimAtPath("/World/Set/Old/Mesh").RemoveAppliedSchema(Schema.TERRAIN)
    hide(stage, "/World/Set", how)
    assert len(read(stage)[0].meshes) == 2 and read(stage)[1] == ()


@pytest.mark.parametrize("how", ["guide", "invisible"])
def test_what_is_hidden_is_the_ground_by_name_only_where_no_other_is(how):
    stage = new_stage()
    for name in ("Ground", "GroundOld"):
        add_mesh(stage, f"/World/{name}", SQUARE, [(0, 1, 2, 3)], Units())
    hide(stage, "/World/GroundOld", how)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == ("/World/Ground",)
    assert problem.where == "/World/GroundOld" and "left out as ground" in problem.message
    stage.GetPrimAtPath("/World/Ground").SetActive(False)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == ("/World/GroundOld",)
    assert "/World/GroundOld: is hidden (invisible or guides), and the ground by name" in problem.message


def test_characters_and_prints_are_no_terrain():
    stage = new_stage()
    add_character(stage, "/World/GroundKeeper", Units(), with_body=True)
    add_plan(stage, "/World/GroundPlan", Units())
    add_mesh(stage, "/World/GroundPlan/Prints/Ground", SQUARE, [(0, 1, 2, 3)], Units())
    add_mesh(stage, "/World/GroundKeeper/Shovel", SQUARE, [(0, 1, 2, 3)], Units())
    stage.GetPrimAtPath("/World").AddAppliedSchema(Schema.TERRAIN)
    terrain, _ = read(stage)
    assert terrain.meshes == ()


def test_the_transform_at_the_stage_s_start_applies():
    stage = new_stage()
    stage.SetStartTimeCode(10)
    mesh = add_ground(stage, "/World/Ground", Units(), size=1.0)
    op = mesh.AddTranslateOp()
    op.Set(Gf.Vec3d(0, 2, 0), 10)
    op.Set(Gf.Vec3d(0, 9, 0), 20)
    terrain, _ = read(stage)
    assert_allclose(terrain.points[:, 1], 2.0)


@pytest.mark.parametrize("left_handed", [True, False])
@pytest.mark.parametrize("mirrored", [True, False])
def test_orientation_and_mirrors_are_honoured(left_handed, mirrored):
    stage = new_stage()
    faces = [(3, 2, 1, 0)] if left_handed else [(0, 1, 2, 3)]
    mesh = add_mesh(stage, "/World/Ground", SQUARE, faces, Units(), terrain=True)
    if left_handed:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    if mirrored:
        mesh.AddScaleOp().Set(Gf.Vec3f(-1.0, 1.0, 1.0))
    terrain, _ = read(stage)
    assert np.all(normals(terrain)[:, 1] > 0.0)


def test_holes_and_faces_without_area_are_left_out():
    points = [*SQUARE, (3, 0, -1), (3, 0, 1)]
    stage = new_stage()
    mesh = add_mesh(
        stage, "/World/Ground", points, [(0, 1, 2, 3), (3, 2, 5, 4), (0, 0, 1), (0, 3, 4)], Units(), terrain=True
    )
    mesh.CreateHoleIndicesAttr([1])
    terrain, problems = read(stage)
    assert area(terrain) == pytest.approx(4.0)
    assert len(terrain.triangles) == 2
    assert problems == ()


@pytest.mark.parametrize("moving", ["points", "transform", "nothing"])
def test_terrain_that_moves_is_said(moving):
    stage = new_stage()
    mesh = add_ground(stage, "/World/Set/Ground", Units())
    lift = UsdGeom.Xform.Define(stage, "/World/Set").AddTranslateOp()
    points = np.array(mesh.GetPointsAttr().Get())
    for code in (0.0, 10.0):
        lift.Set(Gf.Vec3d(0.0, code * (moving == "transform"), 0.0), code)
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points + np.float32(code * (moving == "points"))), code)
    terrain, problems = read(stage)
    assert_allclose(terrain.points[:, 1], 0.0)
    said = "/World/Set/Ground: is terrain that moves, feet keep to where it is at the stage's start. "
    assert [problem.message.startswith(said) for problem in problems] == [True] * (moving != "nothing")


def test_instances_are_separate_meshes(tmp_path):
    source = new_stage()
    add_ground(source, "/World/Stone", Units(), size=0.5)
    source.GetRootLayer().Export(str(tmp_path / "stone.usda"))
    stage = new_stage()
    for i in range(2):
        prim = UsdGeom.Xform.Define(stage, f"/World/S{i}")
        prim.GetPrim().GetReferences().AddReference(str(tmp_path / "stone.usda"), "/World")
        prim.GetPrim().SetInstanceable(True)
        prim.AddTranslateOp().Set(Gf.Vec3d(3.0 * i, 0, 0))
    terrain, _ = read(stage)
    assert terrain.meshes == ("/World/S0/Stone", "/World/S1/Stone")
    assert_allclose(terrain.points[4:, 0].mean(), 3.0)


@pytest.mark.parametrize("is_instance", [False, True])
def test_instances_are_the_terrain_that_copies_are(tmp_path, is_instance):
    """Read as one mesh in several places: each with its own transform and word on whether it can be walked on."""
    source = new_stage()
    add_ground(source, "/World/Part/Stone", Units(), size=0.5)
    source.GetRootLayer().Export(str(tmp_path / "stone.usda"))
    stage = new_stage()
    turned = np.array(Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 1, 0), 30.0)))
    placed = {"A": turned, "B": np.diag([-1.0, 1.0, 1.0, 1.0]), "C": np.eye(4), "D": np.diag([np.nan, 1.0, 1.0, 1.0])}
    for row, (name, matrix) in enumerate(placed.items()):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}")
        prim.GetPrim().GetReferences().AddReference(str(tmp_path / "stone.usda"), "/World")
        prim.GetPrim().SetInstanceable(is_instance)
        matrix = matrix.copy()
        matrix[3, 0] = 3.0 * row
        prim.AddTransformOp().Set(Gf.Matrix4d(matrix))
    marked = stage.GetPrimAtPath("/World/C")
    marked.CreateAttribute(Token.WALKABLE, Sdf.ValueTypeNames.Bool, False).Set(False)
    terrain, problems = read(stage)
    found = {}
    for index, path in enumerate(terrain.meshes):
        own = terrain.triangles[terrain.mesh_indices == index]
        found[path] = terrain.points[own].mean(axis=(0, 1))[0], bool(terrain.walkable[index])
        assert (np.cross(*np.diff(terrain.points[own], axis=1).swapaxes(0, 1))[:, 1] > 0.0).all()
    assert list(found) == [f"/World/{name}/Part/Stone" for name in "ABC"]
    assert_allclose([place for place, _ in found.values()], [0.0, 3.0, 6.0], atol=1e-6)
    assert [is_walkable for _, is_walkable in found.values()] == [True, True, False]
    assert [problem.where for problem in problems] == ["/World/D/Part/Stone"]


def test_faces_whose_points_are_not_finite_are_left_out_with_a_warning():
    stage = new_stage()
    points = [(x, 0.0, z) for x in (0.0, 1.0, 2.0) for z in (0.0, 1.0)] + [(np.nan, 0.0, 0.0)]
    points[4] = (np.inf, 0.0, 0.0)
    add_mesh(stage, "/World/Ground", points, [(0, 1, 3, 2), (2, 3, 5, 4)], Units(), terrain=True)
    terrain, (problem,) = read(stage)
    assert problem.severity == "warning"
    assert problem.message.startswith("/World/Ground: 1 of its faces have points that are not finite and are left out")
    assert np.isfinite(terrain.points).all() and terrain.points[:, 0].max() == 2.0
    assert len(terrain.triangles) == 2 and terrain.points[terrain.triangles, 0].max() == 1.0


@pytest.mark.parametrize(
    ("points", "faces", "message"),
    [
        ([], [], r"/World/Ground: is an empty mesh \(0 points, 0 faces\). give the mesh points and faces"),
        (SQUARE, [], r"/World/Ground: is an empty mesh \(4 points, 0 faces\)"),
        (SQUARE, [(0, 1, 9)], "/World/Ground: has faces that do not match its points"),
        (SQUARE, [(0, 0, 1), (2, 2, 2)], "/World/Ground: has only faces without area"),
        ([(0, 0, 0), (0, np.nan, 1), (1, 0, 0)], [(0, 1, 2)], "/World/Ground: has points that are not finite"),
    ],
)
def test_a_bad_mesh_becomes_a_problem_and_the_rest_goes_on(points, faces, message):
    stage = new_stage()
    add_mesh(stage, "/World/Ground", points, faces, Units(), terrain=True)
    add_ground(stage, "/World/Other", Units())
    terrain, problems = read(stage)
    assert terrain.meshes == ("/World/Other",)
    assert [problem.severity for problem in problems] == ["error"]
    with pytest.raises(AssertionError, match=message):
        raise AssertionError(problems[0].message)


def test_the_schema_without_a_mesh_is_a_problem():
    stage = new_stage()
    UsdGeom.Sphere.Define(stage, "/World/Box").GetPrim().AddAppliedSchema(Schema.TERRAIN)
    _, problems = read(stage)
    assert "/World/Box: has UsdfootTerrainAPI but no mesh, cube or plane at or below it" in problems[0].message


@pytest.mark.parametrize("units", [Units(), Units(0.01, "Z"), Units(0.0254, "Y")])
def test_a_marked_cube_and_plane_are_their_faces_seen_from_outside(units):
    stage = new_stage(None, units)
    cube = UsdGeom.Cube.Define(stage, "/World/Set/Box")
    cube.CreateSizeAttr(2.0 / units.meters)
    UsdGeom.Xformable(cube).AddTranslateOp().Set(Gf.Vec3d(*map(float, units.points([5.0, 1.0, 0.0]))))
    plane = UsdGeom.Plane.Define(stage, "/World/Set/Lawn")
    plane.CreateAxisAttr(units.up)
    plane.CreateWidthAttr(4.0 / units.meters)
    plane.CreateLengthAttr(6.0 / units.meters)
    stage.GetPrimAtPath("/World/Set").AddAppliedSchema(Schema.TERRAIN)
    terrain, problems = read(stage)
    assert terrain.meshes == ("/World/Set/Box", "/World/Set/Lawn") and problems == () and len(terrain.triangles) == 14
    assert area(terrain) == pytest.approx(24.0 + 24.0, rel=1e-6)
    box, lawn = (terrain.points[terrain.triangles[terrain.mesh_indices == i]] for i in range(2))
    outward = np.cross(box[:, 1] - box[:, 0], box[:, 2] - box[:, 0])
    assert np.all(np.sum(outward * (box.mean(axis=1) - [5.0, 1.0, 0.0]), axis=1) > 0.0)
    assert np.all(normals(terrain)[terrain.mesh_indices == 1][:, 1] > 0.0)
    assert_allclose(np.ptp(box.reshape(-1, 3), axis=0), 2.0, rtol=1e-6)
    expected = stage.GetPrimAtPath("/World/Set/Lawn")
    extent = np.array(UsdGeom.Plane(expected).ComputeExtentFromPlugins(UsdGeom.Boundable(expected), Usd.TimeCode(0)))
    reach = np.ptp(read_stage_info(stage).units.points_to_canonical(extent), axis=0)
    assert_allclose(np.ptp(lawn.reshape(-1, 3), axis=0), np.abs(reach), atol=1e-6)


def polygon_area(points):
    x, z = np.asarray(points)[:, 0], np.asarray(points)[:, 2]
    return 0.5 * abs(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1)))


@pytest.mark.parametrize(
    "polygon",
    [
        [(0, 0, 0), (2, 0, 0), (0.2, 0, 0.2), (0, 0, 2)],
        [(0, 0, 0), (3, 0, 0), (3, 0, 3), (2, 0, 1), (1, 0, 3), (0, 0, 3)],
        [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 0, 1), (1, 0, 1), (0, 0, 1)],
        [(0, 0, 0), (4, 0, 0), (4, 0, 4), (3, 0, 4), (3, 0, 1), (1, 0, 1), (1, 0, 4), (0, 0, 4)],
    ],
)
@pytest.mark.parametrize("turns", [0, 1, 2])
@pytest.mark.parametrize("reverse", [False, True])
def test_concave_polygons_keep_their_area_and_winding(polygon, turns, reverse):
    corners = polygon[::-1] if reverse else polygon
    points = np.roll(np.array(corners, dtype=float), turns, axis=1)
    count = len(points)
    triangles = cut_polygons(points, np.array([count]), np.arange(count), holes=np.zeros(0, dtype=int))
    assert len(triangles) == count - 2
    a, b, c = (points[triangles[:, i]] for i in range(3))
    crosses = 0.5 * np.cross(b - a, c - a)
    axis = (1 + turns) % 3
    assert np.all(crosses[:, axis] >= -1e-12) or np.all(crosses[:, axis] <= 1e-12)
    assert abs(crosses[:, axis].sum()) == pytest.approx(polygon_area(polygon))
    assert (crosses[:, axis].sum() > 0) == reverse


@pytest.mark.parametrize(
    ("name", "size", "height"),
    [("straight_stairs", 2.0, 0.6), ("slope", 2.0, 0.2), ("jacksboro_hills", 20.0, 3.0)],
)
def test_the_real_terrains_are_read(shared_data, name, size, height):
    stage = Usd.Stage.Open(str(shared_data / "terrain" / f"{name}.usdc"))
    terrain, problems = read(stage)
    assert problems == ()
    assert_allclose(np.ptp(terrain.points, axis=0), (size, height, size), rtol=0.05)
    assert np.all(normals(terrain)[:, 1] > 0.0)


def test_a_skinned_mesh_by_inheritance_is_no_terrain():
    stage = new_stage()
    skeleton = add_character(stage, "/World/Hero", Units())
    group = UsdGeom.Xform.Define(stage, "/World/Hero/Geometry")
    UsdSkel.BindingAPI.Apply(group.GetPrim()).CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    add_mesh(stage, "/World/Hero/Geometry/Ground", SQUARE, [(0, 1, 2, 3)], Units())
    assert read(stage)[0].meshes == ()


@pytest.mark.parametrize("units", [Units(), Units(0.01, "Z")])
def test_each_instance_of_a_point_instancer_is_a_mesh_of_its_own(units):
    stage = new_stage(None, units)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Stones")
    stage.OverridePrim("/Library")
    paths = ["/World/Stones/Low/Top", "/Library/High/Top"]
    for path in paths:
        UsdGeom.Xform.Define(stage, path.rsplit("/", 1)[0])
        add_mesh(stage, path, SQUARE, [(0, 1, 2, 3)], units)
    lifted = UsdGeom.Xformable(stage.GetPrimAtPath("/Library/High")).AddTranslateOp()
    lifted.Set(Gf.Vec3d(*units.points((0.0, 0.5, 0.0)).tolist()))
    UsdGeom.Xformable(instancer).AddTranslateOp().Set(Gf.Vec3d(*units.points((0.0, 0.25, 0.0)).tolist()))
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(path).GetParentPath() for path in paths])
    instancer.CreateProtoIndicesAttr([0, 1, 0, 1, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(*place) for place in units.points([(3.0 * i, 0.0, i) for i in range(5)])])
    instancer.CreateScalesAttr([(2, 2, 2), (1, 1, 1), (-1, 1, 1), (1, 1, 1), (0, 0, 0)])
    instancer.CreateIdsAttr([7, 8, 9, 10, 11])
    instancer.CreateInvisibleIdsAttr([10])
    assert read(stage)[0].meshes == (), "unmarked it is none"
    instancer.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    instancer.GetPrim().CreateAttribute(Token.WALKABLE, Sdf.ValueTypeNames.Bool, False).Set(False)
    stage.GetPrimAtPath("/Library/High").CreateAttribute(Token.WALKABLE, Sdf.ValueTypeNames.Bool, False).Set(True)
    terrain, problems = read(stage)
    assert problems == () and terrain.meshes == ("/World/Stones",) * 3
    assert_array_equal(terrain.walkable, [False, False, True])
    middles = [terrain.points[terrain.triangles[terrain.mesh_indices == i]].mean(axis=(0, 1)) for i in range(3)]
    flat = [np.delete(terrain.points[4 * i : 4 * i + 4], 1, axis=1).mean(axis=0) for i in range(3)]
    assert_allclose(flat, [(0.0, 0.0), (6.0, 2.0), (3.0, 1.0)], atol=1e-5)
    assert_allclose([middle[1] for middle in middles], [0.25, 0.25, 0.75], atol=1e-6)
    assert area(terrain) == pytest.approx(16.0 + 4.0 + 4.0, rel=1e-5)
    assert np.all(normals(terrain)[:, 1] > 0.0)


@pytest.mark.parametrize(
    ("kinds", "places", "message"),
    [
        ([0, 1], 2, "/World/Stones: names prototypes that do not exist"),
        ([0, 0], 1, "/World/Stones: has not as many positions as protoIndices"),
        ([], 0, "/World/Stones: shows no mesh of its prototypes"),
    ],
)
def test_a_broken_instancer_becomes_a_problem(kinds, places, message):
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Stones")
    add_mesh(stage, "/World/Stones/Stone", SQUARE, [(0, 1, 2, 3)], Units())
    instancer.CreatePrototypesRel().SetTargets(["/World/Stones/Stone"])
    instancer.CreateProtoIndicesAttr(kinds)
    instancer.CreatePositionsAttr([(0, 0, 0)] * places)
    instancer.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == () and problem.message.startswith(message)


@pytest.mark.parametrize(
    ("name", "kind", "values", "message"),
    [
        ("orientations", "quath[]", [Gf.Quath(1)], "orientations has 1 entries for 2 instances. author one for each"),
        ("scales", "float3[]", [(2, 2, 2)] * 3, "scales has 3 entries for 2 instances. author one for each"),
        ("orientationsf", "quatf[]", [Gf.Quatf(1)] * 3, "orientationsf has 3 entries"),
        (
            "orientations",
            "quatf[]",
            [Gf.Quatf(0, 1, 0, 0)] * 2,
            "orientations is of type quatf[]. author it as quath[]",
        ),
        ("scales", "string[]", ["2", "2"], "scales is of type string[]. author it as float3[]"),
        ("positions", "double3[]", [(0, 0, 0)] * 2, "positions is of type double3[]. author it as point3f[]"),
    ],
)
def test_an_instancer_whose_arrays_usd_would_misread_becomes_a_problem(name, kind, values, message):
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Stones")
    add_mesh(stage, "/World/Stones/Stone", SQUARE, [(0, 1, 2, 3)], Units())
    instancer.CreatePrototypesRel().SetTargets(["/World/Stones/Stone"])
    instancer.CreateProtoIndicesAttr([0, 0])
    if name != "positions":
        instancer.CreatePositionsAttr([(0, 0, 0), (5, 0, 0)])
    spec = stage.GetRootLayer().GetPrimAtPath("/World/Stones")
    Sdf.AttributeSpec(spec, name, Sdf.ValueTypeNames.Find(kind)).default = values
    instancer.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == () and problem.message.startswith(f"/World/Stones: {message}")
    assert (problem.severity, problem.where) == ("error", "/World/Stones")


@pytest.mark.parametrize(("shape", "name"), [("Cube", "size"), ("Plane", "width"), ("Plane", "length")])
def test_a_solid_of_negative_size_becomes_a_problem(shape, name):
    stage = new_stage()
    prim = stage.DefinePrim("/World/Block", shape)
    prim.AddAppliedSchema(Schema.TERRAIN)
    prim.GetAttribute(name).Set(-2.0)
    terrain, (problem,) = read(stage)
    assert terrain.meshes == ()
    assert problem.message == f"/World/Block: {name} is -2. author a number above 0"


@pytest.mark.parametrize("inside", [True, False], ids=["prototypes below", "prototypes elsewhere"])
def test_what_instancers_of_instancers_scatter_is_where_usd_puts_it(inside):
    """Heaps of stones, each scaled and turned: as USD's own bounds, and by hand."""
    stage = new_stage()
    top = "/World/Stones" if inside else "/World/Library"
    heap = f"{top}/Group/Heap"
    UsdGeom.Xform.Define(stage, f"{top}/Group").AddTranslateOp().Set((0.0, 0.0, 0.5))
    stones = UsdGeom.PointInstancer.Define(stage, "/World/Stones")
    stones.AddTranslateOp().Set((100.0, 0.0, 0.0))
    stones.CreatePrototypesRel().SetTargets([f"{top}/Group"])
    stones.CreateProtoIndicesAttr([0, 0])
    stones.CreatePositionsAttr([(0, 0, 0), (0, 0, 40)])
    stones.CreateScalesAttr([(1, 1, 1), (2, 2, 2)])
    heaps = UsdGeom.PointInstancer.Define(stage, heap)
    heaps.AddTranslateOp().Set((0.0, 1.0, 0.0))
    heaps.CreatePrototypesRel().SetTargets([f"{heap}/Stone"])
    heaps.CreateProtoIndicesAttr([0, 0, 0])
    heaps.CreatePositionsAttr([(0, 0, 0), (10, 0, 0), (20, 0, 0)])
    heaps.CreateInvisibleIdsAttr([2])
    add_mesh(stage, f"{heap}/Stone", SQUARE, [(0, 1, 2, 3)], Units())
    stones.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    terrain, problems = read(stage)
    assert problems == () and terrain.meshes == ("/World/Stones",) * 4
    middles = terrain.points.reshape(4, 4, 3).mean(axis=1)
    assert_allclose(middles, [(100, 1, 0.5), (110, 1, 0.5), (100, 2, 41), (120, 2, 41)], atol=1e-5)
    assert area(terrain) == pytest.approx(2 * 4.0 + 2 * 16.0, rel=1e-6)
    bounds = UsdGeom.BBoxCache(0, [UsdGeom.Tokens.default_]).ComputeWorldBound(stones.GetPrim()).ComputeAlignedRange()
    assert_allclose(terrain.points.max(axis=0), bounds.GetMax(), atol=1e-5)


def test_an_instancer_that_scatters_itself_becomes_a_problem():
    stage = new_stage()
    for path, prototype in pairwise(["/World/Stones", "/World/Heap", "/World/Stones"]):
        instancer = UsdGeom.PointInstancer.Define(stage, path)
        instancer.CreatePrototypesRel().SetTargets([prototype])
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr([(0, 0, 0)])
    stage.GetPrimAtPath("/World/Stones").AddAppliedSchema(Schema.TERRAIN)
    (problem,) = read(stage)[1]
    assert problem.message.startswith("/World/Heap: scatters /World/Stones and so itself. ")


@pytest.mark.parametrize("broken", ["/World/Stones/Heap", "/World/Stones/Heap/Stone"])
def test_a_prototype_that_usd_cannot_place_becomes_a_problem(broken):
    stage = new_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Stones")
    UsdGeom.Xform.Define(stage, "/World/Stones/Heap")
    add_mesh(stage, "/World/Stones/Heap/Stone", SQUARE, [(0, 1, 2, 3)], Units())
    instancer.CreatePrototypesRel().SetTargets(["/World/Stones/Heap"])
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr([(0, 0, 0)])
    instancer.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    Sdf.AttributeSpec(
        stage.GetRootLayer().GetPrimAtPath(broken), "xformOp:translate", Sdf.ValueTypeNames.String
    ).default = "up"
    UsdGeom.Xformable(stage.GetPrimAtPath(broken)).GetXformOpOrderAttr().Set(["xformOp:translate"])
    (problem,) = read(stage)[1]
    assert problem.message == f"{broken}: xformOp:translate is of type string. author it as double3"
