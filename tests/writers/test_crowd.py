"""What is written: read back it is the motion; its layers, instances and validity."""

import hashlib
import itertools
from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel, UsdValidation

from tests.writers.crowds import (
    Rig,
    character_of,
    scene_of,
    wandering_motion,
    world_joints,
    write_character,
    write_crowd,
)
from usdfoot.bridge.units import StageUnits

FILES = {
    "crowd.usd",
    "overrides.usda",
    "agents.usdc",
    "footsteps.usdc",
    "anims.usda",
    "anims.0000.usdc",
    "crowd.expanded.usda",
    "report.json",
}
CENTIMETRES = StageUnits(time_codes_per_second=30.0)


def write(tmp_path, *, rig=None, agents=2, frames=20, folder="out", collect=False, **stance):
    rig = rig or Rig(units=CENTIMETRES)
    path = tmp_path / "hero.usda"
    if not path.exists():
        write_character(path, rig)
    character = character_of(path, **stance)
    scene = scene_of(character, rig.units, agents=agents, frames=frames)
    motions = [
        wandering_motion(f"A{i}", character, frames=frames, rate=rig.units.time_codes_per_second, seed=i)
        for i in range(agents)
    ]
    crowd, _ = write_crowd(scene, motions, tmp_path / folder, collect=collect)
    return crowd, character, motions


def read_joints(crowd, name, units, codes):
    """World positions of the joints [m, canonical] as UsdSkel sees them, shape (F, J, 3)."""
    stage = Usd.Stage.Open(str(crowd))
    root = UsdSkel.Root(stage.GetPrimAtPath(f"/Crowd/Agents/{name}"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.TraverseInstanceProxies())
    bindings = [
        prim for prim in Usd.PrimRange(root.GetPrim(), Usd.TraverseInstanceProxies()) if prim.IsA(UsdSkel.Skeleton)
    ]
    query = cache.GetSkelQuery(UsdSkel.Skeleton(bindings[0]))
    assert query.GetAnimQuery().GetPrim().GetPath() == f"/Crowd/Anims/{name}"
    frames = []
    for code in codes:
        # A query of an instance computes in the prototype's world, so the instance's own place comes from the proxy.
        above = UsdGeom.XformCache(Usd.TimeCode(float(code))).GetLocalToWorldTransform(bindings[0])
        matrices = query.ComputeJointSkelTransforms(Usd.TimeCode(float(code)))
        frames.append([np.array((matrix * above).ExtractTranslation()) for matrix in matrices])
    return units.points_to_canonical(np.array(frames))


@pytest.mark.parametrize(
    ("meters", "up", "rate", "scale"),
    [
        *itertools.product((0.01, 1.0), ("Y", "Z"), (24.0, 30.0), (1.0,)),
        (1.0, "Z", 24.0, 0.01),
        (0.0254, "Y", 60.0, 2.0),
    ],
)
def test_written_crowd_reads_back_as_the_motion(tmp_path, meters, up, rate, scale):
    units = StageUnits(meters_per_unit=meters, up_axis=up, time_codes_per_second=rate)
    crowd, character, motions = write(tmp_path, rig=Rig(units=units, scale_above=scale), frames=8)
    for motion in motions:
        read = read_joints(crowd, motion.name, units, motion.times * rate)
        np.testing.assert_allclose(read, world_joints(motion, character), atol=1e-5)


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_character_that_lies_down_in_its_file_is_stood_up_and_scaled(tmp_path, up):
    units = StageUnits(up_axis=up, time_codes_per_second=30.0)
    crowd, character, motions = write(tmp_path, rig=Rig(units=units), frames=4, tilt=-0.5 * np.pi, size=0.3)
    read = read_joints(crowd, "A0", units, motions[0].times * 30.0)
    np.testing.assert_allclose(read, world_joints(motions[0], character), atol=1e-5)
    stage = Usd.Stage.Open(str(crowd))
    agent = stage.GetPrimAtPath("/Crowd/Agents/A0")
    names = [op.GetOpName() for op in UsdGeom.Xformable(agent).GetOrderedXformOps()]
    assert names[2:] == ["xformOp:orient:stance", "xformOp:scale:stance"]
    matrix = np.array(UsdGeom.XformCache(2.0).GetLocalToWorldTransform(agent))
    low, high = np.array(agent.GetAttribute("extent").Get(2.0), dtype=float)
    local = (units.points_to_stage(read[2]) - matrix[3, :3]) @ np.linalg.inv(matrix[:3, :3])
    margin = 0.01 / units.meters_per_unit
    np.testing.assert_allclose([low, high], [local.min(axis=0) - margin, local.max(axis=0) + margin], atol=1e-2)


@pytest.mark.parametrize(("bound", "collect"), [(True, False), (False, True), (True, True)])
def test_a_character_with_an_animation_of_its_own_is_copied_and_moves(tmp_path, bound, collect):
    rig = Rig(units=CENTIMETRES, bound=bound)
    crowd, character, motions = write(tmp_path, rig=rig, frames=4, collect=collect)
    for motion in motions:
        read = read_joints(crowd, motion.name, rig.units, motion.times * 30.0)
        np.testing.assert_allclose(read, world_joints(motion, character), atol=1e-5)
    stage = Usd.Stage.Open(str(crowd))
    assert len(stage.GetPrototypes()) == 1
    assert (crowd.parent / "characters" / "Hero.usdc").is_file()
    used = {layer.identifier for layer in stage.GetUsedLayers()}
    assert str(tmp_path / "hero.usda") not in used
    assert not errors_of(stage)


def test_a_skeleton_below_a_transform_that_moves_stays_with_its_agent(tmp_path):
    rig = Rig(units=CENTIMETRES, moving=True)
    character = character_of(write_character(tmp_path / "hero.usda", rig), codes=range(6))
    scene = scene_of(character, rig.units, agents=1, frames=6)
    motion = wandering_motion("A0", character, frames=3, rate=30.0)
    inserted = replace(motion, times=motion.times / 2.0 + 1.0 / 30.0)  # time codes 1, 1.5 and 2
    crowd, _ = write_crowd(scene, [inserted], tmp_path / "out")
    read = read_joints(crowd, "A0", rig.units, [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0])
    expected = world_joints(motion, character)[[0, 0, 1, 2, 2, 2, 2]]
    np.testing.assert_allclose(read, expected, atol=1e-5)


def test_layers_are_those_of_the_contract(tmp_path):
    crowd, _, _ = write(tmp_path)
    assert {path.name for path in crowd.parent.iterdir()} == FILES
    stage = Usd.Stage.Open(str(crowd))
    root = stage.GetRootLayer()
    assert root.GetFileFormat().formatId == "usd" and crowd.read_bytes().startswith(b"#usda 1.0")
    assert list(root.subLayerPaths) == ["./overrides.usda", "./agents.usdc", "./footsteps.usdc", "./anims.usda"]
    assert stage.GetDefaultPrim().GetPath() == "/Crowd" and stage.GetDefaultPrim().GetTypeName() == "Xform"
    assert [root.GetPrimAtPath("/Crowd"), stage.GetTimeCodesPerSecond(), stage.GetEndTimeCode()] == [None, 30.0, 19.0]


def test_agents_of_one_character_share_a_prototype(tmp_path):
    crowd, _, _ = write(tmp_path, agents=3)
    stage = Usd.Stage.Open(str(crowd))
    agents = stage.GetPrimAtPath("/Crowd/Agents").GetChildren()
    assert [agent.IsInstance() for agent in agents] == [True] * 3
    assert len(stage.GetPrototypes()) == 1
    expanded = Usd.Stage.Open(str(crowd.parent / "crowd.expanded.usda"))
    assert not expanded.GetPrototypes() and expanded.GetPrimAtPath("/Crowd/Agents/A0/Group/Body")


def errors_of(stage):
    # Without usdfoot's own, which a test before may have registered: these motions are made up, no foot stands still.
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    stock = [validator for validator in validators if not validator.GetMetadata().name.startswith("usdfoot")]
    context = UsdValidation.ValidationContext(stock)
    return [(error.GetName(), error.GetMessage()) for error in context.Validate(stage)]


def test_validators_are_silent(tmp_path):
    crowd, _, _ = write(tmp_path)
    for name in ("crowd.usd", "crowd.expanded.usda"):
        assert not errors_of(Usd.Stage.Open(str(crowd.parent / name)))


def test_source_is_untouched_and_two_runs_are_the_same(tmp_path):
    first, _, _ = write(tmp_path)
    source = hashlib.sha256((tmp_path / "hero.usda").read_bytes()).digest()
    second, _, _ = write(tmp_path, folder="again")
    assert hashlib.sha256((tmp_path / "hero.usda").read_bytes()).digest() == source
    for name in sorted(FILES):
        assert (first.parent / name).read_bytes() == (second.parent / name).read_bytes(), name
