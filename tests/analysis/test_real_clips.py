"""Analysis on real clips: labels by others, the lead's measurements, every rig's mirror image."""

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Usd

from tests.analysis.worlds import detect_contacts
from tests.images import mirrored_clip
from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.mirror import mirror_map
from usdfoot.analysis.summary import summarise
from usdfoot.analysis.world import world_clip
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.libraries import read_libraries

RIGS = (
    "bandai/bandai_clips.usdc",
    "cmu/cmu_clips.usdc",
    "pfnn/LocomotionFlat04_000.usdc",
    "pab/pab_walk.usdc",
    "pab/pab_jog.usdc",
    "knight/knight_Walking_A.usdc",
    "knight/knight_Running_Strafe_Right.usdc",
)
SEVERAL_STRIKES_OFF = {"cmu_02_04", "cmu_01_01"}
"""Jumps with both feet, where it is a matter of taste what counts as a strike."""


def finite(times: FloatArray) -> FloatArray:
    return times[np.isfinite(times)]


@pytest.fixture(scope="module")
def bandai(shared_data: Path) -> ClipLibrary:
    return read_libraries(shared_data / "bandai" / "bandai_clips.usdc").libraries[0]


def test_strikes_agree_with_the_labels_of_pfnn(shared_data: Path) -> None:
    library = read_libraries(shared_data / "pfnn" / "LocomotionFlat04_000.usdc").libraries[0]
    contacts = detect_contacts(library.clips[0], library.skeleton, library.biped)
    text = (shared_data / "pfnn" / "LocomotionFlat04_000_footsteps.txt").read_text()
    rows = [[int(word) for word in line.split()] for line in text.splitlines() if line.strip()]
    labels = {1: [row[0] for row in rows], 0: [row[1] for row in rows if len(row) > 1]}
    delays, found, strikes = [], 0, 0
    for side in range(2):
        times, marks = finite(contacts[side].strike_times), np.array(labels[side]) / 120.0
        # A label belongs to the strike it is nearest to, if it is also the nearest label of that strike.
        across = marks[:, None] - times - 0.04
        nearest = np.argmin(np.abs(across), axis=1)
        mutual = np.argmin(np.abs(across), axis=0)[nearest] == np.arange(len(marks))
        delays.append((marks - times[nearest])[mutual])
        found, strikes = found + int(mutual.sum()), strikes + len(times)
    delay = np.concatenate(delays)
    spread = np.abs(delay - np.median(delay))
    close = int((spread < 0.3).sum())
    assert close >= 0.95 * sum(map(len, labels.values()))
    assert close >= 0.95 * strikes
    assert np.median(spread) <= 0.04


def test_contacts_agree_with_the_plan_of_walk_flat(shared_data: Path, bandai: ClipLibrary) -> None:
    stage = Usd.Stage.Open(str(shared_data / "scenes" / "walk_flat.usda"))
    plan = stage.GetPrimAtPath("/World/Plans/Walker")
    strikes, liftoffs = (
        np.array([float(code) for code in plan.GetAttribute(f"usdfoot:plan:{name}Times").Get()]) / 30.0
        for name in ("strike", "liftoff")
    )
    places = 0.01 * np.array(plan.GetAttribute("positions").Get())
    clip = next(clip for clip in bandai.clips if clip.name.endswith("dataset_1_walk_normal_001"))
    contacts = detect_contacts(clip, bandai.skeleton, bandai.biped)
    for side in range(2):
        foot = contacts[side]
        begun = np.isfinite(foot.strike_times)
        assert begun.sum() == len(strikes[side::2])
        assert_allclose(foot.strike_times[begun], strikes[side::2], atol=1.5 / 30.0)
        assert np.median(np.abs(foot.strike_times[begun] - strikes[side::2])) <= 1.0 / 30.0
        ended = begun & np.isfinite(foot.liftoff_times)
        assert_allclose(foot.liftoff_times[ended], liftoffs[side::2][: ended.sum()], atol=1.0 / 30.0)
        assert_allclose(foot.positions[begun][:, [0, 2]], places[side::2][:, [0, 2]], atol=0.02)


@pytest.mark.parametrize("source", ["bandai", "cmu"])
def test_strikes_and_speeds_of_the_takes(shared_data: Path, source: str) -> None:
    with (shared_data / source / "takes.csv").open() as lines:
        takes = {row["take"]: row for row in csv.DictReader(lines)}
    for library in read_libraries(shared_data / source / f"{source}_clips.usdc").libraries:
        for summary in summarise(library):
            take = takes[summary.name.rsplit("/", 1)[-1]]
            assert summary.contacts is not None
            count = sum(len(finite(summary.contacts[side].strike_times)) for side in range(2))
            slack = 2 if take["take"] in SEVERAL_STRIKES_OFF else 1
            assert abs(count - int(take["strikes"])) <= slack, take["take"]
            if take["style"] in ("walk", "back", "diagonal", "turn", "run"):
                forward, left = float(take["forward_m_s"]), float(take["left_m_s"])
                assert summary.speed == pytest.approx(np.hypot(forward, left), abs=0.1), take["take"]
                off = planar.wrap_angle(np.array(summary.direction - np.arctan2(left, forward)))
                assert abs(off) < 0.45, take["take"]  # facing by the feet here, by the pelvis there
                # Backward the heel leaves after the ball, which is no part of the contact: a walk goes down to 0.4.
                assert summary.duty_factor < 0.37 if take["style"] == "run" else summary.duty_factor > 0.37


def test_every_bandai_clip_gives_steps(bandai: ClipLibrary) -> None:
    examples, problems = build_examples(bandai)
    counts = np.bincount(examples.clip_indices[~examples.mirrored], minlength=len(bandai.clips))
    assert (counts >= 2).all(), [bandai.clips[i].name for i in np.flatnonzero(counts < 2)]
    assert all(problem.severity == "warning" for problem in problems)
    assert np.isfinite(examples.support_liftoffs).all()
    # The two examples of a stride of straight walking are left and right.
    assert abs(int(examples.swing_sides.sum()) * 2 - len(examples)) <= 2
    assert_allclose(np.abs(examples.support_balls[:, 25:35, [0, 2]][examples.support_liftoffs > 0.4]), 0.0, atol=0.02)


@pytest.mark.parametrize("file", RIGS)
def test_mirror_image_of_every_rig(shared_data: Path, file: str) -> None:
    reflection = np.array([-1.0, 1.0, 1.0])
    for library in read_libraries(shared_data / file).libraries:
        skeleton = library.skeleton
        mirror = mirror_map(skeleton, library.biped)
        assert (mirror.partners[mirror.partners] == np.arange(len(skeleton.joints))).all()
        for clip in library.clips[:3]:
            before, _ = forward_kinematics(skeleton.parents, clip.translations, clip.rotations)
            image = mirrored_clip(clip, mirror)
            after, _ = forward_kinematics(skeleton.parents, image.translations, image.rotations)
            assert_allclose(after, before[:, mirror.partners] * reflection, atol=1e-5)
            twice = mirrored_clip(image, mirror)
            again, _ = forward_kinematics(skeleton.parents, twice.translations, twice.rotations)
            assert_allclose(again, before, atol=1e-6)


@pytest.mark.parametrize("file", RIGS[3:])
def test_exact_cycles_are_loops(shared_data: Path, file: str) -> None:
    library = read_libraries(shared_data / file).libraries[0]
    world = world_clip(library.clips[0], library.skeleton, library.biped)
    assert world.period is not None
    assert world.root_motion.in_place == ("knight" in file)
    contacts = detect_contacts(library.clips[0], library.skeleton, library.biped)
    assert [len(contacts[side].strike_times) for side in range(2)] == [1, 1]


@pytest.mark.parametrize(("file", "speed"), [("pab/pab_walk.usdc", 1.07), ("pab/pab_jog.usdc", 3.1)])
def test_speed_of_exact_cycles(shared_data: Path, file: str, speed: float) -> None:
    (summary,) = summarise(read_libraries(shared_data / file).libraries[0])
    assert summary.speed == pytest.approx(speed, abs=0.05)
    assert summary.steps == 2


def test_contacts_of_our_own_clips_agree_with_their_truth(stages: Path) -> None:
    file = stages / "clips.usdc"
    if not file.is_file():
        pytest.skip("stages are not generated: run tools/make_stages.py")
    stage = Usd.Stage.Open(str(file))
    errors = []
    for library in read_libraries(file).libraries:
        for clip in library.clips:
            truth = stage.GetPrimAtPath(clip.name).GetCustomDataByKey("truth")
            if truth is None:
                continue
            world = world_clip(clip, library.skeleton, library.biped)
            for side, label in enumerate(("left", "right")):
                for kind, times in (
                    ("Strike", world.contacts[side].strike_times),
                    ("Liftoff", world.contacts[side].liftoff_times),
                ):
                    expected = np.array(truth[f"{label}{kind}Times"]) / stage.GetTimeCodesPerSecond()
                    inside = expected[(expected > clip.times[0] + 0.1) & (expected < clip.times[-1] - 0.1)]
                    distances = np.abs(inside[:, None] - finite(times))
                    errors.append(distances.min(axis=1) if distances.size else np.full(len(inside), np.inf))
    error = np.concatenate(errors) * 30.0
    assert np.median(error) <= 0.5
    assert np.mean(error > 0.5) <= 0.05
