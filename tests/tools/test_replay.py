"""Replay: what it takes from a clip, what it leaves out, what it prints."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait, build_walker
from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError


@pytest.fixture(scope="module")
def tools(repository):
    """The tools' folder on the path, as when one of them is run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(repository / "tools"))
        yield


@pytest.fixture(scope="module")
def library() -> PreparedLibrary:
    gaits = [Gait(step_length=length, step_width=width) for length in (0.4, 0.5, 0.6) for width in (0.12, 0.22)]
    walkers = [build_walker(gait, footsteps=8, rate=60.0) for gait in gaits]
    clips = tuple(replace(walker.clip, name=f"/Clips/walk_{index}") for index, walker in enumerate(walkers))
    return prepare_library(replace(walkers[0].library, clips=clips), EngineOptions())


def test_a_take_has_the_clips_footsteps(tools, library):
    from replaying.takes import read_take

    truth = build_walker(Gait(step_length=0.4, step_width=0.12), footsteps=8, rate=60.0).contacts
    take = read_take(library.source, 0, whole=True)
    strikes = np.sort(np.concatenate([truth.left.strike_times, truth.right.strike_times]))
    nearest = np.abs(take.plan.strike_times[:, None] - strikes[np.isfinite(strikes)]).min(axis=1)
    assert len(take.plan) >= 5
    assert nearest.max() < 1.5 / 60.0
    assert_allclose(np.diff(take.plan.positions[:, 2]), 0.4, atol=0.01)


def test_the_range_and_a_stride_on_either_side_are_replayed(tools, library):
    from replaying.takes import read_take

    clip = replace(library.source.clips[0], range_start=1.5, range_end=2.5)
    short = read_take(replace(library.source, clips=(clip,)), 0, whole=False)
    whole = read_take(replace(library.source, clips=(clip,)), 0, whole=True)
    assert len(short.plan) < len(whole.plan)
    assert short.plan.strike_times[0] > 1.5 - 1.1
    assert short.plan.strike_times[-1] < 2.5 + 1.1


def test_a_clip_is_left_out_with_its_mirror_images(tools, library):
    from replaying.leave_out import with_clips

    others = with_clips(library, np.array([0, 2, 3, 4, 5]), style="default")
    assert set(others.examples.clip_indices[:-1]) == {0, 2, 3, 4, 5}
    assert len(others.examples) == np.sum(library.examples.clip_indices[:-1] != 1) + 1
    assert_allclose(others.examples.rotations[-1], library.examples.rotations[-1])


def test_a_clip_replayed_from_itself_is_nearly_itself(tools, library):
    from replaying.leave_out import replay_takes, with_clips
    from replaying.takes import read_take

    take = read_take(library.source, 2, whole=True)
    errors = replay_takes(with_clips(library, np.array([2]), style="default"), [take], EngineOptions())[0]
    assert errors.world < 0.02
    assert errors.pelvis_legs < 0.02


def test_hybrids_are_replayed_on_their_own_pelvis(tools, library):
    from replaying.leave_out import replay_takes, with_clips
    from replaying.takes import read_take

    take = read_take(library.source, 2, whole=True)
    others = with_clips(library, np.array([0, 1, 3, 4, 5]), style="default")
    clips, hybrid = (replay_takes(others, [take], EngineOptions(), hybrid=carried)[0] for carried in (False, True))
    assert hybrid.pelvis_alone == pytest.approx(clips.pelvis_alone, abs=0.05)
    assert abs(hybrid.pelvis_alone - clips.pelvis_alone) > 1e-3
    assert hybrid.outside == clips.outside


def test_a_clip_between_others_is_replayed_from_them(tools, library):
    from replay import Setting, replay_library
    from replaying.outcomes import replay_table

    replays = replay_library(
        library.source,
        Setting(options=EngineOptions(), whole=True, only="walk_2", gap=0.2),
        kinds={"/Clips/walk_2": "walk"},
    )
    assert [replay.clip for replay in replays] == ["walk_2"]
    values = asdict(replays[0])
    assert 0.0 < values["blended"]["pelvis_legs"] < 0.04
    assert 0.0 < values["filled"]["pelvis_legs"] < 0.04
    assert values["own"]["world"] < values["nearest"]["world"]
    assert all(values["best"][name] <= values["nearest"][name] + 1e-12 for name in values["best"])
    text = replay_table(replays)
    assert "walk (1), mean" in text and "filled" in text
    assert "all (1), median" in text


def test_options_are_set_by_name(tools):
    from replay import options_of

    options = options_of(["correction=false", "seam=crossfade", "seam_time=0.1", "corrections=2"])
    assert options == EngineOptions(correction=False, seam="crossfade", seam_time=0.1, corrections=2)
    with pytest.raises(UsdfootError, match="is no option of the engine"):
        options_of(["colour=red"])


def test_json_of_real_clips(tools, shared_data, capsys):
    from replay import main

    assert main([str(shared_data / "pab" / "pab_walk.usdc"), "--json"]) in (0, 2)
    assert isinstance(json.loads(capsys.readouterr().out), list)


@pytest.mark.parametrize(
    ("clips", "takes", "centred"),
    [("cmu/cmu_clips.usdc", "*02_0[12]", 0.03), ("bandai/bandai_clips.usdc", "*_walk_*", 0.035)],
    ids=["cmu", "bandai"],
)
def test_physics_walks_where_people_walked_on_average(tools, shared_data, capsys, clips, takes, centred):
    from replay import main

    assert main([str(shared_data / clips), "--motion", "physics", "--clips", takes, "--json"]) == 0
    replays = json.loads(capsys.readouterr().out)
    assert len(replays) >= 2
    kinds = {replay["kind"] for replay in replays}
    for kind in kinds:
        mean = {
            name: np.mean([replay[name] for replay in replays if replay["kind"] == kind])
            for name in ("rms_centred", "rise", "real_rise")
        }
        assert mean["rms_centred"] < centred
        assert mean["rise"] == pytest.approx(mean["real_rise"], rel=0.25)


def test_physics_walks_where_people_walked(tools, shared_data, capsys):
    from replay import main

    clips = str(shared_data / "cmu" / "cmu_clips.usdc")
    assert main([clips, "--motion", "physics", "--clips", "*02_0[12]", "--json"]) == 0
    replays = json.loads(capsys.readouterr().out)
    assert len(replays) == 2
    for replay in replays:
        assert replay["rms"] < 0.04
        assert replay["rms_centred"] < 0.035
        assert abs(replay["rise"] / replay["real_rise"] - 1.0) < 0.25
        assert 0.75 < replay["sway"] / replay["real_sway"] < 1.4
        assert abs(replay["lag"]) < 0.1


def test_pelvis_errors_of_the_walker_itself(tools, library):
    from replaying.pelvis import pelvis_table, replay_pelvises
    from replaying.takes import read_take

    take = read_take(library.source, 2, whole=True)
    errors = replay_pelvises(library.source, [take])[0]
    parts = np.array([errors.vertical, errors.lateral, errors.forward])
    assert_allclose(np.linalg.norm(parts), errors.rms)
    assert errors.rms_centred <= errors.rms
    assert errors.real_rise == pytest.approx(0.0, abs=1e-9)  # its pelvis keeps its height
    assert errors.rise > 0.0
    assert "all (1), mean" in pelvis_table(["walk"], ["walk"], [errors])
