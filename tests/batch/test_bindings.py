"""Materials that a scene binds to its agents are bound to the written agents, which still share their prototypes."""

import logging

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

from tests.batch.conftest import AGENTS, write_crowd_scene
from tests.batch.test_characters import LOOKS, write_looks
from tests.digests import digests
from usdfoot.model.levels import DetailLevels
from usdfoot.pipeline.animate import animate

WEAK, STRONG = UsdShade.Tokens.weakerThanDescendants, UsdShade.Tokens.strongerThanDescendants
RED, BLUE = "/World/Looks/Red", "/World/Library/Blue"
PURPOSES = (UsdShade.Tokens.allPurpose, UsdShade.Tokens.preview, UsdShade.Tokens.full)


def write_asset(path, human):
    """A person in two variants, one of whose meshes has a material of its own; a second material is for others."""
    write_looks(path, human)
    stage = Usd.Stage.Open(str(path))
    for name in ("Skin", "Plain"):
        UsdShade.Material.Define(stage, f"/Person/Materials/{name}")
    mesh = next(prim for prim in Usd.PrimRange(stage.GetPrimAtPath("/Person")) if prim.IsA(UsdGeom.Mesh))
    bind(mesh, "/Person/Materials/Skin")
    stage.Save()


def bind(prim, path, strength=WEAK, purpose=UsdShade.Tokens.allPurpose):
    material = UsdShade.Material(prim.GetStage().GetPrimAtPath(path))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, strength, purpose)


def add_materials(stage, folder):
    """One in the scene, with a texture, and one in a library of another file."""
    red = UsdShade.Material.Define(stage, RED)
    texture = UsdShade.Shader.Define(stage, f"{RED}/Texture")
    (folder / "skin.png").write_bytes(b"not looked into")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(folder / "skin.png"))
    red.CreateSurfaceOutput().ConnectToSource(texture.ConnectableAPI(), "surface")
    library = Usd.Stage.CreateNew(str(folder / "library.usda"))
    UsdShade.Material.Define(library, "/Materials/Blue")
    library.Save()
    stage.OverridePrim("/World/Library").GetReferences().AddReference(str(folder / "library.usda"), "/Materials")


def write_bound_scene(stages, folder, layout):
    """Agents that are their characters, have one below or point at one, with materials bound in many ways."""
    scene = write_crowd_scene(stages, folder / "scene")
    write_asset(folder / "person.usda", stages / "human.usdc")
    stage = Usd.Stage.Open(str(scene))
    add_materials(stage, folder)
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        places = {"itself": agent.GetPath(), "below": agent.GetPath().AppendChild("Body")}
        place = places.get(layout, Sdf.Path(f"/World/Cast/Person_{number}"))
        character = stage.DefinePrim(place)
        character.GetReferences().AddReference(str(folder / "person.usda"))
        character.GetVariantSet("look").SetVariantSelection(LOOKS[number == 1])
        agent.GetRelationship("usdfoot:agent:character").SetTargets([place])
        if number == 0:
            bind(agent, RED)
            bind(agent, BLUE, STRONG, UsdShade.Tokens.preview)
        elif number == 1:
            bind(agent, place.AppendPath("Materials/Plain"), STRONG)
        else:
            bind(character, BLUE)
            bind(agent, RED, STRONG if layout == "pointed" else WEAK, UsdShade.Tokens.full)
    stage.Save()
    return scene


def bound_materials(agent, character, number):
    """Names of what is bound to each mesh of an agent, for each purpose."""
    meshes = [prim for prim in Usd.PrimRange(character, Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh)]
    return {
        (number, mesh.GetName(), purpose): UsdShade.MaterialBindingAPI(mesh)
        .ComputeBoundMaterial(purpose)[0]
        .GetPath()
        .name
        for mesh in meshes
        for purpose in PURPOSES
    }


@pytest.mark.parametrize("collect", [False, True])
@pytest.mark.parametrize("layout", ["itself", "below"])
def test_meshes_have_the_materials_that_they_have_in_the_scene(stages, tmp_path, layout, collect):
    scene = write_bound_scene(stages, tmp_path, layout)
    report = animate(scene, tmp_path / "out", chunk_size=2, collect=collect)
    stage, crowd = Usd.Stage.Open(str(scene)), Usd.Stage.Open(str(report.crowd_file))
    assert len(crowd.GetPrototypes()) == len(LOOKS)
    for number in range(AGENTS):
        source = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent = crowd.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}")
        assert agent.IsInstance()
        expected = bound_materials(source, source, number)
        assert {*expected.values()} >= [{"Skin", "Red", "Blue"}, {"Plain"}, {"Skin", "Blue"}][number]
        assert bound_materials(agent, agent, number) == expected
    assert {str(material.GetPath()) for material in materials_of(crowd)} == {
        f"/Crowd/Materials{path}" for path in (RED, BLUE)
    }


def materials_of(crowd):
    return [prim for prim in Usd.PrimRange(crowd.GetPrimAtPath("/Crowd/Materials")) if prim.IsA(UsdShade.Material)]


def test_an_agent_has_its_own_over_those_of_the_character_it_points_at(stages, tmp_path):
    crowd = Usd.Stage.Open(str(animate(write_bound_scene(stages, tmp_path, "pointed"), tmp_path / "out").crowd_file))
    agent = crowd.GetPrimAtPath("/Crowd/Agents/Agent_2")
    found = bound_materials(agent, agent, 2)
    names = {purpose: {name for (_, _, said), name in found.items() if said == purpose} for purpose in PURPOSES}
    assert names == {"": {"Skin", "Blue"}, "preview": {"Skin", "Blue"}, "full": {"Red"}}
    assert len(crowd.GetPrototypes()) == len(LOOKS)


def test_materials_are_referenced_where_they_are_said_whole(stages, tmp_path):
    animate(write_bound_scene(stages, tmp_path, "itself"), tmp_path / "out")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "out" / "crowd.materials.usda"))
    (found,) = layer.GetPrimAtPath(f"/Crowd/Materials{BLUE}").referenceList.prependedItems
    assert (found.assetPath, found.primPath) == ("../library.usda", "/Materials/Blue")


def test_a_collected_crowd_brings_materials_and_textures(stages, tmp_path):
    scene = write_bound_scene(stages, tmp_path, "itself")
    animate(scene, tmp_path / "out", collect=True)
    for name in ("library.usda", "skin.png", "person.usda"):
        (tmp_path / name).unlink()
    scene.rename(tmp_path / "elsewhere.usda")
    folder = (tmp_path / "out").rename(tmp_path / "moved")
    crowd = Usd.Stage.Open(str(folder / "crowd.usd"))
    assert not crowd.GetCompositionErrors()
    texture = crowd.GetAttributeAtPath(f"/Crowd/Materials{RED}/Texture.inputs:file").Get()
    assert texture.resolvedPath.startswith(f"{folder}/characters/materials/Red/")
    assert {material.GetName() for material in materials_of(crowd)} == {"Red", "Blue"}


def test_workers_and_a_changed_binding_leave_the_bytes_of_a_first_run(stages, worker, tmp_path, caplog):
    """Only the agent that is bound to something else is made again; nothing bound, and the layer is gone."""
    caplog.set_level(logging.INFO)
    scene = write_bound_scene(stages, tmp_path, "itself")
    animate(scene, tmp_path / "out", chunk_size=2)
    animate(scene, tmp_path / "workers", chunk_size=2, executor=worker)
    assert digests(tmp_path / "out") == digests(tmp_path / "workers")
    stage = Usd.Stage.Open(str(scene))
    bind(stage.GetPrimAtPath("/World/Crowd/Agent_0"), BLUE)
    stage.Save()
    assert animate(scene, tmp_path / "out", chunk_size=2).kept_agents == AGENTS - 1
    assert animate(scene, tmp_path / "out", chunk_size=2).kept_agents == AGENTS
    animate(scene, tmp_path / "fresh", chunk_size=2)
    assert "USD copies it" not in caplog.text
    assert digests(tmp_path / "out") == digests(tmp_path / "fresh")
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        for name in agent.GetAuthoredPropertyNames():
            if name.startswith("material:"):
                agent.RemoveProperty(name)
    stage.Save()
    animate(scene, tmp_path / "out", chunk_size=2)
    assert not (tmp_path / "out" / "crowd.materials.usda").exists()
    assert len(Sdf.Layer.FindOrOpen(str(tmp_path / "out" / "crowd.usd")).subLayerPaths) == 4


def test_materials_of_a_character_with_levels_are_those_of_the_first(stages, tmp_path):
    scene = write_bound_scene(stages, tmp_path, "pointed")
    levels = DetailLevels(variants=LOOKS, distances=(15.0,))
    crowd = Usd.Stage.Open(str(animate(scene, tmp_path / "out", levels=levels).crowd_file))
    agent = crowd.GetPrimAtPath("/Crowd/Agents/Agent_1")
    (target,) = agent.GetRelationship("material:binding").GetTargets()
    assert target == "/Crowd/Agents/Agent_1/Levels/Level0/Materials/Plain" and crowd.GetPrimAtPath(target)


def test_what_binds_nothing_is_left_out(stages, tmp_path):
    """As USD leaves it out: without the schema, of no material, of none that is there."""
    scene = write_bound_scene(stages, tmp_path, "itself")
    stage = Usd.Stage.Open(str(scene))
    agents = [stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}") for number in range(AGENTS)]
    agents[0].RemoveAppliedSchema("MaterialBindingAPI")
    agents[1].GetRelationship("material:binding").SetTargets(["/World/Looks"])
    agents[2].GetRelationship("material:binding").SetTargets(["/World/Nowhere"])
    agents[2].GetRelationship("material:binding:full").SetTargets([])
    stage.Save()
    report = animate(scene, tmp_path / "out")
    crowd = Usd.Stage.Open(str(report.crowd_file))
    assert len(crowd.GetPrototypes()) == len(LOOKS)
    for number in range(AGENTS):
        agent = crowd.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}")
        assert not [name for name in agent.GetAuthoredPropertyNames() if name.startswith("material:")]
    assert not crowd.GetPrimAtPath("/Crowd/Materials")
