"""A hostile file ends in an error that names it, not in an exhausted machine."""

import socket
import threading
from contextlib import suppress

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from tests.scenes import simple_scene
from usdfoot.bridge.tokens import File
from usdfoot.bridge.units import StageUnits
from usdfoot.cli.main import main
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.limits import Limits
from usdfoot.readers.overrides import read_overrides
from usdfoot.readers.samples import regular_codes
from usdfoot.readers.scene import SceneReader

ARTISTS_PLAN = """#usda 1.0
def "Crowd"
{
def "Plans"
{
    def PointInstancer "Hero" (prepend apiSchemas = ["UsdfootPlanAPI"])
    {
        int[] protoIndices = [0, 1, 0]
        point3f[] positions = [(0.1, 0, 0), (-0.1, 0, 0.6), (0.1, 0, 1.2)]
        uniform timecode[] usdfoot:plan:strikeTimes = [0, 12, 24]
        uniform timecode[] usdfoot:plan:liftoffTimes = [16, 28, 40]
    }
}
}
"""


def test_limits_name_what_there_is_too_much_of():
    stage = simple_scene()
    SceneReader(stage, limits=Limits())
    skeleton = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    joints = len(UsdSkel.Skeleton(skeleton).GetJointsAttr().Get())
    with pytest.raises(SceneError, match=f"{skeleton.GetPath()}: has {joints} joints, more than 3.*--max-joints"):
        SceneReader(stage, limits=Limits(joints=3))
    with pytest.raises(SceneError, match=r"frames, more than 5.*--max-frames"):
        SceneReader(stage, limits=Limits(frames=5))
    with pytest.raises(SceneError, match=r"has 101 frames, more than 100"):
        SceneReader(stage, frames=(0, 100), limits=Limits(frames=100))


def test_a_plan_of_too_many_footsteps_is_left_out_by_name(tmp_path, capsys):
    stage = simple_scene()
    plan = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointInstancer))
    count = len(plan.GetAttribute("protoIndices").Get())
    with pytest.raises(SceneError, match=f"{plan.GetPath()}: has {count} footsteps, more than 3.*--max-footsteps"):
        SceneReader(stage, limits=Limits(footsteps=3)).read()
    SceneReader(stage, limits=Limits(footsteps=count)).read()
    stage.Export(str(tmp_path / "scene.usda"))
    flags = ["-o", str(tmp_path / "out"), "-q", "--workers", "1", "--max-footsteps", "3"]
    assert main(["animate", str(tmp_path / "scene.usda"), *flags]) == 2
    assert "footsteps, more than 3" in capsys.readouterr().err


def test_too_many_triangles_are_refused_before_they_are_read():
    stage = simple_scene()
    mesh = UsdGeom.Mesh.Define(stage, "/World/ground_more")
    mesh.GetPrim().AddAppliedSchema("UsdfootTerrainAPI")
    mesh.CreateFaceVertexCountsAttr([4] * 10)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3] * 10)
    mesh.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0)])
    with pytest.raises(SceneError, match=r"triangles, more than 10.*--max-triangles"):
        SceneReader(stage, limits=Limits(triangles=10))


def test_faces_without_corners_count_too():
    """They take no room in a file."""
    stage = simple_scene()
    mesh = UsdGeom.Mesh.Define(stage, "/World/ground_more")
    mesh.GetPrim().AddAppliedSchema("UsdfootTerrainAPI")
    mesh.CreateFaceVertexCountsAttr([0] * 1000)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (1, 0, 1)])
    with pytest.raises(SceneError, match=r"/World/ground_more: has 10\d\d triangles, more than 100\. raise"):
        SceneReader(stage, limits=Limits(triangles=100))


def test_faces_of_fewer_than_no_corners_do_not_hide_one_of_billions():
    stage = simple_scene()
    mesh = UsdGeom.Mesh.Define(stage, "/World/ground_more")
    mesh.GetPrim().AddAppliedSchema("UsdfootTerrainAPI")
    mesh.CreateFaceVertexCountsAttr([-2147483644, 2147483647])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreatePointsAttr([(0, 0, 0), (0, 0, 1), (1, 0, 1)])
    (problem,) = SceneReader(stage).read().crowd.problems
    assert problem.message.startswith("/World/ground_more: has faces that do not match its points")


def test_a_plan_that_never_ends_is_refused():
    stage = simple_scene()
    plan = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointInstancer))
    times = plan.GetAttribute("usdfoot:plan:liftoffTimes")
    codes = [float(code) for code in times.Get()]
    times.Set(Sdf.TimeCodeArray([*codes[:-1], 1e12]))
    with pytest.raises(SceneError, match=r"frames, more than 100000"):
        SceneReader(stage)


def test_samples_far_apart_do_not_become_a_grid_without_end():
    with pytest.raises(SceneError, match=r"/Clip: has \d+ frames, more than 100000"):
        regular_codes([np.array([0.0, 1.0, 2.0, 1e9])], 24.0, where="/Clip")


def test_instances_within_instances_are_refused_before_they_are_walked():
    stage = simple_scene()
    for depth in range(1, 12):
        for number in range(10):
            prim = stage.DefinePrim(f"/Level{depth}/Part{number}", "Xform")
            prim.GetReferences().AddInternalReference(f"/Level{depth - 1}" if depth > 1 else "/World/Ground")
            prim.SetInstanceable(True)
    with pytest.raises(SceneError, match=r"has 2001 prims, more than 2000\. raise the limit with --max-prims"):
        SceneReader(stage, limits=Limits(prims=2000))


def test_a_limit_is_at_least_one():
    with pytest.raises(UsdfootError, match="joints: limit is 0"):
        Limits(joints=0)


def test_the_command_line_sets_limits(tmp_path, capsys):
    scene = tmp_path / "scene.usda"
    simple_scene().Export(str(scene))
    assert main(["animate", str(scene), "-o", str(tmp_path / "out"), "-q", "--max-joints", "3"]) == 2
    assert "joints, more than 3" in capsys.readouterr().err
    assert isinstance(Usd.Stage.Open(str(scene)), Usd.Stage) and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("way", "flag"),
    [
        *(("lint", flag) for flag in ("--max-footsteps", "--max-joints", "--max-prims", "--max-triangles")),
        *(("timing", flag) for flag in ("--max-footsteps", "--max-joints", "--max-prims")),
    ],
)
def test_lint_and_timing_have_the_same_limits(way, flag, tmp_path, capsys):
    scene, output = tmp_path / "scene.usda", tmp_path / "timed.usda"
    simple_scene().Export(str(scene))
    arguments = ["plan", way, str(scene), *(["-o", str(output)] if way == "timing" else [])]
    assert main([*arguments, flag, "1"]) == 2
    assert f"{flag.removeprefix('--max-')}, more than 1. raise the limit with {flag}" in capsys.readouterr().err
    assert not output.exists()
    assert main([*arguments, flag, "1000000"]) in (0, 1)


@pytest.mark.parametrize(
    ("verb", "scene", "flags"),
    [
        ("path", "terrain_slope", ("prims", "triangles")),
        ("stones", "river", ("joints", "prims", "triangles")),
        ("wander", "plaza", ("agents", "joints", "prims", "triangles")),
        ("crowd", "plaza", ("agents", "joints", "prims", "triangles")),
        ("trajectories", "trajectories", ("agents", "joints", "prims", "triangles")),
    ],
)
def test_planners_have_the_limits_they_name(verb, scene, flags, tmp_path, capsys, stages):
    output = tmp_path / "plans.usda"
    for what in flags:
        flag = f"--max-{what}"
        assert main(["plan", verb, str(stages / f"{scene}.usda"), "-o", str(output), flag, "1"]) == 2
        assert f"{what}, more than 1. raise the limit with {flag}" in capsys.readouterr().err
        assert not output.exists()


def test_who_checks_a_plan_says_how_many_footsteps_it_may_have(tmp_path, capsys):
    scene = tmp_path / "scene.usda"
    stage = simple_scene()
    plan = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointInstancer))
    count = len(plan.GetAttribute("protoIndices").Get())
    stage.Export(str(scene))
    assert main(["plan", "lint", str(scene), "--max-footsteps", str(count - 1)]) == 2
    assert f"has {count} footsteps, more than {count - 1}" in capsys.readouterr().err
    assert main(["plan", "lint", str(scene), "--max-footsteps", str(count)]) in (0, 1)


def test_plans_that_artists_made_have_the_limits_of_the_run(tmp_path):
    (tmp_path / File.OVERRIDES).write_text(ARTISTS_PLAN)
    units = StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=24.0)
    with pytest.raises(SceneError, match=r"has 3 footsteps, more than 2\. raise the limit with --max-footsteps"):
        read_overrides(tmp_path, units, most_footsteps=2).plan("Hero", lambda name: None)
    changed = read_overrides(tmp_path, units, most_footsteps=3).plan("Hero", lambda name: None)
    assert changed is not None and len(changed.plan) == 3


def test_a_scene_has_nothing_fetched_from_the_network(tmp_path):
    """Asset paths are USD's to resolve, which knows no network unless a studio's own resolver does."""
    asked = []

    def serve():
        with suppress(OSError):
            while True:
                asked.append(server.accept()[0].close())

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=serve, daemon=True).start()
        host = f"http://127.0.0.1:{server.getsockname()[1]}"
        stage = simple_scene()
        hero = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root))
        hero.CreateAttribute("inputs:file", Sdf.ValueTypeNames.Asset).Set(f"{host}/skin.<UDIM>.png")
        hero.GetPayloads().AddPayload(f"{host}/payload.usd", "/Hero")
        stage.GetRootLayer().subLayerPaths.append(f"{host}/layer.usd")
        stage.GetRootLayer().Export(str(tmp_path / "scene.usda"))
        animate_flags = ["-o", str(tmp_path / "out"), "-q", "--collect", "--workers", "1", "--motion", "physics"]
        assert main(["animate", str(tmp_path / "scene.usda"), *animate_flags]) in (0, 1)
        assert main(["animate", f"{host}/scene.usd", *animate_flags]) == 2
    assert asked == []
