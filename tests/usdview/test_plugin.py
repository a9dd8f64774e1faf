"""The plugin as usdview finds, loads and runs it; usdview itself is stood in for by what it documents."""

import json
import os
import sys

import pytest
from pxr import Plug, Sdf, Tf, Usd

from tests.usdview.usdviewq import Answers, PluginRegistry, PluginUIBuilder, UsdviewApi, installed
from usdfoot.cli.main import main
from usdfoot.pipeline.plugins import plugin_folders

TYPE = "usdfoot.usdview.plugin.UsdfootContainer"


@pytest.fixture(scope="module")
def answers():
    return Answers()


@pytest.fixture(scope="module")
def container(answers):
    """The container, made by USD's plugin system from plugInfo.json."""
    with installed(answers):
        registry = Plug.Registry()
        registry.RegisterPlugins(str(plugin_folders()[-1]))
        plugin = registry.GetPluginWithName("usdfoot.usdview.plugin")
        base = Tf.Type.FindByName("pxr.Usdviewq.plugin.PluginContainer")
        (found,) = [kind for kind in Plug.Registry.GetAllDerivedTypes(base) if kind.typeName == TYPE]
        assert registry.GetPluginForType(found) == plugin
        assert plugin.Load() and plugin.isLoaded
        yield found.pythonClass()


def menu_of(container, api):
    """Commands of the menu by label, submenus included, as usdview makes them."""
    registry, builder = PluginRegistry(api), PluginUIBuilder()
    container.registerPlugins(registry, api)
    container.configureView(registry, builder)
    assert list(builder.menus) == ["Usdfoot"]
    menu = builder.menus["Usdfoot"]
    placed = [item for part in (menu, *menu.submenus.values()) for item in part.items]
    assert {item.name for item in placed} == set(registry.commands)
    assert all(item.description for item in placed)
    return {item.displayName: item for item in placed}


def test_the_menu_is_built_without_importing_what_is_behind_it(container, stage):
    sys.modules.pop("usdfoot.usdview.actions", None)
    labels = set(menu_of(container, UsdviewApi(stage)))
    assert {"Footsteps", "Errors", "Contacts", "Centre of Mass", "Footstep Space", "Timing"} < labels
    assert {"Root Weight...", "Seam...", "Move...", "Add After", "Delete", "Save Overlay..."} < labels
    assert {"Plan Along Selected Curve", "Jump to Worst Step"} < labels
    assert "usdfoot.usdview.actions" not in sys.modules


@pytest.mark.parametrize("label", ["Footsteps", "Errors", "Contacts", "Centre of Mass", "Timing"])
def test_overlays_are_shown_as_guides_and_hidden(container, stage, label):
    api = UsdviewApi(stage, paths=["/Crowd/Agents/Agent_0"])
    command = menu_of(container, api)[label]
    command.run()
    assert api.dataModel.viewSettings.displayGuide
    assert api.statuses[-1].endswith("shown") and api.updates
    command.run()
    assert api.statuses[-1].endswith("hidden")
    menu_of(container, api)["Remove All"].run()
    assert stage.GetSessionLayer().empty


def test_the_worst_step_is_gone_to(container, stage):
    api = UsdviewApi(stage)
    menu_of(container, api)["Jump to Worst Step"].run()
    (path,) = api.selectedPaths
    assert path.GetParentPath() == "/Crowd/Agents"
    strikes = stage.GetPrimAtPath(f"/Crowd/Plans/{path.name}").GetAttribute("usdfoot:plan:strikeTimes").Get()
    assert api.frame.GetValue() in [float(code) for code in strikes]
    assert "mm" in api.statuses[-1]


def test_an_overlay_is_saved_where_it_is_asked_for(container, answers, stage, tmp_path):
    api = UsdviewApi(stage)
    menu = menu_of(container, api)
    menu["Errors"].run()
    answers.answers = [None, str(tmp_path / "inspect.usda")]
    menu["Save Overlay..."].run()
    assert not list(tmp_path.iterdir())
    menu["Save Overlay..."].run()
    assert Sdf.Layer.FindOrOpen(str(tmp_path / "inspect.usda")).GetPrimAtPath("/__usdfoot/Errors")
    menu["Remove All"].run()


def test_agents_and_footsteps_are_changed_from_the_menu(container, answers, opened):
    plan = opened.GetPrimAtPath("/Crowd/Plans/Agent_0")
    api = UsdviewApi(opened, paths=[plan.GetPath()], instances={plan.GetPath(): {9}}, point=(0.0, 0.0, 0.0))
    menu = menu_of(container, api)
    answers.answers = [0.5, "crossfade", None]
    menu["Root Weight..."].run()
    menu["Seam..."].run()
    menu["Seam..."].run()  # cancelled
    assert len(opened.GetSessionLayer().subLayerPaths) == 6
    menu["Drop Takes"].run()
    assert api.statuses[-1] == "2 takes dropped"
    before = plan.GetAttribute("positions").Get()
    answers.answers = [0.04, 0.0, 5.0]
    menu["Move..."].run()
    assert "animated 3 agents" in api.statuses[-1]
    moved = plan.GetAttribute("positions").Get()
    assert [a == b for a, b in zip(before, moved, strict=True)] == [row != 9 for row in range(len(before))]
    menu["Delete"].run()
    assert len(plan.GetAttribute("positions").Get()) == len(before) - 2
    menu["Add After"].run()
    assert len(plan.GetAttribute("positions").Get()) == len(before)
    menu["Move to Picked Point"].run()
    assert "holds no point" in api.statuses[-1]  # usdview's zero


def test_errors_are_told_and_nothing_breaks(container, capsys):
    api = UsdviewApi(Usd.Stage.CreateInMemory())
    menu = menu_of(container, api)
    for label in ("Errors", "Jump to Worst Step", "Plan Along Selected Curve", "Delete", "Drop Takes"):
        menu[label].run()
        assert api.statuses[-1].startswith("Usdfoot: ")
    assert "crowd.usd" in capsys.readouterr().err


def test_the_plugin_path_is_printed(capsys):
    assert main(["plugin-path"]) == 0
    printed = capsys.readouterr().out.strip()
    folders = plugin_folders()
    assert len(folders) == 3 and printed == os.pathsep.join(str(folder) for folder in folders)
    names = set()
    for folder in folders:
        text = (folder / "plugInfo.json").read_text(encoding="utf-8")
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        names |= {plugin["Name"] for plugin in json.loads("\n".join(lines))["Plugins"]}
    assert names == {"usdfoot", "usdfoot.validators", "usdfoot.usdview.plugin"}
