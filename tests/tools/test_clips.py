"""The clips of `stages/` do what they say: contacts as told, ground respected, people-like figures."""

import numpy as np
import pytest

from tests.tools.clip_poses import SIDES, ClipPoses, FloatArray, read_clip_poses

BALL_HEIGHT, ANKLE_HEIGHT, ANKLE_BACK = 0.034, 0.090, 0.135
HEEL_BACK = ANKLE_BACK + 0.4 * np.hypot(ANKLE_BACK, ANKLE_HEIGHT - BALL_HEIGHT)
WALKS = ("walk_110", "walk_130", "walk_150", "walk_175")
RUNS = ("jog_180", "jog_220", "run_260", "run_320", "run_400")


@pytest.fixture(scope="session")
def clips(stages) -> dict[str, ClipPoses]:
    return read_clip_poses(stages / "clips.usdc")


def heel(clip: ClipPoses, side: str) -> FloatArray:
    """Point of the heel on the sole (design.md section 2) [m], shape (F, 3)."""
    offset = np.array([0.0, -ANKLE_HEIGHT, ANKLE_BACK - HEEL_BACK])
    foot = clip.joint(f"{side.capitalize()}Foot")
    return clip.places[:, foot] + clip.turns[:, foot] @ offset


def ball(clip: ClipPoses, side: str) -> FloatArray:
    return clip.place(f"{side.capitalize()}Toe")


def within(clip: ClipPoses, start: float, end: float) -> np.ndarray:
    """Frames from `start` to `end` [time codes]."""
    return (clip.codes >= start - 1e-6) & (clip.codes <= end + 1e-6)


def test_the_library_has_every_gait(clips):
    kinds = {name.split("_")[0] for name in clips}
    assert {"walk", "run", "jog", "back", "side", "diagonal", "turn", "march", "stand", "start", "stop"} <= kinds
    assert len(clips) >= 40
    assert {name for name in clips if name.startswith("side_")} >= {"side_left_035", "side_right_028"}


def test_the_ball_is_planted_from_flat_to_liftoff(clips):
    for clip in clips.values():
        for side in SIDES:
            for _, flat, liftoff in clip.contacts(side):
                planted = ball(clip, side)[within(clip, flat, liftoff)]
                assert np.ptp(planted, axis=0).max(initial=0.0) < 2e-4, (clip.name, side, flat)
                assert np.abs(planted[:, 1] - BALL_HEIGHT).max() < 2e-4, (clip.name, side, flat)


def test_the_heel_stays_from_strike_to_flat(clips):
    for clip in clips.values():
        for side in SIDES:
            for strike, flat, _ in clip.contacts(side):
                standing = heel(clip, side)[within(clip, strike, flat)]
                if len(standing) > 1 and flat > strike:
                    assert np.ptp(standing, axis=0).max() < 2e-4, (clip.name, side, strike)


def test_the_foot_moves_right_after_the_liftoff(clips):
    for clip in clips.values():
        for side in SIDES:
            for _, _, liftoff in clip.contacts(side):
                after = int(np.floor(liftoff)) + 2
                if after < len(clip.codes):
                    moved = np.linalg.norm(ball(clip, side)[after] - ball(clip, side)[int(liftoff)])
                    assert moved > 1e-3, (clip.name, side, liftoff)


def test_flat_comes_in_time(clips):
    for clip in clips.values():
        for side in SIDES:
            for strike, flat, liftoff in clip.contacts(side):
                assert 0.0 <= flat - strike <= min(0.12 * 30.0, 0.25 * (liftoff - strike)) + 1e-9, clip.name


def test_no_foot_is_under_the_ground(clips):
    for clip in clips.values():
        for side in SIDES:
            assert ball(clip, side)[:, 1].min() > BALL_HEIGHT - 5e-4, clip.name
            assert heel(clip, side)[:, 1].min() > -1e-3, clip.name


def test_the_sole_clears_the_ground_in_mid_swing(clips):
    for clip in clips.values():
        for side in SIDES:
            strikes, liftoffs = clip.truth[f"{side}StrikeTimes"], clip.truth[f"{side}LiftoffTimes"]
            for liftoff in liftoffs:
                later = strikes[strikes > liftoff]
                if not len(later):
                    continue
                swing = later[0] - liftoff
                middle = within(clip, liftoff + 0.2 * swing, liftoff + 0.8 * swing)
                assert (ball(clip, side)[middle, 1] - BALL_HEIGHT).min() > 0.010, (clip.name, liftoff)
                assert heel(clip, side)[middle, 1].min() > 0.010, (clip.name, liftoff)


def test_knees_bend_forward_and_never_pop(clips):
    for clip in clips.values():
        for side in SIDES:
            flexion = np.degrees(clip.knee_flexion(side))
            assert flexion.min() > 5.0 and flexion.max() < 130.0, clip.name
            assert np.abs(np.diff(flexion)).max() * 30.0 < 900.0, clip.name
            hip, knee, ankle = (clip.place(f"{side.capitalize()}{name}") for name in ("UpLeg", "Leg", "Foot"))
            ahead = clip.turns[:, clip.joint("Hips")] @ [0.0, 0.0, 1.0]
            assert (np.sum((2.0 * knee - hip - ankle) * ahead, axis=1) > 0.0).all(), clip.name


def test_no_joint_jumps_between_frames(clips):
    for clip in clips.values():
        cosine = np.abs(np.sum(clip.local[1:] * clip.local[:-1], axis=2))
        assert np.degrees(2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))).max() < 40.0, clip.name
        assert (np.sum(clip.local[1:] * clip.local[:-1], axis=2) > 0.0).all(), clip.name


def test_loops_close(clips):
    for clip in clips.values():
        if clip.cyclic:
            cosine = np.abs(np.sum(clip.local[0, 1:] * clip.local[-1, 1:], axis=1))
            assert np.degrees(2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))).max() < 1.0, clip.name
            assert abs(clip.place("Hips")[0, 1] - clip.place("Hips")[-1, 1]) < 1e-3, clip.name


@pytest.mark.parametrize("name", ["walk_130", "run_260", "back_070", "march"])
def test_symmetric_gaits_are_symmetric(clips, name):
    clip = clips[name]
    strikes = np.sort(np.concatenate([clip.truth["leftStrikeTimes"], clip.truth["rightStrikeTimes"]]))
    half = round(strikes[1] - strikes[0])
    assert half == pytest.approx(strikes[1] - strikes[0], abs=0.02)
    left, right = (np.degrees(clip.knee_flexion(side)) for side in SIDES)
    assert np.abs(left[half:] - right[:-half]).max() < 1.0
    height = clip.place("Hips")[:, 1]
    assert np.abs(height[half:] - height[:-half]).max() < 1e-3


@pytest.mark.parametrize("name", WALKS)
def test_walking_vaults_over_the_standing_leg(clips, name):
    clip = clips[name]
    height = clip.place("Hips")[:, 1]
    assert 0.025 < np.ptp(height) < 0.055  # 3 to 5 cm in people
    for side in SIDES:
        for strike, _, liftoff in clip.contacts(side):
            contact = within(clip, strike, liftoff)
            top = clip.codes[contact][height[contact].argmax()]
            assert 0.3 < (top - strike) / (liftoff - strike) < 0.7


@pytest.mark.parametrize("name", RUNS)
def test_running_is_highest_in_flight(clips, name):
    clip = clips[name]
    height = clip.place("Hips")[:, 1]
    flight = np.ones(len(height), dtype=bool)
    for side in SIDES:
        strikes, liftoffs = clip.truth[f"{side}StrikeTimes"], clip.truth[f"{side}LiftoffTimes"]
        for strike in strikes:
            end = liftoffs[liftoffs > strike]
            flight &= ~within(clip, strike, end[0] if len(end) else np.inf)
        if len(liftoffs) and (not len(strikes) or liftoffs[0] < strikes[0]):
            flight &= ~within(clip, 0.0, liftoffs[0])
    assert flight.sum() >= 4
    assert height[flight].min() > np.median(height)
    assert 0.05 < np.ptp(height) < 0.10


def test_arms_swing_against_the_legs(clips):
    clip = clips["walk_130"]
    ahead = np.array([0.0, 0.0, 1.0])
    hips = clip.place("Hips")
    for side, other in (("Left", "Right"), ("Right", "Left")):
        hand, foot = ((clip.place(name) - hips) @ ahead for name in (f"{side}Hand", f"{other}Foot"))
        assert np.corrcoef(hand, foot)[0, 1] > 0.9
        assert 0.2 < np.ptp(hand) < 0.6


def test_the_head_is_steadier_than_the_pelvis(clips):
    clip = clips["walk_130"]
    for row, column in ((0, 2), (1, 0)):  # yaw, list
        head, pelvis = (np.ptp(clip.turns[:, clip.joint(name), row, column]) for name in ("Head", "Hips"))
        assert head < 0.4 * pelvis


def test_clip_names_tell_the_speed(clips):
    for name in (*WALKS, *RUNS):
        travel = clips[name].place("Hips")[-1] - clips[name].place("Hips")[0]
        speed = np.hypot(travel[0], travel[2]) / (len(clips[name].codes) - 1) * 30.0
        assert speed == pytest.approx(int(name.split("_")[1]) / 100.0, rel=0.03)


def test_the_standing_feet_of_starts_and_stops(clips):
    for name, frames in (("start_walk_left", slice(0, 20)), ("stop_walk_left", slice(-25, None))):
        for side in SIDES:
            assert np.ptp(ball(clips[name], side)[frames], axis=0).max() < 2e-4
