"""Footsteps edited in an open crowd: what artists keep is in overrides.usda, what is shown is animated again."""

from dataclasses import replace

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from tests.digests import digests
from usdfoot.errors import PlanError, SceneError
from usdfoot.pipeline.again import edit_plan, remake
from usdfoot.pipeline.validate import validate
from usdfoot.readers.written import read_written_crowd
from usdfoot.usdview.footsteps import add_after_selected, delete_selected, move_selected, move_selected_to_point
from usdfoot.usdview.overlays import toggle_overlay
from usdfoot.usdview.selection import Selection

NOW = Usd.TimeCode(0.0)
PLAN = Sdf.Path("/Crowd/Plans/Agent_1")


def footstep(number, point=None):
    return Selection(paths=(PLAN,), instances={PLAN: frozenset([number])}, point=point)


def places(stage, path=PLAN):
    return np.array(UsdGeom.PointInstancer(stage.GetPrimAtPath(path)).GetPositionsAttr().Get())


def stands(stage):
    """Where the left foot of Agent_1 really stands."""
    return np.array(stage.GetPrimAtPath("/Crowd/Anims/Agent_1").GetAttribute("usdfoot:contact:left:positions").Get())


def test_a_moved_footstep_is_stood_on_and_kept(shot, opened):
    source, before = digests(shot / "scene"), places(opened)
    toggle_overlay(opened, Selection(), NOW, kind="Footsteps")
    move_selected(opened, footstep(8), NOW, ahead=0.05, left=0.03, turn=0.1)
    moved = places(opened)
    assert np.linalg.norm(moved[8] - before[8]) == pytest.approx(np.hypot(0.05, 0.03), abs=1e-4)
    assert np.array_equal(np.delete(moved, 8, axis=0), np.delete(before, 8, axis=0))
    assert np.abs(stands(opened)[:, [0, 2]] - moved[8][[0, 2]]).sum(axis=1).min() < 1e-3
    layer = Sdf.Layer.FindOrOpen(str(shot / "crowd" / "overrides.usda"))
    assert not layer.dirty and layer.GetAttributeAtPath(f"{PLAN}.positions")
    assert digests(shot / "scene") == source
    drawn = places(opened, "/__usdfoot/Footsteps")
    assert np.abs(drawn[:, [0, 2]] - moved[8][[0, 2]]).sum(axis=1).min() < 1e-4  # the overlay followed
    assert validate(shot / "crowd" / "crowd.usd").passed


def test_a_footstep_goes_to_the_point_picked(shot, opened):
    target = places(opened)[8] + [0.04, 0.0, 0.02]
    move_selected_to_point(opened, footstep(8, point=target), NOW)
    assert np.allclose(places(opened)[8], target, atol=1e-5)
    with pytest.raises(SceneError, match="no point"):
        move_selected_to_point(opened, footstep(8), NOW)


def test_footsteps_added_and_deleted_again_are_as_many_as_before(shot, opened):
    before = places(opened)
    last = len(before) - 1
    report = add_after_selected(opened, footstep(6), NOW)
    assert len(places(opened)) == len(before) + 2 == len(report.results["Agent_1"].status)
    assert delete_selected(opened, footstep(7), NOW).kept == 2  # the other agents' chunks
    assert np.allclose(places(opened), before, atol=1e-5)
    delete_selected(opened, footstep(last), NOW)
    assert len(places(opened)) == last


def test_an_edit_that_makes_no_plan_changes_nothing(shot, opened):
    before = digests(shot)
    with pytest.raises(PlanError, match="no footstep 99"):
        delete_selected(opened, footstep(99), NOW)
    assert digests(shot) == before


def test_an_edit_that_cannot_be_animated_is_taken_back(shot, opened):
    crowd, was = read_written_crowd(opened), places(opened)
    remake(crowd)  # a copy lies elsewhere, which its chunks' hashes know
    before = digests(shot)
    with pytest.raises(PlanError, match=r"stays as it was.*moonwalk"):
        edit_plan(crowd, "Agent_1", lambda plan: replace(plan, styles=("moonwalk",) * len(plan)))
    assert digests(shot) == before and np.array_equal(places(opened), was)
