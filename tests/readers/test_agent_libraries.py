"""Characters that are alike share their clips, others do not."""

from pxr import Sdf, Usd, UsdGeom

from tests.scenes import crowd_stage
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.model.hashing import library_hash
from usdfoot.readers.scene import read_scene

LOOKS = ("red", "blue", "red", "red")


def stage_of_looks(tmp_path) -> Usd.Stage:
    """People of an asset with variants, the last one taller than the others."""
    stage = crowd_stage(tmp_path, count=len(LOOKS))
    asset = Usd.Stage.Open(str(tmp_path / "hero.usda"))
    looks = asset.GetPrimAtPath("/World/Hero").GetVariantSets().AddVariantSet("look")
    for look in sorted(set(LOOKS)):
        looks.AddVariant(look)
    for number, look in enumerate(LOOKS):
        stage.GetPrimAtPath(f"/World/Group{number}/Walker").GetVariantSet("look").SetVariantSelection(look)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Group3/Walker")).AddScaleOp().Set((1.1, 1.1, 1.1))
    return stage


def test_variants_of_one_body_share_the_library_and_nobody_else(tmp_path):
    scene = read_scene(stage_of_looks(tmp_path))
    assert [agent.character for agent in scene.crowd.agents] == [0, 1, 0, 2]
    assert [agent.library for agent in scene.crowd.agents] == [0, 0, 0, 1]


def test_a_shared_library_is_the_one_that_each_would_have_alone(tmp_path):
    stage = stage_of_looks(tmp_path)
    crowd = read_scene(stage).crowd
    for agent in crowd.agents:
        (own,) = read_scene(stage, agents=agent.name).crowd.libraries
        assert library_hash(own) == library_hash(crowd.libraries[agent.library])


def test_bodies_that_are_tuned_otherwise_have_their_own(tmp_path):
    stage = stage_of_looks(tmp_path)
    prim = stage.GetPrimAtPath("/World/Group2/Walker")
    prim.CreateAttribute(Token.HIP_SPACING, Sdf.ValueTypeNames.Float, False).Set(1.5)
    assert [agent.library for agent in read_scene(stage).crowd.agents] == [0, 0, 1, 2]


def test_clips_that_cannot_be_used_are_named_once(tmp_path):
    stage = stage_of_looks(tmp_path)
    skeleton = stage.GetPrimAtPath("/World/Clips/walk").CreateRelationship("usdfoot:clip:skeleton", False)
    skeleton.SetTargets(["/World/Clips"])
    scene = read_scene(stage, motion="physics")
    assert [problem.where for problem in scene.crowd.problems] == ["/World/Clips/walk"] * 2  # one a body
