"""Joined layers against the same prims copied into one layer by USD."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from usdfoot.errors import OutputError
from usdfoot.writers.crate.columns import pack_bytes, pack_column, unpack_bytes, unpack_column
from usdfoot.writers.crate.join import CrateError, JoinedLayer
from usdfoot.writers.joined import JoinedFile
from usdfoot.writers.staging import staged_files

SCOPE = "/Crowd/Agents"
Types = Sdf.ValueTypeNames


def new_layer(kind="group"):
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    prim = Sdf.CreatePrimInLayer(layer, SCOPE)
    prim.specifier, prim.typeName, prim.kind = Sdf.SpecifierDef, "Scope", kind
    layer.startTimeCode, layer.defaultPrim = 3.0, "Crowd"
    return layer


def add_agent(layer, name, seed):
    """All kinds of things that agents, plans and animations have."""
    rng = np.random.default_rng(seed)
    prim = Sdf.CreatePrimInLayer(layer, f"{SCOPE}/{name}")
    prim.specifier, prim.typeName, prim.instanceable = Sdf.SpecifierDef, "SkelRoot", True
    prim.referenceList.prependedItems = [Sdf.Reference(f"../human{seed % 2}.usdc", f"/Human{seed % 3}")]
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = ["SkelBindingAPI", f"Of{seed}API"]
    prim.SetInfo("apiSchemas", schemas)
    for target in ("/Crowd/Anims", "/Crowd/Plans"):
        relationship = Sdf.RelationshipSpec(prim, target[1:].replace("/", ":"), custom=False)
        relationship.targetPathList.explicitItems = [Sdf.Path(f"{target}/{name}"), prim.path.AppendChild("Left")]
    values = {
        "floats": (Types.FloatArray, Vt.FloatArray.FromNumpy(rng.normal(size=40).astype(np.float32))),
        "same": (Types.IntArray, Vt.IntArray([1, 2, 3] * 20)),
        "none": (Types.Float3Array, Vt.Vec3fArray()),
        "tokens": (Types.TokenArray, Vt.TokenArray([name, "ok", f"clip{seed}"])),
        "times": (Types.TimeCodeArray, Sdf.TimeCodeArray([0.5, float(seed)])),
        "halves": (Types.QuathArray, Vt.QuathArray([Gf.Quath(1.0, 0.0, 0.0, 0.5)])),
        "token": (Types.Token, f"guide{seed}"),
        "text": (Types.String, f"text{seed}"),
        "asset": (Types.Asset, Sdf.AssetPath(f"./{name}.usd")),
        "orient": (Types.Quatd, Gf.Quatd(0.5, 0.1, 0.2, float(seed))),
        "large": (Types.Double, 0.1 * seed),
    }
    for attribute, (kind, value) in values.items():
        Sdf.AttributeSpec(prim, attribute, kind, Sdf.VariabilityUniform).default = value
    moving = Sdf.AttributeSpec(prim, "xformOp:translate", Types.Double3)
    shape = Sdf.AttributeSpec(prim, "extent", Types.Float3Array)
    seen = Sdf.AttributeSpec(prim, "visibility", Types.Token)
    for code in range(1 + seed % 4):
        layer.SetTimeSample(moving.path, code, Gf.Vec3d(*rng.normal(size=3)))
        layer.SetTimeSample(shape.path, code, Vt.Vec3fArray.FromNumpy(rng.normal(size=(2, 3)).astype(np.float32)))
    layer.SetTimeSample(seen.path, 1.5, f"seen{seed % 2}")
    mesh = Sdf.CreatePrimInLayer(layer, f"{SCOPE}/{name}/Left")
    mesh.specifier, mesh.typeName = Sdf.SpecifierDef, "Mesh"
    if seed % 2:
        points = Sdf.AttributeSpec(mesh, "points", Types.Point3fArray)
        points.default = Vt.Vec3fArray([(0.0, 0.0, float(seed))] * 20)
        points.SetInfo("interpolation", "uniform")


def join_layers(file, parts):
    joined = JoinedLayer(file, scope=SCOPE)
    for part in parts:
        joined.add(part)
    joined.finish()


def write_joined(folder, parts):
    with staged_files(folder) as files:
        joined = JoinedFile(files, "agents.usdc", new_layer(), scope=SCOPE)
        for part in parts:
            joined.add(part)
        joined.finish()


@pytest.mark.parametrize("counts", [[1], [3, 2], [12, 1, 7], [2, 0, 1]])
def test_joined_layers_are_what_usd_makes_of_them(counts, tmp_path):
    names = iter([f"Agent_{number}" for number in range(sum(counts))])
    expected, parts = new_layer(), []
    for count in counts:
        layer = new_layer()
        layer.customLayerData = {"usdfoot": {"contentHash": "made from"}}
        for name in [next(names) for _ in range(count)]:
            add_agent(layer, name, int(name[6:]))
            Sdf.CopySpec(layer, f"{SCOPE}/{name}", expected, f"{SCOPE}/{name}")
        parts.append(tmp_path / f"{len(parts)}.usdc")
        layer.Export(str(parts[-1]))
    joined = tmp_path / "joined.usdc"
    new_layer().Export(str(joined))
    join_layers(joined, parts)
    layer = Sdf.Layer.OpenAsAnonymous(str(joined))
    assert layer.ExportToString() == expected.ExportToString()
    paths: list[list[Sdf.Path]] = [[], []]
    for each, found in zip((layer, expected), paths, strict=True):
        each.Traverse("/", found.append)
    assert sorted(paths[0]) == sorted(paths[1])
    layer.GetPrimAtPath(SCOPE).documentation = "edited"
    layer.Export(str(tmp_path / "edited.usdc"))
    expected.GetPrimAtPath(SCOPE).documentation = "edited"
    assert Sdf.Layer.FindOrOpen(str(tmp_path / "edited.usdc")).ExportToString() == expected.ExportToString()


def test_what_fields_share_is_renumbered_once(tmp_path):
    expected, parts = new_layer(), []
    for name in ("A", "B"):
        layer = new_layer()
        prim = Sdf.CreatePrimInLayer(layer, f"{SCOPE}/{name}")
        Sdf.CreatePrimInLayer(layer, f"{SCOPE}/{name}/Left{name}")  # names of children and of properties are one list
        Sdf.AttributeSpec(prim, f"Left{name}", Types.Token).default = f"other{name}"
        Sdf.CopySpec(layer, prim.path, expected, prim.path)
        parts.append(tmp_path / f"{name}.usdc")
        layer.Export(str(parts[-1]))
    joined = tmp_path / "joined.usdc"
    new_layer().Export(str(joined))
    join_layers(joined, parts)
    assert Sdf.Layer.OpenAsAnonymous(str(joined)).ExportToString() == expected.ExportToString()


def test_what_cannot_be_joined_is_named(tmp_path):
    layer, joined, part = new_layer(), tmp_path / "joined.usdc", tmp_path / "part.usdc"
    layer.Export(str(joined))
    Sdf.CreatePrimInLayer(layer, f"{SCOPE}/A").customData = {"of": "somebody"}
    layer.Export(str(part))
    with pytest.raises(CrateError, match=r"part.usdc cannot be joined .*type 31"):
        join_layers(joined, [part])
    new_layer().Export(str(joined))
    part.write_text("#usda 1.0\n")
    with pytest.raises(CrateError, match="no layer in USD's binary format"):
        join_layers(joined, [part])


def test_what_cannot_be_joined_as_bytes_is_copied_by_usd(tmp_path):
    expected, parts = new_layer(), []
    for seed, data in enumerate(({}, {"of": "somebody"})):
        layer = new_layer()
        add_agent(layer, f"A{seed}", seed)
        layer.GetPrimAtPath(f"{SCOPE}/A{seed}").customData = data
        Sdf.CopySpec(layer, f"{SCOPE}/A{seed}", expected, f"{SCOPE}/A{seed}")
        parts.append(tmp_path / f"{seed}.usdc")
        layer.Export(str(parts[-1]))
    write_joined(tmp_path / "out", parts)
    joined = Sdf.Layer.FindOrOpen(str(tmp_path / "out" / "agents.usdc"))
    assert joined.ExportToString() == expected.ExportToString()


def test_what_is_no_layer_is_named(tmp_path):
    broken = tmp_path / "broken.usdc"
    broken.write_bytes(b"PXR-USDC")
    with pytest.raises(OutputError, match=r"broken.usdc: cannot be read"):
        write_joined(tmp_path / "out", [broken])
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize("integers", [[], [0], [5, 5, 6, 7, 300, 70000, -70000, 0, 1 << 30, -(1 << 30)]])
def test_columns_are_what_was_packed(integers):
    packed = pack_column(integers)
    assert int.from_bytes(packed[:8], "little") == len(packed) - 8
    assert unpack_column(packed[8:], len(integers)).tolist() == integers


@pytest.mark.parametrize("size", [0, 14, 15, 16, 269, 270, 271, 5000])
def test_blocks_are_what_was_packed(size):
    content = bytes(np.random.default_rng(size).integers(0, 256, size, dtype=np.uint8))
    assert unpack_bytes(pack_bytes(content)[8:]) == content


def test_matches_repeat_what_was_before_them():
    block = bytes([0, 0x3F, *b"abc", 3, 0, 6, 0x10, *b"d"])  # 4 + 15 + 6 bytes from 3 back
    assert unpack_bytes(block) == (b"abc" * 10)[:28] + b"d"
    with pytest.raises(ValueError, match="several pieces"):
        unpack_bytes(b"\1" + block)


@pytest.mark.parametrize("back", [0, 4])
def test_matches_of_what_is_not_there_are_refused(back):
    with pytest.raises(ValueError, match="before the beginning"):
        unpack_bytes(bytes([0, 0x30, *b"abc", back, 0, 0x10, *b"d"]))


def test_columns_that_claim_to_be_longer_are_refused():
    with pytest.raises(ValueError, match="shorter than it says"):
        unpack_column(pack_column([1, 2, 3])[8:], 1 << 46)
