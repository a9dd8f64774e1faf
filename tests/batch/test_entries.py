"""Entries of the report: JSON, of which the figures are read back as they were to seven digits."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from usdfoot.batch.entries import EntryResults, entry_of, read_totals, totals_json
from usdfoot.model.motion import ForceResults, StepResults
from usdfoot.model.totals import add_totals, sum_results

COLUMNS = ("blend_error", "placement_error", "slide", "yaw_error", "hull_distance", "root_velocity_error")
COLUMNS += ("time_warp", "root_weight", "beta")


def results_of(seed, *, forces=False):
    rng = np.random.default_rng(seed)
    columns = {name: rng.normal(size=4) * 10.0 ** rng.integers(-9, 9) for name in COLUMNS}
    columns["placement_error"][1:3] = np.nan, np.inf
    return StepResults(
        **columns,
        status=("ok", "ok", "outsideHull", "offTerrain"),
        clip_counts=np.array([0, 2, 1, 0]),
        clips=('/Clips/"Walk"', "/Clips/Läufer", "/Clips/Walk"),
        clip_weights=np.array([0.25, 0.75, 1.0]),
        forces=ForceResults(force_imbalance=rng.normal(size=4), clamp_time=np.zeros(4), jump_height=np.ones(4))
        if forces
        else None,
    )


def entry(name, results):
    agent = SimpleNamespace(source=f"/World/{name}", plan=SimpleNamespace(name=f"/World/Plans/{name}"))
    motion = SimpleNamespace(name=name, results=results)
    return entry_of(agent, motion, source={"kneeSpeedP99": 0.1}, trajectory=None)


@pytest.mark.parametrize("forces", [False, True])
def test_figures_are_read_as_they_were(forces):
    results = results_of(3, forces=forces)
    made = entry("A", results)
    told = json.loads(made.text)
    assert [*told] == sorted(told) and [*told["steps"]] == sorted(told["steps"])
    assert told["prim"] == "/World/A" and told["source"] == {"kneeSpeedP99": 0.1} and told["trajectory"] is None
    assert told["steps"]["placementError"][1:3] == [None, None]
    assert told["steps"]["clips"][1] == {'/Clips/"Walk"': 0.25, "/Clips/Läufer": 0.75}
    read = EntryResults([made])["A"]
    assert (read.status, read.clips) == (results.status, results.clips)
    np.testing.assert_array_equal(read.clip_counts, results.clip_counts)
    np.testing.assert_array_equal(read.clip_weights, results.clip_weights)
    for name in COLUMNS:
        given = getattr(results, name)
        np.testing.assert_allclose(getattr(read, name), np.where(np.isfinite(given), given, np.nan), rtol=1e-6)
    assert (read.forces is not None) == forces
    if results.forces and read.forces:
        np.testing.assert_allclose(read.forces.force_imbalance, results.forces.force_imbalance, rtol=1e-6)


def test_totals_are_those_of_the_entries():
    entries = [entry(name, results_of(seed)) for seed, name in enumerate("ABC")]
    results = EntryResults(entries)
    assert list(results) == ["A", "B", "C"] and len(results) == 3
    told = read_totals(json.loads(json.dumps(totals_json(entries))))
    expected = add_totals(map(sum_results, results.values()))
    assert (told.steps, told.promised) == (12, 9) == (expected.steps, expected.promised)
    for name, figure in expected.figures.items():
        assert told.figures[name] == pytest.approx(figure, rel=1e-12)
