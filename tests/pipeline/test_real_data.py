"""Real clips on the way from footsteps to a measured crowd."""

import json

import numpy as np
import pytest
from pxr import Usd, UsdValidation

from usdfoot.pipeline.analyze import analyze
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate

PLACED = ("placement mean", "placement worst", "slide", "heel slide", "yaw error", "timing faults", "lowest sole")


@pytest.mark.parametrize("name", ["walk_flat", "stepping_stones"])
def test_scene_is_animated_within_its_targets(shared_data, tmp_path, name):
    report = animate(shared_data / "scenes" / f"{name}.usda", tmp_path)
    assert not report.skipped
    validation = validate(report.crowd_file)
    figures = {figure.name: figure for figure in validation.total.figures}
    assert not [figure for figure in validation.total.figures if figure.name in PLACED and not figure.passed]
    assert not validation.total.unpromised and validation.total.steps == len(report.results["Walker"].status)
    assert figures["blend error mean"].passed
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    for file in ("crowd.usd", "crowd.expanded.usda"):
        stage = Usd.Stage.Open(str(tmp_path / file))
        assert not [(error.GetName(), error.GetMessage()) for error in context.Validate(stage)]
    collected = animate(shared_data / "scenes" / f"{name}.usda", tmp_path / "collected", frames=(10, 20), collect=True)
    stage = Usd.Stage.Open(str(collected.crowd_file))
    files = {layer.realPath for layer in stage.GetUsedLayers() if layer.realPath}
    outside = [file for file in files if not file.startswith(str(tmp_path / "collected"))]
    assert not outside


def test_tracked_people_are_followed(shared_data, tmp_path):
    report = animate(shared_data / "scenes" / "crowd_zara.usda", tmp_path)
    assert len(report.results) == 20 and not report.problems
    assert {status for results in report.results.values() for status in results.status} <= {"ok", "outsideHull"}
    agents = json.loads(report.report_file.read_text())["agents"]
    assert all(agent["trajectory"]["rootDistanceMean"] < 0.06 for agent in agents)
    assert all(np.mean(agent["trajectory"]["velocityError"]) < 0.1 for agent in agents)
    again = animate(report.crowd_file, tmp_path / "again", agents="person_079")  # the footsteps are a plan like any
    assert again.results["person_079"].status == report.results["person_079"].status
    validation = validate(again.crowd_file)
    assert not [figure for figure in validation.total.figures if figure.name in PLACED and not figure.passed]


@pytest.mark.parametrize(
    ("file", "clips"),
    [
        ("bandai/bandai_clips.usdc", 31),
        ("cmu/cmu_clips.usdc", 7),
        ("pab/pab_walk.usdc", 1),
        ("knight/knight_Walking_A.usdc", 1),
    ],
)
def test_clips_of_every_exporter_are_summed_up(shared_data, tmp_path, file, clips):
    report = analyze(shared_data / file, output=tmp_path / "events.usda")
    assert len(report.summaries) == clips and not report.problems
    assert all(summary.steps > 0 for summary in report.summaries)
    assert report.output is not None and Usd.Stage.Open(str(report.output))
