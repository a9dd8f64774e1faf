"""The command line from argument to exit code."""

import json
import logging
import runpy
import shutil
import subprocess
import sys

import pytest
from pxr import Sdf, Usd

from tests.few_clips import write_few_clips_scene
from usdfoot import __version__
from usdfoot.bridge.tokens import Clip
from usdfoot.cli.main import main


@pytest.fixture(scope="module")
def scene(stages, tmp_path_factory):
    return write_few_clips_scene(stages, tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def written(scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cli") / "out"
    assert main(["animate", str(scene), "-o", str(folder), "--quiet"]) == 0
    return folder


@pytest.mark.parametrize("verb", ["animate", "analyze", "import", "export", "validate"])
def test_every_verb_has_help_with_an_example_and_a_python_twin(verb, capsys):
    assert main([verb, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"usdfoot {verb}" in text and "example:" in text and "in Python:" in text and "exit codes:" in text


def test_version_and_usage(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"usdfoot {__version__}"
    assert main([]) == 2
    assert main(["dance"]) == 2
    assert main(["animate", "scene.usda"]) == 2
    assert "-o" in capsys.readouterr().err


def test_the_package_runs_as_a_module(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["usdfoot", "--version"])
    with pytest.raises(SystemExit) as stop:
        runpy.run_module("usdfoot", run_name="__main__")
    assert stop.value.code == 0 and capsys.readouterr().out.strip() == f"usdfoot {__version__}"


@pytest.mark.parametrize(
    ("verb", "flag", "text"), [("animate", "--frames", "-5:10"), ("plan wander", "--bounds", "-1,-1,1,1")]
)
def test_what_begins_with_a_minus_and_a_digit_is_a_value(verb, flag, text, tmp_path, capsys):
    arguments = [*verb.split(), str(tmp_path / "none.usda"), "-o", str(tmp_path / "out.usda")]
    assert main([*arguments, flag, text]) == 2
    assert "no such file" in capsys.readouterr().err


def test_options_that_a_job_hands_on_are_refused_as_its_own(scene, tmp_path, capsys):
    assert main(["job", str(scene), "-o", str(tmp_path / "out"), "--with=--chunk-size 0"]) == 2
    assert "--chunk-size: '0' is no number of things; give 1 or more" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["10", "a:b", "20:10", "1:2:3"])
def test_frames_must_be_a_range(text, tmp_path, capsys):
    assert main(["animate", "scene.usda", "-o", str(tmp_path), "--frames", text]) == 2
    assert f"{text!r} is not a range of frames; give first:last, like 1:240" in capsys.readouterr().err


def test_animate_prints_the_steps_on_stdout_and_talks_on_stderr(scene, tmp_path, capsys):
    cut = scene.with_name("cut.usda")
    shutil.copy(scene, cut)
    stage = Usd.Stage.Open(str(cut))
    clip = stage.OverridePrim("/World/Library/Motion/Clips/walk_130")
    clip.CreateAttribute(Clip.END, Sdf.ValueTypeNames.TimeCode, custom=False).Set(Sdf.TimeCode(2.0))
    stage.Save()
    arguments = ["animate", str(cut), "-o", str(tmp_path / "out"), "--frames", "0:40"]
    assert main([*arguments, "--no-correction", "--seam", "crossfade", "--agents", "Walk*"]) == 0
    out, err = capsys.readouterr()
    assert "Walker" in out and "placement mean mm" in out and f"wrote {tmp_path / 'out' / 'crowd.usd'}" in out
    assert "warning: " in err and "walk_130: no usable step" in err and "warning" not in out
    options = json.loads((tmp_path / "out" / "report.json").read_text())["options"]
    assert options["correction"] is False and options["seam"] == "crossfade"


def test_quiet_is_quiet(written, scene, capfd):
    assert main(["animate", str(scene), "-o", str(written), "-q", "--frames", "0:9"]) == 0
    assert capfd.readouterr().err == ""


def test_scenes_stay_open_only_in_processes_of_its_own(scene, tmp_path, monkeypatch):
    kept = []
    monkeypatch.setattr("usdfoot.readers.stage.keep_open", kept.append)
    arguments = ["animate", str(scene), "-o", str(tmp_path / "out"), "--quiet", "--frames", "0:9"]
    assert main(arguments) == 0 and not kept
    monkeypatch.setattr("usdfoot.cli.main.collect_seldom", lambda: None)
    monkeypatch.setattr("usdfoot.cli.main.collect_no_more", lambda: None)
    monkeypatch.setattr("sys.argv", ["usdfoot", *arguments])
    assert main() == 0 and len(kept) == 1


def test_workers_load_early_for_a_large_scene_of_which_nothing_is_made(scene, tmp_path, monkeypatch):
    early = []
    monkeypatch.setattr("usdfoot.batch.executors.load_early", early.append)
    arguments = ["animate", str(scene), "-o", str(tmp_path / "out"), "--quiet", "--workers", "2"]
    assert main(arguments) == 0 and not early  # its file is small
    monkeypatch.setattr("usdfoot.cli.animate.LARGE_FILE", 10)
    assert main(arguments) == 0 and not early  # there is a crowd
    shutil.rmtree(tmp_path / "out")
    assert main(arguments) == 0 and len(early) == 1


def test_validate_prints_a_table_or_json(scene, tmp_path, capsys):
    assert main(["animate", str(scene), "-o", str(tmp_path), "--quiet"]) == 0
    capsys.readouterr()
    code = main(["validate", str(tmp_path / "crowd.usd")])
    out = capsys.readouterr().out
    assert "placement mean" in out and "Walker" in out and ("NOT passed" in out) == (code == 1)
    assert main(["validate", str(tmp_path / "crowd.usd"), "--json"]) == code
    figures = json.loads(capsys.readouterr().out)
    assert figures["passed"] is (code == 0)
    assert figures["agents"]["Walker"]["figures"]["slide"]["target"] == 1.0
    assert all(figure["passed"] for figure in figures["total"]["figures"].values()) is figures["passed"]


def test_a_figure_over_its_target_is_exit_code_1(written, capsys):
    (written / "report.json").write_text(
        json.dumps({"agents": [{"name": "Walker", "source": {"kneeSpeedP99": 0.01, "jointJerkP99": 0.01}}]})
    )
    assert main(["validate", str(written / "crowd.usd")]) == 1
    out = capsys.readouterr().out
    assert "OVER" in out and "NOT passed" in out


def test_errors_are_one_line_and_exit_code_2(tmp_path, stages, capsys):
    assert main(["animate", str(tmp_path / "none.usda"), "-o", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert "none.usda: no such file" in err and "Traceback" not in err
    assert main(["animate", str(tmp_path / "none.usda"), "-o", str(tmp_path), "--verbose"]) == 2
    assert "Traceback" in capsys.readouterr().err
    assert main(["validate", str(stages / "terrain_flat.usda")]) == 2
    assert main(["analyze", str(tmp_path / "none.usda")]) == 2


@pytest.mark.parametrize("verb", ["animate", "job"])
def test_no_folder_is_not_the_current_one(verb, scene, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([verb, str(scene), "-o", ""]) == 2
    assert "output: no folder is named. name one; . is the current folder" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_output_that_usd_could_not_open_is_refused_and_nothing_written(tmp_path, capsys, stages):
    output = tmp_path / "take:SDF_FORMAT_ARGS:2.usda"
    assert main(["animate", str(stages / "stepping_stones.usda"), "-o", str(output)]) == 2
    assert f"{output}: holds :SDF_FORMAT_ARGS:, where USD ends a file's name. name another" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_names_with_brackets_are_printed_and_found(written, tmp_path, capsys):
    folder = tmp_path / "take [b] [1]"
    shutil.copytree(written, folder)
    crowd = folder / "crowd.usd"
    assert main(["export", str(crowd), "-o", str(folder / "plans.csv"), "-q"]) == 0
    assert f"wrote {folder / 'plans.csv'}" in capsys.readouterr().out


def test_an_error_nobody_foresaw_is_no_exit_code_1(scene, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("usdfoot.pipeline.animate.animate", lambda *_, **__: {}["unforeseen"])
    assert main(["animate", str(scene), "-o", str(tmp_path)]) == 2
    assert "usdfoot itself failed, please report it (KeyError: 'unforeseen')" in capsys.readouterr().err


def test_analyze_prints_a_table(stages, tmp_path, capsys):
    code = main(["analyze", str(stages / "clips.usdc"), "-o", str(tmp_path / "events.usda")])
    out = capsys.readouterr().out
    assert code == 0 and "walk_110" in out and "step length m" in out and (tmp_path / "events.usda").is_file()


def test_logging_of_the_calling_program_is_left_as_it_was(tmp_path):
    package, scene = logging.getLogger("usdfoot"), logging.getLogger("usdfoot.readers.scene")
    before = (package.level, list(package.handlers), scene.level)
    assert main(["analyze", str(tmp_path / "missing.usd"), "--verbose"]) == 2
    assert (package.level, list(package.handlers), scene.level) == before


def test_root_weights_reach_the_results(scene, tmp_path, capsys):
    for arguments in (["--root-weight", "0.5"], ["--max-root-weight-within", "0.02"]):
        folder = tmp_path / arguments[0]
        assert main(["animate", str(scene), "-o", str(folder), *arguments, "--frames", "0:20", "-q"]) == 0
        steps = json.loads((folder / "report.json").read_text())["agents"][0]["steps"]
        if arguments[0] == "--root-weight":
            assert set(steps["rootWeight"][2:]) == {0.5} and "rootWeighted" in steps["status"]
            assert max(steps["beta"]) > 0.0
        else:
            assert 0.0 < max(steps["rootWeight"]) <= 1.0


@pytest.mark.parametrize(
    ("flag", "value", "message"),
    [
        ("--root-weight", "2", "'2' is no root weight; give a number between 0 and 1"),
        ("--root-weight", "much", "'much' is no root weight"),
        ("--max-root-weight-within", "-1", "'-1' is no distance; give metres, like 0.02"),
    ],
)
def test_root_weights_out_of_range_are_refused(flag, value, message, tmp_path, capsys):
    assert main(["animate", "scene.usda", "-o", str(tmp_path), f"{flag}={value}"]) == 2
    assert message in capsys.readouterr().err


def test_it_runs_with_stderr_closed(stages, tmp_path):
    """As `2>&-` of a shell leaves it: what would be said there is no result and no failure."""
    for code, file in ((0, stages / "clips.usdc"), (2, stages / "none.usda")):
        command = f'exec "{sys.executable}" -m usdfoot analyze "{file}" 2>&-'
        done = subprocess.run(["sh", "-c", command], stdout=subprocess.PIPE, text=True, check=False)
        assert done.returncode == code and ("walk" in done.stdout) == (code == 0) and "none" not in done.stdout
