"""Contacts against the analytic walker's truth, and rules they must keep."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.analysis.worlds import detect_contacts
from tests.builders import Gait, Walker, build_walker
from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.motion import clip_leg_lengths, foot_motions, moved
from usdfoot.analysis.world import world_clip
from usdfoot.errors import ClipError
from usdfoot.maths import planar
from usdfoot.model.clip import AuthoredEvents, Clip
from usdfoot.model.contacts import Contacts

GAITS = {
    "walk": Gait(),
    "slow": Gait(step_time=0.8, step_length=0.25, duty=0.7),
    "shuffle": Gait(step_time=0.6, step_length=0.12, duty=0.72, clearance=0.03),
    "fast": Gait(step_time=0.4, step_length=0.75, duty=0.58),
    "run": Gait(step_time=0.35, step_length=1.0, duty=0.32, clearance=0.2),
    "forefoot run": Gait(step_time=0.33, step_length=1.1, duty=0.25, heel_strike=False, clearance=0.25),
    "backward": Gait(step_length=-0.4, heel_strike=False),
    "sideways": Gait(step_length=0.0, sideways=0.15, step_width=0.3, heel_strike=False),
    "on the spot": Gait(step_length=0.0, heel_strike=False),
    "turn": Gait(turn=0.3),
    "upstairs": Gait(rise=0.17, step_length=0.32, step_time=0.6, clearance=0.25),
    "downstairs": Gait(rise=-0.17, step_length=0.32, step_time=0.6, clearance=0.2),
}


def contacts_of_clip(walker: Walker, clip: Clip | None = None) -> Contacts:
    return detect_contacts(clip or walker.clip, walker.library.skeleton, walker.library.biped)


def assert_events(found: Contacts, truth: Contacts, clip: Clip, *, tolerance: float, edge: float = 0.08) -> None:
    """Every true event is found within `tolerance` [s] and no other; both only `edge` [s] inside the clip."""
    first, last = clip.times[0] + edge, clip.times[-1] - edge
    for side in range(2):
        for name in ("strike_times", "liftoff_times"):
            expected, times = (getattr(contacts[side], name) for contacts in (truth, found))
            for some, others in ((expected, times), (times, expected)):
                inside = some[(some > first) & (some < last)]
                distances = np.abs(inside[:, None] - others[np.isfinite(others)])
                assert (distances.min(axis=1) <= tolerance).all(), (name, side, times, expected)


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 120.0])
@pytest.mark.parametrize("gait", GAITS.values(), ids=GAITS.keys())
def test_strikes_and_liftoffs_within_half_a_frame(gait: Gait, rate: float) -> None:
    walker = build_walker(gait, rate=rate, start_time=1.7)
    assert_events(contacts_of_clip(walker), walker.contacts, walker.clip, tolerance=0.5 / rate)


@pytest.mark.parametrize("gait", GAITS.values(), ids=GAITS.keys())
def test_flat_positions_and_kind(gait: Gait) -> None:
    walker = build_walker(gait, rate=60.0)
    found = contacts_of_clip(walker)
    for side in range(2):
        foot, truth = found[side], walker.contacts[side]
        for k in np.flatnonzero(np.isfinite(truth.strike_times) & np.isfinite(truth.liftoff_times)):
            i = int(np.argmin(np.abs(foot.strike_times - truth.strike_times[k])))
            assert_allclose(foot.positions[i], truth.positions[k], atol=2e-3)
            assert_allclose(planar.wrap_angle(foot.yaws[i] - truth.yaws[k]), 0.0, atol=0.02)
            assert foot.ball_first[i] == truth.ball_first[k]
            assert_allclose(foot.flat_times[i], truth.flat_times[k], atol=0.02)


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 120.0])
def test_the_last_digits_of_rates_and_times_do_not_count(rate: float) -> None:
    walker = build_walker(Gait(), rate=rate)
    exact = contacts_of_clip(walker)
    for factor in (1.0 - 1e-15, 1.0 + 1e-15):
        found = contacts_of_clip(walker, replace(walker.clip, rate=rate * factor, start_time=1e-15))
        for side in range(2):
            assert_allclose(found[side].strike_times, exact[side].strike_times, atol=1e-9)
            assert_allclose(found[side].liftoff_times, exact[side].liftoff_times, atol=1e-9)


def test_flat_is_never_late() -> None:
    for gait in GAITS.values():
        found = contacts_of_clip(build_walker(gait))
        for side in range(2):
            foot = found[side]
            whole = np.isfinite(foot.strike_times) & np.isfinite(foot.liftoff_times)
            rolls = foot.flat_times[whole] - foot.strike_times[whole]
            durations = foot.liftoff_times[whole] - foot.strike_times[whole]
            assert (rolls >= 0.0).all()
            assert (rolls <= np.minimum(0.12, 0.25 * durations) + 1e-9).all()


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_contacts_are_not_refined_to_less_than_the_shortest(noise: float) -> None:
    """Taps of 40 ms: where both ends move inwards, hardly anything may be left between them."""
    taps = Gait(step_time=0.2, step_length=0.0, duty=0.1, heel_strike=False, clearance=0.2)
    found = contacts_of_clip(build_walker(taps, rate=30.0, noise=noise))
    for side in range(2):
        assert len(found[side].strike_times) == 4
        assert np.min(found[side].liftoff_times - found[side].strike_times) >= ContactOptions().shortest_contact


@pytest.mark.parametrize("size", [0.3, 2.0])
def test_size_of_the_body_does_not_matter(size: float) -> None:
    walker = build_walker(size=size)
    assert_events(contacts_of_clip(walker), walker.contacts, walker.clip, tolerance=0.5 / 30.0)


def test_noise_is_tolerated() -> None:
    walker = build_walker(rate=120.0, noise=0.0005)
    assert_events(contacts_of_clip(walker), walker.contacts, walker.clip, tolerance=0.025)


def test_rotated_and_shifted_clip_has_its_contacts_moved() -> None:
    walker = build_walker(Gait(turn=0.1))
    yaw, shift = 2.0, np.array([3.0, -7.0])
    clip = moved(walker.clip, walker.library.skeleton, positions=shift, yaws=np.array(yaw))
    before, after = contacts_of_clip(walker), contacts_of_clip(walker, clip)
    for side in range(2):
        assert_allclose(after[side].strike_times, before[side].strike_times, atol=1e-9)
        assert_allclose(after[side].liftoff_times, before[side].liftoff_times, atol=1e-9)
        ground = planar.rotate(np.array(yaw), before[side].positions[:, [0, 2]]) + shift
        assert_allclose(after[side].positions[:, [0, 2]], ground, atol=1e-9)
        assert_allclose(planar.wrap_angle(after[side].yaws - before[side].yaws - yaw), 0.0, atol=1e-9)


def test_time_shift_moves_the_events() -> None:
    walker = build_walker()
    before = contacts_of_clip(walker)
    after = contacts_of_clip(walker, replace(walker.clip, start_time=walker.clip.start_time + 12.5))
    for side in range(2):
        assert_allclose(after[side].strike_times, before[side].strike_times + 12.5, atol=1e-9)
        assert_allclose(after[side].flat_times, before[side].flat_times + 12.5, atol=1e-9)


def test_raised_floor_does_not_matter() -> None:
    walker = build_walker()
    translations = walker.clip.translations.copy()
    translations[:, 0, 1] += 5.0
    before, after = contacts_of_clip(walker), contacts_of_clip(walker, replace(walker.clip, translations=translations))
    for side in range(2):
        assert_allclose(after[side].strike_times, before[side].strike_times, atol=1e-9)
        assert_allclose(after[side].positions[:, 1], before[side].positions[:, 1] + 5.0, atol=1e-9)


@pytest.mark.parametrize("gait", ["walk", "backward", "sideways", "run"])
def test_clip_in_place_gives_the_same_contacts(gait: str) -> None:
    truth = build_walker(GAITS[gait], rate=60.0)
    walker = build_walker(GAITS[gait], rate=60.0, in_place=True)
    world = world_clip(walker.clip, walker.library.skeleton, walker.library.biped)
    assert world.root_motion.in_place
    assert_events(world.contacts, truth.contacts, walker.clip, tolerance=0.5 / 30.0)
    first = truth.contacts.right.positions[1] - truth.contacts.left.positions[0]
    found = world.contacts.right.positions[1] - world.contacts.left.positions[0]
    assert_allclose(found, first, atol=0.02)


def test_travelling_clip_is_left_alone() -> None:
    for gait in GAITS.values():
        walker = build_walker(gait)
        world = world_clip(walker.clip, walker.library.skeleton, walker.library.biped)
        assert not world.root_motion.in_place
        assert world.period is None


@pytest.mark.parametrize("in_place", [False, True])
@pytest.mark.parametrize("rate", [24.0, 30.0, 31.0])
def test_single_loop_is_found_and_its_contacts_wrap(rate: float, in_place: bool) -> None:
    walker = build_walker(rate=rate, loop=True, in_place=in_place)
    world = world_clip(walker.clip, walker.library.skeleton, walker.library.biped)
    assert world.period == pytest.approx(1.0, abs=1e-3)
    contacts = contacts_of_clip(walker)
    for side in range(2):
        assert len(contacts[side].strike_times) == 1
        duration = contacts[side].liftoff_times - contacts[side].strike_times
        assert_allclose(duration, 0.62, atol=1.2 / rate)


@pytest.mark.parametrize("drop", [0, 1])
def test_loop_with_and_without_its_first_pose_repeated(drop: int) -> None:
    walker = build_walker(loop=True)
    count = len(walker.clip.rotations) - drop
    clip = replace(walker.clip, translations=walker.clip.translations[:count], rotations=walker.clip.rotations[:count])
    world = world_clip(clip, walker.library.skeleton, walker.library.biped)
    assert world.period == pytest.approx(1.0, abs=1e-3)


def test_loop_between_samples() -> None:
    walker = build_walker(Gait(step_time=0.51), rate=24.0, loop=True)
    count = int(1.02 * 24.0) + 1
    clip = replace(walker.clip, translations=walker.clip.translations[:count], rotations=walker.clip.rotations[:count])
    world = world_clip(clip, walker.library.skeleton, walker.library.biped)
    assert world.period == pytest.approx(1.02, abs=4e-3)


def frozen(clip: Clip, time: float) -> Clip:
    sample = [int(np.argmin(np.abs(clip.times - time)))] * 40
    return replace(clip, translations=clip.translations[sample], rotations=clip.rotations[sample])


def test_standing_feet_stand_from_end_to_end() -> None:
    walker = build_walker()
    double_support = 0.5 * (walker.contacts.left.flat_times[1] + walker.contacts.right.liftoff_times[1])
    contacts = contacts_of_clip(walker, frozen(walker.clip, double_support))
    for side in range(2):
        assert contacts[side].strike_times.tolist() == [-np.inf]
        assert contacts[side].liftoff_times.tolist() == [np.inf]


def test_foot_held_in_the_air_does_not_stand() -> None:
    walker = build_walker(Gait(clearance=0.3))
    mid_swing = 0.5 * (walker.contacts.left.liftoff_times[1] + walker.contacts.left.strike_times[2])
    contacts = contacts_of_clip(walker, frozen(walker.clip, mid_swing))
    assert len(contacts.left.strike_times) == 0
    assert len(contacts.right.strike_times) == 1


def test_authored_events_replace_detection() -> None:
    walker = build_walker()
    detected = contacts_of_clip(walker)
    strikes = np.array([0.3, 1.3, 2.3])
    events = AuthoredEvents(strike_times=strikes, flat_times=strikes + 0.05, liftoff_times=strikes + 0.5)
    contacts = contacts_of_clip(walker, replace(walker.clip, events=(events, AuthoredEvents())))
    assert_allclose(contacts.left.strike_times, strikes)
    assert_allclose(contacts.left.flat_times, strikes + 0.05)
    assert_allclose(contacts.left.liftoff_times, strikes + 0.5)
    assert_allclose(contacts.right.strike_times, detected.right.strike_times)


def test_authored_strikes_alone_keep_detected_liftoffs() -> None:
    walker = build_walker()
    detected = contacts_of_clip(walker)
    whole = np.isfinite(detected.left.strike_times)
    strikes = detected.left.strike_times[whole] - 0.02
    events = (AuthoredEvents(strike_times=strikes), AuthoredEvents())
    contacts = contacts_of_clip(walker, replace(walker.clip, events=events))
    assert_allclose(contacts.left.strike_times, strikes)
    assert_allclose(contacts.left.liftoff_times, detected.left.liftoff_times[whole])


def test_authored_events_of_a_loop_repeat() -> None:
    walker = build_walker(loop=True)
    found = contacts_of_clip(walker)
    events = tuple(
        AuthoredEvents(strike_times=found[side].strike_times, liftoff_times=np.mod(found[side].liftoff_times, 1.0))
        for side in range(2)
    )
    contacts = contacts_of_clip(walker, replace(walker.clip, events=events))
    for side in range(2):
        assert_allclose(contacts[side].strike_times, found[side].strike_times, atol=1e-6)
        assert_allclose(contacts[side].liftoff_times, found[side].liftoff_times, atol=1e-6)


def test_two_authored_strikes_without_a_liftoff_are_refused() -> None:
    walker = build_walker()
    events = AuthoredEvents(strike_times=np.array([0.3, 1.3]), liftoff_times=np.array([1.9]))
    with pytest.raises(ClipError, match=r"two left strikes without a liftoff between them: 0\.3 s.*left:liftoffTimes"):
        contacts_of_clip(walker, replace(walker.clip, events=(events, AuthoredEvents())))


def test_heel_is_behind_and_below_the_ankle() -> None:
    walker = build_walker(twisted=True)
    rig = walker.library.skeleton, walker.library.biped
    (motion,) = foot_motions([walker.clip], *rig, leg_lengths=clip_leg_lengths([walker.clip], *rig))
    for side in range(2):
        truth = walker.contacts[side]
        flat = (motion.times > truth.flat_times[1]) & (motion.times < truth.flat_times[1] + 0.1)
        heel, ankle = motion.heels[flat, side].mean(axis=0), motion.ankles[flat, side].mean(axis=0)
        assert heel[1] == pytest.approx(0.0, abs=2e-3)
        reach = 0.4 * np.linalg.norm(motion.balls[0, side] - motion.ankles[0, side])
        assert ankle[2] - heel[2] == pytest.approx(reach, abs=2e-3)
