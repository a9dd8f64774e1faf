"""glTF files: joints end up where a textbook says, whatever hangs above them, and malformed files are named."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from numpy.testing import assert_allclose

from tests.builders import build_walker
from tests.importers.gltf_files import GltfBuilder, gltf_of, naive_positions, random_gltf
from tests.strategies import seeds
from usdfoot.errors import ClipError, SceneError
from usdfoot.model.limits import Limits
from usdfoot.model.skeleton import forward_kinematics

pytest.importorskip("pygltflib", reason="glTF needs the extra import")
from usdfoot.importers.gltf import import_gltf


def places_of(capture) -> dict[str, np.ndarray]:
    """Joint positions (T, 3) of the first clip by leaf name."""
    clip = capture.clips[0]
    places, _ = forward_kinematics(capture.skeleton.parents, clip.translations, clip.rotations)
    return {joint.rsplit("/", 1)[-1]: places[:, index] for index, joint in enumerate(capture.skeleton.joints)}


def pair(folder, **changes) -> GltfBuilder:
    """Two joints, the second moved."""
    builder = GltfBuilder()
    builder.document["nodes"] = [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}]
    builder.document["skins"] = [{"joints": [0, 1]}]
    builder.animate("move", [(1, "translation", "LINEAR", np.array([0.0, 1.0]), np.array([[0, 1, 0], [0, 2, 0]]))])
    builder.document |= changes
    return builder


@hypothesis_settings(max_examples=40)
@given(seed=seeds)
def test_joints_are_where_a_textbook_puts_them(seed, tmp_path_factory):
    file = random_gltf(np.random.default_rng(seed)).save(tmp_path_factory.mktemp("gltf") / "some.gltf")
    captures, _ = import_gltf(file)
    for capture in captures:
        clip = capture.clips[0]
        assert clip.rate in (24.0, 30.0)
        expected = naive_positions(file, clip.times)
        for name, places in places_of(capture).items():
            true = expected[name.replace("_", " ")]
            assert_allclose(places, true, atol=1e-5 * max(1.0, np.abs(true).max()))


@pytest.mark.parametrize("how", ["embedded", "beside", "glb"])
def test_a_known_walk_below_a_scaled_and_turned_node(tmp_path, how):
    library = build_walker(footsteps=4).library
    clip = library.clips[0]
    above = {"scale": [0.01] * 3, "rotation": [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]}
    large = [100.0 * values for values in (library.skeleton.rest_translations, clip.translations)]
    skeleton = type(library.skeleton)(**{**vars(library.skeleton), "rest_translations": large[0]})
    moved = type(clip)(**{**vars(clip), "translations": large[1]})
    builder = gltf_of(skeleton, moved, above=above)
    file = builder.save(tmp_path / ("walk.glb" if how == "glb" else "walk.gltf"), how)
    (capture,), problems = import_gltf(file)
    assert problems == () and capture.clips[0].rate == 30.0 and capture.clips[0].name == "walk"
    expected, _ = forward_kinematics(library.skeleton.parents, clip.translations, clip.rotations)
    found = places_of(capture)
    for index, joint in enumerate(library.skeleton.joints):
        turned = expected[:, index][:, [0, 2, 1]] * (1.0, 1.0, -1.0)
        assert_allclose(found[joint.rsplit("/", 1)[-1]], turned, atol=1e-5)


def test_normalised_shorts_and_strides(tmp_path):
    library = build_walker(footsteps=4).library
    file = gltf_of(library.skeleton, library.clips[0], short=True).save(tmp_path / "walk.gltf")
    (capture,), _ = import_gltf(file)
    expected, _ = forward_kinematics(
        library.skeleton.parents, library.clips[0].translations, library.clips[0].rotations
    )
    names = [joint.rsplit("/", 1)[-1] for joint in library.skeleton.joints]
    assert_allclose(np.stack([places_of(capture)[name] for name in names], axis=1), expected, atol=5e-4)
    builder = GltfBuilder()
    builder.document |= pair(tmp_path).document | {"animations": [], "accessors": [], "bufferViews": []}
    values = np.array([[0, 1, 0], [0, 2, 0]])
    builder.animate("move", [(1, "translation", "LINEAR", np.array([0.0, 1.0]), values)], gap=8)
    (capture,), _ = import_gltf(builder.save(tmp_path / "gaps.gltf"))
    assert_allclose(capture.clips[0].translations[[0, -1], 1, 1], [1.0, 2.0])


def test_sparse_values_replace_zeros(tmp_path):
    builder = pair(tmp_path)
    indices = builder.view(np.array([1], dtype="<u2").tobytes())
    values = builder.view(np.array([0, 5, 0], dtype="<f4").tobytes())
    builder.document["accessors"][1] = {
        "componentType": 5126,
        "count": 2,
        "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": {"bufferView": indices, "componentType": 5123},
            "values": {"bufferView": values},
        },
    }
    (capture,), _ = import_gltf(builder.save(tmp_path / "sparse.gltf"))
    assert_allclose(capture.clips[0].translations[[0, -1], 1, 1], [0.0, 5.0])


def test_what_moves_no_joint_is_left_out_and_said(tmp_path):
    builder = pair(tmp_path)
    builder.document["animations"][0]["channels"].append({"sampler": 0, "target": {"node": 1, "path": "weights"}})
    builder.animate("pose", [(1, "translation", "STEP", np.array([0.0]), np.array([[0, 1, 0]]))])
    builder.document["nodes"].append({"name": "sword"})
    builder.document["skins"][0]["name"] = "Body/rig.001"
    builder.document["skins"].append({"name": "sword", "joints": [2]})
    (capture,), problems = import_gltf(builder.save(tmp_path / "some.gltf"))
    assert [clip.name for clip in capture.clips] == ["move"] and capture.skeleton.name.endswith("/Body_rig_001")
    messages = " ".join(problem.message for problem in problems)
    assert "animation move: weights is not imported" in messages
    assert "animation pose lasts 0 s" in messages and "skeleton sword has no clip" in messages


def test_the_rate_may_be_asked_for(tmp_path):
    file = pair(tmp_path).save(tmp_path / "some.gltf")
    assert import_gltf(file)[0][0].clips[0].rate == 24.0
    clip = import_gltf(file, rate=48.0)[0][0].clips[0]
    assert clip.rate == 48.0 and len(clip.rotations) == 49


@pytest.mark.parametrize(
    ("at", "value", "message"),
    [
        (("asset", "version"), "1.0", "is glTF 1.0"),
        (("nodes", 0, "children"), [0], r"nodes\[0\] has child 0, which cannot hang there"),
        (("nodes", 1, "children"), [0], "has nodes that hang on themselves"),
        (("nodes", 0, "children"), [7], r"nodes\[0\] has child 7"),
        (("nodes", 0, "translation"), [1, 2], r"nodes\[0\].translation is \[1.0, 2.0\]. 3 finite numbers are right"),
        (("nodes", 0, "rotation"), [0, 0, 0, 0], r"nodes\[0\] has a rotation that is zero"),
        (("skins", 0, "joints"), [0, 9], r"refers to nodes\[9\], it has 2"),
        (("accessors", 1, "count"), 200, r"accessors\[1\].*needs 2400 bytes of bufferViews\[1\], which has 24"),
        (("accessors", 1, "count"), -1, r"accessors\[1\].*count -1"),
        (("accessors", 1, "type"), "VEC9", r"accessors\[1\].*type VEC9"),
        (("accessors", 1, "count"), 1, r"channels\[0\] has 2 times and values of shape \(1, 3\)"),
        (("accessors", 1, "bufferView"), 5, r"refers to bufferViews\[5\], it has 2"),
        (("bufferViews", 1, "byteLength"), 10**9, r"bufferViews\[1\] ends at byte 1000000008 of buffers\[0\]"),
        (("bufferViews", 1, "buffer"), 3, r"refers to buffers\[3\]"),
        (("animations", 0, "channels", 0, "sampler"), 4, r"channels\[0\] has sampler 4 of 1"),
        (("animations", 0, "samplers", 0, "interpolation"), "MAGIC", "is interpolated by MAGIC"),
        (("animations", 0, "samplers", 0, "input"), 1, r"channels\[0\] has 2 times"),
        (("animations", 0, "channels"), [], "has no animation that moves nodes"),
        (("buffers", 0, "uri"), "missing.bin", "buffer missing.bin cannot be read"),
        (("buffers", 0, "uri"), "data:;base64,!!", "is no base64"),
        (("nodes",), 3, "is no glTF file"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, at, value, message):
    file = pair(tmp_path).save(tmp_path / "some.gltf")
    document = json.loads(file.read_text())
    part = document
    for key in at[:-1]:
        part = part[key]
    part[at[-1]] = value
    file.write_text(json.dumps(document))
    with pytest.raises(ClipError, match=message):
        import_gltf(file)


def test_files_that_are_none_and_hostile_sizes(tmp_path):
    for name, data in (
        ("a.gltf", b"{"),
        ("b.gltf", b"\xff\xfe"),
        ("c.glb", b"glTF\x02\0\0\0"),
        ("d.gltf", b"[" * 10**5),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(ClipError, match=f"{name}: is no glTF file"):
            import_gltf(tmp_path / name)
    for name, data in (("e.gltf", b'{"nodes": {"node_1": {}}}'), ("f.glb", b"glTF\x01\0\0\0")):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(ClipError, match=f"{name}: is glTF 1.0, which is another format. convert it to glTF 2.0"):
            import_gltf(tmp_path / name)
    with pytest.raises(ClipError, match="cannot be read"):
        import_gltf(tmp_path / "none.glb")
    builder = pair(tmp_path)
    values = np.array([[0, 1, 0], [0, 2, 0]])
    builder.animate("long", [(1, "translation", "LINEAR", np.array([0.0, 1e9]), values)])
    with pytest.raises(SceneError, match=r"frames, more than 100000"):
        import_gltf(builder.save(tmp_path / "long.gltf"))
    with pytest.raises(SceneError, match=r"has 2 joints, more than 1"):
        import_gltf(pair(tmp_path).save(tmp_path / "some.gltf"), limits=Limits(joints=1))
    glb = pair(tmp_path).save(tmp_path / "some.glb", "glb")
    glb.write_bytes(glb.read_bytes()[:-40])
    with pytest.raises(ClipError, match=r"some.glb"):
        import_gltf(glb)
