"""Scenes of which not all can be used: what is said of it, and that the rest goes on."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt

from tests.scenes import (
    JOINTS,
    Units,
    add_agent,
    add_character,
    add_clip,
    add_mesh,
    add_plan,
    crowd_stage,
    messages,
    new_stage,
    simple_scene,
    walk_pose,
)
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Plan
from usdfoot.errors import SceneError
from usdfoot.readers.scene import read_scene

TIMES = np.arange(0.0, 1.0, 1.0 / 30.0)
_TOKEN, _FLOAT = Sdf.ValueTypeNames.Token, Sdf.ValueTypeNames.Float


def test_one_bad_agent_is_reported_and_the_others_go_on(tmp_path):
    stage = crowd_stage(tmp_path)
    times = stage.GetPrimAtPath("/World/Plans/P1").GetAttribute(Plan.STRIKE_TIMES)
    times.Set(Sdf.TimeCodeArray([Sdf.TimeCode(0)] * 2))
    scene = read_scene(stage)
    assert [agent.name for agent in scene.crowd.agents] == ["Walker", "Walker_2"]
    (message,) = messages(scene)
    assert message.startswith("/World/Group1/Walker: /World/Plans/P1: arrays differ in length")


def test_a_plan_nobody_walks_is_a_warning():
    stage = simple_scene()
    add_plan(stage, "/World/Plans/Spare", Units(), yaws=np.zeros(6))
    scene = read_scene(stage)
    assert len(scene.crowd.agents) == 1
    assert messages(scene, "warning") == [
        "/World/Plans/Spare: no agent walks this plan. point an agent's usdfoot:agent:plan at it"
    ]


def test_agents_whose_path_is_no_curve_are_named(tmp_path):
    stage = crowd_stage(tmp_path)
    prim = stage.GetPrimAtPath("/World/Group0/Walker")
    prim.RemoveProperty(Token.PLAN)
    UsdGeom.Xform.Define(stage, "/World/Way")
    add_agent(stage, "/World/Group0/Walker", path="/World/Way")
    scene = read_scene(stage)
    assert len(scene.crowd.agents) == 2
    (message,) = messages(scene)
    assert message.startswith(
        "/World/Group0/Walker: /World/Way: is Xform. a path is a BasisCurves or HermiteCurves prim"
    )


def authored(name, kind, value):
    return lambda prim: prim.CreateAttribute(name, kind, False).Set(value)


def pointed(name, target):
    return lambda prim: prim.GetRelationship(name).SetTargets([target])


def mute_plan(prim):
    (plan,) = prim.GetRelationship(Token.PLAN).GetTargets()
    prim.GetStage().GetPrimAtPath(plan).SetActive(False)


def author_text(prim):
    layer, path = prim.GetStage().GetRootLayer(), prim.GetPath().AppendProperty(Token.ROOT_WEIGHT)
    Sdf.JustCreatePrimAttributeInLayer(layer, path, Sdf.ValueTypeNames.String)
    layer.GetAttributeAtPath(path).default = "1"


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (authored(Token.MOTION, _TOKEN, "fly"), "agent:motion is fly. author one of clips, physics, hybrid"),
        (authored(Token.IK_REACH, _FLOAT, -1.0), "agent:ikReach is -1. author a number of at least 0"),
        (authored(Token.ROOT_WEIGHT, _FLOAT, 2.0), "agent:rootWeight is 2. author a number between 0 and 1"),
        (author_text, "/World/Hero: usdfoot:agent:rootWeight is of type string. author it"),
        (authored(Token.CROUCH, _FLOAT, 0.75), "/World/Hero: usdfoot:agent:crouch is 0.75. -0.2 to 0.6 is possible"),
        (authored(Token.GRAVITY, _FLOAT, 0.0), "usdfoot:agent:gravity is 0. a positive number is possible"),
        (pointed(Token.PLAN, "/Nowhere"), "agent:plan points at what does not exist: /Nowhere"),
        (mute_plan, "/World/Hero: usdfoot:agent:plan points at what is inactive: /World/Plan"),
        (pointed(Token.PLAN, "/World/Clips"), "/World/Clips: is an untyped prim. a footstep plan is a PointInstancer"),
        (pointed(Token.CLIPS, "/World/Plans"), "/World/Plans: has no clips"),
    ],
)
def test_an_agent_that_cannot_be_used_is_the_scene_s_error_if_it_is_the_only_one(spoil, message):
    stage = simple_scene()
    spoil(stage.GetPrimAtPath("/World/Hero"))
    with pytest.raises(SceneError, match="no agent can be used") as caught:
        read_scene(stage)
    assert message in str(caught.value)


def test_no_clips():
    stage = simple_scene(schemas=False)
    stage.RemovePrim("/World/Clips")
    with pytest.raises(SceneError, match=r"the stage: has no clips \(SkelAnimation prims\). add some"):
        read_scene(stage)


def test_no_character():
    stage = simple_scene(schemas=False)
    stage.RemovePrim("/World/Hero")
    with pytest.raises(SceneError, match=r"has no Skeleton with joints. add a character"):
        read_scene(stage)


def test_no_plan():
    stage = simple_scene(schemas=False)
    stage.RemovePrim("/World/Plans")
    with pytest.raises(SceneError, match=r"has no footstep plan. add a PointInstancer with UsdfootPlanAPI"):
        read_scene(stage)


def test_no_biped():
    stage = new_stage()
    names = [f"j{i}" for i in range(3)]
    add_character(stage, "/World/Hero", Units(), joints=names, offsets=np.eye(3), with_body=True)
    add_plan(stage, "/World/Plan", Units(), yaws=np.zeros(6))
    with pytest.raises(SceneError, match="no joint found for the role") as caught:
        read_scene(stage)
    assert "uniform token usdfoot:biped:left:hip" in str(caught.value)


def test_joints_that_do_not_match():
    stage = simple_scene()
    stage.GetPrimAtPath("/World/Hero").RemoveProperty(Token.CLIPS)
    names = [f"other{i}" for i in range(len(JOINTS))]
    stage.RemovePrim("/World/Clips")
    add_clip(stage, "/World/Clips/alien", Units(), TIMES, *walk_pose(TIMES), joints=names)
    with pytest.raises(
        SceneError, match=r"none of 1 clip\(s\) fits /World/Hero/Skeleton: /World/Clips/alien"
    ) as caught:
        read_scene(stage)
    assert "usdfoot retarget" in str(caught.value)
    add_agent(stage, "/World/Hero", clips="/World/Clips")
    with pytest.raises(
        SceneError, match="/World/Clips/alien: does not move the leg joints of /World/Hero/Skeleton"
    ) as caught:
        read_scene(stage)
    assert "usdfoot retarget" in str(caught.value)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda clip: clip.GetJointsAttr().Set([*JOINTS[:-1], JOINTS[0]]), f"lists joints twice: {JOINTS[0]}"),
        (
            lambda clip: [clip.GetRotationsAttr().Set([Gf.Quatf(1)] * 7, code) for code in clip_codes(clip)],
            f"has 7 rotations for its {len(JOINTS)} joints",
        ),
        (
            lambda clip: clip.GetTranslationsAttr().Set([Gf.Vec3f(np.nan)] * len(JOINTS), clip_codes(clip)[3]),
            "translations at time code",
        ),
    ],
)
@pytest.mark.parametrize("asked", [True, False])
def test_why_the_only_clip_cannot_be_used_is_said(spoil, message, asked):
    stage = simple_scene()
    if not asked:
        stage.GetPrimAtPath("/World/Hero").RemoveProperty(Token.CLIPS)
    spoil(UsdSkel.Animation(stage.GetPrimAtPath("/World/Clips/walk")))
    message = f"none of 1 clip\\(s\\) can be used on /World/Hero/Skeleton; /World/Clips/walk: {message}"
    with pytest.raises(SceneError, match=message):
        read_scene(stage)


def clip_codes(clip):
    return clip.GetRotationsAttr().GetTimeSamples()


def test_a_missing_file(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        read_scene(tmp_path / "nowhere.usda")


def test_a_bad_clip_among_good_ones_is_named():
    stage = simple_scene()
    animation = add_clip(stage, "/World/Clips/broken", Units(), TIMES, *walk_pose(TIMES))
    bad = np.full((len(JOINTS), 3), np.nan, dtype=np.float32)
    animation.GetTranslationsAttr().Set(Vt.Vec3fArray.FromNumpy(bad), 0.0)
    scene = read_scene(stage)
    assert len(scene.crowd.libraries[0].clips) == 1
    assert messages(scene) == [
        "/World/Clips/broken: translations at time code 0 are not finite, or zero. repair the sample"
    ]


def test_clips_nobody_asked_for_and_that_fit_nobody_are_warnings():
    stage = simple_scene(schemas=False)
    names = [f"horse{i}" for i in range(len(JOINTS))]
    add_clip(stage, "/World/Horse/gallop", Units(), TIMES, *walk_pose(TIMES), joints=names)
    scene = read_scene(stage)
    assert messages(scene) == []
    assert messages(scene, "warning") == ["/World/Horse/gallop: not used, lacks leg joints of /World/Hero/Skeleton"]


def test_an_empty_terrain_mesh_is_a_problem_of_the_scene():
    stage = simple_scene()
    add_mesh(stage, "/World/Hole", [], [], Units(), terrain=True)
    scene = read_scene(stage)
    assert len(scene.crowd.agents) == 1
    assert messages(scene)[0].startswith("/World/Hole: is an empty mesh (0 points, 0 faces)")


def test_a_second_plan_of_an_agent_is_named():
    stage = simple_scene()
    add_plan(stage, "/World/Plans/Other", Units(), yaws=np.zeros(6))
    stage.GetPrimAtPath("/World/Hero").GetRelationship(Token.PLAN).AddTarget("/World/Plans/Other")
    scene = read_scene(stage)
    assert [agent.plan.name for agent in scene.crowd.agents] == ["/World/Plans/Walk"]
    (problem,) = scene.crowd.problems
    assert problem.severity == "warning" and problem.where == "/World/Hero"
    assert "has several targets, /World/Plans/Walk is used. remove /World/Plans/Other" in problem.message
