"""The built wheel is complete: schemas ship, the entry point exists, the command starts without the source tree."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import usdfoot


def run(*command: str, folder: Path, installed: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command that sees the installed wheel and the interpreter's own packages, not the source tree."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    if installed is not None:
        environment["PYTHONPATH"] = str(installed)
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def wheel(repository, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-deps", "--wheel-dir", str(folder)]
    # The build backend of this environment, where it has one: no download, no second environment.
    has_backend = run(sys.executable, "-c", "import hatchling.build", folder=folder).returncode == 0
    built = run(*pip, *(["--no-build-isolation"] if has_backend else []), str(repository), folder=folder)
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("installed")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--no-deps", "--target", str(folder)]
    done = run(*pip, str(wheel), folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_the_wheel_holds_the_package_and_the_schemas_and_nothing_else(wheel, repository):
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    files = [path for path in (repository / "usdfoot").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    sources = {path.relative_to(repository).as_posix() for path in files}
    schemas = {f"usdfoot/schemas/{path.name}" for path in (repository / "schemas").iterdir()}
    assert sources | schemas | {"usdfoot/validators/plugInfo.json"} <= names
    assert {name.split("/")[0] for name in names} == {"usdfoot"}
    assert not [name for name in names if "__pycache__" in name]


def test_the_installed_package_registers_the_schemas_it_ships(installed, tmp_path):
    script = (
        "import usdfoot; from usdfoot.bridge import schema; from pxr import Usd; print(usdfoot.__file__);"
        "print(schema.schema_folder());"
        "print(bool(Usd.SchemaRegistry().FindAppliedAPIPrimDefinition('UsdfootPlanAPI')))"
    )
    done = run(sys.executable, "-c", script, folder=tmp_path, installed=installed)
    assert done.returncode == 0, done.stderr
    package, schemas, registered = done.stdout.splitlines()
    assert Path(package).resolve().is_relative_to(installed.resolve())
    assert Path(schemas).resolve() == (installed / "usdfoot" / "schemas").resolve()
    assert registered == "True"


def test_the_installed_command_starts(installed, tmp_path, repository):
    if not (repository / "usdfoot" / "cli" / "main.py").is_file():
        pytest.skip("usdfoot/cli/main.py is not there yet")
    done = run(sys.executable, "-m", "usdfoot.cli.main", "--version", folder=tmp_path, installed=installed)
    assert done.returncode == 0, done.stderr
    assert usdfoot.__version__ in done.stdout
    command = installed / "bin" / "usdfoot"
    usage = run(sys.executable, str(command), "--help", folder=tmp_path, installed=installed)
    assert usage.returncode == 0, usage.stderr
    for verb in ("animate", "analyze", "validate"):
        assert verb in usage.stdout
