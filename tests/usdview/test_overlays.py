"""Overlays in the session layer of an open crowd."""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdValidation

from usdfoot.errors import OutputError, SceneError
from usdfoot.model.overlay_kinds import KINDS
from usdfoot.usdview.overlays import remove_overlays, save_overlay, shown_kinds, toggle_overlay
from usdfoot.usdview.selection import Selection

NOW = Usd.TimeCode(30.0)
ONE = Selection(paths=(Sdf.Path("/Crowd/Agents/Agent_1"),))


@pytest.fixture(autouse=True)
def clean(stage):
    yield
    stage.GetSessionLayer().Clear()


@pytest.mark.parametrize("kind", KINDS)
def test_every_overlay_is_shown_hidden_and_shown_again(stage, kind):
    before = {layer.identifier: layer.ExportToString() for layer in stage.GetLayerStack(includeSessionLayers=False)}
    assert toggle_overlay(stage, ONE, NOW, kind=kind) == ()
    assert shown_kinds(stage) == (kind,)
    drawn = [prim for prim in Usd.PrimRange(stage.GetPrimAtPath(f"/__usdfoot/{kind}")) if prim.IsA(UsdGeom.Gprim)]
    assert drawn
    toggle_overlay(stage, ONE, NOW, kind=kind)
    assert shown_kinds(stage) == ()
    toggle_overlay(stage, Selection(), NOW, kind=kind)
    assert shown_kinds(stage) == (kind,)
    assert {
        layer.identifier: layer.ExportToString() for layer in stage.GetLayerStack(includeSessionLayers=False)
    } == before


def test_what_is_selected_is_drawn_or_else_everybody(stage):
    toggle_overlay(stage, ONE, NOW, kind="Com")
    agents = stage.GetPrimAtPath("/__usdfoot/Com").GetAttribute("usdfoot:overlay:agents")
    assert list(agents.Get()) == ["Agent_1"]
    toggle_overlay(stage, ONE, NOW, kind="Com")
    toggle_overlay(stage, Selection(), NOW, kind="Com")
    assert len(agents.Get()) == 3 == len(UsdGeom.BasisCurves(agents.GetPrim()).GetCurveVertexCountsAttr().Get())


def test_removed_overlays_leave_nothing(stage):
    toggle_overlay(stage, ONE, NOW, kind="Errors")
    remove_overlays(stage)
    assert not stage.GetPrimAtPath("/__usdfoot")
    assert stage.GetSessionLayer().empty


def test_saved_overlays_open_over_the_crowd(stage, made, tmp_path):
    toggle_overlay(stage, ONE, NOW, kind="Errors")
    toggle_overlay(stage, ONE, NOW, kind="Timing")
    file = save_overlay(stage, tmp_path / "inspect.usda")
    crowd = Sdf.Layer.FindOrOpen(str(made / "crowd" / "crowd.usd"))
    again = Usd.Stage.Open(crowd, Sdf.Layer.FindOrOpen(str(file)))
    assert shown_kinds(again) == ("Errors", "Timing")
    assert again.GetPrimAtPath("/__usdfoot").GetAttribute("usdfoot:overlay:scale:error").Get() == 100.0
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetMessage() for error in context.Validate(again)] == []
    with pytest.raises(OutputError, match="would replace what it is made from"):
        save_overlay(stage, made / "crowd" / "agents.usdc")


def test_what_cannot_be_done_is_said(stage, tmp_path):
    with pytest.raises(SceneError, match=r"no overlay.*Footsteps"):
        toggle_overlay(stage, ONE, NOW, kind="Shoes")
    with pytest.raises(SceneError, match="shows no overlay"):
        save_overlay(stage, tmp_path / "inspect.usda")
    with pytest.raises(SceneError, match="has no agents"):
        toggle_overlay(Usd.Stage.CreateInMemory(), Selection(), NOW, kind="Errors")
