"""Levels of detail: variants of a character become the items of a UsdLod root, in prototypes that agents share."""

import pytest
from pxr import Gf, Usd, UsdGeom, UsdSkel, UsdValidation

from tests.batch.conftest import AGENTS, write_crowd_scene
from tests.batch.test_characters import LOOKS, write_looks
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.levels import DetailLevels
from usdfoot.pipeline.again import remake
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate
from usdfoot.readers.written import read_written_crowd

LEVELS = DetailLevels(variants=LOOKS, distances=(15.0,))


@pytest.fixture(scope="module")
def leveled_scene(stages, tmp_path_factory):
    """A crowd of people in two variants, whose character is bound to an animation of its own as many are."""
    folder = tmp_path_factory.mktemp("levels")
    scene = write_crowd_scene(stages, folder / "scene")
    write_looks(folder / "looks.usda", stages / "human.usdc")
    stage = Usd.Stage.Open(str(scene))
    stage.DefinePrim("/World/Cast/Person").GetReferences().AddReference(str(folder / "looks.usda"))
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets(["/World/Cast/Person"])
    stage.Save()
    return scene


@pytest.fixture(scope="module", params=[False, True], ids=["referenced", "collected"])
def leveled(request, leveled_scene, tmp_path_factory):
    return animate(leveled_scene, tmp_path_factory.mktemp("out"), levels=LEVELS, collect=request.param, chunk_size=2)


def below(prim, kind):
    return [part for part in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if part.IsA(kind)]


def colors_of(prim):
    meshes = [UsdGeom.Mesh(mesh) for mesh in below(prim, UsdGeom.Mesh)]
    return {tuple(color) for mesh in meshes for color in mesh.GetDisplayColorAttr().Get() or ()}


def test_agents_share_one_prototype_and_every_level_moves(leveled):
    stage = Usd.Stage.Open(str(leveled.crowd_file))
    agents = stage.GetPrimAtPath("/Crowd/Agents").GetChildren()
    assert all(agent.IsInstance() for agent in agents) and len(stage.GetPrototypes()) == 1
    cache = UsdSkel.Cache()
    code = 0.5 * (stage.GetStartTimeCode() + stage.GetEndTimeCode())
    for agent in agents:
        cache.Populate(UsdSkel.Root(agent), Usd.TraverseInstanceProxies())
        near, far = below(agent, UsdSkel.Skeleton)
        poses = [cache.GetSkelQuery(UsdSkel.Skeleton(part)).ComputeSkinningTransforms(code) for part in (near, far)]
        assert poses[0] == poses[1] and not Gf.IsClose(poses[0][5], Gf.Matrix4d(1.0), 1e-3)
        assert UsdGeom.Xformable(near).ComputeLocalToWorldTransform(code) == UsdGeom.Xformable(
            far
        ).ComputeLocalToWorldTransform(code)
        colors = [colors_of(part.GetParent()) for part in (near, far)]
        assert (1.0, 0.0, 0.0) in colors[0] and (0.0, 0.0, 1.0) in colors[1]
    assert validate(leveled.crowd_file).passed


def test_usd_itself_chooses_by_distance(leveled):
    lod = pytest.importorskip("pxr.UsdLod", reason="USD before 26.08 has no UsdLod")
    stage = Usd.Stage.Open(str(leveled.crowd_file))
    agent = stage.GetPrimAtPath("/Crowd/Agents/Agent_0")
    root = next(part for part in below(agent, UsdGeom.Xform) if part.HasAPI(lod.RootAPI))
    items = root.GetChildren()
    shown = [UsdGeom.Imageable(item).ComputeVisibility() for item in items]
    assert shown == ["inherited", "invisible"] and lod.RootAPI(root).GetLodDefaultIndexAttr().Get() == 0
    (target,) = lod.RootAPI(root).GetLodHeuristicsRel().GetTargets()
    heuristic = lod.DistanceHeuristic(stage.GetPrimAtPath(target))
    assert heuristic and heuristic.GetLodDomainAttr().Get() == lod.Tokens.imaging
    code = stage.GetStartTimeCode()
    place = UsdGeom.Xformable(root).ComputeLocalToWorldTransform(code)
    query = heuristic.CreateDistanceHeuristicQuery(code)
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    for metres, level in ((1.0, 0.0), (14.9, 0.0), (15.1, 1.0), (500.0, 1.0)):
        eye = place.ExtractTranslation() + Gf.Vec3d(0.0, 0.0, metres / scale)
        assert query.ComputeLOD(eye, place) == level


def test_nothing_is_wrong_with_it_for_usd(leveled):
    registry = UsdValidation.ValidationRegistry()
    names = [meta.name for meta in registry.GetAllValidatorMetadata() if not meta.name.startswith("usdfoot:")]
    context = UsdValidation.ValidationContext(registry.GetOrLoadValidatorsByName(names))
    found = context.Validate(Usd.Stage.Open(str(leveled.crowd_file)))
    assert [error.GetErrorAsString() for error in found] == []


def test_levels_that_an_asset_has_itself_work_through_the_agents_reference(stages, tmp_path):
    lod = pytest.importorskip("pxr.UsdLod", reason="USD before 26.08 has no UsdLod")
    asset = Usd.Stage.CreateNew(str(tmp_path / "person.usda"))
    UsdGeom.SetStageUpAxis(asset, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(asset, 1.0)
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Person").GetPrim())
    root = lod.RootAPI.Apply(UsdGeom.Xform.Define(asset, "/Person/Levels").GetPrim())
    heuristic = lod.DistanceHeuristic.Define(asset, "/Person/Distance")
    heuristic.CreateLodDomainAttr(lod.Tokens.imaging)
    heuristic.CreateThresholdsAttr([15.0])
    root.CreateLodHeuristicsRel().SetTargets([heuristic.GetPath()])
    for name in ("Near", "Far"):
        asset.DefinePrim(f"/Person/Levels/{name}").GetReferences().AddReference(str(stages / "human.usdc"))
    asset.Save()
    scene = write_crowd_scene(stages, tmp_path / "scene")
    stage = Usd.Stage.Open(str(scene))
    stage.DefinePrim("/World/Cast/Person").GetReferences().AddReference(str(tmp_path / "person.usda"))
    for number in range(AGENTS):
        agent = stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}")
        agent.GetRelationship("usdfoot:agent:character").SetTargets(["/World/Cast/Person"])
    stage.Save()

    stage = Usd.Stage.Open(str(animate(scene, tmp_path / "out", agents="Agent_[01]").crowd_file))
    assert len(stage.GetPrototypes()) == 1
    code = 0.5 * (stage.GetStartTimeCode() + stage.GetEndTimeCode())
    cache = UsdSkel.Cache()
    for agent in stage.GetPrimAtPath("/Crowd/Agents").GetChildren():
        (levels,) = (part for part in below(agent, UsdGeom.Xform) if part.HasAPI(lod.RootAPI))
        (target,) = lod.RootAPI(levels).GetLodHeuristicsRel().GetTargets()
        query = lod.DistanceHeuristic(stage.GetPrimAtPath(target)).CreateDistanceHeuristicQuery(code)
        place = UsdGeom.Xformable(levels).ComputeLocalToWorldTransform(code)
        far = 16.0 / UsdGeom.GetStageMetersPerUnit(stage)
        assert [query.ComputeLOD(place.Transform(Gf.Vec3d(0, 0, away)), place) for away in (0.0, far)] == [0.0, 1.0]
        cache.Populate(UsdSkel.Root(agent), Usd.TraverseInstanceProxies())
        queries = [cache.GetSkelQuery(UsdSkel.Skeleton(part)) for part in below(agent, UsdSkel.Skeleton)]
        near, far = [query.ComputeSkinningTransforms(code) for query in queries]
        assert near == far and not Gf.IsClose(near[5], Gf.Matrix4d(1.0), 1e-3)


def test_it_is_remade_with_its_levels(leveled):
    before = {path.name: path.read_bytes() for path in leveled.crowd_file.parent.glob("*.levels.usda")}
    assert before and remake(read_written_crowd(leveled.crowd_file)).kept_agents == AGENTS
    assert {path.name: path.read_bytes() for path in leveled.crowd_file.parent.glob("*.levels.usda")} == before


def test_variants_that_nobody_has_are_refused_by_name(leveled_scene, tmp_path):
    levels = DetailLevels.parse("red:10:green")
    with pytest.raises(SceneError, match=r"no character has a variant set with red, green.*look: blue, red"):
        animate(leveled_scene, tmp_path / "out", levels=levels)


@pytest.mark.parametrize("text", ["full", "full:far:low", "full:10", "full:0:low", "a:20:b:10:c", "a:5:a", "a:nan:b"])
def test_what_are_no_levels_is_refused(text):
    with pytest.raises(UsdfootError, match="levels: "):
        DetailLevels.parse(text)


def test_levels_are_said_as_they_are_read():
    assert str(DetailLevels.parse("full:15:mid:40.5:low")) == "full:15:mid:40.5:low"
