"""Which prim is the character of a stage that names none."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel

from tests.scenes import JOINTS, Units, add_character, add_ground, add_plan, new_stage
from usdfoot.errors import SkeletonError
from usdfoot.readers.candidates import only_character
from usdfoot.readers.characters import read_character
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.terrain import read_terrain


def read(stage, path):
    return read_character(stage.GetPrimAtPath(path), read_stage_info(stage).units, np.zeros(1))


def found(stage):
    return str(only_character(collect_prims(stage)).GetPath())


def test_the_one_with_skin_wins():
    stage = new_stage()
    add_character(stage, "/World/Rig", Units())
    add_character(stage, "/World/Hero", Units(), with_body=True)
    assert found(stage) == "/World/Hero"


def test_the_visible_one_wins():
    stage = new_stage()
    add_character(stage, "/World/A", Units())
    add_character(stage, "/World/B", Units())
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/A")).MakeInvisible()
    assert found(stage) == "/World/B"


def test_the_referenced_prim_is_the_character(tmp_path):
    source = new_stage(tmp_path / "hero.usda")
    add_character(source, "/World/Armature/Rig", Units(), root_type="Xform")
    source.GetRootLayer().Save()
    stage = new_stage()
    stage.DefinePrim("/World/Hero").GetReferences().AddReference(str(tmp_path / "hero.usda"))
    assert found(stage) == "/World/Hero"


def test_without_skel_root_and_reference_it_is_the_prim_above_the_skeleton():
    stage = new_stage()
    add_character(stage, "/World/Armature/Rig", Units(), root_type="Xform")
    assert found(stage) == "/World/Armature/Rig"


def test_several_different_ones_are_named():
    stage = new_stage()
    add_character(stage, "/World/A", Units())
    add_character(stage, "/World/B", Units(), joints=[joint.replace("Hips", "Root") for joint in JOINTS])
    with pytest.raises(SkeletonError, match="has several characters: /World/A/Skeleton, /World/B/Skeleton"):
        found(stage)


def test_of_body_and_face_the_one_with_legs_counts():
    """As of one person: several skinned Skeletons in one SkelRoot, the face first."""
    stage = new_stage()
    UsdSkel.Root.Define(stage, "/World/Hero")
    face = ["Neck", "Neck/Head", "Neck/Head/Jaw"]
    add_character(stage, "/World/Hero/Face", Units(), joints=face, offsets=np.eye(3), root_type="Xform", with_body=True)
    add_character(stage, "/World/Hero/Body", Units(), root_type="Xform", with_body=True)
    assert found(stage) == "/World/Hero"
    character = read(stage, "/World/Hero")
    assert character.skeleton_path == "Body/Skeleton"
    assert len(character.bounds) == 2


def test_none_is_said():
    with pytest.raises(SkeletonError, match=r"has no Skeleton with joints. add a character"):
        found(new_stage())


def test_a_skel_root_over_the_whole_scene_is_not_the_character():
    """Blender makes the common root of everything the SkelRoot."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdSkel.Root.Define(stage, "/Scene")
    add_character(stage, "/Scene/Armature", Units(), root_type="Xform")
    ground = add_ground(stage, "/Scene/Ground/Plane", Units(), terrain=False)
    plan = add_plan(stage, "/Scene/Plan", Units())
    prims = collect_prims(stage)
    assert str(only_character(prims, [plan.GetPrim(), ground.GetPrim()]).GetPath()) == "/Scene/Armature"
    assert read_terrain(stage, prims, read_stage_info(stage).units)[0].meshes == ("/Scene/Ground/Plane",)
