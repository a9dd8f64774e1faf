"""README is copy and paste: its commands and its Python run, in a folder with the files they name."""

import io
import re
import shlex
import shutil
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Sdf, Usd

from tests.few_clips import KEPT
from tests.importers.motion_files import random_bvh
from tests.importers.test_steersuite import PLACE, SEEK, agent, case
from tests.pipeline.test_plan import scene_with_path
from usdfoot.cli.main import build_parser, main

README = Path(__file__).resolve().parents[1] / "README.md"
NOT_HERE = {"city.usd"}
"""Files of a reader's own whose commands are parsed only: crowds for farms."""
PLAN = """foot,x,y,z,yaw,strike,liftoff
left,0.1,0,0,0,0,0.6
right,-0.1,0,0.5,0,0.5,1.1
left,0.1,0,1,0,1,1.6
"""
DROPPED = ("--workers", "--scheduler")


def blocks(language):
    """Code blocks of README, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text(encoding="utf-8"), re.S | re.M)


def commands():
    """Arguments of every usdfoot command in README's shell blocks, those within $( ) too."""
    for line in "\n".join(blocks("sh")).splitlines():
        words = shlex.split(line, comments=True)
        ends = [place for place, word in enumerate(words) if word in (">", "|", "&&")]
        if words[:1] == ["usdfoot"]:
            yield words[1 : min(ends, default=len(words))]
        yield from (shlex.split(inner) for inner in re.findall(r"\$\(usdfoot ([^)]*)\)", line))


@pytest.fixture(scope="module")
def workplace(stages, tmp_path_factory):
    """A folder with stages/, of whose clips few are kept, and the files README names."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(stages, folder / "stages", ignore=shutil.ignore_patterns("*.png"))
    layer = Sdf.Layer.FindOrOpen(str(folder / "stages" / "clips.usdc"))
    stage = Usd.Stage.Open(layer)
    for prim in stage.GetPrimAtPath("/HumanClips/Clips").GetChildren():
        prim.SetActive(prim.GetName() in {*KEPT, "run_250", "run_300"})
    layer.Save()
    shutil.copy(folder / "stages" / "human.usdc", folder / "hero.usdc")
    (folder / "plan.csv").write_text(PLAN)
    Image.fromarray(np.arange(64, dtype=np.uint8).reshape(8, 8)).save(folder / "hills.png")
    scene_with_path(folder / "street.usda")
    (folder / "tracks.txt").write_text("".join(f"7 {frame} {0.04 * frame} 1.0\n" for frame in range(100)))
    case(folder, agent(SEEK.format(PLACE.format(5, 6))))
    generator = np.random.default_rng(1)
    skeleton, walk = random_bvh(generator).split("MOTION")
    (folder / "walk.bvh").write_text(f"{skeleton}MOTION{walk}", newline="")
    (folder / "run.bvh").write_text(f"{skeleton}MOTION{walk}", newline="")
    return folder


def test_every_command_parses():
    found = list(commands())
    assert len(found) > 15
    for words in found:
        build_parser().parse_args(words)


def runnable(words):
    if words[:2] == ["plan", "crowd"] and find_spec("jupedsim") is None:
        return False  # an extra of more than 1 GB
    return not NOT_HERE & set(words) and not any(word in DROPPED for word in words)


@pytest.fixture(scope="module")
def ran(workplace):
    """Arguments, exit code and complaints of every command that can be run, in order."""
    results = []
    for words in filter(runnable, commands()):
        out, err = io.StringIO(), io.StringIO()
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
            patch.chdir(workplace)
            results.append((words, main(words), err.getvalue()))
    return results


def test_every_command_runs(ran):
    failed = [(words, code, err) for words, code, err in ran if code == 2]
    assert failed == [] and len(ran) > 12


def test_python_runs_and_prints_what_it_says(ran, workplace, capsys, monkeypatch):
    monkeypatch.chdir(workplace)
    for text in blocks("python"):
        exec(compile(text, str(README), "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Walker ") and "'ok'" in lines[0]


def test_links_of_readme_lead_somewhere():
    targets = re.findall(r"\]\((?!https?:)([^)#]+)\)", README.read_text(encoding="utf-8"))
    assert targets and all((README.parent / target).exists() for target in targets)
