"""Bench: its rigs and plans are what they claim, and its figures add up."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import build_walker
from tests.few_clips import copy_stages
from usdfoot.analysis import gaits
from usdfoot.model.skeleton import forward_kinematics


@pytest.fixture(scope="module")
def tools(repository):
    """The tools' folder on the path, as when one of them is run; the processor's threads as they were afterwards."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(repository / "tools"))
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
            patch.setenv(name, "1")
        yield


@pytest.mark.parametrize("count", [14, 16, 40])
def test_rigs_have_the_joints_asked_for_and_the_same_legs(tools, count):
    from benching.rigs import with_joints

    library = build_walker(footsteps=5).library
    resized = with_joints(library, count)
    assert len(resized.skeleton.joints) == len(set(resized.skeleton.joints)) == count
    legs = []
    for each in (library, resized):
        clip, biped = each.clips[0], each.biped
        positions, _ = forward_kinematics(each.skeleton.parents, clip.translations, clip.rotations)
        legs.append(positions[:, [biped.pelvis, *biped.hips, *biped.knees, *biped.ankles, *biped.balls]])
    assert_allclose(legs[1], legs[0], atol=1e-12)


def test_plans_last_as_long_as_asked(tools):
    from benching.rigs import straight_plan

    for number in range(8):
        plan = straight_plan(number, 8.0)
        assert 7.0 < plan.liftoff_times.max() <= 8.0 + 1e-9
        assert len(plan) > 8


def test_figures_of_a_small_crowd(tools):
    from benching.kernels import frame_times

    library = build_walker(footsteps=8, rate=60.0).library
    figures = frame_times(library, 20, agents=2, frames=60)
    assert set(figures) == {"warp, blend, place", "plant", "frame"}
    assert all(value > 0.0 for value in figures.values())


def test_figures_of_a_small_crowd_in_real_time(tools):
    from benching.realtime import realtime_times

    library = build_walker(footsteps=8, rate=60.0).library
    figures = realtime_times(library, 20, agents=3, seconds=3.0)
    assert figures["frame [ms]"] <= figures["longest frame [ms]"]
    assert figures["agents at 25 frames a second"] == pytest.approx(40e3 / figures["agent-frame [us]"])


def test_physics_figures(tools, monkeypatch):
    import benching.physics

    from tests.physics.builders import human

    monkeypatch.setattr(benching.physics, "STEPS", (4, 6))
    monkeypatch.setattr(benching.physics, "AGENTS", 2)
    figures = benching.physics.physics_times(human())
    assert set(figures) == {"4 steps", "6 steps", "2 agents, 4 steps, each", "4 steps, greedy", "one footstep more"}
    assert all(value > 0.0 for value in figures.values())


def test_plan_figures(tools):
    from benching.plans import plan_times

    figures = plan_times(together=2, repeats=1)
    assert {"path, stairs", "wander, level", "wander, to one goal", "trajectories"} <= set(figures)
    assert all(value > 0.0 for parts in figures.values() for value in parts.values())


def test_the_stopwatch_sees_named_functions(tools):
    from benching.stopwatch import best_time, function_times

    def run() -> None:
        gaits.has_flight(np.zeros(20000), np.zeros(20000), np.zeros((20000, 2)))

    untimed = gaits.has_flight
    assert 0.0 < function_times(run, ("has_flight",))["has_flight"] < 1.0
    assert gaits.has_flight is untimed
    assert best_time(run) > 0.0
    with pytest.raises(KeyError):
        function_times(run, ("play",))


def test_the_table_shows_targets(tools):
    from bench import table

    text = table({"frame, 65 joints [us]": {"frame": 3.2}, "step [us]": {"seams": 9.0}})
    assert "3.200  <= 4 at 65 joints" in text
    assert "9.000" in text


def test_growth_is_the_slope_of_durations_over_agents(tools):
    from benching.crowd import growth_exponent

    figures = {agents: {"whole [s]": 0.02 * agents**1.5} for agents in (10, 100, 1000)}
    assert growth_exponent(figures, "whole [s]") == pytest.approx(1.5)


def test_crowds_are_measured_and_reported(tools, stages, tmp_path):
    import bench
    from benching.crowd import crowd_times, draw_growth

    row = crowd_times(copy_stages(stages, tmp_path), agents=1, frames=60)
    assert min(row.values()) > 0.0 and row["ratio"] == row["one process [s]"] / row["author alone [s]"]
    assert row["end to end [agent-frames/s]"] == pytest.approx(60 / row["one process [s]"])
    figures = {1: row, 10: {name: 10.0 * value for name, value in row.items()}}
    draw_growth(figures, ["one process [s]"], tmp_path / "growth.png")
    assert (tmp_path / "growth.png").stat().st_size > 1000
    report = bench.crowd_report(figures, frames=60)
    assert "| memory [MB] |" in report and "- one process [s]: 1.00" in report
