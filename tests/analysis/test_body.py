"""Trunk, neck and arms are found whatever the joints are called."""

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


def build(style, *, collars_on_neck=False):
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
    for side, sign in ((0, 1.0), (1, -1.0)):
        for names, limb, start in ((arm, ARM, chain[5 if collars_on_neck else 4]), (leg, LEG, chain[1])):
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
    return skeleton, chain[1:], (arms[:5], arms[5:])


@pytest.mark.parametrize("style", STYLES)
def test_every_naming_is_understood(style):
    skeleton, spine, arms = build(style)
    biped = make_biped(skeleton, find_biped(skeleton, {}), {})
    body = find_body(
        skeleton, biped, forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)[0]
    )
    assert body.trunk == tuple(spine[1:4])
    assert body.neck == tuple(spine[4:])
    for arm, expected in zip(body.arms, arms, strict=True):
        assert (arm.upper, arm.lower, arm.hand) == tuple(expected[1:4])
        assert arm.collar == (expected[0],)


def test_collars_on_the_neck_leave_the_neck_a_neck():
    skeleton, spine, arms = build("max", collars_on_neck=True)
    biped = make_biped(skeleton, find_biped(skeleton, {}), {})
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    body = find_body(skeleton, biped, places)
    assert body.trunk == tuple(spine[1:4]) and body.neck == tuple(spine[4:])
    assert [arm.collar for arm in body.arms] == [(arms[0][0],), (arms[1][0],)]
