"""`tools/make_stages.py` makes what is committed, and it is clean USD."""

import numpy as np
import pytest
from make_stages import main
from pxr import Sdf, Usd, UsdGeom, UsdSkel, UsdValidation, Vt
from stagecraft.rig import human_rig

FILES = (
    "human.usdc", "bird.usdc", "dinosaur.usdc", "clips.usdc", "terrain_flat.usda", "terrain_slope.usda",
    "terrain_stairs.usda", "terrain_stones.usda", "terrain_hills.usda", "obstacle_course.usda",
    "stepping_stones.usda", "crowd.usda", "trajectories.usda", "terrain_spiral.usda", "physics_bird_walk.usda",
    "physics_bird_tracks.usda", "physics_dinosaur_stairs.usda", "physics_dinosaur_leaps.usda", "physics_human_run.usda",
    "plaza.usda", "river.usda",
)  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stages")
    assert main(["-o", str(folder)]) == 0
    return folder


def spec_values(layer: Sdf.Layer) -> dict:
    """Every field of every spec of a layer, with time samples as their values."""
    found = {}

    def visit(path: Sdf.Path) -> None:
        spec = layer.GetObjectAtPath(path)
        for key in spec.ListInfoKeys() if spec else []:  # targets of relationships have no spec
            found[path, key] = spec.GetInfo(key)
        for code in layer.ListTimeSamplesForPath(path) if path.IsPropertyPath() else []:
            found[path, code] = layer.QueryTimeSample(path, code)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found


def same(first: object, second: object) -> bool:
    """Equal, numbers to 1e-5 (other processors round the last digit differently)."""
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(same(first[key], second[key]) for key in first)
    if type(first).__module__.endswith("_vt") or isinstance(first, float):
        mine, other = (np.array(value) for value in (first, second))
        if mine.dtype.kind in "fiu":
            return mine.shape == other.shape and np.allclose(mine, other, rtol=1e-5, atol=1e-5)
    return first == second


@pytest.mark.parametrize("name", FILES)
def test_the_committed_stages_are_what_the_tool_makes(stages, made, name):
    committed, fresh = (spec_values(Sdf.Layer.FindOrOpen(str(folder / name))) for folder in (stages, made))
    assert committed.keys() == fresh.keys()
    differing = [key for key in committed if not same(committed[key], fresh[key])]
    assert differing == []


def test_nothing_else_is_made(stages, made):
    assert {path.name for path in made.iterdir()} == set(FILES)
    assert {path.name for path in stages.iterdir()} == {*FILES, "README.md", "gallery"}


def test_the_same_bytes_again(made, tmp_path):
    main(["-o", str(tmp_path)])
    for name in FILES:
        assert (made / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_small(stages):
    assert sum(path.stat().st_size for path in stages.iterdir()) < 12e6


@pytest.mark.parametrize("name", FILES)
def test_all_validators_are_silent(stages, name):
    stage = Usd.Stage.Open(str(stages / name))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [error.GetErrorAsString() for error in errors] == []


@pytest.mark.parametrize("name", FILES)
def test_metadata_is_authored(stages, name):
    layer = Sdf.Layer.FindOrOpen(str(stages / name))
    keys = layer.pseudoRoot.ListInfoKeys()
    assert {"defaultPrim", "metersPerUnit", "upAxis", "timeCodesPerSecond"} <= set(keys)
    assert all(not path.startswith("/") for path in layer.GetExternalReferences())


class TestHuman:
    @pytest.fixture
    def stage(self, stages) -> Usd.Stage:
        return Usd.Stage.Open(str(stages / "human.usdc"))

    def meshes(self, stage) -> list[UsdGeom.Mesh]:
        return [UsdGeom.Mesh(prim) for prim in stage.GetPrimAtPath("/Human/Body").GetChildren()]

    def test_stands_as_tall_as_a_person_with_the_soles_on_the_ground(self, stage):
        low, high = np.array(UsdGeom.Boundable.Get(stage, "/Human").GetExtentAttr().Get())
        assert low[1] == pytest.approx(0.0, abs=1e-6)
        assert high[1] == pytest.approx(1.75, abs=0.01)
        assert high[0] == pytest.approx(-low[0], abs=5e-3)

    def test_surfaces_are_closed_and_face_outward(self, stage):
        for mesh in self.meshes(stage):
            quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
            edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
            forward, backward = set(map(tuple, edges)), set(map(tuple, edges[:, ::-1]))
            assert forward == backward and len(forward) == len(edges), mesh.GetPath()
            points = np.array(mesh.GetPointsAttr().Get(), dtype=float)
            a, b, c, d = (points[quads[:, k]] for k in range(4))
            assert np.einsum("ij,ij->", a, np.cross(b, c) + np.cross(c, d)) > 0.0, mesh.GetPath()

    def test_weights_sum_to_one_with_at_most_four_influences(self, stage):
        for mesh in self.meshes(stage):
            binding = UsdSkel.BindingAPI(mesh.GetPrim())
            primvar = binding.GetJointWeightsPrimvar()
            weights = np.array(primvar.Get()).reshape(-1, primvar.GetElementSize())
            assert primvar.GetElementSize() <= 4
            assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-5

    def test_neighbouring_points_have_similar_weights(self, stage):
        count = len(human_rig().names)
        for mesh in self.meshes(stage):
            binding = UsdSkel.BindingAPI(mesh.GetPrim())
            joints, weights = (
                np.array(primvar.Get()).reshape(-1, 4)
                for primvar in (binding.GetJointIndicesPrimvar(), binding.GetJointWeightsPrimvar())
            )
            dense = np.zeros((len(joints), count))
            np.add.at(dense, (np.arange(len(joints))[:, None], joints), weights)
            quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
            assert np.abs(dense[quads[:, 0]] - dense[quads[:, 1]]).max() < 0.6, mesh.GetPath()

    def test_the_biped_is_told(self, stage):
        prim = stage.GetPrimAtPath("/Human/Skeleton")
        joints = list(UsdSkel.Skeleton(prim).GetJointsAttr().Get())
        assert len(joints) == 24
        rest = np.array(
            UsdSkel.ConcatJointTransforms(
                UsdSkel.Topology(joints), UsdSkel.Skeleton(prim).GetRestTransformsAttr().Get()
            )
        )
        for side in ("left", "right"):
            for role in ("hip", "knee", "ankle", "ball"):
                assert prim.GetAttribute(f"usdfoot:biped:{side}:{role}").Get() in joints
            ball = joints.index(prim.GetAttribute(f"usdfoot:biped:{side}:ball").Get())
            told = prim.GetAttribute(f"usdfoot:biped:{side}:ballHeight").Get()
            assert rest[ball, 3, 1] == pytest.approx(told, abs=1e-6)
        com = np.array(prim.GetAttribute("usdfoot:biped:com").Get()) + rest[0, 3, :3]
        assert com[1] == pytest.approx(0.56 * 1.75, abs=0.04)  # people: 55 to 57 % of the height
        assert isinstance(prim.GetAttribute("joints").Get(), Vt.TokenArray)
