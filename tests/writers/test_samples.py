"""Layers that begin with their samples against layers in which samples are set one by one."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from usdfoot.writers.crate.sampled import Samples
from usdfoot.writers.crate.stored import read_samples
from usdfoot.writers.samples import copy_unsampled, sampled_layer, sampled_prims, samples_of

FRAMES = np.array([-3.0, 0.0, 0.125, 1.0, 1e6])
VALUES = {
    "double": (Sdf.ValueTypeNames.Double, (), float),
    "double3": (Sdf.ValueTypeNames.Double3, (3,), lambda row: Gf.Vec3d(*row.tolist())),
    "float[]": (Sdf.ValueTypeNames.FloatArray, (3,), Vt.FloatArray.FromNumpy),
    "float3[]": (Sdf.ValueTypeNames.Float3Array, (2, 3), Vt.Vec3fArray.FromNumpy),
    "quatf[]": (Sdf.ValueTypeNames.QuatfArray, (300, 4), Vt.QuatfArray.FromNumpy),
}
NAMES = {kind: f"a:{kind.removesuffix('[]')}{len(kind)}" for kind in VALUES}


def values_of(type_name: str, seed: int) -> np.ndarray:
    """Some of which stay the same for a frame or two."""
    shape = VALUES[type_name][1]
    drawn = np.random.default_rng(seed).normal(size=(len(FRAMES), *shape))
    drawn[1 + seed % 3] = drawn[seed % 3]
    drawn[-1] = drawn[-2] = -0.0 if seed % 2 else drawn[-1]
    return drawn.astype(np.float32 if type_name.endswith("[]") else float)


def samples_for(agents: int) -> dict[str, dict[str, Samples]]:
    return {
        f"Agent_{number}": {
            NAMES[kind]: Samples(type_name=kind, codes=FRAMES + number // 2, values=values_of(kind, number))
            for kind in VALUES
        }
        for number in range(agents)
    }


def author_one_by_one(samples: dict[str, dict[str, Samples]]) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    for name, attributes in samples.items():
        prim = Sdf.CreatePrimInLayer(layer, f"/Crowd/Anims/{name}")
        for above in prim.path.GetPrefixes():
            layer.GetPrimAtPath(above).specifier = Sdf.SpecifierDef
        for attribute, sampled in attributes.items():
            kind, _, convert = VALUES[sampled.type_name]
            spec = Sdf.AttributeSpec(prim, attribute, kind)
            for code, value in zip(sampled.codes.tolist(), sampled.values, strict=True):
                layer.SetTimeSample(spec.path, code, convert(value))
    return layer


@pytest.mark.parametrize("agents", [1, 2, 70])
def test_layers_are_the_same_as_with_samples_set_one_by_one(tmp_path: Path, agents: int) -> None:
    samples = samples_for(agents)
    layer, expected = sampled_layer(tmp_path / "own.usdc", "/Crowd/Anims", samples), author_one_by_one(samples)
    assert layer.ExportToString() == expected.ExportToString()
    for each in (layer, expected):
        with Sdf.ChangeBlock():
            for prim in each.GetPrimAtPath("/Crowd/Anims").nameChildren:
                prim.typeName = "SkelAnimation"
                Sdf.AttributeSpec(prim, "joints", Sdf.ValueTypeNames.TokenArray).default = ["a", "b"]
        each.customLayerData = {"made": "since"}
    written = layer.ExportToString()
    assert layer.Save() and written == expected.ExportToString()
    assert Sdf.Layer.OpenAsAnonymous(str(tmp_path / "own.usdc")).ExportToString() == written


def test_what_stays_the_same_is_in_the_file_once(tmp_path: Path) -> None:
    still = np.ones((100, 300, 4), dtype=np.float32)
    moving = still + np.arange(100, dtype=np.float32)[:, None, None]
    for name, values in (("still", still), ("moving", moving)):
        samples = Samples(type_name="quatf[]", codes=np.arange(100.0), values=values)
        sampled_layer(tmp_path / f"{name}.usdc", "/Crowd", {"A": {"rotations": samples}})
    sizes = [(tmp_path / f"{name}.usdc").stat().st_size for name in ("still", "moving")]
    assert sizes[1] - sizes[0] == 99 * (8 + 300 * 16)


def test_agents_taken_from_another_layer_leave_the_bytes_they_had(tmp_path: Path) -> None:
    samples = samples_for(3)
    first = sampled_layer(tmp_path / "first.usdc", "/Crowd/Anims", samples)
    for number, name in enumerate(samples):
        author_rest(first.GetPrimAtPath(f"/Crowd/Anims/{name}"), number)
    first.Save()
    source = Sdf.Layer.OpenAsAnonymous(str(tmp_path / "first.usdc"))
    prims = {name: source.GetPrimAtPath(f"/Crowd/Anims/{name}") for name in samples}
    again = sampled_layer(tmp_path / "again.usdc", "/Crowd/Anims", {name: samples_of(prims[name]) for name in samples})
    author_rest(again.GetPrimAtPath("/Crowd/Anims/Agent_1"), 1)
    for name in ("Agent_2", "Agent_0"):
        copy_unsampled(prims[name], again.GetPrimAtPath(f"/Crowd/Anims/{name}"))
    again.Save()
    assert (tmp_path / "again.usdc").read_bytes() == (tmp_path / "first.usdc").read_bytes()


def author_rest(prim: Sdf.PrimSpec, number: int) -> None:
    """All kinds of things that the prims of a crowd have."""
    prim.typeName, prim.instanceable = "SkelRoot", True
    prim.referenceList.prependedItems = [Sdf.Reference("../human.usdc", "/Human")]
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = ["SkelBindingAPI", "UsdfootAgentAPI"]
    prim.SetInfo("apiSchemas", schemas)
    target = Sdf.RelationshipSpec(prim, "usdfoot:agent:plan", custom=False)
    target.targetPathList.explicitItems = [Sdf.Path(f"/Crowd/Plans/Agent_{number}")]
    order = Sdf.AttributeSpec(prim, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
    order.default = [NAMES["double3"]]
    seen = Sdf.AttributeSpec(prim, "visibility", Sdf.ValueTypeNames.Token)
    seen.default = "inherited"
    prim.layer.SetTimeSample(seen.path, 3.0 + number, "invisible")


def test_what_a_failed_run_left_in_memory_is_not_taken_for_the_file(tmp_path: Path) -> None:
    file, samples = tmp_path / "own.usdc", samples_for(2)
    held = sampled_layer(file, "/Crowd/Anims", samples)
    author_rest(held.GetPrimAtPath("/Crowd/Anims/Agent_0"), 0)
    file.unlink()
    layer = sampled_layer(file, "/Crowd/Anims", {"Other": samples["Agent_1"]})
    assert layer.ExportToString() == author_one_by_one({"Other": samples["Agent_1"]}).ExportToString()


def test_samples_are_read_as_written_and_one_by_one_where_somebody_else_wrote_them(tmp_path: Path) -> None:
    samples = samples_for(4)
    layer = sampled_layer(tmp_path / "own.usdc", "/Crowd/Anims", samples)
    for name in samples:
        author_rest(layer.GetPrimAtPath(f"/Crowd/Anims/{name}"), 1)
    layer.Save()
    layer.Export(str(tmp_path / "other.usdc"))
    with pytest.raises(ValueError, match="not written as whole arrays"):
        read_samples(tmp_path / "other.usdc", "/Crowd/Anims")
    assert list(read_samples(tmp_path / "own.usdc", "/Crowd/Anims")) == list(samples)
    for file in (tmp_path / "own.usdc", tmp_path / "other.usdc"):
        opened = Sdf.Layer.OpenAsAnonymous(str(file))
        prims = [opened.GetPrimAtPath(f"/Crowd/Anims/Agent_{index}") for index in (2, 0)]
        found = sampled_prims(file, prims)
        assert list(found) == ["Agent_2", "Agent_0"]
        for name, attributes in found.items():
            assert list(attributes) == list(samples[name])
            for attribute, read in attributes.items():
                given = samples[name][attribute]
                assert read.type_name == given.type_name
                np.testing.assert_array_equal(read.codes, given.codes)
                np.testing.assert_array_equal(read.values, given.values, strict=True)


def test_prims_below_prims_are_not_read_as_arrays(tmp_path: Path) -> None:
    layer = sampled_layer(tmp_path / "own.usdc", "/Crowd/Anims", samples_for(2))
    Sdf.CreatePrimInLayer(layer, "/Crowd/Anims/Agent_0/Below")
    layer.Save()
    with pytest.raises(ValueError, match="Agent_0 has prims below it"):
        read_samples(tmp_path / "own.usdc", "/Crowd/Anims")
