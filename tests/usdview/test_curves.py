"""Plans along curves selected in any stage."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdfoot.errors import PlanError, SceneError
from usdfoot.readers.plans import read_plan
from usdfoot.readers.stage import read_stage_info
from usdfoot.usdview.curves import plan_along_selected
from usdfoot.usdview.selection import Selection

RATE = 24.0


@pytest.fixture
def stage():
    """A straight line of 5 m along -Y of a stage in centimetres with Z up."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetTimeCodesPerSecond(RATE)
    curve = UsdGeom.BasisCurves.Define(stage, "/Set/Way")
    curve.CreateTypeAttr("linear")
    curve.CreatePointsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(0, -500, 0)])
    curve.CreateCurveVertexCountsAttr([2])
    stage.SetEditTarget(stage.GetSessionLayer())
    return stage


def along(stage, time):
    return plan_along_selected(stage, Selection(paths=(Sdf.Path("/Set/Way"),)), time)


def test_a_plan_follows_the_curve_from_the_current_time(stage):
    root = stage.GetRootLayer().ExportToString()
    (path,) = along(stage, Usd.TimeCode(48.0))
    assert path == "/Plans/Way"
    plan, _ = read_plan(stage.GetPrimAtPath(path), read_stage_info(stage).units)
    assert plan.start == pytest.approx(2.0)
    assert np.ptp(plan.positions[:, 2]) == pytest.approx(5.0, abs=0.4)
    assert np.abs(plan.positions[:, 0]).max() < 0.2
    assert stage.GetRootLayer().ExportToString() == root  # it is at the edit target
    (again,) = along(stage, Usd.TimeCode.Default())
    assert again == "/Plans/Way_1"


def test_what_the_curve_says_of_its_time_is_kept(stage):
    curve = stage.GetPrimAtPath("/Set/Way")
    curve.CreateAttribute("usdfoot:path:startTime", Sdf.ValueTypeNames.TimeCode).Set(Sdf.TimeCode(12.0))
    (path,) = along(stage, Usd.TimeCode(48.0))
    plan, _ = read_plan(stage.GetPrimAtPath(path), read_stage_info(stage).units)
    assert plan.start == pytest.approx(0.5)


def test_what_is_no_curve_is_said_and_nothing_written(stage):
    with pytest.raises(SceneError, match="no curve"):
        plan_along_selected(stage, Selection(paths=(Sdf.Path("/Set"),)), Usd.TimeCode(0.0))
    UsdGeom.BasisCurves(stage.GetPrimAtPath("/Set/Way")).GetPointsAttr().Set([Gf.Vec3f(0), Gf.Vec3f(0, -1, 0)])
    with pytest.raises(PlanError):
        along(stage, Usd.TimeCode(0.0))
    assert not stage.GetPrimAtPath("/Plans")
