"""Schemas are registered when usdfoot is imported first, and nothing is lost when it is not."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Plug, Sdf, Usd, UsdGeom

from usdfoot.bridge import schema, tokens

AUTHOR = """
import sys
from pxr import Sdf, Usd, UsdSkel

stage = Usd.Stage.CreateInMemory()
if "late" in sys.argv:
    Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("SkelBindingAPI")

from usdfoot.bridge import schema, tokens

schema.register_schemas()
prim = UsdSkel.Animation.Define(stage, "/Anim").GetPrim()
for name in (tokens.Schema.CLIP, *tokens.Schema.CONTACT_INSTANCES):
    prim.AddAppliedSchema(name)
    assert schema.has_api(prim, name), name
assert not schema.has_api(prim, tokens.Schema.AGENT)
prim.CreateAttribute(
    tokens.Contact.STRIKE_TIMES[1], Sdf.ValueTypeNames.TimeCodeArray, custom=False, variability=Sdf.VariabilityUniform
).Set([1.0, 31.0])
known = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(tokens.Schema.CLIP) is not None
print("registered" if known else "unregistered")
print("style", prim.GetAttribute(tokens.Clip.STYLE).Get())
print("applied", *prim.GetAppliedSchemas())
print(stage.GetRootLayer().ExportToString())
"""


def run(script: str, *arguments: str, folder: Path, repository: Path, plugins: Path | None = None):
    """Run a script in a Python of its own, where USD has not been used yet."""
    search = [str(repository), *filter(None, [os.environ.get("PYTHONPATH")])]
    # USD would tell of every setting the caller's environment has; here only what usdfoot causes is to be seen.
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(search), "TF_ENV_SETTING_ALERTS_ENABLED": "0"}
    if plugins is not None:
        environment["PXR_PLUGINPATH_NAME"] = str(plugins)
    command = [sys.executable, "-c", script, *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def registered(tmp_path_factory, repository):
    return run(AUTHOR, folder=tmp_path_factory.mktemp("early"), repository=repository)


@pytest.fixture(scope="module")
def unregistered(tmp_path_factory, repository):
    return run(AUTHOR, "late", folder=tmp_path_factory.mktemp("late"), repository=repository)


def facts(done: subprocess.CompletedProcess[str]) -> list[str]:
    return done.stdout.splitlines()[:3]


def layer_text(done: subprocess.CompletedProcess[str]) -> str:
    return done.stdout.partition("#usda")[2]


def test_importing_the_bridge_registers_the_schemas(registered):
    assert registered.stderr == ""
    assert facts(registered) == [
        "registered",
        "style default",
        "applied UsdfootClipAPI UsdfootContactAPI:left UsdfootContactAPI:right",
    ]


def test_without_registration_nothing_warns_and_usd_knows_no_fallback(unregistered):
    assert unregistered.stderr == ""
    assert facts(unregistered) == ["unregistered", "style None", "applied"]


def test_the_same_file_is_written_with_and_without_registration(registered, unregistered):
    assert layer_text(registered) == layer_text(unregistered)
    assert "uniform timecode[] usdfoot:contact:right:strikeTimes = [1, 31]" in layer_text(registered)


def test_a_plugin_found_by_usd_itself_is_not_registered_twice(repository, tmp_path):
    copy = shutil.copytree(repository / "schemas", tmp_path / "plugins")
    script = (
        AUTHOR
        + """
from pxr import Plug
print(Plug.Registry().GetPluginWithName(tokens.PLUGIN).resourcePath)
"""
    )
    done = run(script, folder=tmp_path, repository=repository, plugins=copy)
    first, *_, last = done.stdout.splitlines()
    assert first == "registered"
    assert Path(last).resolve() == copy.resolve()


def test_a_plugin_that_claims_the_same_schemas_is_a_warning_not_a_failure(repository, tmp_path):
    copy = Path(shutil.copytree(repository / "schemas", tmp_path / "plugins"))
    info = (copy / "plugInfo.json").read_text(encoding="utf-8")
    (copy / "plugInfo.json").write_text(info.replace('"Name": "usdfoot"', '"Name": "other"'), encoding="utf-8")
    done = run(AUTHOR, folder=tmp_path, repository=repository, plugins=copy)
    assert "are not registered" in done.stderr
    assert "previously provided by plugin 'other'" in done.stderr


def test_contact_instances_take_their_properties_from_the_schema(repository, tmp_path):
    script = """
import usdfoot.bridge
from pxr import Usd, UsdSkel
stage = Usd.Stage.CreateInMemory()
prim = UsdSkel.Animation.Define(stage, "/Anim").GetPrim()
prim.AddAppliedSchema("UsdfootContactAPI:left")
print(*(name for name in prim.GetPropertyNames() if name.startswith("usdfoot:")))
print(Usd.SchemaRegistry.IsAllowedAPISchemaInstanceName("UsdfootContactAPI", "middle"))
"""
    names, allowed = run(script, folder=tmp_path, repository=repository).stdout.splitlines()
    contact = tokens.Contact
    left = (contact.STRIKE_TIMES, contact.FLAT_TIMES, contact.LIFTOFF_TIMES, contact.POSITIONS, contact.BALL_HEIGHT)
    assert sorted(names.split()) == sorted(name[0] for name in left)
    assert allowed == "False"


def test_schemas_apply_where_the_contract_puts_them(repository, tmp_path):
    script = """
import usdfoot.bridge
from pxr import Usd, UsdGeom
stage = Usd.Stage.CreateInMemory()
mesh = UsdGeom.Mesh.Define(stage, "/Mesh").GetPrim()
xform = UsdGeom.Xform.Define(stage, "/Xform").GetPrim()
for name in ("UsdfootObstacleAPI", "UsdfootTerrainAPI", "UsdfootAgentAPI", "UsdfootPlanAPI"):
    print(name, bool(mesh.CanApplyAPI(name)), bool(xform.CanApplyAPI(name)))
"""
    assert run(script, folder=tmp_path, repository=repository).stdout.splitlines() == [
        "UsdfootObstacleAPI True False",
        "UsdfootTerrainAPI True True",
        "UsdfootAgentAPI False True",
        "UsdfootPlanAPI False False",
    ]


def test_schema_folder_holds_a_plugin_usd_accepts(repository):
    folder = schema.schema_folder()
    assert folder is not None
    assert folder.resolve() == (repository / "schemas").resolve()
    assert (folder / "generatedSchema.usda").is_file()
    assert Plug.Registry().GetPluginWithName(tokens.PLUGIN) is not None


def test_applied_apis_are_composed_over_layers_and_references():
    asset = Sdf.Layer.CreateAnonymous(".usda")
    asset.ImportFromString('#usda 1.0\ndef Xform "A" (prepend apiSchemas = ["UsdfootAgentAPI", "GoneAPI"]) {}\n')
    weak = Sdf.Layer.CreateAnonymous(".usda")
    weak.ImportFromString('#usda 1.0\nover "A" (append apiSchemas = ["UsdfootContactAPI:right"]) {}\n')
    strong = Sdf.Layer.CreateAnonymous(".usda")
    strong.ImportFromString('#usda 1.0\nover "A" (delete apiSchemas = ["GoneAPI"]) {}\n')
    strong.subLayerPaths.append(weak.identifier)
    stage = Usd.Stage.Open(strong)
    prim = stage.GetPrimAtPath("/A")
    prim.GetReferences().AddReference(asset.identifier, "/A")
    assert schema.applied_apis(prim) == ("UsdfootAgentAPI", "UsdfootContactAPI:right")
    assert schema.has_api(prim, tokens.Schema.CONTACT_INSTANCES[1])
    assert not schema.has_api(prim, tokens.Schema.CONTACT_INSTANCES[0])
    assert not schema.has_api(prim, tokens.Schema.CONTACT)
    assert not schema.has_api(prim, "GoneAPI")


def test_a_layer_that_adds_a_schema_keeps_those_of_weaker_layers():
    weak, strong = Sdf.Layer.CreateAnonymous(".usda"), Sdf.Layer.CreateAnonymous(".usda")
    weak.ImportFromString('#usda 1.0\ndef Xform "A" (prepend apiSchemas = ["UsdfootAgentAPI"]) {}\n')
    strong.ImportFromString('#usda 1.0\nover "A" (add apiSchemas = ["OtherAPI"]) {}\n')
    strong.subLayerPaths.append(weak.identifier)
    stage = Usd.Stage.Open(strong)
    assert schema.applied_apis(stage.GetPrimAtPath("/A")) == ("UsdfootAgentAPI", "OtherAPI")


def test_a_prim_without_schemas_has_none():
    stage = Usd.Stage.CreateInMemory()
    assert schema.applied_apis(UsdGeom.Xform.Define(stage, "/A").GetPrim()) == ()
