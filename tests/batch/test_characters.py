"""Several characters with variants in one crowd share as many prototypes as there are characters and variants."""

import pytest
from pxr import Gf, Usd, UsdGeom

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
