"""Clips retargeted: the same rig gives the same clip, other rigs the same limbs, and feet stand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait, build_walker
from tests.retarget.rigs import from_world, other_axes, reproportioned, rig_of, scaled, spread_arms, world
from tests.walker_body import walker_rig
from usdfoot.errors import ClipError
from usdfoot.maths import quaternion
from usdfoot.model.biped import Biped
from usdfoot.model.clip import AuthoredEvents
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.retarget.clips import retarget_clips
from usdfoot.retarget.rig import build_rig, same_legs


def poses(rig, clip):
    return forward_kinematics(rig.skeleton.parents, clip.translations, clip.rotations)


def angles_between(first, second):
    cosines = np.sum(first * second, axis=-1) / np.linalg.norm(first, axis=-1) / np.linalg.norm(second, axis=-1)
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


def turn_angles(first, second):
    relative = quaternion.compose(quaternion.inverse(first), second)
    return np.degrees(np.linalg.norm(quaternion.to_rotation_vector(relative), axis=-1))


def planted_slides(rig, result):
    """Largest distance between two samples of a planted ball, of every contact [m]."""
    places, _ = poses(rig, result.clip)
    slides = []
    for side in (0, 1):
        foot = result.contacts[side]
        for flat, liftoff in zip(foot.flat_times, foot.liftoff_times, strict=True):
            balls = places[(result.clip.times >= flat) & (result.clip.times <= liftoff), rig.biped.balls[side]]
            if len(balls):
                slides.append(np.linalg.norm(balls[:, None] - balls, axis=-1).max())
    return np.array(slides)


@pytest.fixture(scope="module")
def tall(person):
    """A person of other proportions: longer shins and feet, shorter thighs, wider hips and shoulders."""
    rig, _ = person
    factors = dict.fromkeys(rig.biped.knees, 0.94) | dict.fromkeys(rig.biped.ankles, 1.15)
    factors |= dict.fromkeys(rig.biped.balls, 1.3) | dict.fromkeys(rig.biped.hips, 1.2)
    factors |= {arm.upper: 1.3 for arm in rig.body.arms} | {rig.body.neck[0]: 1.2}
    return rig_of(reproportioned(rig.skeleton, factors), rig.biped)


@pytest.fixture(scope="module")
def on_tall(person, tall):
    rig, clips = person
    return retarget_clips(rig, clips, tall)


def test_on_its_own_rig_a_clip_stays_as_it_is(person):
    rig, clips = person
    for clip, result in zip(clips, retarget_clips(rig, clips, rig), strict=True):
        assert_allclose(result.clip.translations, clip.translations, atol=1e-6)
        assert_allclose(np.abs(np.sum(result.clip.rotations * clip.rotations, axis=-1)), 1.0, atol=1e-9)
        assert_allclose(poses(rig, result.clip)[0], poses(rig, clip)[0], atol=1e-6)


@pytest.mark.parametrize("in_place", [False, True])
@pytest.mark.parametrize("loop", [False, True])
def test_loops_and_clips_in_place_stay_what_they_are(in_place, loop):
    walker = build_walker(Gait(turn=0.0 if in_place else 0.1), in_place=in_place, loop=loop, twisted=True)
    skeleton, biped = scaled(walker.library.skeleton, walker.library.biped, 1.25)
    source, target = rig_of(walker.library.skeleton, walker.library.biped), rig_of(skeleton, biped)
    (result,) = retarget_clips(source, [walker.clip], target)
    assert_allclose(result.clip.times, walker.clip.times)
    assert_allclose(poses(target, result.clip)[0], 1.25 * poses(source, walker.clip)[0], atol=1e-6)


def test_joint_axes_do_not_matter(person, generator):
    rig, clips = person
    skeleton, axes = other_axes(rig.skeleton, generator)
    other = rig_of(skeleton, rig.biped)
    for clip, result in zip(clips, retarget_clips(rig, clips, other), strict=True):
        places, turns = poses(rig, clip)
        found, turned = poses(other, result.clip)
        assert_allclose(found, places, atol=1e-6)
        assert turn_angles(turned, quaternion.compose(turns, axes)).max() < 1e-3


def test_a_larger_rig_moves_as_much_larger(person):
    rig, clips = person
    bigger = rig_of(*scaled(rig.skeleton, rig.biped, 1.7))
    for clip, result in zip(clips, retarget_clips(rig, clips, bigger), strict=True):
        assert_allclose(poses(bigger, result.clip)[0], 1.7 * poses(rig, clip)[0], atol=1e-6)


@pytest.mark.parametrize("back", [False, True])
def test_spread_and_hanging_arms_mean_the_same(person, back):
    """A T-pose is another rest pose of the same joints: their rotations in the world are the same."""
    rig, clips = person
    spread = rig_of(spread_arms(rig), rig.biped)
    source, target = (spread, rig) if back else (rig, spread)
    for clip, result in zip(clips, retarget_clips(source, clips, target), strict=True):
        places, turns = poses(source, clip)
        found, turned = poses(target, result.clip)
        hands = np.isin(rig.skeleton.parents, [arm.hand for arm in rig.body.arms])  # fingers tell how hands are turned
        assert_allclose(found[:, ~hands], places[:, ~hands], atol=1e-6)
        assert_allclose(found[:, hands], places[:, hands], atol=5e-3)
        arms = [joint for arm in rig.body.arms for joint in (arm.upper, arm.lower, arm.hand)]
        arms += np.flatnonzero(hands).tolist()
        assert turn_angles(turned, turns)[:, arms].max() < 15.0
        others = np.setdiff1d(np.arange(len(rig.skeleton.joints)), arms)
        assert turn_angles(turned, turns)[:, others].max() < 1e-3


def test_planted_balls_stand_still_over_the_scaled_contacts(person, tall, on_tall):
    rig, _ = person
    assert not same_legs(rig, tall)
    scale = legs(tall.skeleton, tall.biped) / legs(rig.skeleton, rig.biped)
    for result in on_tall:
        assert planted_slides(tall, result).max() < 1e-6
        assert result.slide < 1e-6
        places, _ = poses(tall, result.clip)
        for side in (0, 1):
            foot = result.contacts[side]
            inside = (result.clip.times >= foot.flat_times[0]) & (result.clip.times <= foot.liftoff_times[0])
            if inside.any():
                ball = places[inside, tall.biped.balls[side]].mean(axis=0)
                expected = scale * foot.positions[0] + [0.0, tall.biped.ball_heights[side], 0.0]
                assert_allclose(ball, expected, atol=1e-6)


def legs(skeleton: Skeleton, biped: Biped) -> float:
    places, _ = world(skeleton)
    bones = [
        np.linalg.norm(np.diff(places[list(leg)], axis=0), axis=1).sum() for leg in zip(*pairs(biped), strict=True)
    ]
    return float(np.mean(bones))


def pairs(biped: Biped):
    return biped.hips, biped.knees, biped.ankles


def test_limbs_keep_their_directions(person, tall, on_tall):
    rig, clips = person
    for clip, result in zip(clips, on_tall, strict=True):
        places, found = poses(rig, clip)[0], poses(tall, result.clip)[0]
        for arm in rig.body.arms:
            for start, end in ((arm.upper, arm.lower), (arm.lower, arm.hand)):
                assert angles_between(found[:, end] - found[:, start], places[:, end] - places[:, start]).max() < 1e-3
        for side in (0, 1):
            for above, below in zip(pairs(rig.biped), pairs(rig.biped)[1:], strict=False):
                start, end = above[side], below[side]
                angles = angles_between(found[:, end] - found[:, start], places[:, end] - places[:, start])
                assert angles.mean() < 8.0 and angles.max() < 20.0


def test_knees_and_elbows_bend_about_their_hinges(person, tall, on_tall):
    """The axis a limb is bent about, seen from its upper joint, is the same in source and target."""
    rig, clips = person
    limbs = [leg for leg in zip(*pairs(rig.biped), strict=True)]
    limbs += [(arm.upper, arm.lower, arm.hand) for arm in rig.body.arms]
    for clip, result in zip(clips, on_tall, strict=True):
        for upper, lower, end in limbs:
            axes, bent = [], []
            for own, each in ((rig, clip), (tall, result.clip)):
                places, turns = poses(own, each)
                axis = np.cross(places[:, lower] - places[:, upper], places[:, end] - places[:, lower])
                bones = [
                    np.linalg.norm(places[:, b] - places[:, a], axis=-1) for a, b in ((upper, lower), (lower, end))
                ]
                bent.append(np.linalg.norm(axis, axis=-1) / bones[0] / bones[1] > np.sin(np.radians(12.0)))
                axes.append(quaternion.rotate(quaternion.inverse(turns[:, upper]), axis))
            rows = bent[0] & bent[1]
            assert rows.any()
            assert angles_between(axes[0][rows], axes[1][rows]).max() < 6.0


def test_soles_are_flat_when_the_source_s_are(person, tall, on_tall):
    rig, clips = person
    for clip, result in zip(clips, on_tall, strict=True):
        (_, turns), (_, turned) = poses(rig, clip), poses(tall, result.clip)
        assert turn_angles(turns, turned)[:, [*rig.biped.ankles, *rig.biped.balls]].max() < 1e-3


def test_rotations_are_unit_and_do_not_flip(person, on_tall, generator):
    rig, clips = person
    other = rig_of(other_axes(rig.skeleton, generator)[0], rig.biped)
    for result in [*on_tall, *retarget_clips(rig, clips, other, plant=True)]:
        rotations = result.clip.rotations
        assert_allclose(np.linalg.norm(rotations, axis=-1), 1.0, atol=1e-12)
        assert np.sum(rotations[1:] * rotations[:-1], axis=-1).min() > 0.5


def with_spine(skeleton: Skeleton, biped: Biped, chain, at) -> tuple[Skeleton, Biped, list[int]]:
    """The skeleton with the joints of a straight chain replaced by as many as `at` (0..1 of its length) says."""
    places, turns = world(skeleton)
    kept = [joint for joint in range(len(skeleton.joints)) if joint not in chain[1:-1]]
    names = [skeleton.joints[joint] for joint in kept]
    order = {joint: index for index, joint in enumerate(kept)}
    parents = [order.get(int(skeleton.parents[joint]), -1) for joint in kept]
    new_places, new_turns = [places[joint] for joint in kept], [turns[joint] for joint in kept]
    top = order[chain[-1]]
    added = []
    for fraction in at:
        place = places[chain[0]] + fraction * (places[chain[-1]] - places[chain[0]])
        names.append(f"{names[order[chain[0]]]}/Extra{len(added)}")
        parents.append(order[chain[0]] if not added else added[-1])
        added.append(len(names) - 1)
        new_places.append(place)
        new_turns.append(turns[chain[0]])
    parents[top] = added[-1] if added else order[chain[0]]
    rows: list[int] = []
    while len(rows) < len(names):
        rows += [i for i in range(len(names)) if i not in rows and (parents[i] < 0 or parents[i] in rows)]
    place_of = {old: new for new, old in enumerate(rows)}
    base = Skeleton(
        name=skeleton.name,
        joints=tuple(names[row] for row in rows),
        parents=np.array([place_of.get(parents[row], -1) for row in rows]),
        rest_translations=np.zeros((len(rows), 3)),
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(rows), 1)),
    )
    made = from_world(base, np.array(new_places)[rows], np.array(new_turns)[rows])
    moved = {name: tuple(place_of[order[joint]] for joint in getattr(biped, name)) for name in ROLES}
    return made, replace(biped, pelvis=place_of[order[biped.pelvis]], **moved), [place_of[row] for row in added]


ROLES = ("hips", "knees", "ankles", "balls")


@pytest.mark.parametrize("at", [(), (0.5,), (0.2, 0.4, 0.6, 0.8)])
def test_spines_with_other_joints_carry_chest_and_head_alike(person, at):
    rig, clips = person
    skeleton, biped, added = with_spine(rig.skeleton, rig.biped, (rig.biped.pelvis, *rig.body.trunk), at)
    other = rig_of(skeleton, biped)
    assert list(other.body.trunk[:-1]) == added
    for clip, result in zip(clips[:1], retarget_clips(rig, clips[:1], other), strict=True):
        (_, turns), (_, turned) = poses(rig, clip), poses(other, result.clip)
        assert turn_angles(turns[:, rig.body.trunk[-1]], turned[:, other.body.trunk[-1]]).max() < 1e-3
        assert turn_angles(turns[:, rig.body.neck[-1]], turned[:, other.body.neck[-1]]).max() < 1e-3
        way = turn_angles(turned[:, biped.pelvis], turned[:, other.body.trunk[-1]])
        for lower, upper in zip((biped.pelvis, *added), (*added, other.body.trunk[-1]), strict=True):
            assert np.all(turn_angles(turned[:, lower], turned[:, upper]) <= way + 1e-3)


def test_authored_events_count_and_are_carried_along():
    walker = build_walker()
    strikes = walker.contacts.left.strike_times
    events = AuthoredEvents(strike_times=strikes[np.isfinite(strikes)] + 0.02)
    clip = replace(walker.clip, events=(events, AuthoredEvents()), style="careful", range_start=0.1)
    source = rig_of(walker.library.skeleton, walker.library.biped)
    target = rig_of(reproportioned(source.skeleton, dict.fromkeys(source.biped.ankles, 1.2)), source.biped)
    (result,) = retarget_clips(source, [clip], target)
    assert_allclose(result.contacts[0].strike_times, events.strike_times, atol=1e-9)
    assert (result.clip.style, result.clip.range_start) == ("careful", 0.1)
    spoilt = AuthoredEvents(strike_times=np.array([0.1, 0.2]), liftoff_times=np.array([0.3]))
    (error,) = retarget_clips(source, [replace(walker.clip, events=(spoilt, AuthoredEvents()))], target)
    assert isinstance(error, ClipError) and "without a liftoff between them" in str(error)


def test_feet_that_are_too_far_lower_the_pelvis_as_far_as_needed(person):
    rig, clips = person
    wide = rig_of(reproportioned(rig.skeleton, dict.fromkeys(rig.biped.hips, 1.5)), rig.biped)
    results = retarget_clips(rig, clips, wide)
    assert 0.001 < max(result.lowered for result in results) < 0.1
    assert max(planted_slides(wide, result).max() for result in results) < 1e-6


def test_the_symmetric_one_of_rest_and_bind_pose_is_compared(person):
    from usdfoot.model.skeleton import Pose

    rig, clips = person
    clean = Pose(places=rig.reference.places, turns=rig.reference.turns)
    stride = clips[0].rotations[8]
    current = replace(rig.skeleton, rest_rotations=stride, rest_translations=clips[0].translations[8])
    built = build_rig(current, rig.biped, clean)
    assert_allclose(built.reference.places, clean.places, atol=1e-9)
    for clip, result in zip(clips[:1], retarget_clips(built, clips[:1], rig), strict=True):
        assert_allclose(poses(rig, result.clip)[0], poses(rig, clip)[0], atol=1e-6)
    kept = build_rig(rig.skeleton, rig.biped, Pose(places=poses(rig, clips[0])[0][8], turns=poses(rig, clips[0])[1][8]))
    assert_allclose(kept.reference.places, rig.reference.places, atol=1e-9)


def test_a_rig_without_arms_or_neck_walks_all_the_same(person):
    rig, clips = person
    skeleton, biped = walker_rig(twisted=True)
    bare = rig_of(skeleton, biped)
    (result, *_) = retarget_clips(rig, clips, bare)
    assert planted_slides(bare, result).max() < 1e-6
    walker = build_walker()
    (back,) = retarget_clips(rig_of(walker.library.skeleton, walker.library.biped), [walker.clip], rig)
    assert planted_slides(rig, back).max() < 1e-6
