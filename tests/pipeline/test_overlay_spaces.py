"""The footstep spaces of an overlay, found again from the scene the crowd was made of."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd, UsdGeom

from usdfoot.cli.main import main
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.inspect import InspectOptions, draw_overlay, inspect
from usdfoot.pipeline.provenance import options_of
from usdfoot.readers.written import read_written_crowd

LENGTH = 0.3


@pytest.fixture(scope="module")
def drawn(stones):
    """Marks of the stepping stones by path, and the crowd's stage."""
    overlay, problems = draw_overlay(
        read_written_crowd(stones.crowd_file), options=InspectOptions(weight_length=LENGTH)
    )
    assert problems == ()
    return {marks.path: marks for marks in overlay.marks}, Usd.Stage.Open(str(stones.crowd_file))


def strikes_of(plan):
    codes = np.array([float(code) for code in plan.GetAttribute("usdfoot:plan:strikeTimes").Get()])
    return codes / plan.GetStage().GetTimeCodesPerSecond()


def test_weighted_examples_land_on_the_next_footstep(drawn):
    marks, stage = drawn
    plan = stage.GetPrimAtPath("/Crowd/Plans/Walker")
    weights = marks["Space/Weights"]
    places = np.array(UsdGeom.PointInstancer(plan).GetPositionsAttr().Get())
    blended = np.array(plan.GetAttribute("usdfoot:result:blendError").Get())
    strikes = strikes_of(plan)
    shares = np.where(weights.hidden, 0.0, weights.scales[..., 1] / LENGTH)
    seen = 0
    for step in range(4, len(strikes) - 1):
        row = int(np.searchsorted(weights.times, 0.5 * (strikes[step - 1] + strikes[step])))
        if weights.hidden[row].all() or blended[step] > 0.01:
            continue
        assert shares[row].sum() == pytest.approx(1.0, abs=1e-3)
        landing = shares[row] @ weights.positions[row][:, [0, 2]]
        assert_allclose(landing, places[step][[0, 2]], atol=0.05)  # corrected for what the blend does to it
        seen += 1
    assert seen > 10


def test_the_space_lies_at_the_support_foot_while_it_supports(drawn):
    marks, stage = drawn
    plan = stage.GetPrimAtPath("/Crowd/Plans/Walker")
    spaces = marks["Space/Examples"]
    places = np.array(UsdGeom.PointInstancer(plan).GetPositionsAttr().Get())
    strikes = strikes_of(plan)
    rows = np.flatnonzero(~spaces.hidden[:, 0])
    assert len(rows) > 100
    supports = np.searchsorted(strikes, spaces.times[rows] + 1e-6, side="right") - 1
    assert_allclose(spaces.positions[rows, 0][:, [0, 2]], places[supports][:, [0, 2]], atol=1e-5)


def test_where_footsteps_are_looked_for_from_the_root_it_lies_midway_between_the_feet(scene, tmp_path):
    assert main(["animate", str(scene), "-o", str(tmp_path), "--landing-frame", "root", "--quiet"]) == 0
    crowd = read_written_crowd(tmp_path / "crowd.usd")
    assert options_of(crowd.provenance).frame == "root"
    overlay, problems = draw_overlay(crowd)
    assert problems == ()
    spaces = next(marks for marks in overlay.marks if marks.path == "Space/Examples")
    plan = crowd.stage.GetPrimAtPath("/Crowd/Plans/Walker")
    places = np.array(UsdGeom.PointInstancer(plan).GetPositionsAttr().Get())[:, [0, 2]]
    rows = np.flatnonzero(~spaces.hidden[:, 0])
    supports = np.searchsorted(strikes_of(plan), spaces.times[rows] + 1e-6, side="right") - 1
    rows, supports = rows[supports > 1], supports[supports > 1]
    assert_allclose(spaces.positions[rows, 0][:, [0, 2]], 0.5 * (places[supports - 1] + places[supports]), atol=1e-5)


def test_the_triangle_joins_the_columns(drawn):
    marks, _ = drawn
    edges, weights = marks["Space/Triangle"], marks["Space/Weights"]
    row = int(np.flatnonzero(~edges.hidden.any(axis=1))[0])
    corners = weights.positions[row, :3]
    assert_allclose(edges.positions[row], corners, atol=1e-12)
    assert_allclose(edges.scales[row, :, 0], np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1))


def test_a_scene_that_changed_since_is_said_to_have(stones, scene, tmp_path):
    changed, over = (Sdf.Layer.CreateNew(str(tmp_path / name)) for name in ("changed.usda", "crowd.usda"))
    changed.TransferContent(Sdf.Layer.FindOrOpen(str(scene)))
    changed.subLayerPaths = [str(scene)]
    Sdf.CreatePrimInLayer(changed, "/World/Library/Motion/Clips/walk_070").active = False
    changed.Save()
    over.TransferContent(Sdf.Layer.FindOrOpen(str(stones.crowd_file)))
    over.subLayerPaths = [str(stones.crowd_file)]
    over.customLayerData = {"usdfoot": {**over.customLayerData["usdfoot"], "scene": "changed.usda"}}
    over.Save()
    report = inspect(tmp_path / "crowd.usda", tmp_path / "inspect.usda")
    assert ["has changed since" in problem.message for problem in report.problems] == [True]
    assert not report.skipped
    assert not Sdf.Layer.FindOrOpen(str(report.file)).GetPrimAtPath("/__usdfoot/Space")
    (tmp_path / "changed.usda").unlink()
    report = inspect(tmp_path / "crowd.usda", tmp_path / "inspect.usda")
    assert any("no such file" in problem.message for problem in report.problems)


def test_bodies_that_physics_moves_have_no_space(scene, tmp_path):
    from usdfoot.physics.motion_options import MotionOptions

    report = animate(scene, tmp_path, options=MotionOptions(motion="physics"))
    overlay, problems = draw_overlay(read_written_crowd(report.crowd_file))
    assert problems == ()
    assert not any(marks.path.startswith("Space") for marks in overlay.marks)
