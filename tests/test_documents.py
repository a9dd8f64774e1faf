"""README and GUIDE are copy and paste: their commands and their Python run, in a folder with the files they name."""

import io
import re
import shlex
import shutil
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from tests.few_clips import KEPT, copy_stages
from tests.importers.motion_files import random_bvh
from tests.importers.test_steersuite import PLACE, SEEK, agent, case
from tests.pipeline.test_plan import scene_with_path
from usdfoot.cli.main import build_parser, main

REPOSITORY = Path(__file__).resolve().parents[1]
DOCUMENTS = ("README.md", "GUIDE.md")
NOT_HERE = {"city.usd"}
"""Files of a reader's own whose commands are parsed only: crowds for farms."""
PLAN = """foot,x,y,z,yaw,strike,liftoff
left,0.1,0,0,0,0,0.6
right,-0.1,0,0.5,0,0.5,1.1
left,0.1,0,1,0,1,1.6
"""
DROPPED = ("--workers", "--scheduler")


def blocks(language):
    """Code blocks of the documents, in order."""
    text = "".join((REPOSITORY / name).read_text(encoding="utf-8") for name in DOCUMENTS)
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.S | re.M)


def commands():
    """Arguments of every usdfoot command in the documents' shell blocks, those within $( ) too."""
    for line in "\n".join(blocks("sh")).splitlines():
        words = shlex.split(line, comments=True)
        ends = [place for place, word in enumerate(words) if word in (">", "|", "&&")]
        if words[:1] == ["usdfoot"]:
            yield words[1 : min(ends, default=len(words))]
        yield from (shlex.split(inner) for inner in re.findall(r"\$\(usdfoot ([^)]*)\)", line))


@pytest.fixture(scope="module")
def workplace(stages, tmp_path_factory):
    """A folder with stages/, of whose clips few are kept, and the files the documents name."""
    folder = tmp_path_factory.mktemp("readme")
    copy_stages(stages, folder, kept={*KEPT, "run_250", "run_300"})
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


def test_python_runs_and_does_what_it_says(ran, workplace, capsys, monkeypatch):
    monkeypatch.chdir(workplace)
    scope = {}
    for text in blocks("python"):
        exec(compile(text, "document", "exec"), scope)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Walker ") and "'ok'" in lines[0]
    pose = scope["pose"]  # of the example of real time: one agent steered ahead, one on footsteps that end
    assert pose.root_positions[0, 2] > 1.5
    assert_allclose(pose.root_positions[1, [0, 2]], [2.0, 0.65], atol=0.01)
    assert pose.translations.shape == (2, 24, 3)
    assert_allclose(np.linalg.norm(pose.rotations, axis=-1), 1.0, atol=1e-5)
    assert pose.halted.tolist() == [False, True]
