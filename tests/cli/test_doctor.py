"""The doctor sees what is there, what is missing, and what to do about it."""

import json
import os
import re
import subprocess
import sys

import pytest
from pxr import Usd

from usdfoot import __version__
from usdfoot.bridge.schema import schema_folder
from usdfoot.cli.console import results_console
from usdfoot.cli.main import main
from usdfoot.cli.tables import symptom_table
from usdfoot.pipeline.doctor import DISTRIBUTIONS, EXTRAS, LOWEST_PYTHON, LOWEST_USD, NEEDED, Symptom


def diagnose(script, *, folder, repository, plugins=""):
    """Exit code and symptoms by name of a doctor in a Python of its own, after a script."""
    search = [str(repository), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(search), "PXR_PLUGINPATH_NAME": plugins}
    program = f"import sys\n{script}\nfrom usdfoot.cli.main import main\nsys.exit(main(['doctor', '--json']))"
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    told = json.loads(done.stdout)
    assert told["healthy"] is (done.returncode == 0)
    return done.returncode, {symptom["name"]: symptom for symptom in told["symptoms"]}


def test_here_all_is_well(capsys):
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    version = ".".join(str(part) for part in Usd.GetVersion()[1:])
    for told in (__version__, sys.executable, version, "cpu", "plugin schemas", "plugin validators", "extra crowd"):
        assert told in re.sub(r"[\s│]+", "", out) or told in out
    assert "broken" not in out


def test_a_plugin_on_the_search_path_is_told_from_one_that_is_not(repository, tmp_path):
    code, symptoms = diagnose("", folder=tmp_path, repository=repository, plugins=f"{schema_folder()}{os.sep}")
    assert code == 0
    schemas, validators = symptoms["plugin schemas"], symptoms["plugin validators"]
    assert schemas["state"] == "ok" and "other programs find it" in schemas["told"] and schemas["remedy"] == ""
    assert validators["state"] == "ok" and "6 of 6" in validators["told"]
    assert "PXR_PLUGINPATH_NAME" in validators["remedy"]


@pytest.mark.parametrize(("module", "name"), [("scipy", "scipy"), ("pxr", "USD")])
def test_what_is_broken_is_named_with_a_remedy(module, name, repository, tmp_path):
    code, symptoms = diagnose(f"sys.modules[{module!r}] = None", folder=tmp_path, repository=repository)
    assert code == 1 and symptoms[name]["state"] == "broken"
    assert "pip install" in symptoms[name]["remedy"]
    assert symptoms["Python"]["state"] == "ok"


def test_the_remedy_for_an_extra_keeps_its_brackets(capsys):
    symptom = Symptom(name="extra crowd", state="absent", told="-", remedy="pip install 'usdfoot[crowd]'")
    results_console().print(symptom_table([symptom]))
    assert "pip install 'usdfoot[crowd]'" in capsys.readouterr().out


def test_what_is_needed_is_what_pyproject_says(repository):
    text = (repository / "pyproject.toml").read_text(encoding="utf-8")
    needed = text.split("\ndependencies = [")[1].split("\n]")[0]
    lowest = dict(re.findall(r'"([\w-]+)>=([\d.]+)"', needed))
    for module, version in NEEDED.items():
        assert lowest[DISTRIBUTIONS.get(module, module)] == ".".join(str(part) for part in version)
    assert lowest["usd-core"] == ".".join(str(part) for part in LOWEST_USD[1:])
    assert f'requires-python = ">={LOWEST_PYTHON[0]}.{LOWEST_PYTHON[1]}"' in text
    extras = text.split("[project.optional-dependencies]")[1].split("\n[")[0]
    bodies = re.findall(r"(\w+) = \[(.*?)\]", extras, re.S)
    listed = {name: set(re.findall(r'"([\w-]+)>=', body)) for name, body in bodies}
    listed.pop("dev")
    told = {name: {DISTRIBUTIONS.get(module, module) for module in modules} for name, (modules, _) in EXTRAS.items()}
    assert told == listed, "an extra the doctor does not know: add it to EXTRAS in usdfoot/pipeline/doctor.py"
