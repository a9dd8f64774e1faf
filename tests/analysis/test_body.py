"""Trunk, neck and arms are found whatever the joints are called."""

from dataclasses import replace

import numpy as np
import pytest

from usdfoot.analysis.biped import find_biped, make_biped
from usdfoot.analysis.body import find_body
from usdfoot.model.skeleton import Skeleton, forward_kinematics

LEG = ((0.1, -0.05, 0.0), (0.0, -0.42, 0.0), (0.0, -0.4, 0.0), (0.0, -0.06, 0.14))
ARM = ((0.04, 0.1, 0.0), (0.14, 0.0, 0.0), (0.28, 0.0, 0.0), (0.25, 0.0, 0.0), (0.09, 0.0, 0.0))
SPINE = ((0.0, 1.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.15, 0.0), (0.0, 0.15, 0.0), (0.0, 0.15, 0.0), (0.0, 0.1, 0.0))
"""Pelvis, three joints of the spine, neck and head."""

STYLES = {
    "mixamo": (
        [f"mixamorig:{name}" for name in ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")],
        ["mixamorig:{Left}Shoulder", "mixamorig:{Left}Arm", "mixamorig:{Left}ForeArm", "mixamorig:{Left}Hand",
         "mixamorig:{Left}HandMiddle1"],
        ["mixamorig:{Left}UpLeg", "mixamorig:{Left}Leg", "mixamorig:{Left}Foot", "mixamorig:{Left}ToeBase"],
    ),
    "unreal": (
        ["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"],
        ["clavicle_{l}", "upperarm_{l}", "lowerarm_{l}", "hand_{l}", "middle_01_{l}"],
        ["thigh_{l}", "calf_{l}", "foot_{l}", "ball_{l}"],
    ),
    "max": (
        ["Bip01 Pelvis", "Bip01 Spine", "Bip01 Spine1", "Bip01 Spine2", "Bip01 Neck", "Bip01 Head"],
        ["Bip01 {L} Clavicle", "Bip01 {L} UpperArm", "Bip01 {L} Forearm", "Bip01 {L} Hand", "Bip01 {L} Finger0"],
        ["Bip01 {L} Thigh", "Bip01 {L} Calf", "Bip01 {L} Foot", "Bip01 {L} Toe0"],
    ),
    "bip001 in usd": (
        [f"Bip001_{name}" for name in ("Pelvis", "Spine", "Spine1", "Spine2", "Neck", "Head")],
        [f"Bip001_{{L}}_{name}" for name in ("Clavicle", "UpperArm", "Forearm", "Hand", "Finger0")],
        [f"Bip001_{{L}}_{name}" for name in ("Thigh", "Calf", "Foot", "Toe0")],
    ),
    "rigify": (
        ["DEF-spine", "DEF-spine.001", "DEF-spine.002", "DEF-spine.003", "DEF-neck", "DEF-head"],
        ["DEF-shoulder.{L}", "DEF-upper_arm.{L}", "DEF-forearm.{L}", "DEF-hand.{L}", "DEF-f_middle.01.{L}"],
        ["DEF-thigh.{L}", "DEF-shin.{L}", "DEF-foot.{L}", "DEF-toe.{L}"],
    ),
    "smpl": (
        ["Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Head"],
        ["{L}_Collar", "{L}_Shoulder", "{L}_Elbow", "{L}_Wrist", "{L}_Hand"],
        ["{L}_Hip", "{L}_Knee", "{L}_Ankle", "{L}_Foot"],
    ),
    "cmu": (
        ["root", "lowerback", "upperback", "thorax", "lowerneck", "head"],
        ["{l}clavicle", "{l}humerus", "{l}radius", "{l}wrist", "{l}hand"],
        ["{l}femur", "{l}tibia", "{l}foot", "{l}toes"],
    ),
    "humanik": (
        ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"],
        ["{Left}Shoulder", "{Left}Arm", "{Left}ForeArm", "{Left}Hand", "{Left}HandMiddle1"],
        ["{Left}UpLeg", "{Left}Leg", "{Left}Foot", "{Left}ToeBase"],
    ),
    "vrm": (
        [f"J_Bip_C_{name}" for name in ("Hips", "Spine", "Chest", "UpperChest", "Neck", "Head")],
        [f"J_Bip_{{L}}_{name}" for name in ("Shoulder", "UpperArm", "LowerArm", "Hand", "Middle1")],
        [f"J_Bip_{{L}}_{name}" for name in ("UpperLeg", "LowerLeg", "Foot", "ToeBase")],
    ),
    "daz": (
        ["hip", "abdomenLower", "abdomenUpper", "chestLower", "neckLower", "head"],
        ["{l}Collar", "{l}ShldrBend", "{l}ForearmBend", "{l}Hand", "{l}Mid1"],
        ["{l}ThighBend", "{l}Shin", "{l}Foot", "{l}Toe"],
    ),
    "character creator": (
        [f"CC_Base_{name}" for name in ("Hip", "Waist", "Spine01", "Spine02", "NeckTwist01", "Head")],
        [f"CC_Base_{{L}}_{name}" for name in ("Clavicle", "Upperarm", "Forearm", "Hand", "Mid1")],
        [f"CC_Base_{{L}}_{name}" for name in ("Thigh", "Calf", "Foot", "ToeBase")],
    ),
    "cat": (
        [f"Base Human{name}" for name in ("Pelvis", "Spine1", "Spine2", "Ribcage", "Neck", "Head")],
        [f"Base Human{{L}}Arm{name}" for name in ("Collarbone", "1", "2", "Palm", "Digit11")],
        [f"Base Human{{L}}Leg{name}" for name in ("1", "2", "Ankle", "Digit11")],
    ),
    "cat by hand": (
        [f"CATRig{name}" for name in ("Hub001", "Spine1", "Spine2", "Hub002", "Spine3", "Hub003")],
        [f"CATRig{{L}}Arm{name}" for name in ("Collarbone", "Upperarm", "Forearm", "Palm", "Digit11")],
        [f"CATRig{{L}}Leg{name}" for name in ("Thigh", "Calf", "Ankle", "Digit11")],
    ),
    "auto-rig": (
        ["root.x", "spine_01.x", "spine_02.x", "spine_03.x", "neck.x", "head.x"],
        ["shoulder.{l}", "arm_stretch.{l}", "forearm_stretch.{l}", "hand.{l}", "middle1.{l}"],
        ["thigh_stretch.{l}", "leg_stretch.{l}", "foot.{l}", "toes_01.{l}"],
    ),
    "advanced skeleton": (
        [f"{name}_M" for name in ("Root", "Spine1", "Spine2", "Chest", "Neck", "Head")],
        [f"{name}_{{L}}" for name in ("Scapula", "Shoulder", "Elbow", "Wrist", "MiddleFinger1")],
        [f"{name}_{{L}}" for name in ("Hip", "Knee", "Ankle", "Toes")],
    ),
    "nonsense": (
        ["a", "b", "c", "d", "e", "f"],
        ["g{L}", "h{L}", "i{L}", "j{L}", "k{L}"],
        ["m{L}", "n{L}", "o{L}", "p{L}"],
    ),
}  # fmt: skip


def sided(name, side):
    words = (("Left", "Right"), ("left", "right"), ("L", "R"), ("l", "r"))
    for pair in words:
        name = name.replace("{" + pair[0] + "}", pair[side])
    return name


def build(style, *, arms_on=3, legs_on=0, between=()):
    """A rig, its spine from pelvis to head, its arms; legs hang on joints `between` below a joint of the spine."""
    spine, arm, leg = STYLES[style]
    joints, parents, offsets = [], [], []

    def add(name, parent, offset):
        joints.append(f"{joints[parent]}/{name}" if parent >= 0 else name)
        parents.append(parent)
        offsets.append(offset)
        return len(joints) - 1

    chain = [-1]
    for name, offset in zip(spine, SPINE, strict=True):
        chain.append(add(name, chain[-1], offset))
    arms = []
    below = chain[1 + legs_on]
    for name in between:
        below = add(name, below, (0.0, 0.0, 0.0))
    for side, sign in ((0, 1.0), (1, -1.0)):
        for names, limb, start in ((arm, ARM, chain[1 + arms_on]), (leg, LEG, below)):
            above = start
            for name, (x, y, z) in zip(names, limb, strict=True):
                above = add(sided(name, side), above, (sign * x, y, z))
                if names is arm:
                    arms.append(above)
    skeleton = Skeleton(
        name="/Rig",
        joints=tuple(joints),
        parents=np.array(parents),
        rest_translations=np.array(offsets),
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(joints), 1)),
    )
    return skeleton, tuple(chain[1:]), (arms[:5], arms[5:])


def found(skeleton):
    biped = make_biped(skeleton, find_biped(skeleton, {}), {})
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    return biped, find_body(skeleton, biped, places)


@pytest.mark.parametrize("style", STYLES)
def test_every_naming_is_understood(style):
    skeleton, spine, arms = build(style)
    biped, body = found(skeleton)
    assert biped.pelvis == spine[0]
    assert body.trunk == spine[1:4] and body.neck == spine[4:]
    for arm, expected in zip(body.arms, arms, strict=True):
        assert (arm.upper, arm.lower, arm.hand) == tuple(expected[1:4])
        assert arm.collar == (expected[0],)


@pytest.mark.parametrize("style", ["max", "bip001 in usd"])
def test_3ds_max_hangs_collars_on_the_neck_and_thighs_on_the_spine(style):
    skeleton, spine, arms = build(style, arms_on=4, legs_on=1)
    biped, body = found(skeleton)
    assert biped.pelvis == spine[0]
    assert body.trunk == spine[1:4] and body.neck == spine[4:]
    assert [arm.collar for arm in body.arms] == [(arms[0][0],), (arms[1][0],)]


def test_thighs_on_the_spine_leave_it_a_spine_without_names():
    skeleton, spine, arms = build("nonsense", legs_on=1)
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    legs = find_biped(skeleton, {})
    biped = make_biped(skeleton, legs | {"pelvis": spine[0]}, {})
    body = find_body(skeleton, biped, places)
    assert body.trunk == spine[1:4] and body.neck == spine[4:]
    assert [arm.upper for arm in body.arms] == [arms[0][1], arms[1][1]]


@pytest.mark.parametrize(("style", "joint"), [("daz", "pelvis"), ("character creator", "CC_Base_Pelvis")])
def test_a_pelvis_of_the_legs_alone_does_not_carry_the_body(style, joint):
    skeleton, spine, _ = build(style, between=(joint,))
    biped, body = found(skeleton)
    assert biped.pelvis == spine[0]
    assert body.trunk == spine[1:4] and body.neck == spine[4:]


@pytest.mark.parametrize("name", ["Bip01 Tail", "tail_01", "DEF-tail"])
def test_tails_that_hang_are_known_by_name(name):
    skeleton, spine, _ = build("max")
    longer = replace(
        skeleton,
        joints=(*skeleton.joints, f"{skeleton.joints[spine[0]]}/{name}", f"{skeleton.joints[spine[0]]}/{name}/{name}1"),
        parents=np.append(skeleton.parents, [spine[0], len(skeleton.joints)]),
        rest_translations=np.vstack([skeleton.rest_translations, [[0.0, -0.1, -0.1], [0.0, -0.4, -0.1]]]),
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(skeleton.joints) + 2, 1)),
    )
    _, body = found(longer)
    assert body.tail == (len(skeleton.joints), len(skeleton.joints) + 1)
    assert body.trunk == spine[1:4]


def test_arms_in_halves_are_known_by_name():
    skeleton, _, arms = build("rigify")
    joints, parents, offsets = list(skeleton.joints), list(skeleton.parents), skeleton.rest_translations.copy()
    for arm in arms:  # each upper arm and forearm gets a second half, on which the rest of the arm hangs
        for joint, below in ((arm[1], arm[2]), (arm[2], arm[3])):
            joints.append(f"{joints[joint]}.001")
            offsets = np.vstack([offsets, 0.5 * offsets[below]])
            parents.append(joint)
            parents[below] = len(joints) - 1
            offsets[below] *= 0.5
    order = sorted(range(len(joints)), key=lambda joint: depth(parents, joint))
    place = {joint: at for at, joint in enumerate(order)}
    halved = Skeleton(
        name="/Rig",
        joints=tuple(joints[joint] for joint in order),
        parents=np.array([place.get(parents[joint], -1) for joint in order]),
        rest_translations=offsets[order],
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(joints), 1)),
    )
    _, body = found(halved)
    for arm, expected in zip(body.arms, arms, strict=True):
        assert (arm.upper, arm.lower, arm.hand) == tuple(place[joint] for joint in expected[1:4])


def depth(parents, joint):
    return 0 if parents[joint] < 0 else 1 + depth(parents, parents[joint])
