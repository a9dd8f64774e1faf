"""Mirror images: twice is the identity, and joints land on the reflection of their partners, whatever their axes."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.analysis.worlds import detect_contacts
from tests.builders import Gait, build_walker
from tests.images import REFLECTION, mirrored_clip, mirrored_contacts
from tests.walker_body import walker_rig
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.analysis.mirror import mirror_map
from usdfoot.maths import quaternion
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics


def positions_of(clip: Clip, skeleton: Skeleton) -> np.ndarray:
    return forward_kinematics(skeleton.parents, clip.translations, clip.rotations)[0]


def with_rest_translations(clip: Clip, skeleton: Skeleton, pelvis: int) -> Clip:
    translations = np.broadcast_to(skeleton.rest_translations, clip.translations.shape).copy()
    translations[:, : pelvis + 1] = clip.translations[:, : pelvis + 1]
    return replace(clip, translations=translations)


@pytest.mark.parametrize("twisted", [False, True])
def test_mirrored_joints_are_the_reflected_partners(twisted: bool) -> None:
    walker = build_walker(Gait(turn=0.2, sideways=0.1), twisted=twisted)
    skeleton, biped = walker.library.skeleton, walker.library.biped
    mirror = mirror_map(skeleton, biped)
    image = mirrored_clip(walker.clip, mirror)
    reflected = positions_of(walker.clip, skeleton)[:, mirror.partners] * REFLECTION
    assert_allclose(positions_of(image, skeleton), reflected, atol=1e-9)
    # The rig is symmetric, so its own rest translations do as well.
    own = with_rest_translations(image, skeleton, biped.pelvis)
    assert_allclose(positions_of(own, skeleton), reflected, atol=1e-6)


@pytest.mark.parametrize("twisted", [False, True])
def test_twice_is_the_identity(twisted: bool) -> None:
    walker = build_walker(Gait(turn=0.2), twisted=twisted)
    mirror = mirror_map(walker.library.skeleton, walker.library.biped)
    twice = mirrored_clip(mirrored_clip(walker.clip, mirror), mirror)
    assert_allclose(twice.translations, walker.clip.translations, atol=1e-9)
    same = np.abs(np.sum(twice.rotations * walker.clip.rotations, axis=-1))
    assert_allclose(same, 1.0, atol=1e-9)


def test_world_rotations_of_plain_axes_are_reflected() -> None:
    walker = build_walker(Gait(turn=0.2))
    skeleton = walker.library.skeleton
    mirror = mirror_map(skeleton, walker.library.biped)
    image = mirrored_clip(walker.clip, mirror)
    before = forward_kinematics(skeleton.parents, walker.clip.translations, walker.clip.rotations)[1]
    after = forward_kinematics(skeleton.parents, image.translations, image.rotations)[1]
    expected = quaternion.mirror_x(before[:, mirror.partners])
    assert_allclose(np.abs(np.sum(after * expected, axis=-1)), 1.0, atol=1e-9)


def test_rest_pose_taken_from_a_walk_mirrors_as_well() -> None:
    walker = build_walker(Gait(), twisted=True)
    skeleton, biped = walker.library.skeleton, walker.library.biped
    strides = replace(
        skeleton, rest_rotations=walker.clip.rotations[7].copy(), rest_translations=walker.clip.translations[7].copy()
    )
    mirror = mirror_map(strides, biped)
    image = with_rest_translations(mirrored_clip(walker.clip, mirror), skeleton, biped.pelvis)
    reflected = positions_of(walker.clip, skeleton)[:, mirror.partners] * REFLECTION
    assert_allclose(positions_of(image, skeleton)[:, biped.balls], reflected[:, biped.balls], atol=5e-3)


def test_rest_pose_taken_from_a_walk_tells_the_axes_of_one_that_stands() -> None:
    walker = build_walker(Gait())
    skeleton, biped = walker.library.skeleton, walker.library.biped
    strides = replace(skeleton, rest_rotations=walker.clip.rotations[7].copy())
    standing, striding = (mirror_map(rig, biped).relations for rig in (skeleton, strides))
    assert_allclose(np.abs(np.sum(standing * striding, axis=-1)), 1.0, atol=1e-9)


def test_joints_are_reflected_where_axes_are_not_square_to_the_last_digit() -> None:
    """The rest pose is a frame of a walk, so axes count as square; one thigh's are off by 2 mrad, as if hand-drawn."""
    walker = build_walker(Gait())
    skeleton, biped = walker.library.skeleton, walker.library.biped
    hip, knee = biped.hips[1], biped.knees[1]
    slip = quaternion.from_axis_angle(np.array([0.6, 0.0, 0.8]), np.array(2e-3))
    rotations, offsets = walker.clip.rotations.copy(), skeleton.rest_translations.copy()
    rotations[:, hip] = quaternion.compose(rotations[:, hip], quaternion.inverse(slip))
    rotations[:, knee] = quaternion.compose(slip, rotations[:, knee])
    offsets[knee] = quaternion.rotate(slip, offsets[knee])
    clip = replace(walker.clip, rotations=rotations)
    drawn = replace(skeleton, rest_translations=offsets, rest_rotations=rotations[7].copy())
    mirror = mirror_map(drawn, biped)
    image = with_rest_translations(mirrored_clip(clip, mirror), drawn, biped.pelvis)
    reflected = positions_of(walker.clip, skeleton)[:, mirror.partners] * REFLECTION
    legs = [*biped.hips, *biped.knees, *biped.ankles, *biped.balls]
    assert_allclose(positions_of(image, drawn)[:, legs], reflected[:, legs], atol=1e-6)


def test_axes_stay_square_where_no_turn_brings_a_joint_onto_its_image() -> None:
    """The rest pose is a frame of a walk; one thigh is 5 % longer than the other, and bowed by 50 mrad."""
    walker = build_walker(Gait())
    skeleton, biped = walker.library.skeleton, walker.library.biped
    offsets, knee = skeleton.rest_translations.copy(), biped.knees[1]
    bow = quaternion.from_axis_angle(np.array([0.6, 0.0, 0.8]), np.array(0.05))
    offsets[knee] = 1.05 * quaternion.rotate(bow, offsets[knee])
    rest = walker.clip.rotations[7].copy()
    expected = mirror_map(replace(skeleton, rest_rotations=rest), biped).relations
    found = mirror_map(replace(skeleton, rest_rotations=rest, rest_translations=offsets), biped).relations
    assert_allclose(np.abs(np.sum(found * expected, axis=-1)), 1.0, atol=1e-9)


def test_contacts_of_the_mirrored_clip_are_the_mirrored_contacts() -> None:
    walker = build_walker(Gait(turn=0.2), twisted=True)
    skeleton, biped = walker.library.skeleton, walker.library.biped
    image = mirrored_clip(walker.clip, mirror_map(skeleton, biped))
    found = detect_contacts(image, skeleton, biped)
    expected = mirrored_contacts(detect_contacts(walker.clip, skeleton, biped))
    for side in range(2):
        assert_allclose(found[side].strike_times, expected[side].strike_times, atol=1e-6)
        assert_allclose(found[side].positions, expected[side].positions, atol=1e-6)
        assert_allclose(found[side].yaws, expected[side].yaws, atol=1e-6)


def renamed(skeleton: Skeleton, names: dict[str, str]) -> Skeleton:
    joints = tuple("/".join(names.get(leaf, leaf) for leaf in joint.split("/")) for joint in skeleton.joints)
    return replace(skeleton, joints=joints)


@pytest.mark.parametrize(
    ("left", "right"),
    [("L_{}", "R_{}"), ("{}_l", "{}_r"), ("{}.L", "{}.R"), ("l{}", "r{}"), ("Bip01 L {}", "Bip01 R {}")],
)
def test_names_of_many_rigs_pair(left: str, right: str) -> None:
    skeleton, biped = walker_rig()
    names = {f"Left{role}": left.format(role) for role in ("Arm", "Hand", "UpLeg", "Leg", "Foot", "Toe")}
    names |= {f"Right{role}": right.format(role) for role in ("Arm", "Hand", "UpLeg", "Leg", "Foot", "Toe")}
    assert joint_pairs(renamed(skeleton, names), biped).tolist() == joint_pairs(skeleton, biped).tolist()
    assert joint_pairs(skeleton, biped).tolist() == [0, 1, 2, 3, 6, 7, 4, 5, 12, 13, 14, 15, 8, 9, 10, 11]


@pytest.mark.parametrize("yaw", [0.0, 1.9])
def test_without_names_joints_pair_by_the_mirrored_rest_pose(yaw: float) -> None:
    """Also where the character does not face +Z, and beside something that has no counterpart."""
    skeleton, biped = walker_rig()
    expected = joint_pairs(skeleton, biped).tolist()
    leaves = {joint.rsplit("/", 1)[-1]: f"bone{i}" for i, joint in enumerate(skeleton.joints)}
    nameless = renamed(skeleton, leaves)
    turn = quaternion.yaw_quaternion(np.array(yaw))
    sword = replace(
        nameless,
        joints=(*nameless.joints, f"{nameless.joints[2]}/bone99"),
        parents=np.append(nameless.parents, 2),
        rest_translations=np.vstack([nameless.rest_translations, (0.3, 0.1, 0.2)]),
        rest_rotations=np.vstack([nameless.rest_rotations, (0.0, 0.0, 0.0, 1.0)]),
    )
    roots = (sword.parents < 0)[:, None]
    turned = replace(
        sword,
        rest_translations=np.where(roots, quaternion.rotate(turn, sword.rest_translations), sword.rest_translations),
        rest_rotations=np.where(roots, quaternion.compose(turn, sword.rest_rotations), sword.rest_rotations),
    )
    assert joint_pairs(turned, biped).tolist() == [*expected, len(expected)]


def test_what_hangs_on_one_leg_alone_does_not_turn_the_mirror_image() -> None:
    """A holster on the right thigh."""
    skeleton, biped = walker_rig(twisted=True)
    thigh = biped.hips[1]
    armed = replace(
        skeleton,
        joints=(*skeleton.joints, f"{skeleton.joints[thigh]}/Holster"),
        parents=np.append(skeleton.parents, thigh),
        rest_translations=np.vstack([skeleton.rest_translations, [0.1, -0.1, 0.2]]),
        rest_rotations=np.vstack([skeleton.rest_rotations, [0.0, 0.0, 0.0, 1.0]]),
    )
    expected, found = mirror_map(skeleton, biped), mirror_map(armed, biped)
    assert_allclose(found.relations[:-1], expected.relations, atol=1e-9)
