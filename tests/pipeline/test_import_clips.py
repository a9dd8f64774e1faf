"""Imported clips: in UsdSkel joints are where a textbook puts them, the rest pose stands, and agents can use them."""

import logging
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from numpy.testing import assert_allclose
from pxr import Usd, UsdGeom, UsdSkel, UsdValidation

from tests.builders import Gait, build_walker
from tests.importers.gltf_files import gltf_of, naive_positions, random_gltf
from tests.importers.motion_files import bvh_of, random_acclaim, random_bvh
from tests.importers.naive_files import acclaim_positions, bvh_positions
from tests.references import usdskel_positions
from tests.strategies import seeds
from usdfoot.analysis.biped import find_biped
from usdfoot.analysis.rest_pose import stands
from usdfoot.cli.main import main
from usdfoot.errors import ClipError, OutputError
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.pipeline.analyze import analyze
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.import_clips import ClipFormat, import_clips

EXACT = 1e-4
"""What the issue asks for [m]."""


def written_positions(stage: Usd.Stage, clip: str, frames: slice = slice(None)) -> tuple[list[str], np.ndarray]:
    """Joint names and positions (T, J, 3) of a clip of an imported stage, by UsdSkel."""
    animation = stage.GetPrimAtPath(f"/Clips/Motion/{clip}")
    skeleton = stage.GetPrimAtPath(animation.GetRelationship("usdfoot:clip:skeleton").GetTargets()[0])
    codes = UsdSkel.Animation(animation).GetRotationsAttr().GetTimeSamples()[frames]
    names = [joint.rsplit("/", 1)[-1] for joint in UsdSkel.Skeleton(skeleton).GetJointsAttr().Get()]
    return names, usdskel_positions(stage, skeleton, animation, codes)


def rest_places(capture) -> dict[str, np.ndarray]:
    """Leg joints of the rest pose by role."""
    skeleton = capture.skeleton
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    return {role: places[joint] for role, joint in find_biped(skeleton, {}).items()}


def assert_stands(capture, *, ball_height: float, within: float) -> None:
    rest = rest_places(capture)
    assert stands(capture.skeleton, find_biped(capture.skeleton, {}))
    assert_allclose(rest["pelvis"][[0, 2]], 0.0, atol=1e-9)
    across = rest["left ball"] + rest["right ball"] - rest["left ankle"] - rest["right ankle"]
    assert abs(np.arctan2(across[0], across[2])) < 0.01, "faces +Z"
    assert_allclose([rest[f"{side} ball"][1] for side in ("left", "right")], ball_height, atol=within)
    assert rest["left hip"][0] > 0.0 > rest["right hip"][0]


@pytest.mark.parametrize("twisted", [False, True], ids=["T-pose", "bones anywhere"])
def test_a_known_walk_comes_through_whole(tmp_path, twisted):
    walker = build_walker(Gait(turn=0.1), rate=30.0, footsteps=8, twisted=twisted)
    skeleton, clip = walker.library.skeleton, walker.library.clips[0]
    (tmp_path / "my walk.bvh").write_text(bvh_of(skeleton, clip, metres=0.0254))
    report = import_clips([tmp_path / "my walk.bvh"], tmp_path / "clips.usd", clip_format=ClipFormat(unit="inch"))
    assert report.problems == ()
    stage = Usd.Stage.Open(str(report.file))
    names, places = written_positions(stage, "my_walk")
    expected, _ = forward_kinematics(skeleton.parents, clip.translations, clip.rotations)
    order = [names.index(joint.rsplit("/", 1)[-1]) for joint in skeleton.joints]
    assert_allclose(places[:, order], expected, atol=EXACT)
    assert_stands(report.captures["my walk"], ball_height=0.04, within=0.003)
    (summary,) = analyze(report.file).summaries
    for side in range(2):
        found, true = (contacts[side].strike_times for contacts in (summary.contacts, walker.contacts))
        assert_allclose(found[np.isfinite(found)], true[np.isfinite(true)], atol=1.5 / 30.0)
    errors = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(
        stage
    )
    assert [error.GetMessage() for error in errors] == []
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0 and UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetPath() == "/Clips" and stage.GetTimeCodesPerSecond() == 30.0


@hypothesis_settings(max_examples=12)
@given(seed=seeds)
def test_random_skeletons_are_in_usdskel_where_a_textbook_puts_them(seed, tmp_path_factory):
    folder, generator = tmp_path_factory.mktemp("random"), np.random.default_rng(seed)
    bvh = random_bvh(generator)
    asf, amc = random_acclaim(generator)
    for name, text in (("a.bvh", bvh), ("b.asf", asf), ("b.amc", amc)):
        (folder / name).write_bytes(text.encode())
    files = [folder / name for name in ("a.bvh", "b.asf", "b.amc")]
    report = import_clips(files, folder / "clips.usd", clip_format=ClipFormat(unit="cm", rate=120.0))
    stage = Usd.Stage.Open(str(report.file))
    expected, places = bvh_positions("\n".join(line.split("#")[0] for line in bvh.splitlines()))
    names, found = written_positions(stage, "a")
    assert names == expected
    assert_allclose(found, 0.01 * places, atol=EXACT)
    expected, places = acclaim_positions(asf, amc, degrees=1.0 if "angle deg" in asf else 180.0 / np.pi)
    names, found = written_positions(stage, "b")
    assert_allclose(found[:, [names.index(name) for name in expected]], places * 0.01 / 0.45, atol=EXACT)


@hypothesis_settings(max_examples=8)
@given(seed=seeds)
def test_random_gltf_is_in_usdskel_where_a_textbook_puts_it(seed, tmp_path_factory):
    pytest.importorskip("pygltflib", reason="glTF needs the extra import")
    folder = tmp_path_factory.mktemp("random")
    file = random_gltf(np.random.default_rng(seed)).save(folder / "some.gltf")
    report = import_clips([file], folder / "clips.usd")
    stage = Usd.Stage.Open(str(report.file))
    clips = [clip for capture in report.captures.values() for clip in capture.clips]
    for clip, prim in zip(clips, stage.GetPrimAtPath("/Clips/Motion").GetChildren(), strict=True):
        expected = naive_positions(file, clip.times)
        names, found = written_positions(stage, prim.GetName())
        true = np.stack([expected[name.replace("_", " ")] for name in names], axis=1)
        assert_allclose(found, true, atol=EXACT)


def test_a_gltf_walk_shares_the_skeleton_of_a_bvh_walk(tmp_path):
    pytest.importorskip("pygltflib", reason="glTF needs the extra import")
    library = build_walker(footsteps=4).library
    skeleton, clip = library.skeleton, library.clips[0]
    files = [gltf_of(skeleton, clip).save(tmp_path / "walk.glb", "glb"), tmp_path / "walk.bvh"]
    files[1].write_text(bvh_of(skeleton, clip, metres=1.0))
    report = import_clips(files[:1], tmp_path / "clips.usd")
    expected, _ = forward_kinematics(skeleton.parents, clip.translations, clip.rotations)
    names, places = written_positions(Usd.Stage.Open(str(report.file)), "walk")
    order = [names.index(joint.rsplit("/", 1)[-1]) for joint in skeleton.joints]
    assert_allclose(places[:, order], expected, atol=EXACT)
    both = import_clips(files, tmp_path / "both.usd", clip_format=ClipFormat(unit="m"))
    (capture,) = both.captures.values()
    assert both.problems == () and len(capture.clips) == 2
    assert_stands(capture, ball_height=0.04, within=0.003)
    with pytest.raises(ClipError, match="is in metres, as glTF defines it, not cm"):
        import_clips(files[:1], tmp_path / "clips.usd", clip_format=ClipFormat(unit="cm"))


def test_a_rig_without_names_or_a_pose_to_stand_in(tmp_path):
    library = build_walker(footsteps=8, twisted=True).library
    text = bvh_of(library.skeleton, library.clips[0])
    for number, name in enumerate(re.findall(r"(?:ROOT|JOINT) (\w+)", text)):
        text = re.sub(rf"(ROOT|JOINT) {name}\n", rf"\1 bone{number}\n", text)
    (tmp_path / "walk.bvh").write_text(text)
    report = import_clips([tmp_path / "walk.bvh"], tmp_path / "clips.usd", clip_format=ClipFormat(unit="cm"))
    assert report.problems == ()
    assert_stands(report.captures["walk"], ball_height=0.04, within=0.003)
    assert analyze(report.file).summaries[0].steps == 7


def test_files_on_the_same_bones_share_a_skeleton_and_names_are_unique(tmp_path):
    walks = [build_walker(Gait(step_length=length), footsteps=4).library for length in (0.6, 0.5)]
    large = build_walker(footsteps=4, size=1.2).library
    for folder, library in (("a", walks[0]), ("b", walks[1]), ("c", large)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "walk.bvh").write_text(bvh_of(library.skeleton, library.clips[0]))
    files = [tmp_path / folder / "walk.bvh" for folder in "abc"]
    report = import_clips(files, tmp_path / "clips.usda", clip_format=ClipFormat(unit="cm"))
    assert [len(capture.clips) for capture in report.captures.values()] == [2, 1]
    stage = Usd.Stage.Open(str(report.file))
    motions = stage.GetPrimAtPath("/Clips/Motion").GetChildren()
    assert [prim.GetName() for prim in motions] == ["walk", "walk_1", "walk_2"]
    rigs = [prim.GetRelationship("usdfoot:clip:skeleton").GetTargets()[0] for prim in motions]
    assert rigs[0] == rigs[1] != rigs[2] and all(stage.GetPrimAtPath(rig).IsA(UsdSkel.Skeleton) for rig in rigs)


def test_what_looks_wrong_is_doubted(tmp_path):
    library = build_walker(footsteps=4).library
    (tmp_path / "walk.bvh").write_text(bvh_of(library.skeleton, library.clips[0]))
    (tmp_path / "snake.bvh").write_text(
        "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOINT b\n{\nOFFSET 0 1 0\nCHANNELS 0\n}\n}\n"
        "MOTION\nFrames: 2\nFrame Time: 0.04\n1\n2\n"
    )
    doubts = import_clips([tmp_path / "walk.bvh"], tmp_path / "m.usd", clip_format=ClipFormat(unit="in")).problems
    assert "legs are 2.08 m long. Is the unit right?" in doubts[0].message
    doubts = import_clips(
        [tmp_path / "walk.bvh"], tmp_path / "z.usd", clip_format=ClipFormat(unit="cm", up="Z")
    ).problems
    assert "legs point along +Z. Is --up right?" in doubts[0].message
    (doubt,) = import_clips([tmp_path / "snake.bvh"], tmp_path / "s.usd", clip_format=ClipFormat(unit="cm")).problems
    assert "no joint found for the role(s)" in doubt.message and "keeps the file's own rest pose" in doubt.message


def test_a_file_with_z_up_becomes_one_with_y_up(tmp_path):
    library = build_walker(footsteps=4).library
    skeleton, clip = library.skeleton, library.clips[0]
    text = bvh_of(skeleton, clip, metres=1.0)
    (tmp_path / "walk.bvh").write_text(text)
    import_clips([tmp_path / "walk.bvh"], tmp_path / "z.usd", clip_format=ClipFormat(unit="m", up="Z"))
    names, places = written_positions(Usd.Stage.Open(str(tmp_path / "z.usd")), "walk")
    expected, upright = bvh_positions(text)
    assert names == expected
    assert_allclose(places, upright[..., [0, 2, 1]] * (1.0, 1.0, -1.0), atol=EXACT)


def test_the_command_line_skips_bad_files_and_never_replaces_its_input(tmp_path, capsys):
    library = build_walker(footsteps=4).library
    good, bad = tmp_path / "good.bvh", tmp_path / "bad.bvh"
    good.write_text(bvh_of(library.skeleton, library.clips[0]))
    bad.write_text("HIERARCHY\nROOT Hips\n{\n")
    arguments = ["--unit", "cm", "-o", str(tmp_path / "clips.usd"), "-q"]
    assert main(["import", str(good), str(bad), *arguments]) == 1
    streams = capsys.readouterr()
    assert "bad.bvh:2: joint Hips is never closed" in streams.err and "good" in streams.out
    assert main(["import", str(bad), *arguments]) == 2
    assert main(["import", str(good), "-o", str(tmp_path / "clips.usd")]) == 2
    assert "give --unit" in capsys.readouterr().err
    assert main(["import", str(good), *arguments, "--max-frames", "3"]) == 2
    assert "more than 3" in capsys.readouterr().err
    assert main(["import", str(good), *arguments, "--rate", "120"]) == 2
    assert "says it has 30 frames a second, not 120" in capsys.readouterr().err
    assert main(["import", str(good), *arguments, "--scene", "shot.usda"]) == 2
    assert "--scene: is for plans and terrain" in capsys.readouterr().err
    assert main(["import", str(good), "--unit", "cm", "-o", str(good)]) == 2
    assert main(["import", str(tmp_path), *arguments]) == 2
    assert f"{tmp_path}: is a folder. name the files in it" in capsys.readouterr().err
    assert main(["import", str(tmp_path / "walk.fbx"), *arguments]) == 2
    assert "walk.fbx: .fbx is unknown. .bvh, .asf with its .amc, .gltf, .glb; .csv" in capsys.readouterr().err
    with pytest.raises(OutputError, match="would replace what it is made from"):
        (tmp_path / "scene.usda").write_text(good.read_text())
        (tmp_path / "link.bvh").symlink_to(tmp_path / "scene.usda")
        import_clips([tmp_path / "link.bvh"], tmp_path / "scene.usda", clip_format=ClipFormat(unit="cm"))
    with pytest.raises(ClipError, match="there are none"):
        import_clips([], tmp_path / "clips.usd")
    with pytest.raises(ClipError, match=r"fbx is unknown.*\.bvh"):
        import_clips([tmp_path / "walk.fbx"], tmp_path / "clips.usd")


def test_real_mocap_is_where_a_textbook_puts_it(shared_data, tmp_path):
    files = sorted((shared_data / "bandai").glob("*.bvh"))
    report = import_clips(files, tmp_path / "clips.usd", clip_format=ClipFormat(unit="cm"))
    assert report.problems == ()
    (capture,) = report.captures.values()
    assert_stands(capture, ball_height=0.0455, within=0.005)
    stage = Usd.Stage.Open(str(report.file))
    for file in files:
        lines = file.read_text().splitlines()
        at = next(i for i, line in enumerate(lines) if line.startswith("Frames"))
        kept = lines[at + 2 :: 9]
        text = "\n".join([*lines[:at], f"Frames: {len(kept)}", lines[at + 1], *kept])
        expected, places = bvh_positions(text)
        names, found = written_positions(stage, file.stem.replace("-", "_"), slice(None, None, 9))
        assert names == expected
        assert_allclose(found, 0.01 * places, atol=EXACT)


def test_real_acclaim_files_are_where_a_textbook_puts_them(shared_data, tmp_path):
    pairs = {"02_01": "02", "02_03": "02", "03_01": "03"}
    files = [shared_data / "cmu" / name for name in ("03.asf", "02.asf", *(f"{clip}.amc" for clip in pairs))]
    report = import_clips(files, tmp_path / "clips.usd", clip_format=ClipFormat(unit="inches", rate=120.0))
    assert report.problems == () and sorted(report.captures) == ["02", "03"]
    for capture in report.captures.values():
        assert_stands(capture, ball_height=0.035, within=0.02)
    stage = Usd.Stage.Open(str(report.file))
    for clip, asf in pairs.items():
        amc = (shared_data / "cmu" / f"{clip}.amc").read_text()
        blocks = amc.replace("\r", "").split("\nroot ")
        count = len(blocks) - 1
        kept = "".join(f"\n{i}\nroot {blocks[i].rsplit(chr(10), 1)[0]}" for i in range(1, count, 20))
        expected, places = acclaim_positions((shared_data / "cmu" / f"{asf}.asf").read_text(), kept)
        names, found = written_positions(stage, f"_{clip}", slice(0, count - 1, 20))
        assert_allclose(found[:, [names.index(name) for name in expected]], places * 0.0254 / 0.45, atol=EXACT)


def test_imported_clips_walk_a_plan(shared_data, tmp_path, caplog):
    files = sorted((shared_data / "bandai").glob("*walk_*.bvh"))
    import_clips(files, tmp_path / "clips.usd", clip_format=ClipFormat(unit="cm"))
    (tmp_path / "scene.usda").write_text(
        f"""#usda 1.0
(
    subLayers = [@{shared_data / "scenes" / "walk_flat.usda"}@]
    metersPerUnit = 0.01
    upAxis = "Y"
    timeCodesPerSecond = 30
    framesPerSecond = 30
)
over "World"
{{
    def "Imported" (
        references = @./clips.usd@
    )
    {{
        double3 xformOp:scale = (100, 100, 100)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }}
    over "Walker"
    {{
        rel usdfoot:agent:clips = </World/Imported/Motion>
    }}
}}
"""
    )
    with caplog.at_level(logging.WARNING, "usdfoot"):
        report = animate(tmp_path / "scene.usda", tmp_path / "out")
    (results,) = report.results.values()
    assert not report.skipped and set(results.status) <= {"ok", "outsideHull"}
    assert results.placement_error.max() < 1e-3 and results.slide.max() < 1e-3
    assert all(name.startswith("/World/Imported/Motion/") for name in results.clips)
