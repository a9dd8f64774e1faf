"""Whole scenes: who is read and what is shared."""

import logging

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils

from tests.scenes import (
    JOINTS,
    Units,
    add_agent,
    add_character,
    add_clip,
    add_ground,
    add_plan,
    crowd_stage,
    messages,
    new_stage,
    simple_scene,
    straight_steps,
    walk_pose,
)
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Plan
from usdfoot.errors import SceneError
from usdfoot.model.sampling import SamplingOptions
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.model.tuning import BodyTuning
from usdfoot.readers.scene import SceneReader, read_scene

TIMES = np.arange(0.0, 1.0, 1.0 / 30.0)
EVERY_UNITS = [
    Units(m, u, r) for m, u, r in ((1.0, "Y", 24), (0.01, "Z", 30), (0.0254, "Y", 60), (0.01, "Y", 48), (1, "Z", 120))
]


@pytest.mark.parametrize("units", EVERY_UNITS)
@pytest.mark.parametrize("schemas", [True, False])
def test_the_same_scene_in_any_units_with_or_without_schemas(units, schemas):
    scene = read_scene(simple_scene(units=units, schemas=schemas))
    (agent,) = scene.crowd.agents
    (library,) = scene.crowd.libraries
    sides, positions, strikes, _ = straight_steps()
    assert_array_equal(agent.plan.sides, sides)
    assert_allclose(agent.plan.positions, positions, atol=1e-6)
    assert_allclose(agent.plan.strike_times, strikes, atol=1e-9)
    assert [clip.name for clip in library.clips] == ["/World/Clips/walk"]
    assert library.skeleton is scene.characters[agent.character].skeleton
    assert scene.crowd.terrain.meshes == ("/World/Ground",)
    assert agent.name == ("Hero" if schemas else "Walk")
    assert scene.crowd.problems == ()
    assert (agent.ik_reach, agent.root_weight, agent.replace_distance, agent.motion) == (0.3, 0.0, 0.0, "clips")


def test_frames_are_whole_codes_around_all_plans():
    stage = simple_scene(units=Units(1.0, "Y", 30.0))
    scene = read_scene(stage)
    _, _, strikes, liftoffs = straight_steps()
    assert_array_equal(scene.frame_codes, np.arange(np.floor(strikes[0] * 30), np.ceil(liftoffs[-1] * 30) + 1))
    assert_allclose(scene.crowd.frame_times, scene.frame_codes / 30.0)
    assert scene.crowd.frame_rate == 30.0
    assert_array_equal(read_scene(stage, frames=(20, 22)).frame_codes, [20, 21, 22])
    with pytest.raises(SceneError, match="frames: 9:3 is empty"):
        read_scene(stage, frames=(9, 3))


def test_frames_in_which_nobody_walks_are_named():
    stage = simple_scene(units=Units(1.0, "Y", 30.0))
    begin, *_, end = read_scene(stage).frame_codes.astype(int).tolist()
    for frames in ((end - 1, end + 9), (begin - 9, begin)):
        assert read_scene(stage, frames=frames).crowd.problems == ()
    for frames in ((end + 1, end + 9), (begin - 9, begin - 1)):
        (message,) = messages(read_scene(stage, frames=frames), "warning")
        assert f"nobody walks in {frames[0]}:{frames[1]}" in message
        assert f"lie in {begin}:" in message


@pytest.mark.parametrize(
    ("rate", "every", "said"),
    [
        (
            4800.0,
            1,
            "has 4800 time codes a second, each agent has a sample at each of them. take fewer with --every 160",
        ),
        (5.0, 1, "has 5 time codes a second, feet drift between samples that far apart. author 24 or more"),
        (4800.0, 40, ""),
        (240.0, 1, ""),
        (12.0, 1, ""),
    ],
)
def test_rates_out_of_the_ordinary_are_said(rate, every, said):
    stage = simple_scene(units=Units(1.0, "Y", rate))
    stage.SetFramesPerSecond(1e6)  # which counts for nothing
    read = SceneReader(stage, sampling=SamplingOptions(every=every)).read()
    found = messages(read, "warning")
    assert [said in message for message in found] == ([True] if said else [])


@pytest.mark.parametrize(("kilometres", "units", "spacing"), [(10.0, Units(), 0), (4000.0, Units(0.01, "Z"), 320)])
def test_a_scene_on_the_grid_of_a_map_is_named(kilometres, units, spacing):
    """Positions are of single precision: figures would say that footsteps are missed."""
    stage = simple_scene(units=units)
    place = np.array([0.0, 0.0, 1000.0 * kilometres])
    UsdGeom.Xformable(stage.GetPrimAtPath("/World")).AddTranslateOp().Set(Gf.Vec3d(*units.points(place).tolist()))
    said = [problem.message for problem in read_scene(stage).crowd.problems]
    assert [f"are {spacing} mm apart" in message for message in said] == [True] * bool(spacing)


def test_tuning_is_read_in_the_scenes_units_and_what_is_given_goes_over_it():
    stage = simple_scene(units=Units(0.01))
    prim = stage.GetPrimAtPath("/World/Hero")
    for name, value in ((Token.CROUCH, 0.1), (Token.GRAVITY, 162.0), (Token.HIP_SPACING, 1.5), (Token.PITCH, 2.0)):
        prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, False).Set(value)
    prim.CreateAttribute(Token.COM_SHIFT, Sdf.ValueTypeNames.Float3, False).Set((0.0, 5.0, -2.0))
    scene = read_scene(stage, tuning=BodyTuning(crouch=0.3, comfort=500.0))
    (agent,) = scene.crowd.agents
    expected = {"hip_spacing": 1.5, "crouch": 0.3, "pitch": 2.0, "gravity": 1.62, "comfort": 500.0}
    expected |= {"com_left": 0.0, "com_up": 0.05, "com_ahead": -0.02}
    assert agent.tuning.given == pytest.approx(expected)
    (usual,) = read_scene(simple_scene(units=Units(0.01))).characters
    assert_allclose(hip_distance(scene.characters[0]), 1.5 * hip_distance(usual))


def hip_distance(character):
    skeleton = character.skeleton
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    return np.linalg.norm(places[character.biped.hips[0]] - places[character.biped.hips[1]])


def test_options_of_an_agent_are_read_in_its_units():
    stage = simple_scene(units=Units(0.01))
    prim = stage.GetPrimAtPath("/World/Hero")
    for name, value in ((Token.IK_REACH, 12.0), (Token.ROOT_WEIGHT, 0.5), (Token.REPLACE_DISTANCE, 3.0)):
        prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, False).Set(value)
    prim.CreateAttribute(Token.MOTION, Sdf.ValueTypeNames.Token, False).Set("hybrid")
    (agent,) = read_scene(stage).crowd.agents
    assert (agent.ik_reach, agent.root_weight, agent.replace_distance) == pytest.approx((0.12, 0.5, 0.03))
    assert agent.motion == "hybrid"
    assert_array_equal(agent.plan.root_weights, 0.5)


def test_root_weights_of_a_plan_go_before_the_agents_even_if_all_are_zero():
    stage = simple_scene()
    prim = stage.GetPrimAtPath("/World/Hero")
    prim.CreateAttribute(Token.ROOT_WEIGHT, Sdf.ValueTypeNames.Float, False).Set(0.5)
    (agent,) = read_scene(stage).crowd.agents
    plan = stage.GetPrimAtPath(agent.plan.name)
    attribute = plan.CreateAttribute(Plan.ROOT_WEIGHTS, Sdf.ValueTypeNames.FloatArray, False)
    attribute.Set([0.0] * len(agent.plan))
    (agent,) = read_scene(stage).crowd.agents
    assert_array_equal(agent.step_root_weights, 0.0)


def test_agents_share_character_and_clips_and_have_names_of_their_own(tmp_path):
    scene = read_scene(crowd_stage(tmp_path))
    assert [agent.name for agent in scene.crowd.agents] == ["Walker", "Walker_1", "Walker_2"]
    assert len(scene.characters) == 1
    assert len(scene.crowd.libraries) == 1
    assert scene.characters[0].asset == str((tmp_path / "hero.usda").resolve())
    assert scene.stage.layers == tuple(sorted(str((tmp_path / n).resolve()) for n in ("hero.usda", "scene.usda")))


def test_agents_are_hidden_with_what_is_above_them(tmp_path):
    stage = crowd_stage(tmp_path)
    groups = [UsdGeom.Imageable(UsdGeom.Xform.Define(stage, f"/World/Group{i}")) for i in range(3)]
    groups[0].MakeInvisible()
    groups[1].CreateVisibilityAttr().Set("invisible", 10.0)
    groups[1].GetVisibilityAttr().Set("inherited", 20.0)
    walker = UsdGeom.Imageable(stage.GetPrimAtPath("/World/Group1/Walker"))
    walker.CreateVisibilityAttr().Set("inherited", 5.0)
    walker.GetVisibilityAttr().Set("invisible", 30.0)
    blinks = ((5.0, "invisible"), (10.0, "invisible"), (20.0, "inherited"), (30.0, "invisible"))  # held to both sides
    assert read_scene(stage).visibility == {"Walker": ((None, "invisible"),), "Walker_1": blinks}


def test_agents_are_chosen_by_name_or_path(tmp_path):
    stage = crowd_stage(tmp_path)
    assert [agent.name for agent in read_scene(stage, agents="Walker_*").crowd.agents] == ["Walker_1", "Walker_2"]
    assert [agent.name for agent in read_scene(stage, agents="/World/Group2/*").crowd.agents] == ["Walker_2"]
    with pytest.raises(SceneError, match="agents Nobody: match none of the scene's agents: Walker, Walker_1, Walker_2"):
        read_scene(stage, agents="Nobody")


def test_a_character_of_its_own_or_elsewhere():
    stage = simple_scene()
    add_character(stage, "/World/Library/Other", Units(), joints=[joint.replace("Hips", "pelvis") for joint in JOINTS])
    add_plan(stage, "/World/Plans/Second", Units(), yaws=np.zeros(6))
    add_agent(stage, "/World/Guest", plan="/World/Plans/Second", character="/World/Library/Other")
    names = [joint.replace("Hips", "pelvis") for joint in JOINTS]
    add_clip(stage, "/World/Library/Other/Skeleton/walk", Units(), TIMES, *walk_pose(TIMES), joints=names)
    scene = read_scene(stage)
    assert [scene.characters[agent.character].path for agent in scene.crowd.agents] == [
        "/World/Hero",
        "/World/Library/Other",
    ]
    hero, guest = scene.crowd.agents
    assert [clip.name for clip in scene.crowd.libraries[hero.library].clips] == ["/World/Clips/walk"]
    # Nobody chose clips for the guest: those of the hero fit its legs too.
    names = {clip.name for clip in scene.crowd.libraries[guest.library].clips}
    assert names == {"/World/Clips/walk", "/World/Library/Other/Skeleton/walk"}


def test_an_agent_prim_on_an_instance_proxy(tmp_path):
    simple_scene(tmp_path / "all.usda")
    stage = new_stage()
    prim = stage.DefinePrim("/World/Copy", "Xform")
    prim.GetReferences().AddReference(str(tmp_path / "all.usda"))
    prim.SetInstanceable(True)
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(4.0, 0.0, 0.0))
    scene = read_scene(stage)
    (agent,) = scene.crowd.agents
    assert agent.source == "/World/Copy/Hero"
    assert_allclose(agent.plan.positions, straight_steps()[1] + (4.0, 0.0, 0.0), atol=1e-6)


def test_a_usdz_package(tmp_path):
    simple_scene(tmp_path / "scene.usdc")
    UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "scene.usdc")), str(tmp_path / "scene.usdz"))
    scene = read_scene(tmp_path / "scene.usdz")
    assert [agent.name for agent in scene.crowd.agents] == ["Hero"]
    assert scene.stage.identifier == str((tmp_path / "scene.usdz").resolve())


def test_every_plan_gets_an_agent_where_no_agent_is_authored():
    stage = simple_scene(schemas=False)
    add_plan(stage, "/World/Plans/Second", Units(), yaws=np.zeros(6), with_api=False)
    scene = read_scene(stage)
    assert [agent.name for agent in scene.crowd.agents] == ["Walk", "Second"]
    assert {agent.character for agent in scene.crowd.agents} == {0}


def test_the_only_agent_takes_the_only_plan():
    stage = simple_scene()
    stage.GetPrimAtPath("/World/Hero").RemoveProperty(Token.PLAN)
    assert read_scene(stage).crowd.agents[0].plan.name == "/World/Plans/Walk"


def test_clips_may_be_a_collection():
    stage = simple_scene()
    for name in ("limp", "other"):
        add_clip(stage, f"/World/Clips/{name}", Units(), TIMES, *walk_pose(TIMES))
    collection = Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/World"), "walks")
    collection.CreateIncludesRel().SetTargets(["/World/Clips"])
    collection.CreateExcludesRel().SetTargets(["/World/Clips/limp"])
    relationship = stage.GetPrimAtPath("/World/Hero").GetRelationship(Token.CLIPS)
    relationship.SetTargets([collection.GetCollectionPath()])
    (library,) = read_scene(stage).crowd.libraries
    assert [clip.name for clip in library.clips] == ["/World/Clips/other", "/World/Clips/walk"]
    relationship.SetTargets([Usd.CollectionAPI.GetNamedCollectionPath(stage.GetPrimAtPath("/World"), "runs")])
    with pytest.raises(SceneError, match=r"points at what does not exist: /World\.collection:runs"):
        read_scene(stage)


def test_physics_needs_no_clips():
    stage = simple_scene()
    stage.RemovePrim("/World/Clips")
    prim = stage.GetPrimAtPath("/World/Hero")
    prim.RemoveProperty(Token.CLIPS)
    prim.CreateAttribute(Token.MOTION, Sdf.ValueTypeNames.Token, False).Set("physics")
    scene = read_scene(stage)
    assert scene.crowd.libraries[0].clips == ()


def test_the_stage_is_not_edited_and_problems_are_logged(caplog):
    stage = simple_scene()
    add_ground(stage, "/World/More", Units())
    add_plan(stage, "/World/Plans/Spare", Units(), yaws=np.zeros(6))
    before = [layer.ExportToString() for layer in stage.GetUsedLayers()]
    with caplog.at_level(logging.WARNING):
        read_scene(stage)
    assert [layer.ExportToString() for layer in stage.GetUsedLayers()] == before
    assert "no agent walks this plan" in caplog.text


@pytest.mark.parametrize(("name", "footsteps"), [("walk_flat", 12), ("stepping_stones", 16)])
def test_the_real_scenes(shared_data, name, footsteps):
    scene = read_scene(shared_data / "scenes" / f"{name}.usda")
    (agent,) = scene.crowd.agents
    assert len(agent.plan) == footsteps
    assert len(scene.crowd.libraries[agent.library].clips) == 31
    assert scene.crowd.problems == ()
    assert scene.characters[0].asset == str(shared_data / "bandai" / "bandai_character.usdc")
    assert scene.characters[0].asset_prim == "/BandaiCharacter"
    bed = [not walkable for walkable in scene.crowd.terrain.walkable]
    assert sum(bed) == (1 if name == "stepping_stones" else 0)


def test_tracked_people_are_followers(shared_data):
    crowd = read_scene(shared_data / "scenes" / "crowd_zara.usda").crowd
    assert not crowd.agents and len(crowd.followers) == 20 and not crowd.problems
    assert {follower.name for follower in crowd.followers} >= {"person_075", "person_097"}


@pytest.mark.parametrize("name", ["pab/pab_walk.usdc", "knight/knight_Walking_A.usdc"])
def test_files_of_blender_with_a_plan_and_no_schema(shared_data, name):
    units = Units(1.0, "Z", 30.0 if "pab" in name else 24.0)
    stage = new_stage(None, units)
    stage.DefinePrim("/World/Guy").GetReferences().AddReference(str(shared_data / name))
    add_plan(stage, "/World/Plan", units, yaws=np.zeros(6), with_api=False)
    scene = read_scene(stage)
    (agent,) = scene.crowd.agents
    character = scene.characters[agent.character]
    assert (character.path, character.asset) == ("/World/Guy", str(shared_data / name))
    assert len(scene.crowd.libraries[agent.library].clips) == 1
    assert len(character.skeleton_to_agent) == (len(scene.frame_codes) if "pab" in name else 1)
    assert isinstance(stage, Usd.Stage)


@pytest.mark.parametrize("name", ["walk_flat", "stepping_stones"])
@pytest.mark.parametrize("units", [Units(1.0, "Z", 24.0), Units(0.0254, "Y", 120.0), Units(0.01, "Z", 48.0)])
def test_a_real_scene_brought_into_another_stage_is_the_same_scene(shared_data, name, units):
    """Referenced below a transform that resolves units and axes, as an assembly does; USD rescales the times."""
    path = str(shared_data / "scenes" / f"{name}.usda")
    stage = new_stage(None, units)
    prim = UsdGeom.Xform.Define(stage, "/World/Set")
    prim.GetPrim().GetReferences().AddReference(path)
    if units.up == "Z":
        prim.AddRotateXOp().Set(90.0)
    prim.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(0.01 / units.meters))
    here, there = read_scene(stage), read_scene(path)
    plan, expected = here.crowd.agents[0].plan, there.crowd.agents[0].plan
    assert_allclose(plan.positions, expected.positions, atol=1e-6)
    assert_allclose(plan.yaws, expected.yaws, atol=1e-6)
    assert_allclose(plan.strike_times, expected.strike_times, atol=1e-9)
    assert_allclose(here.crowd.terrain.points, there.crowd.terrain.points, atol=1e-5)
    assert here.characters[0].asset == there.characters[0].asset
    assert_allclose(here.characters[0].biped.ball_heights, there.characters[0].biped.ball_heights, atol=1e-6)
    for clip, other in zip(here.crowd.libraries[0].clips, there.crowd.libraries[0].clips, strict=True):
        assert clip.rate == pytest.approx(30.0)
        assert (clip.range_start, clip.range_end) == pytest.approx((other.range_start, other.range_end))
        assert_allclose(clip.translations, other.translations, atol=1e-5)
        assert_allclose(clip.rotations, other.rotations, atol=1e-5)
