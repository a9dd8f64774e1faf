"""Layers written from specs against layers that USD made of the same, and read back as the specs they were."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, Vt

from usdfoot.bridge.units import StageUnits
from usdfoot.writers.attributes import (
    Attribute,
    author_attributes,
    layer_spec,
    prim_spec,
    relationship_spec,
    sampled_spec,
    seen_spec,
    specs_of,
)
from usdfoot.writers.crate.reading import read_layer
from usdfoot.writers.crate.specs import PackedSamples, Reference, Samples, Spec, switch
from usdfoot.writers.crate.writing import write_layer
from usdfoot.writers.layers import LayerFormat, apply_schemas, author_targets, define_prim, new_layer

SCOPE = "/Crowd/Agents"
FORMAT = LayerFormat(
    units=StageUnits(meters_per_unit=0.01, up_axis="Z", time_codes_per_second=24.0),
    frames_per_second=1.0 / 3.0,
    start_code=-3.0,
    end_code=1e6,
)
DATA = {"usdfoot": {"made": {"A": "1", "B": "2"}, "hash": "a hash", "report": '{"of": "A"}\n' * 999}}
FRAMES = np.array([-3.0, 0.0, 0.125, 1.0, 1e6])
SAMPLED = {
    "double": (Sdf.ValueTypeNames.Double, (), float),
    "double3": (Sdf.ValueTypeNames.Double3, (3,), lambda row: Gf.Vec3d(*row.tolist())),
    "float[]": (Sdf.ValueTypeNames.FloatArray, (3,), Vt.FloatArray.FromNumpy),
    "float3[]": (Sdf.ValueTypeNames.Float3Array, (2, 3), Vt.Vec3fArray.FromNumpy),
    "quatf[]": (Sdf.ValueTypeNames.QuatfArray, (300, 4), Vt.QuatfArray.FromNumpy),
}


def samples_for(number: int) -> dict[str, Samples]:
    """Some of which stay the same for a frame or two."""
    found = {}
    for kind, (_, shape, _) in SAMPLED.items():
        values = np.random.default_rng(number).normal(size=(len(FRAMES), *shape))
        values[1 + number % 3] = values[number % 3]
        values[-1] = values[-2] = -0.0 if number % 2 else values[-1]
        values = values.astype(np.float32 if kind.endswith("[]") else float)
        found[f"over:{kind.strip('[]')}"] = Samples(type_name=kind, codes=FRAMES + number // 2, values=values)
    return found


def attributes_for(number: int) -> dict[str, Attribute]:
    rng = np.random.default_rng(number)
    return {
        "purpose": Attribute("token", "guide", uniform=True),
        "names": Attribute("token[]", ["", "ok", f"clip{number}"], uniform=True),
        "nobody": Attribute("token[]", []),
        "height": Attribute("float", 0.1 * number, uniform=True),
        "large": Attribute("double", 0.1),
        "turned": Attribute("quatd", [0.5, -0.5, 0.5, 0.5]),
        "scaled": Attribute("double3", [0.01, 0.01, 2.0]),
        "indices": Attribute("int[]", np.array([1, -2, 3])),
        "same": Attribute("float[]", np.ones(40), uniform=True),
        "none": Attribute("float3[]", np.zeros((0, 3))),
        "points": Attribute("point3f[]", rng.normal(size=(5, 3))),
        "normals": Attribute("normal3f[]", np.eye(3), interpolation="uniform"),
        "color": Attribute("color3f[]", np.array([[1.0, 0.0, 0.5]]), interpolation="constant"),
        "scales": Attribute("half3[]", rng.normal(size=(2, 3)).astype(np.float16)),
        "turns": Attribute("quath[]", rng.normal(size=(2, 4)).astype(np.float16)),
        "times": Attribute("timecode[]", np.array([0.5, number])),
    }


def spec_for(number: int, mesh: Spec) -> Spec:
    name = f"Agent_{number}"
    below = {
        **{f".{attribute}": sampled_spec(samples) for attribute, samples in samples_for(number).items()},
        ".of": relationship_spec([f"/Crowd/Anims/{name}", f"{SCOPE}/{name}/Left", f"{SCOPE}/{name}/Looks/Skin"]),
        **specs_of(attributes_for(number)),
        ".visibility": seen_spec("inherited", [1.5] if number else [], ["invisible"] if number else []),
        "Left": mesh,
    }
    fields = {"instanceable": switch(True), "references": Reference(f"../human{number % 2}.usdc", "/Human")}
    return prim_spec("SkelRoot", below, schemas=["SkelBindingAPI", f"Of{number}API"], fields=fields)


def author_one_by_one(numbers: list[int]) -> Sdf.Layer:
    layer = new_layer(FORMAT)
    layer.customLayerData = DATA
    define_prim(layer, SCOPE, "Scope")
    for number in numbers:
        prim = define_prim(layer, f"{SCOPE}/Agent_{number}", "SkelRoot")
        prim.instanceable = True
        prim.referenceList.prependedItems = [Sdf.Reference(f"../human{number % 2}.usdc", "/Human")]
        apply_schemas(prim, ["SkelBindingAPI", f"Of{number}API"])
        for attribute, sampled in samples_for(number).items():
            kind, _, convert = SAMPLED[sampled.type_name]
            spec = Sdf.AttributeSpec(prim, attribute, kind)
            for code, value in zip(sampled.codes.tolist(), sampled.values, strict=True):
                layer.SetTimeSample(spec.path, code, convert(value))
        targets = [f"/Crowd/Anims/Agent_{number}", f"{prim.path}/Left", f"{prim.path}/Looks/Skin"]
        author_targets(prim, "of", targets)
        author_attributes(prim, attributes_for(number))
        seen = Sdf.AttributeSpec(prim, "visibility", Sdf.ValueTypeNames.Token)
        seen.default = "inherited"
        if number:
            layer.SetTimeSample(seen.path, 1.5, "invisible")
        author_attributes(define_prim(layer, f"{prim.path}/Left", "Mesh"), attributes_for(0))
    return layer


def write(file: Path, prims: dict[str, Spec]) -> bytes:
    with file.open("wb") as stream:
        write_layer(stream, layer_spec(FORMAT, SCOPE, prims, data=DATA))
    return file.read_bytes()


def prims_for(numbers: list[int]) -> dict[str, Spec]:
    mesh = prim_spec("Mesh", specs_of(attributes_for(0)))
    return {f"Agent_{number}": spec_for(number, mesh) for number in numbers}


@pytest.mark.parametrize("numbers", [[0], [1, 0], [*range(70)]])
def test_layers_are_what_usd_makes_of_the_same(tmp_path: Path, numbers: list[int]) -> None:
    write(tmp_path / "own.usdc", prims_for(numbers))
    expected = author_one_by_one(numbers)
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "own.usdc"))
    assert layer.ExportToString() == expected.ExportToString()
    for each in (layer, expected):
        Sdf.CreatePrimInLayer(each, f"{SCOPE}/Agent_0/More").typeName = "Xform"
    edited = layer.ExportToString()
    assert layer.Save() and edited == expected.ExportToString()
    assert Sdf.Layer.OpenAsAnonymous(str(tmp_path / "own.usdc")).ExportToString() == edited
    assert Usd.Stage.Open(layer).GetPrimAtPath(f"{SCOPE}/Agent_0").IsInstanceable()


def test_files_have_the_version_of_what_is_in_them(tmp_path: Path) -> None:
    plain = prim_spec("Scope", specs_of({"height": Attribute("float", 1.0)}))
    timed = prim_spec("Scope", specs_of({"times": Attribute("timecode[]", np.array([1.0]))}))
    for version, prim in ((8, plain), (9, timed)):
        assert write(tmp_path / "own.usdc", {"A": prim})[9] == version
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        layer.TransferContent(Sdf.Layer.OpenAsAnonymous(str(tmp_path / "own.usdc")))
        layer.Export(str(tmp_path / "usd.usdc"))
        assert (tmp_path / "usd.usdc").read_bytes()[9] == version


def test_what_stays_the_same_is_in_the_file_once(tmp_path: Path) -> None:
    still = np.ones((100, 300, 4), dtype=np.float32)
    moving = still + np.arange(100, dtype=np.float32)[:, None, None]
    sizes = []
    for values in (still, moving):
        samples = Samples(type_name="quatf[]", codes=np.arange(100.0), values=values)
        sizes.append(len(write(tmp_path / "own.usdc", {"A": prim_spec("", {".rotations": sampled_spec(samples)})})))
    assert sizes[1] - sizes[0] == 99 * (8 + 300 * 16)


def test_prims_taken_from_another_file_leave_the_bytes_they_had(tmp_path: Path) -> None:
    numbers = [3, 0, 2, 1]
    first = write(tmp_path / "first.usdc", prims_for(numbers))
    data, read = read_layer(tmp_path / "first.usdc", SCOPE)
    assert data == DATA
    assert list(read) == [f"Agent_{number}" for number in numbers]
    assert write(tmp_path / "again.usdc", {**read, "Agent_2": prims_for([2])["Agent_2"]}) == first
    write(tmp_path / "more.usdc", prims_for([7, 2, 0, 3, 1]))
    _, more = read_layer(tmp_path / "more.usdc", SCOPE)
    assert write(tmp_path / "again.usdc", {name: more[name] for name in read}) == first


def test_prims_read_stay_as_they_were_whatever_becomes_of_their_file(tmp_path: Path) -> None:
    first = write(tmp_path / "first.usdc", prims_for([0, 1]))
    _, read = read_layer(tmp_path / "first.usdc", SCOPE)
    with (tmp_path / "first.usdc").open("r+b") as stream:  # a shorter one would end the process if it was mapped
        stream.write(bytes(len(first)))
    assert write(tmp_path / "again.usdc", read) == first


@pytest.mark.parametrize("is_last", [False, True])
def test_prims_that_come_again_are_written_as_if_each_was_another(tmp_path: Path, is_last: bool) -> None:
    def tree(end: float) -> Spec:
        inner = prim_spec("Scope", {**specs_of(attributes_for(1)), "Inner": prim_spec("Mesh", {})})
        after = prim_spec("Scope", specs_of({"end": Attribute("float", end)}))
        return prim_spec("Scope", {"First": inner} if is_last else {"First": inner, "After": after})

    def agent(outer: Spec) -> Spec:
        return prim_spec("Xform", {".of": relationship_spec([f"{SCOPE}/B/Outer/First/Inner"]), "Outer": outer})

    one = tree(1.0)
    several = {"A": agent(one), "B": agent(one), "C": agent(tree(2.0)), "Leaf": prim_spec("Mesh", {}), "D": agent(one)}
    apart = {name: agent(tree(2.0 if name == "C" else 1.0)) for name in several} | {"Leaf": prim_spec("Mesh", {})}
    shared = write(tmp_path / "shared.usdc", several)
    assert shared == write(tmp_path / "apart.usdc", apart)
    _, read = read_layer(tmp_path / "shared.usdc", SCOPE)
    for names in (["D", "A", "B"], ["Leaf", "C", "B"], ["B", "A", "Leaf"]):
        some = write(tmp_path / "some.usdc", {name: apart[name] for name in names})
        assert some == write(tmp_path / "kept.usdc", {name: read[name] for name in names})
        assert some == write(tmp_path / "mixed.usdc", {**{name: read[name] for name in names}, "B": several["B"]})


def test_samples_are_read_as_they_were(tmp_path: Path) -> None:
    write(tmp_path / "own.usdc", prims_for([5]))
    own = read_layer(tmp_path / "own.usdc", SCOPE)[1]["Agent_5"]
    for name, samples in samples_for(5).items():
        packed = own.layer.field(own.rows, name, "timeSamples")
        assert isinstance(packed, PackedSamples)
        np.testing.assert_array_equal(packed.codes, samples.codes)


def test_what_usd_wrote_is_refused(tmp_path: Path) -> None:
    author_one_by_one([0, 1]).Export(str(tmp_path / "usd.usdc"))
    with pytest.raises((ValueError, LookupError)):
        read_layer(tmp_path / "usd.usdc", SCOPE)
