"""An agent that artists move in overrides.usda walks where they moved it, however they wrote that, and nobody twice."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.batch.conftest import AGENTS, write_crowd_scene
from tests.batch.edits import edited, remake, strikes
from tests.digests import digests
from usdfoot.bridge.tokens import File
from usdfoot.pipeline.animate import animate
from usdfoot.usdview.footsteps import move_selected
from usdfoot.usdview.selection import Selection

AGENT, PLAN = "/Crowd/Agents/Agent_1", "/Crowd/Plans/Agent_1"


def composed(folder):
    """The crowd as anybody sees it."""
    stage = Usd.Stage.Open(str(folder / File.CROWD))
    stage.Reload()
    return stage


def starts(folder, name="Agent_1"):
    """Where an agent's prim is at its start, as position and heading [degrees]."""
    stage = composed(folder)
    prim = stage.GetPrimAtPath(f"/Crowd/Agents/{name}")
    matrix = np.array(UsdGeom.XformCache(stage.GetStartTimeCode()).GetLocalToWorldTransform(prim))
    return matrix[3, :3], np.degrees(np.arctan2(matrix[2, 0], matrix[2, 2]))


def moved(points, translation=(0.0, 0.0, 0.0), degrees=0.0):
    """Points turned about the origin's vertical, then translated."""
    x, y, z = np.asarray(points).T
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.stack([cosine * x + sine * z, y, cosine * z - sine * x], axis=-1) + translation


def prints(folder, name="Agent_1"):
    """Where the prints of an agent's plan are seen."""
    stage = composed(folder)
    plan = UsdGeom.PointInstancer(stage.GetPrimAtPath(f"/Crowd/Plans/{name}"))
    to_world = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(plan.GetPrim()))
    return np.array(plan.GetPositionsAttr().Get()) @ to_world[:3, :3] + to_world[3, :3]


def before_all(xformable: UsdGeom.Xformable, *ops: UsdGeom.XformOp) -> None:
    """Has ops that were added last come first, which is in the world's directions."""
    own = [op for op in xformable.GetOrderedXformOps() if op not in ops]
    xformable.SetXformOpOrder([*ops, *own])


def shift(agent):
    before_all(agent, agent_op := agent.AddTranslateOp(opSuffix="edit"))
    agent_op.Set(Gf.Vec3d(1.0, 0.25, 2.0))


def turn(agent):
    translate, rotate = agent.AddTranslateOp(opSuffix="edit"), agent.AddRotateXYZOp(opSuffix="edit")
    translate.Set(Gf.Vec3d(1.0, 0.0, 2.0))
    rotate.Set(Gf.Vec3f(0.0, 90.0, 0.0))
    before_all(agent, translate, rotate)


def matrix(agent):
    before_all(agent, op := agent.AddTransformOp(opSuffix="edit1"))
    op.Set(Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 1, 0), 90.0)) * Gf.Matrix4d().SetTranslate((1, 0, 2)))


def keyed_once(agent):
    before_all(agent, op := agent.AddTranslateOp(opSuffix="edit"))
    op.Set(Gf.Vec3d(1.0, 0.25, 2.0), 40.0)


@pytest.mark.parametrize(
    ("move", "translation", "degrees"),
    [(shift, (1, 0.25, 2), 0), (turn, (1, 0, 2), 90), (matrix, (1, 0, 2), 90), (keyed_once, (1, 0.25, 2), 0)],
)
def test_an_agent_moved_in_the_world_walks_its_footsteps_there(shot, move: Callable, translation, degrees):
    scene, folder = shot
    before, first, untouched = strikes(folder, "Agent_1")[0], prints(folder), digests(folder)
    unsaid, (place, heading) = (folder / File.OVERRIDES).read_bytes(), starts(folder)
    with edited(folder) as stage:
        move(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    assert remake(scene, folder).kept == AGENTS - 1
    np.testing.assert_allclose(strikes(folder, "Agent_1")[0], moved(before, translation, degrees), atol=2e-4)
    np.testing.assert_allclose(prints(folder), moved(first, translation, degrees), atol=1e-5)
    now, turned = starts(folder)
    np.testing.assert_allclose(now, moved(place, translation, degrees), atol=1e-5)
    assert (turned - heading - degrees + 180.0) % 360.0 == pytest.approx(180.0, abs=1e-3)
    (folder / File.OVERRIDES).write_bytes(unsaid)
    animate(scene, folder, chunk_size=1)
    assert digests(folder) == untouched


def in_its_own_frame(agent):
    agent.AddTranslateOp(opSuffix="edit").Set(Gf.Vec3d(0.3, 0.0, 0.2))
    agent.AddRotateYOp(opSuffix="edit").Set(30.0)


def far_off_in_its_own_frame(agent):
    """As Houdini appends it."""
    agent.AddTransformOp(opSuffix="edit1").Set(Gf.Matrix4d().SetTranslate((4.0, 0.0, -3.0)))


def translation_replaced(agent):
    agent.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(3.0, 0.1, -2.0))


def all_replaced(agent):
    """As Blender writes it."""
    prim = agent.GetPrim()
    prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(3.0, 0.1, -2.0))
    prim.CreateAttribute("xformOp:rotateXYZ", Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(0.0, -60.0, 0.0))
    prim.CreateAttribute("xformOp:scale", Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(1.0, 1.0, 1.0))
    prim.GetAttribute("xformOpOrder").Set(["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"])


def one_matrix(agent):
    agent.MakeMatrixXform().Set(Gf.Matrix4d().SetTranslate((3, 0.1, -2)))


def pivoted(agent):
    """As Maya turns things, about a pivot."""
    pivot = agent.AddTranslateOp(opSuffix="pivot")
    turned = agent.AddRotateYOp(opSuffix="edit")
    pivot.Set(Gf.Vec3d(0.5, 0.0, 1.0))
    turned.Set(45.0)
    undone = agent.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    before_all(agent, pivot, turned, undone)


@pytest.mark.parametrize(
    "move", [in_its_own_frame, far_off_in_its_own_frame, translation_replaced, all_replaced, one_matrix, pivoted]
)
def test_an_agent_starts_where_artists_placed_it_and_its_footsteps_go_along(shot, move: Callable):
    scene, folder = shot
    first, (place, heading) = prints(folder), starts(folder)
    with edited(folder) as stage:
        move(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    wanted, turned = starts(folder)
    assert remake(scene, folder).kept == AGENTS - 1
    now, heading_now = starts(folder)
    np.testing.assert_allclose(now, wanted, atol=1e-4)
    assert heading_now == pytest.approx(turned, abs=1e-3)
    relative = moved(first - place, wanted, turned - heading)
    np.testing.assert_allclose(prints(folder), relative, atol=1e-3)


def write_z_up(scene, path):
    """The scene in a stage in centimetres with +Z up, so that characters need a stance below their agents' ops."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetTimeCodesPerSecond(Usd.Stage.Open(str(scene)).GetTimeCodesPerSecond())
    world = UsdGeom.Xform.Define(stage, "/Set/World")
    world.GetPrim().GetReferences().AddReference(str(scene), "/World")
    world.AddRotateXOp(opSuffix="up").Set(90.0)
    world.AddScaleOp(opSuffix="up").Set(Gf.Vec3f(100.0, 100.0, 100.0))
    world.SetXformOpOrder([world.GetRotateXOp("up"), world.GetScaleOp("up")])
    stage.Save()
    return path


def turned_below_the_stance(agent):
    agent.AddTranslateOp(opSuffix="edit").Set(Gf.Vec3d(0.5, 0.0, 0.3))  # [m], +Y up, as the character is
    agent.AddRotateYOp(opSuffix="edit").Set(30.0)


def all_replaced_in_centimetres(agent):
    prim = agent.GetPrim()
    prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(300.0, 200.0, 10.0))
    prim.CreateAttribute("xformOp:rotateXYZ", Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(90.0, 0.0, -60.0))
    prim.CreateAttribute("xformOp:scale", Sdf.ValueTypeNames.Float3, False).Set(Gf.Vec3f(100.0, 100.0, 100.0))
    prim.GetAttribute("xformOpOrder").Set(["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"])


@pytest.mark.parametrize("move", [turned_below_the_stance, all_replaced_in_centimetres])
def test_an_agent_whose_character_stands_otherwise_starts_where_artists_placed_it(stages, tmp_path, move: Callable):
    scene, folder = write_z_up(write_crowd_scene(stages, tmp_path / "scene"), tmp_path / "z.usda"), tmp_path / "out"
    animate(scene, folder, chunk_size=1)
    first = prints(folder)
    with edited(folder) as stage:
        move(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    wanted, _ = starts(folder)
    assert remake(scene, folder).kept == AGENTS - 1
    now, _ = starts(folder)
    np.testing.assert_allclose(now, wanted, atol=1e-2)
    assert np.abs(prints(folder) - first).max() > 10.0


def scaled(agent):
    agent.AddScaleOp(opSuffix="edit").Set(Gf.Vec3f(1.2, 1.2, 1.2))


def tilted(agent):
    before_all(agent, op := agent.AddRotateXOp(opSuffix="edit"))
    op.Set(10.0)


def animated(agent):
    before_all(agent, op := agent.AddTranslateOp(opSuffix="edit"))
    op.Set(Gf.Vec3d(0.0, 0.0, 0.0), 10.0)
    op.Set(Gf.Vec3d(1.0, 0.0, 0.0), 60.0)


@pytest.mark.parametrize(
    ("move", "reason"),
    [
        (scaled, "its transform scales it"),
        (tilted, "its transform tilts it"),
        (animated, "xformOp:translate:edit is animated"),
    ],
)
def test_a_transform_that_no_feet_can_follow_is_named_and_changes_nothing(shot, move: Callable, reason):
    scene, folder = shot
    untouched = digests(folder)
    with edited(folder) as stage:
        move(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    report = animate(scene, folder, chunk_size=1)
    assert report.kept == AGENTS
    said = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    assert len(said) == 1 and said[0].startswith(f"overrides.usda {AGENT}: {reason}")
    assert "off its footsteps" in said[0]
    after = digests(folder)
    assert {name for name in after if after[name] != untouched[name]} == {File.OVERRIDES, File.CROWD, File.REPORT}


def test_a_plan_of_an_agent_that_is_moved_is_edited_in_usdview_too(shot):
    scene, folder = shot
    with edited(folder) as stage:
        turn(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    remake(scene, folder)
    first = prints(folder)
    stage = Usd.Stage.Open(str(folder / File.CROWD))
    stage.Reload()
    move_selected(
        stage,
        Selection(paths=(Sdf.Path(PLAN),), instances={Sdf.Path(PLAN): frozenset({4})}),
        Usd.TimeCode(0),
        ahead=0.05,
        left=0.0,
    )
    change = prints(folder) - first
    assert np.linalg.norm(change, axis=1) == pytest.approx([0.05 * (row == 4) for row in range(len(first))], abs=1e-4)


def test_footsteps_edited_after_the_agent_was_moved_are_not_moved_twice(shot):
    scene, folder = shot
    first = prints(folder)
    with edited(folder) as stage:
        turn(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
    remake(scene, folder)
    with edited(folder) as stage:
        positions = stage.GetPrimAtPath(PLAN).GetAttribute("positions")
        points = np.array(positions.Get())
        points[4, 0] += 0.05
        positions.Set(points)
    seen = prints(folder)
    remake(scene, folder)
    np.testing.assert_allclose(prints(folder), seen, atol=1e-5)
    first[4, 0] += 0.05
    np.testing.assert_allclose(seen, moved(first, (1, 0, 2), 90), atol=1e-5)


@pytest.mark.parametrize("first", [AGENT, PLAN])
def test_a_plan_that_is_moved_itself_is_walked_where_it_is_seen(shot, first):
    """Moved with the agent, at once or before it, it alone counts; moved after it, both do."""
    scene, folder = shot
    before = prints(folder)
    with edited(folder) as stage:
        UsdGeom.Xformable(stage.GetPrimAtPath(first)).AddTranslateOp(opSuffix="edit").Set((0.0, 0.0, 1.0))
    remake(scene, folder)
    one = prints(folder)
    with edited(folder) as stage:
        second = UsdGeom.Xformable(stage.GetPrimAtPath(AGENT if first == PLAN else PLAN))
        second.AddTranslateOp(opSuffix="edit").Set((0.0, 0.0, 1.0))
    seen = prints(folder)
    report = remake(scene, folder)
    np.testing.assert_allclose(prints(folder), seen, atol=1e-4)
    assert np.abs(one - before).max() > 0.5
    said = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    text = f"overrides.usda {AGENT}: its transform is not followed, since {PLAN} has a place of its own. move that"
    assert said == ([text] if first == PLAN else [])


def test_a_plan_given_to_another_agent_is_walked_where_it_lies(shot):
    scene, folder = shot
    with edited(folder) as stage:
        turn(UsdGeom.Xformable(stage.GetPrimAtPath(AGENT)))
        other = stage.GetPrimAtPath("/Crowd/Agents/Agent_0")
        other.GetRelationship("usdfoot:agent:plan").SetTargets([PLAN])
        shift(UsdGeom.Xformable(other))
    report = remake(scene, folder)
    for ours, theirs in zip(strikes(folder, "Agent_0"), strikes(folder, "Agent_1"), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-4)
    [said] = [problem.message for problem in report.problems if problem.where.startswith("overrides.usda")]
    assert said.startswith("overrides.usda /Crowd/Agents/Agent_0: its transform is not followed")


@pytest.mark.parametrize("move", [turn, all_replaced])
def test_an_agent_on_a_trajectory_takes_it_along(stages, tmp_path, move: Callable):
    scene, folder = write_crowd_scene(stages, tmp_path / "scene"), tmp_path / "out"
    stage = Usd.Stage.Open(str(scene))
    translate = UsdGeom.Xform.Define(stage, "/World/Way").AddTranslateOp()
    for code in range(0, 151, 5):
        translate.Set(Gf.Vec3d(3.0, 0.0, 1.1 * code / stage.GetTimeCodesPerSecond()), code)
    agent = stage.GetPrimAtPath("/World/Crowd/Agent_1")
    agent.GetRelationship("usdfoot:agent:plan").ClearTargets(True)
    agent.CreateRelationship("usdfoot:agent:trajectory", custom=False).SetTargets(["/World/Way"])
    stage.Save()
    animate(scene, folder, chunk_size=1)
    first = prints(folder)
    with edited(folder) as crowd:
        move(UsdGeom.Xformable(crowd.GetPrimAtPath(AGENT)))
    remake(scene, folder)
    found = prints(folder)
    distances = [np.linalg.norm(np.diff(points, axis=0), axis=1) for points in (first, found)]
    np.testing.assert_allclose(distances[1], distances[0], atol=2e-3)
    with edited(folder) as crowd:
        times = crowd.GetPrimAtPath(PLAN).GetAttribute("usdfoot:plan:strikeTimes")
        times.Set(times.Get())
    remake(scene, folder)
    np.testing.assert_allclose(prints(folder), found, atol=1e-4)  # kept as they were found, and not moved again
