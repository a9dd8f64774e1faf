"""Retargeted stages: they hold the character and its clips, play, and are animated from."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from tests.references import canonical_points, usdskel_positions
from tests.scenes import JOINTS, OFFSETS, Units, add_character, add_clip, new_stage, walk_pose
from usdfoot.analysis.examples import build_examples
from usdfoot.bridge import tokens
from usdfoot.cli.main import main
from usdfoot.errors import BipedError, OutputError, SceneError
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.retarget import retarget
from usdfoot.pipeline.validate import validate
from usdfoot.readers.libraries import read_libraries

KEPT = (
    "walk_090",
    "walk_110",
    "walk_130",
    "turn_left_200",
    "turn_right_150",
    "stand",
    "start_walk_left",
    "start_walk_right",
    "stop_walk_left",
)


@pytest.fixture(scope="module")
def few_clips(stages, tmp_path_factory):
    """A layer over stages/clips.usdc with some of its clips."""
    source = Usd.Stage.Open(str(stages / "clips.usdc"))
    layer = Sdf.Layer.CreateNew(str(tmp_path_factory.mktemp("clips") / "clips.usda"))
    layer.subLayerPaths = [str(stages / "clips.usdc")]
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond", "defaultPrim"):
        layer.pseudoRoot.SetInfo(key, source.GetRootLayer().pseudoRoot.GetInfo(key))
    stage = Usd.Stage.Open(layer)
    for prim in stage.GetDefaultPrim().GetChild("Clips").GetChildren():
        if prim.GetName() not in KEPT:
            stage.OverridePrim(prim.GetPath()).SetActive(False)
    stage.Save()
    return layer.realPath


def write_character(path, *, units: Units, size: float, tilted: bool = False):
    """A character of the tests' own on a stage in units of its own, with a body, perhaps lying below a rotation."""
    inner = Units(units.meters, "Y") if tilted else units
    stage = new_stage(path, units)
    add_character(stage, "/World/Cast/Hero", inner, offsets=size * OFFSETS, with_body=True)
    if tilted:
        UsdGeom.Xformable(stage.GetPrimAtPath("/World/Cast/Hero")).AddRotateXOp().Set(90.0)
    stage.Save()
    return path


@pytest.fixture(scope="module", params=[Units(0.01, "Y"), Units(1.0, "Z"), Units(0.0254, "Z")], ids=lambda u: u.up)
def hero(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hero")
    return write_character(folder / "hero.usda", units=request.param, size=1.3, tilted=request.param.meters == 1.0)


@pytest.fixture(scope="module")
def report(few_clips, hero):
    before = [hashlib.sha256(Path(file).read_bytes()).digest() for file in (few_clips, hero)]
    report = retarget(few_clips, hero, hero.parent / "out" / "hero_clips.usd")
    assert [hashlib.sha256(Path(file).read_bytes()).digest() for file in (few_clips, hero)] == before
    return report


def test_the_stage_plays_what_was_made(report, hero):
    stage = Usd.Stage.Open(str(report.file))
    original = Usd.Stage.Open(str(hero))
    assert stage.GetDefaultPrim().GetPath() == "/Retargeted"
    assert UsdGeom.GetStageMetersPerUnit(stage) == pytest.approx(UsdGeom.GetStageMetersPerUnit(original))
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.GetStageUpAxis(original)
    assert set(report.clips) == set(KEPT) and not report.skipped
    skeleton = stage.GetPrimAtPath("/Retargeted/Character/Skeleton")
    assert UsdSkel.Skeleton(skeleton).GetJointsAttr().Get() == Vt.TokenArray(JOINTS)
    animation = stage.GetPrimAtPath("/Retargeted/Clips/walk_110")
    codes = UsdSkel.Animation(animation).GetRotationsAttr().GetTimeSamples()
    assert stage.GetStartTimeCode() <= codes[0] and codes[-1] <= stage.GetEndTimeCode()
    places = canonical_points(stage, usdskel_positions(stage, skeleton, animation, codes))
    for side, ball in ((0, "LeftFoot"), (1, "RightFoot")):
        balls = places[:, [joint.rsplit("/", 1)[-1] for joint in JOINTS].index(ball) + 1]
        times = np.array(codes)
        flats, liftoffs = (
            [float(code) for code in animation.GetAttribute(name[side]).Get()]
            for name in (tokens.Clip.FLAT_TIMES, tokens.Clip.LIFTOFF_TIMES)
        )
        stood = 0
        for flat in flats:
            liftoff = min([code for code in liftoffs if code > flat], default=np.inf)
            planted = balls[(times >= flat) & (times <= liftoff)]
            if len(planted):
                stood += 1
                assert np.ptp(planted, axis=0).max() < 1e-4
                assert planted[:, 1].mean() == pytest.approx(0.05, abs=2e-3)  # as its body has it
        assert stood


def test_it_reads_back_as_clips_of_the_character(report, hero):
    found = read_libraries(report.file)
    assert not found.problems
    (library,), (character,) = found.libraries, found.characters
    assert character.asset == str(hero)
    assert {clip.name.rsplit("/", 1)[-1] for clip in library.clips} == set(KEPT)
    for clip in library.clips:
        result = report.clips[clip.name.rsplit("/", 1)[-1]]
        assert_allclose(clip.times, result.clip.times, atol=1e-6)
        assert_allclose(clip.translations, result.clip.translations, atol=1e-5)
        assert_allclose(np.abs(np.sum(clip.rotations * result.clip.rotations, axis=-1)), 1.0, atol=1e-5)


def test_crowds_are_animated_from_it(report, tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    source = Usd.Stage.Open(str(report.file))
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(source))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(source))
    stage.SetTimeCodesPerSecond(source.GetTimeCodesPerSecond())
    stage.SetEndTimeCode(120)
    UsdGeom.Imageable(stage.DefinePrim("/World/Library")).GetPrim().GetReferences().AddReference(str(report.file))
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Library")).MakeInvisible()
    curve = UsdGeom.BasisCurves.Define(stage, "/World/Path")
    curve.CreateTypeAttr("linear")
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.5]]) / UsdGeom.GetStageMetersPerUnit(stage)
    if UsdGeom.GetStageUpAxis(stage) == "Z":
        points = points[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    curve.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*point) for point in points.tolist()]))
    curve.CreateCurveVertexCountsAttr([2])
    agent = stage.DefinePrim("/World/Agent", "Xform")
    agent.AddAppliedSchema(tokens.Schema.AGENT)
    for name, target in (
        (tokens.Agent.PATH, "/World/Path"),
        (tokens.Agent.CHARACTER, "/World/Library/Character"),
        (tokens.Agent.CLIPS, "/World/Library/Clips"),
    ):
        agent.CreateRelationship(name, custom=False).SetTargets([target])
    stage.Save()
    animated = animate(tmp_path / "scene.usda", tmp_path / "shot")
    assert not animated.skipped
    (results,) = animated.results.values()
    assert set(results.status) <= {"ok", "outsideHull"}
    figures = {figure.name: figure for figure in validate(animated.crowd_file).total.figures}
    for name in ("placement worst", "slide", "yaw error", "timing faults", "lowest sole"):
        assert figures[name].passed, figures[name]


def test_who_only_stands_still_does_on_the_other_rig(report):
    (library,) = read_libraries(report.file).libraries
    stand = next(clip for clip in library.clips if clip.name.endswith("/stand"))
    assert all(times is None for events in stand.events for times in vars(events).values())
    _, problems = build_examples(library)
    assert not [problem for problem in problems if problem.where == stand.name]


def test_the_command_line(few_clips, hero, tmp_path, capsys):
    out = tmp_path / "clips.usdc"
    assert main(["retarget", few_clips, "--to", str(hero), "--prim", "/World/Cast/Hero", "-o", str(out)]) == 0
    printed, talk = capsys.readouterr()
    assert "walk_110" in printed and "slide mm" in printed and f"wrote {out}" in printed
    assert "has no left collar, left arm, left hand, right collar" in talk
    assert main(["retarget", "--help"]) == 0
    assert "in Python:" in capsys.readouterr().out


def test_what_is_wrong_is_said(few_clips, hero, tmp_path):
    with pytest.raises(SceneError, match="has no prim /World/Nobody"):
        retarget(few_clips, hero, tmp_path / "out.usd", character_prim="/World/Nobody")
    with pytest.raises(OutputError, match="would replace what it is made from"):
        retarget(few_clips, hero, hero)
    with pytest.raises(OutputError, match="is no name of a USD layer"):
        retarget(few_clips, hero, tmp_path / "out.fbx")
    armless = new_stage(tmp_path / "snake.usda")
    add_character(armless, "/World/Snake", Units(), joints=("A", "A/B", "A/B/C"), offsets=np.eye(3))
    armless.Save()
    with pytest.raises(BipedError, match="no joint found for the role"):
        retarget(few_clips, tmp_path / "snake.usda", tmp_path / "out.usd")


def test_clips_of_the_same_name_keep_apart_and_one_bad_clip_is_skipped(hero, tmp_path):
    stage = new_stage(tmp_path / "clips.usda", Units(1.0, "Y", 30.0))
    times = np.arange(0.0, 2.0, 1.0 / 30.0)
    for name in ("First", "Second"):
        add_character(stage, f"/World/{name}", Units())
        add_clip(stage, f"/World/{name}/Skeleton/walk", Units(rate=30.0), times, *walk_pose(times))
    bad = add_clip(stage, "/World/First/Skeleton/bad", Units(rate=30.0), times, *walk_pose(times))
    for name, codes in ((tokens.Clip.STRIKE_TIMES[0], (3, 6)), (tokens.Clip.LIFTOFF_TIMES[0], (9,))):
        attribute = bad.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.TimeCodeArray)
        attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in codes]))
    stage.Save()
    report = retarget(tmp_path / "clips.usda", hero, tmp_path / "out.usda")
    assert list(report.clips) == ["walk", "walk_1"]
    assert [problem.where for problem in report.skipped] == ["/World/First/Skeleton/bad"]


@pytest.mark.parametrize("source", ["bandai/bandai_clips.usdc", "cmu/cmu_clips.usdc"])
def test_motion_capture_on_a_character_of_others(shared_data, tmp_path, source):
    report = retarget(
        shared_data / source, shared_data / "animlab" / "AnimLabSimpleMale.usd", tmp_path / "male_clips.usd"
    )
    assert not report.skipped and len(report.clips) == (31 if "bandai" in source else 7)
    assert max(result.slide for result in report.clips.values()) < 1e-3
    assert max(result.lowered for result in report.clips.values()) < 0.06
    (library,), (character,) = (getattr(read_libraries(report.file), name) for name in ("libraries", "characters"))
    assert len(library.clips) == len(report.clips)
    assert character.skeleton.joints[character.biped.pelvis].endswith("Hips")
    for clip in library.clips:
        assert np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1).min() > 0.5
