"""Numbers that no option of a planner takes: each is refused with what would be right, before anything is read."""

from __future__ import annotations

import argparse

import pytest

from usdfoot.cli import quantities
from usdfoot.cli.main import main
from usdfoot.cli.plan import PLANNERS
from usdfoot.planning.crowd import CrowdOptions
from usdfoot.planning.path import PathOptions
from usdfoot.planning.retiming import TimingOptions
from usdfoot.planning.trajectories import TrajectoryOptions

VALUES = ("0", "-1", "nan", "inf", "1e300", "1e-300")
TAKEN = {
    ("path", "--stand-time"): {"1e-300"},
    ("trajectories", "--smoothing"): {"0", "1e-300"},
    ("wander", "--seed"): {"0"},
    ("scenario", "--seed"): {"0"},
    ("timing", "--start-time"): {"0", "-1", "1e-300"},
}
"""Those of the values that an option takes; nobody takes the others."""


def numeric_options() -> list[tuple[str, str]]:
    """Every option of every planner that is read by one of the quantities."""
    found = []
    for planner in PLANNERS:
        parser = argparse.ArgumentParser()
        planner.add_arguments(parser)
        for action in parser._actions:
            if getattr(action.type, "__module__", "") == quantities.__name__:
                found.append((planner.NAME, action.option_strings[-1]))
    return found


def test_there_are_options_with_numbers():
    assert {("wander", "--radius"), ("stones", "--spacing"), *TAKEN} <= set(numeric_options())


@pytest.mark.parametrize(("planner", "option"), numeric_options())
@pytest.mark.parametrize("value", VALUES)
def test_numbers_that_make_no_sense_are_refused_and_others_are_not(planner, option, value, tmp_path, capsys):
    source = tmp_path / (
        "none.txt" if planner == "trajectories" else "none.xml" if planner == "scenario" else "none.usd"
    )
    output = [] if planner == "lint" else ["-o", str(tmp_path / "plans.usda")]
    assert main(["plan", planner, str(source), *output, f"{option}={value}"]) == 2
    said = capsys.readouterr().err
    assert "usdfoot itself failed" not in said and "Warning" not in said
    taken = value in TAKEN.get((planner, option), ())
    assert (str(source) in said) == taken, said
    assert taken or option[2:].replace("-", "_") in said.replace("-", "_")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["wander", "--radius", "1e-6"], "radius: is 1e-06 m. must be 0.001 to 1000 m"),
        (["wander", "--steps", "1000000000"], "steps: is 1e+09 footsteps. must be 2 to 100000 footsteps"),
        (["wander", "--bounds=-1e12,-1,1e12,1"], "bounds: is -1e+12 m. must be -1e+09 to 1e+09 m"),
        (["crowd", "--duration", "0.01"], "duration: is 0.01 s. must be 1 to 1e+10 s"),
        (["timing", "--speed", "1e9"], "speed: is 1e+09 m/s. must be 0.001 to 1000 m/s"),
    ],
)
def test_what_nobody_is_or_does_is_refused(arguments, message, tmp_path, capsys):
    way, *rest = arguments
    assert main(["plan", way, str(tmp_path / "none.usda"), "-o", str(tmp_path / "plans.usda"), *rest]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("bounds", ["-1e9,-1e9,1e9,1e9", "-1e-300,-1e-300,1e-300,1e-300"])
def test_bounds_far_too_wide_or_narrow_are_told(stages, bounds, tmp_path, capsys):
    arguments = ["plan", "wander", str(stages / "plaza.usda"), "-o", str(tmp_path / "plans.usda"), f"--bounds={bounds}"]
    assert main([*arguments, "--agents", "Visitor_00", "--steps", "4"]) == 2
    said = capsys.readouterr().err
    assert "too large for a route" in said or "out of bounds" in said


@pytest.mark.parametrize(
    ("options", "given"),
    [
        (CrowdOptions, {"duration": 0.0}),
        (PathOptions, {"stand_time": float("nan")}),
        (TimingOptions, {"speed": -1.0}),
        (TimingOptions, {"start_time": float("inf")}),
        (TrajectoryOptions, {"smoothing_time": 1e9}),
    ],
)
def test_in_python_they_are_refused_alike(options, given):
    with pytest.raises(ValueError, match=next(iter(given))):
        options(**given)
