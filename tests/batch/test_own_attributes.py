"""What a scene says of an agent's own prim comes to the written agent, which still shares its prototype."""

import logging

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from tests.batch.conftest import AGENTS, write_crowd_scene
from tests.batch.test_characters import LOOKS, write_looks
from tests.digests import digests
from usdfoot.pipeline.animate import animate
from usdfoot.readers.scene import read_scene

TYPES = Sdf.ValueTypeNames
SAID = {
    "primvars:one": (TYPES.Float, 0.1),
    "primvars:pair": (TYPES.TexCoord2f, Gf.Vec2f(0.5, 3)),
    "primvars:tint": (TYPES.Color3f, Gf.Vec3f(1, 2, 3)),
    "primvars:four": (TYPES.Color4fArray, [Gf.Vec4f(1, 0, 0.25, 1), Gf.Vec4f(7)]),
    "primvars:many": (TYPES.FloatArray, [0.1, 0.2, 0.4]),
    "primvars:many:indices": (TYPES.IntArray, [2, -1, 0]),
    "primvars:none": (TYPES.FloatArray, []),
    "userProperties:job": (TYPES.String, "baker, “second” shift"),
    "userProperties:age": (TYPES.Int, -42),
    "userProperties:id": (TYPES.Int64, -(1 << 40)),
    "userProperties:ids": (TYPES.Int64Array, [1 << 40, -3]),
    "userProperties:tired": (TYPES.Bool, True),
    "userProperties:tags": (TYPES.TokenArray, ["a", "", "b"]),
    "userProperties:kind": (TYPES.Token, "tall"),
    "studio:height": (TYPES.Double, 1.1),
    "studio:place": (TYPES.Double3, Gf.Vec3d(0.1, 0.2, 0.3)),
    "studio:places": (TYPES.Double2, Gf.Vec2d(0.1, 0.2)),
    "studio:turn": (TYPES.Double4, Gf.Vec4d(0.1, 0.2, 0.3, 0.4)),
}
OVER_TIME = {
    "primvars:glow": (TYPES.Float, (0.1, 0.25, 0.25)),
    "primvars:fade": (TYPES.Color3fArray, ([Gf.Vec3f(1, 0, 0)], [Gf.Vec3f(1, 0, 0)], [Gf.Vec3f(0, 0, 1)])),
    "primvars:offset": (TYPES.Double, (0.1, 0.2, 0.2)),
    "userProperties:mood": (TYPES.Token, ("glad", "sad", "glad")),
    "userProperties:count": (TYPES.Int, (1, -2, 3)),
    "userProperties:on": (TYPES.Bool, (True, False, True)),
}
CODES = (0.0, 12.5, 40.0)


def color_of(number):
    return Gf.Vec3f(0.1 * number, 0.5, 1.0)


def set_color(prim, color):
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("displayColor", TYPES.Color3fArray, UsdGeom.Tokens.constant, 1)
    primvar.Set(Vt.Vec3fArray([color]))


def describe(prim, number):
    """Everything a scene can say of an agent that does not make it another character."""
    set_color(prim, color_of(number))
    UsdGeom.Imageable(prim).CreatePurposeAttr("render" if number else "proxy")
    for name, (kind, value) in SAID.items():
        prim.CreateAttribute(name, kind, custom=not name.startswith("primvars")).Set(value)
    for name, (kind, values) in OVER_TIME.items():
        attribute = prim.CreateAttribute(name, kind)
        attribute.Set(values[number % 3])
        for code, value in zip(CODES, values, strict=True):
            attribute.Set(value, code + number)
    prim.GetAttribute("primvars:one").AddConnection("/World/Somewhere.out")
    prim.CreateAttribute("primvars:only", TYPES.Float).AddConnection("/World/Somewhere.out")


def write_own_scene(stages, folder, *, asset=None, describe=describe):
    """Agents that are references to the character each, with attributes of their own."""
    scene = write_crowd_scene(stages, folder)
    stage = Usd.Stage.Open(str(scene))
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.RemoveProperty("usdfoot:agent:character")
        agent.GetReferences().AddReference(str(asset or stages / "human.usdc"))
        describe(agent, number)
    stage.Save()
    return scene


def said_of(prim):
    """All that a prim's own attributes say, without what places and animates it."""
    found = {}
    for attribute in prim.GetAuthoredAttributes():
        if attribute.GetName().startswith(("xformOp", "usdfoot:", "extent")):
            continue
        found[attribute.GetName()] = (
            attribute.GetTypeName(),
            attribute.Get(),
            [(code, attribute.Get(code)) for code in attribute.GetTimeSamples()],
            attribute.IsCustom(),
            attribute.GetVariability(),
            attribute.GetMetadata("interpolation"),
            attribute.GetMetadata("elementSize"),
        )
    return found


def agents_in(crowd):
    return [crowd.GetPrimAtPath(f"/Crowd/Agents/Agent_{number}") for number in range(AGENTS)]


@pytest.fixture(scope="module")
def shot(stages, tmp_path_factory):
    folder = tmp_path_factory.mktemp("own")
    scene = write_own_scene(stages, folder / "scene")
    return scene, animate(scene, folder / "out", chunk_size=2)


def test_agents_share_character_library_and_prototype(shot):
    scene, report = shot
    read = read_scene(str(scene))
    assert (len(read.characters), len(read.crowd.libraries)) == (1, 1)
    crowd = Usd.Stage.Open(str(report.crowd_file))
    assert len(crowd.GetPrototypes()) == 1
    assert all(agent.IsInstance() for agent in agents_in(crowd))


def test_agents_say_what_the_scene_says(shot):
    scene, report = shot
    stage, crowd = Usd.Stage.Open(str(scene)), Usd.Stage.Open(str(report.crowd_file))
    for number, agent in enumerate(agents_in(crowd)):
        source = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        expected = said_of(source)
        assert expected.pop("primvars:only")[1] is None
        assert {*SAID, *OVER_TIME, "primvars:displayColor", "purpose"} <= {*expected}
        assert said_of(agent) == expected
        assert not agent.GetAttribute("primvars:one").HasAuthoredConnections()


def test_primvars_reach_the_shared_meshes(shot):
    crowd = Usd.Stage.Open(str(shot[1].crowd_file))
    for agent in agents_in(crowd):
        meshes = [prim for prim in Usd.PrimRange(agent, Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh)]
        found = [UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("primvars:tint") for mesh in meshes]
        assert meshes and all(mesh.IsInstanceProxy() for mesh in meshes)
        assert {tuple(primvar.Get()) for primvar in found} == {(1.0, 2.0, 3.0)}


def test_workers_and_a_changed_color_leave_the_bytes_of_a_first_run(stages, worker, tmp_path, caplog):
    """Only the agent whose colour changed is made again."""
    caplog.set_level(logging.INFO)
    scene = write_own_scene(stages, tmp_path / "scene")
    report = animate(scene, tmp_path / "out", chunk_size=2)
    animate(scene, tmp_path / "workers", chunk_size=2, executor=worker)
    assert digests(tmp_path / "out") == digests(tmp_path / "workers")
    stage = Usd.Stage.Open(str(scene))
    set_color(stage.GetPrimAtPath("/World/Crowd/Agent_0"), Gf.Vec3f(0.0, 1.0, 0.0))
    stage.Save()
    again = animate(scene, tmp_path / "out", chunk_size=2)
    assert "USD copies it" not in caplog.text
    assert (report.kept_agents, again.kept_agents) == (0, AGENTS - 1)
    animate(scene, tmp_path / "fresh", chunk_size=2)
    assert digests(tmp_path / "out") == digests(tmp_path / "fresh")
    crowd = Usd.Stage.Open(str(again.crowd_file))
    assert tuple(agents_in(crowd)[0].GetAttribute("primvars:displayColor").Get()[0]) == (0.0, 1.0, 0.0)


def test_who_comes_first_is_no_part_of_what_others_are_made_from(stages, tmp_path):
    scene = write_own_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", chunk_size=1)
    stage = Usd.Stage.Open(str(scene))
    stage.GetPrimAtPath("/World/Crowd/Agent_0").SetActive(False)
    stage.Save()
    assert animate(scene, tmp_path / "out", chunk_size=1).kept_agents == AGENTS - 1


def test_an_agent_has_its_own_over_those_of_the_character_it_points_at(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    stage = Usd.Stage.Open(str(scene))
    character = stage.DefinePrim("/World/Hero")
    character.GetReferences().AddReference(str(stages / "human.usdc"))
    set_color(character, Gf.Vec3f(1, 0, 0))
    character.CreateAttribute("userProperties:of", TYPES.String).Set("all")
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets(["/World/Hero"])
    set_color(agent, Gf.Vec3f(0, 0, 1))
    agent.CreateAttribute("userProperties:name", TYPES.String).Set("last")
    stage.Save()
    crowd = Usd.Stage.Open(str(animate(scene, tmp_path / "out").crowd_file))
    assert len(crowd.GetPrototypes()) == 1
    colors = [tuple(agent.GetAttribute("primvars:displayColor").Get()[0]) for agent in agents_in(crowd)]
    assert colors == [(1.0, 0.0, 0.0)] * (AGENTS - 1) + [(0.0, 0.0, 1.0)]
    assert [agent.GetAttribute("userProperties:of").Get() for agent in agents_in(crowd)] == ["all"] * AGENTS
    assert agents_in(crowd)[-1].GetAttribute("userProperties:name").Get() == "last"


def test_variants_with_colors_of_their_own_share_prototypes(stages, tmp_path):
    write_looks(tmp_path / "looks.usda", stages / "human.usdc")

    def describe(agent, number):
        agent.GetVariantSet("look").SetVariantSelection(LOOKS[number % 2])
        agent.CreateAttribute("primvars:tint", TYPES.Float).Set(float(number))

    scene = write_own_scene(stages, tmp_path / "scene", asset=tmp_path / "looks.usda", describe=describe)
    crowd = Usd.Stage.Open(str(animate(scene, tmp_path / "out", chunk_size=2).crowd_file))
    assert len(crowd.GetPrototypes()) == len(LOOKS)
    assert [agent.GetAttribute("primvars:tint").Get() for agent in agents_in(crowd)] == [*range(AGENTS)]


def write_varied_scene(stages, folder):
    """Agents in two variants of one asset, of whom only some say more of themselves."""
    write_looks(folder / "looks.usda", stages / "human.usdc")

    def describe(agent, number):
        agent.GetVariantSet("look").SetVariantSelection(LOOKS[number == 1])
        if number == 2:
            set_color(agent, color_of(number))
            UsdGeom.Imageable(agent).MakeInvisible()
            agent.CreateAttribute("usdfoot:agent:ikReach", TYPES.Float, custom=False).Set(0.2)

    return write_own_scene(stages, folder / "scene", asset=folder / "looks.usda", describe=describe)


@pytest.mark.parametrize("collect", [False, True])
def test_variants_share_prototypes_whatever_else_their_agents_say(stages, tmp_path, collect):
    report = animate(write_varied_scene(stages, tmp_path), tmp_path / "out", chunk_size=2, collect=collect)
    crowd = Usd.Stage.Open(str(report.crowd_file))
    first, other, last = (agent.GetPrototype() for agent in agents_in(crowd))
    assert first == last != other
    assert [agent.GetAttribute("visibility").Get() for agent in agents_in(crowd)] == ["inherited"] * 2 + ["invisible"]
    assert not agents_in(crowd)[0].GetAttribute("primvars:displayColor").HasAuthoredValue()
    for number, agent in enumerate(agents_in(crowd)):
        meshes = [prim for prim in Usd.PrimRange(agent, Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh)]
        colors = {tuple(color) for mesh in meshes for color in UsdGeom.Mesh(mesh).GetDisplayColorAttr().Get() or ()}
        assert ((0.0, 0.0, 1.0) if number == 1 else (1.0, 0.0, 0.0)) in colors


def test_variants_do_not_depend_on_who_comes_first(stages, tmp_path):
    scene = write_varied_scene(stages, tmp_path)
    animate(scene, tmp_path / "out", chunk_size=1)
    stage = Usd.Stage.Open(str(scene))
    stage.GetPrimAtPath("/World/Crowd/Agent_0").SetActive(False)
    stage.Save()
    assert animate(scene, tmp_path / "out", chunk_size=1).kept_agents == AGENTS - 1


def move_a_joint(prim):
    prim.GetStage().OverridePrim(f"{prim.GetPath()}/Skeleton").SetCustomDataByKey("changed", True)


def bind_a_skin(prim):
    prim.CreateAttribute("primvars:skel:jointIndices", TYPES.IntArray).Set([1])


def color_by_vertex(prim):
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("each", TYPES.FloatArray, UsdGeom.Tokens.vertex).Set([1.0])


def hide_as_guide(prim):
    UsdGeom.Imageable(prim).CreatePurposeAttr("guide")


def take_away(prim):
    prim.CreateAttribute("primvars:tint", TYPES.Float).Block()


def point_at_a_file(prim):
    prim.CreateAttribute("userProperties:file", TYPES.Asset).Set("./a.txt")


def bind_a_collection(prim):
    targets = [prim.GetPath().AppendProperty("collection:hair"), "/World/Looks/Red"]
    prim.CreateRelationship("material:binding:collection:hair").SetTargets(targets)


@pytest.mark.parametrize(
    "change", [move_a_joint, bind_a_skin, color_by_vertex, hide_as_guide, take_away, point_at_a_file, bind_a_collection]
)
def test_what_changes_the_character_makes_another(stages, tmp_path, change):
    def describe(agent, number):
        if not number:
            change(agent)

    scene = write_own_scene(stages, tmp_path / "scene", describe=describe)
    assert len(read_scene(str(scene)).characters) == 2


def test_an_attribute_may_be_of_another_type_than_the_asset_s(stages, tmp_path):
    def describe(agent, number):
        layer = agent.GetStage().GetRootLayer()
        spec = Sdf.AttributeSpec(layer.GetPrimAtPath(agent.GetPath()), "primvars:tint", TYPES.Color3fArray)
        layer.SetTimeSample(spec.path, 1.0, Vt.Vec3fArray([color_of(number)]))

    asset = Usd.Stage.CreateNew(str(tmp_path / "person.usda"))
    asset.SetDefaultPrim(asset.DefinePrim("/Person"))
    asset.GetDefaultPrim().GetReferences().AddReference(str(stages / "human.usdc"))
    asset.GetDefaultPrim().CreateAttribute("primvars:tint", TYPES.Float).Set(1.0)
    asset.Save()
    scene = write_own_scene(stages, tmp_path / "scene", asset=tmp_path / "person.usda", describe=describe)
    read = read_scene(str(scene))
    own = [read.own_attributes[f"Agent_{number}"]["primvars:tint"] for number in range(AGENTS)]
    assert len(read.characters) == 1
    assert [(said.type_name, said.value, said.codes) for said in own] == [("color3f[]", None, (1.0,))] * AGENTS
