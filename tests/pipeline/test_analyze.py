"""Clips are summed up, and their events written so that they read back."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from pxr import Sdf, Usd

from usdfoot.bridge import tokens
from usdfoot.cli.main import main
from usdfoot.cli.tables import clip_table
from usdfoot.errors import OutputError, SceneError, UsdfootError
from usdfoot.pipeline.analyze import analyze
from usdfoot.readers.libraries import read_libraries
from usdfoot.spaces.holes import HoleOptions


@pytest.fixture(scope="module")
def clips(stages, tmp_path_factory):
    """Three of the project's clips in a file of their own."""
    source = Usd.Stage.Open(str(stages / "clips.usdc"))
    names = [prim.GetName() for prim in source.GetDefaultPrim().GetChild("Clips").GetChildren()]
    kept = {"walk_110", "run_320", "side_left_035"}
    assert kept <= set(names)
    path = tmp_path_factory.mktemp("clips") / "clips.usda"
    layer = Sdf.Layer.CreateNew(str(path))
    layer.subLayerPaths = [str(stages / "clips.usdc")]
    stage = Usd.Stage.Open(layer)
    stage.SetTimeCodesPerSecond(source.GetTimeCodesPerSecond())
    for key in ("metersPerUnit", "upAxis", "defaultPrim"):
        stage.SetMetadata(key, source.GetMetadata(key))
    for name in set(names) - kept:
        stage.OverridePrim(source.GetDefaultPrim().GetPath().AppendPath(f"Clips/{name}")).SetActive(False)
    stage.Save()
    return path


def by_name(report):
    return {summary.name.rsplit("/", 1)[-1]: summary for summary in report.summaries}


def test_summaries(clips):
    found = by_name(analyze(clips))
    assert set(found) == {"walk_110", "run_320", "side_left_035"}
    assert found["walk_110"].speed == pytest.approx(1.1, abs=0.05)
    assert found["run_320"].speed == pytest.approx(3.2, abs=0.15)
    assert np.degrees(found["side_left_035"].direction) == pytest.approx(90.0, abs=5.0)
    assert found["walk_110"].duty_factor > 0.5 > found["run_320"].duty_factor
    marching = replace(found["side_left_035"], speed=0.001, direction=1.4)
    directions = list(clip_table([found["walk_110"], marching]).columns[4].cells)
    assert directions == ["0", "-"]  # who goes nowhere has none


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
def test_events_read_back_and_can_be_corrected(clips, tmp_path, suffix):
    before = hashlib.sha256(clips.read_bytes()).digest()
    first = analyze(clips, output=tmp_path / f"events{suffix}")
    again = analyze(first.output)
    assert hashlib.sha256(clips.read_bytes()).digest() == before
    for name, summary in by_name(first).items():
        for side in (0, 1):
            for events in ("strike_times", "flat_times", "liftoff_times"):
                expected = getattr(summary.contacts[side], events)
                np.testing.assert_allclose(
                    getattr(by_name(again)[name].contacts[side], events),
                    expected,
                    atol=1e-4,
                    err_msg=f"{name} {events}",
                )
    stage = Usd.Stage.Open(str(first.output))
    prim = stage.GetPrimAtPath(by_name(first)["walk_110"].name)
    attribute = prim.GetAttribute(tokens.Clip.STRIKE_TIMES[0])
    codes = [float(code) + 1.0 for code in attribute.Get()]
    attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in codes]))
    stage.Save()
    corrected = by_name(analyze(first.output))["walk_110"].contacts[0].strike_times
    shift = 1.0 / stage.GetTimeCodesPerSecond()
    np.testing.assert_allclose(corrected, by_name(first)["walk_110"].contacts[0].strike_times + shift, atol=1e-4)


def test_messages(clips, tmp_path, stages):
    with pytest.raises(OutputError, match="would replace what it is made from"):
        analyze(clips, output=clips)
    with pytest.raises(OutputError, match=r"is no name of a USD layer. name a file that ends in \.usd"):
        analyze(clips, output=tmp_path / "events.txt")
    with pytest.raises(SceneError, match="has no clips"):
        analyze(stages / "terrain_slope.usda")
    with pytest.raises(SceneError, match="no such file"):
        analyze(tmp_path / "none.usda")


def test_styles_are_found_written_and_drawn(clips, tmp_path):
    report = analyze(clips, output=tmp_path / "styles.usda", styles=True, plots=tmp_path / "plots")
    styles = {name: summary.style for name, summary in by_name(report).items()}
    assert styles["walk_110"] == styles["side_left_035"] != styles["run_320"]
    again = analyze(report.output)
    assert {name: summary.style for name, summary in by_name(again).items()} == styles
    assert sorted(path.stem.split("_")[-3:] for path in report.plots) == [
        ["run", "flight", "left"],
        ["walk", "ground", "left"],
    ]
    for path in report.plots:
        assert path.read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_pictures_are_refused(clips, tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(UsdfootError, match=r"matplotlib: is not installed.*pip install 'usdfoot\[report\]'"):
        analyze(clips, plots=tmp_path)


def test_coverage_is_found_written_drawn_and_told(clips, tmp_path, capsys):
    assert main(["analyze", str(clips), "--coverage", str(tmp_path / "coverage.usda"), "-q"]) == 0
    told = capsys.readouterr().out
    assert f"wrote {tmp_path / 'coverage.usda'}" in told and f"drew {tmp_path / 'coverage.png'}" in told
    assert "no step lands near x=" in told and "foot" in told and "nearest example 0." in told
    assert (tmp_path / "coverage.png").read_bytes().startswith(b"\x89PNG")
    report = analyze(clips, coverage=tmp_path / "again.usda")
    assert (tmp_path / "again.usda").read_bytes() == (tmp_path / "coverage.usda").read_bytes()
    stage = Usd.Stage.Open(str(tmp_path / "coverage.usda"))
    shown = [prim for prim in stage.Traverse() if prim.GetName() == "Landings"]
    assert len(shown) == len(report.coverage) == 4
    assert {(space.flight, space.side) for space in report.coverage} == {(f, s) for f in (False, True) for s in (0, 1)}
    with pytest.raises(OutputError, match="would replace what it is made from"):
        analyze(clips, coverage=clips)


def test_holes_are_filled_beside_the_clips(clips, tmp_path):
    before = hashlib.sha256(clips.read_bytes()).digest()
    report = analyze(clips, output=tmp_path / "filled.usda", fill=HoleOptions(gap=0.4))
    assert hashlib.sha256(clips.read_bytes()).digest() == before
    (filled,) = report.filled
    made = {clip.name: clip for clip in filled.clips}
    assert made and set(made) < {summary.name for summary in report.summaries}
    (library,) = read_libraries(report.output).libraries
    read = {clip.name: clip for clip in library.clips}
    assert {name for name, clip in read.items() if clip.synthetic} == set(made)
    for name, clip in made.items():
        assert read[name].range_start == pytest.approx(clip.range_start, abs=1e-4)
        assert read[name].range_end == pytest.approx(clip.range_end, abs=1e-4)
        np.testing.assert_allclose(read[name].translations, clip.translations, atol=1e-5)
        np.testing.assert_allclose(
            np.abs(np.sum(read[name].rotations * clip.rotations, axis=-1)), 1.0, atol=1e-5, err_msg=name
        )
        for side in (0, 1):
            known = clip.events[side].strike_times
            assert np.isin(known.round(4), read[name].events[side].strike_times.round(4)).all()
    stage = Usd.Stage.Open(str(report.output))
    prim = stage.GetPrimAtPath(next(iter(made)))
    assert prim.GetTypeName() == "SkelAnimation" and prim.GetCustomDataByKey("synthetic")
    assert prim.GetAttribute(tokens.Clip.SOURCE).Get() == tokens.ClipSource.SYNTHETIC


def test_a_filled_file_is_filled_no_further(clips, tmp_path):
    first = analyze(clips, output=tmp_path / "filled.usda", fill=HoleOptions(gap=0.4))
    again = analyze(first.output, fill=HoleOptions(gap=0.45))
    assert len(again.filled[0].holes) < 0.2 * len(first.filled[0].holes) + 1
