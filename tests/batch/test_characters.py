"""Several characters with variants in one crowd share as many prototypes as there are characters and variants."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils

from tests.batch.conftest import AGENTS, write_crowd_scene
from usdfoot.pipeline.animate import animate

LOOKS = ("red", "blue")


def write_looks(path, human):
    """The project's human in two colours, as variants of one asset."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = stage.DefinePrim("/Person")
    prim.GetReferences().AddReference(str(human))
    stage.SetDefaultPrim(prim)
    mesh = next(below for below in Usd.PrimRange(prim) if below.IsA(UsdGeom.Mesh))
    looks = prim.GetVariantSets().AddVariantSet("look")
    for number, name in enumerate(LOOKS):
        looks.AddVariant(name)
        looks.SetVariantSelection(name)
        with looks.GetVariantEditContext():
            UsdGeom.Mesh(stage.GetPrimAtPath(mesh.GetPath())).CreateDisplayColorAttr([Gf.Vec3f(1 - number, 0, number)])
    looks.ClearVariantSelection()
    stage.Save()


@pytest.fixture(scope="module")
def shot(stages, tmp_path_factory):
    folder = tmp_path_factory.mktemp("looks")
    scene = write_crowd_scene(stages, folder / "scene")
    write_looks(folder / "looks.usda", stages / "human.usdc")
    stage = Usd.Stage.Open(str(scene))
    for name in LOOKS:
        character = stage.DefinePrim(f"/World/Cast/{name}")
        character.GetReferences().AddReference(str(folder / "looks.usda"))
        character.GetVariantSet("look").SetVariantSelection(name)
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets([f"/World/Cast/{LOOKS[number % 2]}"])
    stage.Save()
    return animate(scene, folder / "out", chunk_size=2)


def test_variants_share_prototypes_and_keep_their_looks(shot):
    stage = Usd.Stage.Open(str(shot.crowd_file))
    agents = [stage.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}") for number in range(AGENTS)]
    assert all(agent.IsInstance() for agent in agents)
    assert len(stage.GetPrototypes()) == len(LOOKS)
    assert agents[0].GetPrototype() == agents[2].GetPrototype() != agents[1].GetPrototype()
    for number, agent in enumerate(agents):
        meshes = [prim for prim in Usd.PrimRange(agent, Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh)]
        colors = {tuple(color) for mesh in meshes for color in UsdGeom.Mesh(mesh).GetDisplayColorAttr().Get() or ()}
        assert ((0.0, 0.0, 1.0) if number % 2 else (1.0, 0.0, 0.0)) in colors


def test_a_collected_character_out_of_a_package_brings_its_textures(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    (tmp_path / "skin.png").write_bytes(b"not looked into")
    asset = Usd.Stage.CreateNew(str(tmp_path / "person.usda"))
    asset.SetDefaultPrim(asset.DefinePrim("/Person"))
    asset.GetDefaultPrim().GetReferences().AddReference(str(stages / "human.usdc"))
    skin = asset.DefinePrim("/Person/Skin").CreateAttribute("inputs:file", Sdf.ValueTypeNames.Asset)
    skin.Set("./skin.png")
    asset.Save()
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "person.usda"), str(tmp_path / "person.usdz"))
    stage = Usd.Stage.Open(str(scene))
    stage.DefinePrim("/World/Cast").GetReferences().AddReference(str(tmp_path / "person.usdz"))
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets(["/World/Cast"])
    stage.Save()
    animate(scene, tmp_path / "out", collect=True)
    (tmp_path / "person.usdz").unlink()
    folder = (tmp_path / "out").rename(tmp_path / "moved")
    crowd = Usd.Stage.Open(str(folder / "crowd.usd"))
    found = crowd.GetAttributeAtPath("/Crowd/Agents/Agent_1/Skin.inputs:file").Get()
    assert found.resolvedPath.startswith(f"{folder}/characters/") and found.resolvedPath.endswith("[skin.png]")


def test_devices_folders_and_files_of_no_kind_are_no_textures_to_collect(stages, tmp_path, caplog):
    """The first would be copied for ever, the last are what a hostile scene would have somebody hand on."""
    keys = [tmp_path / name for name in ("id_rsa", ".netrc")]
    for key in keys:
        key.write_text("secret")
    scene = write_crowd_scene(stages, tmp_path / "scene")
    stage = Usd.Stage.Open(str(scene))
    cast = stage.DefinePrim("/World/Cast")
    cast.GetReferences().AddReference(str(stages / "human.usdc"))
    for number, path in enumerate(("/dev/zero", str(tmp_path), *map(str, keys))):
        cast.CreateAttribute(f"inputs:file{number}", Sdf.ValueTypeNames.Asset).Set(path)
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets(["/World/Cast"])
    stage.Save()
    animate(scene, tmp_path / "out", collect=True)
    assert [path.name for path in (tmp_path / "out" / "characters").rglob("*") if path.is_file()] == ["Cast.usdc"]
    assert f"{keys[0]}: is no file to collect" in caplog.text
