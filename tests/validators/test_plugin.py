"""USD finds the plugin by itself or late, and validators of others load whatever is wrong with it."""

import os
import subprocess
import sys

import pytest

COUNT = """
from pxr import Gf, Tf, Usd, UsdGeom, UsdSkel, UsdValidation
loaded = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
names = [validator.GetMetadata().name for validator in loaded]
own = [name for name in names if name.startswith("usdfoot.validators:")]
stage = Usd.Stage.CreateInMemory()
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
UsdGeom.SetStageUpAxis(stage, "Y")
stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
plan = UsdGeom.PointInstancer.Define(stage, "/World/Plan")
plan.GetPrim().AddAppliedSchema("UsdfootPlanAPI")
found = UsdValidation.ValidationContext(loaded).Validate(stage)
print(len(own), len(names) - len(own), *(error.GetIdentifier() for error in found))
"""


def run(script, *, folder, repository, plugin=False):
    """Standard output and standard error of a script in a Python of its own."""
    search = [str(repository), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(search), "TF_ENV_SETTING_ALERTS_ENABLED": "0"}
    if plugin:
        environment["PXR_PLUGINPATH_NAME"] = str(repository / "usdfoot" / "validators")
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines(), done.stderr


@pytest.fixture(scope="module")
def stock(repository, tmp_path_factory):
    """How many validators USD itself has."""
    (line,), _ = run(COUNT, folder=tmp_path_factory.mktemp("stock"), repository=repository)
    own, others = line.split()
    assert own == "0" and int(others) > 10
    return others


@pytest.mark.parametrize("plugin", [True, False])
def test_the_plugin_is_found_on_the_path_or_by_import_however_late(plugin, stock, repository, tmp_path):
    first = (
        ""
        if plugin
        else "from pxr import UsdValidation; UsdValidation.ValidationRegistry(); import usdfoot.validators\n"
    )
    (line,), errors = run(first + COUNT, folder=tmp_path, repository=repository, plugin=plugin)
    assert line == f"6 {stock} usdfoot.validators:PlanArrays.PlanInconsistent"
    assert errors == ""


def test_without_what_it_needs_it_registers_nothing_and_all_others_load(stock, repository, tmp_path):
    (line,), errors = run(
        "import sys; sys.modules['scipy'] = sys.modules['numpy'] = None\n" + COUNT,
        folder=tmp_path,
        repository=repository,
        plugin=True,
    )
    assert line == f"0 {stock}"
    assert "the validators of usdfoot are not registered: " in errors
