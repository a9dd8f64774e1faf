"""Legs are found by the names of every usual rig, by authored joints, and by shape."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.analysis.biped import find_biped, make_biped
from usdfoot.analysis.feet import ball_height_of_foot
from usdfoot.errors import BipedError
from usdfoot.model.skeleton import Skeleton
from usdfoot.readers.joints import leaf_name, parent_indices

LEFT_LEG = np.array([(0.1, -0.05, 0.0), (0.0, -0.42, 0.0), (0.0, -0.4, 0.0), (0.0, -0.08, 0.12)])
HELPER = (0.0, -0.1, 0.02)

# For each rig: joints above the legs, the left leg (more than four names: with helpers), right leg, other joints.
RIGS = {
    "mixamo": (
        ["mixamorig:Hips"],
        ["mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot", "mixamorig:LeftToeBase"],
    ),
    "mixamo in blender": (
        ["mixamorig_Hips"],
        ["mixamorig_LeftUpLeg", "mixamorig_LeftLeg", "mixamorig_LeftFoot", "mixamorig_LeftToeBase"],
    ),
    "humanik": (["Reference", "Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"]),
    "cmu": (["root"], ["lfemur", "ltibia", "lfoot", "ltoes"]),
    "bvh": (["Hips"], ["LeftHip", "LeftKnee", "LeftAnkle", "LeftToe"]),
    "unreal": (["root", "pelvis"], ["thigh_l", "calf_l", "foot_l", "ball_l"]),
    "unity": (["Hips"], ["LeftUpperLeg", "LeftLowerLeg", "LeftFoot", "LeftToes"]),
    "vroid": (
        ["Root", "J_Bip_C_Hips"],
        ["J_Bip_L_UpperLeg", "J_Bip_L_LowerLeg", "J_Bip_L_Foot", "J_Bip_L_ToeBase"],
    ),
    "blender": (["hips"], ["thigh_L", "shin_L", "foot_L", "toe_L"]),
    "blender dotted": (["hips"], ["thigh.L", "shin.L", "foot.L", "toe.L"]),
    "bandai": (["joint_Root", "Hips"], ["UpperLeg_L", "LowerLeg_L", "Foot_L", "Toes_L"]),
    "kaykit": (["root", "hips"], ["upperleg_l", "lowerleg_l", "foot_l", "toes_l"]),
    "animlab": (["Root", "Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToe"]),
    "biped": (["Bip01", "Bip01 Pelvis"], ["Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 L Toe0"]),
    "biped in usd": (["Bip01", "Bip01_Pelvis"], ["Bip01_L_Thigh", "Bip01_L_Calf", "Bip01_L_Foot", "Bip01_L_Toe0"]),
    "smpl": (["Pelvis"], ["L_Hip", "L_Knee", "L_Ankle", "L_Foot"]),
    "smpl in maya": (
        ["m_avg_root", "m_avg_Pelvis"],
        ["m_avg_L_Hip", "m_avg_L_Knee", "m_avg_L_Ankle", "m_avg_L_Foot"],
    ),
    "valve": (
        ["ValveBiped.Bip01", "ValveBiped.Bip01_Pelvis"],
        [f"ValveBiped.Bip01_L_{name}" for name in ("Thigh", "Calf", "Foot", "Toe0")],
    ),
    "arkit": (["root", "hips_joint"], [f"left_{name}_joint" for name in ("upLeg", "leg", "foot", "toes")]),
    "advanced skeleton": (["Root_M"], ["Hip_L", "Knee_L", "Ankle_L", "Toes_L"]),
    "character creator": (
        ["CC_Base_Hip"],
        ["CC_Base_L_Thigh", "CC_Base_L_Calf", "CC_Base_L_Foot", "CC_Base_L_ToeBase"],
    ),
    "openusd": (["Hips"], ["LLeg", "LKnee", "LFoot", "LToes"]),
    "kinect": (["HipCenter"], ["HipLeft", "KneeLeft", "AnkleLeft", "FootLeft"]),
    "xsens": (["Pelvis"], ["LeftUpperLeg", "LeftLowerLeg", "LeftFoot", "LeftToe"]),
}


LEFT_FOOT = "LeftUpLeg/LeftLeg/LeftFoot"


def right_of(name):
    """The right-hand name of a left-hand one."""
    for left, right in (("Left", "Right"), ("left", "right")):
        if left in name:
            return name.replace(left, right)
    words = {"_L_": "_R_", " L ": " R ", "_L": "_R", ".L": ".R", "_l": "_r"}
    for left, right in words.items():
        if left in name and (
            left.endswith(("_", " ")) or name.endswith(left) or f"{left}_" in name or f"{left}." in name
        ):
            return name.replace(left, right)
    if name.startswith(("l", "L")):
        return ("r" if name[0] == "l" else "R") + name[1:]
    raise AssertionError(name)


def make_skeleton(joints, offsets):
    return Skeleton(
        name="/Rig",
        joints=tuple(joints),
        parents=parent_indices(joints),
        rest_translations=np.array(offsets, dtype=float),
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(joints), 1)),
    )


def rig(above, leg, extra=()):
    """A skeleton with both legs; extra = (path below the pelvis without leading slash, offset)."""
    joints, offsets = [], []
    for i in range(len(above)):
        joints.append("/".join(above[: i + 1]))
        offsets.append((0.0, 1.0 if i == len(above) - 1 else 0.0, 0.0))
    pelvis = joints[-1]
    for sign, rename in ((1.0, str), (-1.0, right_of)):
        for i in range(len(leg)):
            joints.append("/".join([pelvis, *(rename(name) for name in leg[: i + 1])]))
            offsets.append(LEFT_LEG[i] * (sign, 1.0, 1.0))
    for path, offset in extra:
        joints.append(f"{pelvis}/{path}")
        offsets.append(offset)
    joints.append(f"{pelvis}/Spine")
    offsets.append((0.0, 0.3, 0.0))
    return make_skeleton(joints, offsets)


def names_found(skeleton, authored=None):
    roles = find_biped(skeleton, authored or {})
    return {role: leaf_name(skeleton.joints[joint]) for role, joint in roles.items()}


@pytest.mark.parametrize("name", RIGS)
def test_usual_names_are_known(name):
    above, leg = RIGS[name]
    found = names_found(rig(above, leg))
    assert found["pelvis"] == above[-1]
    assert [found[f"left {role}"] for role in ("hip", "knee", "ankle", "ball")] == leg
    assert [found[f"right {role}"] for role in ("hip", "knee", "ankle", "ball")] == [right_of(name) for name in leg]


def test_controls_and_twist_joints_do_not_win():
    extra = [
        ("thigh_l/thigh_twist_01_l", HELPER),
        ("thigh_r/thigh_twist_01_r", HELPER),
        ("ik_foot_root/ik_foot_l", HELPER),
        ("ik_foot_root/ik_foot_r", HELPER),
        ("kneeIK_l", HELPER),
        ("control_toe_roll_l/control_foot_roll_l", HELPER),
    ]
    found = names_found(rig(["root", "pelvis"], ["thigh_l", "calf_l", "foot_l", "ball_l"], extra))
    assert [found[f"left {role}"] for role in ("hip", "knee", "ankle", "ball")] == [
        "thigh_l",
        "calf_l",
        "foot_l",
        "ball_l",
    ]


def test_rigify_deform_joints_win_over_their_second_halves_and_mechanism():
    joints, offsets = ["DEF-spine"], [(0.0, 1.0, 0.0)]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        path = "DEF-spine"
        for name, offset in (
            ("DEF-thigh", (0.1 * sign, -0.05, 0)),
            ("DEF-thigh.{}.001", (0, -0.2, 0)),
            ("DEF-shin", (0, -0.22, 0)),
            ("DEF-shin.{}.001", (0, -0.2, 0)),
            ("DEF-foot", (0, -0.2, 0)),
            ("DEF-toe", (0, -0.08, 0.12)),
        ):
            path += "/" + (name.format(side) if "{}" in name else f"{name}.{side}")
            joints.append(path)
            offsets.append(offset)
        joints += [
            f"DEF-spine/ORG-thigh.{side}",
            f"DEF-spine/ORG-thigh.{side}/ORG-shin.{side}",
            f"DEF-spine/MCH-foot.{side}",
        ]
        offsets += [HELPER] * 3
    found = names_found(make_skeleton(joints, offsets))
    assert [found[f"left {role}"] for role in ("hip", "knee", "ankle", "ball")] == [
        "DEF-thigh.L",
        "DEF-shin.L",
        "DEF-foot.L",
        "DEF-toe.L",
    ]


def test_an_extra_hip_joint_is_not_the_thigh():
    joints = ["Hips"]
    offsets = [(0.0, 1.0, 0.0)]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        path = f"Hips/{side[0]}HipJoint"
        joints.append(path)
        offsets.append((0.0, 0.0, 0.0))
        for name, offset in zip(("UpLeg", "Leg", "Foot", "ToeBase"), LEFT_LEG, strict=True):
            path += f"/{side}{name}"
            joints.append(path)
            offsets.append(offset * (sign, 1.0, 1.0))
    found = names_found(make_skeleton(joints, offsets))
    assert found["left hip"] == "LeftUpLeg"
    assert found["pelvis"] == "Hips"


@pytest.mark.parametrize(
    ("above", "pelvis"), [("Bip01 Pelvis", "Bip01 Pelvis"), ("Carrier", "Spine0"), ("Hips_ctrl", "Spine0")]
)
def test_thighs_below_the_spine_hang_on_the_pelvis_above(above, pelvis):
    leg = ["Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 L Toe0"]
    assert names_found(rig(["Bip01", above, "Spine0"], leg))["pelvis"] == pelvis


@pytest.mark.parametrize("name", ["LeftFootThumb1", "LeftFoot_End", "LeftFootNub"])
def test_a_ball_of_an_unknown_name_is_the_joint_that_reaches_farthest(name):
    """A foot that has no toes ends in its own end joint; a control is neither."""
    beside = [(f"{path}/{side}HeelIK", HELPER) for side, path in (("Left", LEFT_FOOT), ("Right", right_of(LEFT_FOOT)))]
    found = names_found(rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", name], beside))
    assert (found["left ball"], found["right ball"]) == (name, right_of(name))


@pytest.mark.parametrize("facing", [0.0, 90.0, 180.0])
def test_legs_without_names_are_found_by_shape(facing):
    plain = rig(["a"], ["lb", "lc", "ld", "le"], [("x", (0.3, 0.3, 0)), ("y", (-0.3, 0.3, 0))])
    joints = ["/".join(f"j{hash_of(part)}" for part in joint.split("/")) for joint in plain.joints]
    angle = np.radians(facing)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    skeleton = make_skeleton(joints, plain.rest_translations @ turn.T)
    roles = find_biped(skeleton, {})
    assert [roles[f"left {role}"] for role in ("hip", "knee", "ankle", "ball")] == [1, 2, 3, 4]
    assert [roles[f"right {role}"] for role in ("hip", "knee", "ankle", "ball")] == [5, 6, 7, 8]
    assert roles["pelvis"] == 0


def test_a_heel_without_a_name_is_no_ball():
    """It lies as low as the toes, but reaches less far; taken for the ball it would turn the character round."""
    plain = rig(["a"], ["lb", "lc", "ld", "le"], [("x", (0.3, 0.3, 0)), ("y", (-0.3, 0.3, 0))])
    joints, offsets = [], []
    for joint, offset in zip(plain.joints, plain.rest_translations, strict=True):
        joints.append(joint)
        offsets.append(offset)
        if joint.endswith("d"):
            joints.append(f"{joint}/h")
            offsets.append((0.0, -0.1, -0.05))
    skeleton = make_skeleton(["/".join(f"j{hash_of(part)}" for part in joint.split("/")) for joint in joints], offsets)
    roles = find_biped(skeleton, {})
    assert [joints[roles[f"{side} ball"]][-2:] for side in ("left", "right")] == ["le", "re"]


def hash_of(name):
    """A number that tells nothing but tells names apart."""
    return sum(ord(letter) * 31**i for i, letter in enumerate(name))


def test_swapped_names_are_trusted():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    mirrored = make_skeleton(skeleton.joints, skeleton.rest_translations * (-1.0, 1.0, 1.0))
    assert find_biped(mirrored, {}) == find_biped(skeleton, {})


def test_authored_joints_count_first():
    skeleton = rig(["Root", "Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    assert names_found(skeleton, {"pelvis": 0})["pelvis"] == "Root"
    knee = skeleton.joints.index("Root/Hips/RightUpLeg/RightLeg")
    with pytest.raises(BipedError, match=r"left and right knee are the same joint: .*RightLeg. author a joint of each"):
        find_biped(skeleton, {"left knee": knee})
    with pytest.raises(BipedError, match=r"left leg: joint .*LeftLeg is not below .*LeftFoot"):
        find_biped(skeleton, {"left hip": skeleton.joints.index("Root/Hips/LeftUpLeg/LeftLeg/LeftFoot")})


def test_legs_without_length_are_named():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    kept = [not joint.endswith("/LeftFoot") for joint in skeleton.joints]
    flat = make_skeleton(skeleton.joints, skeleton.rest_translations * np.array(kept)[:, None])
    with pytest.raises(BipedError, match=r"left leg: joints .*/LeftLeg and .*/LeftFoot are on one spot at rest"):
        find_biped(flat, {})


def test_missing_roles_are_named_with_the_way_to_author_them():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot"])
    with pytest.raises(BipedError) as caught:
        find_biped(skeleton, {})
    assert caught.value.names == ("left ball", "right ball")
    assert "add a joint at the ball of each foot, or apply UsdfootBipedAPI" in str(caught.value)
    assert 'uniform token usdfoot:biped:left:ball = "<joint>"' in str(caught.value)


def test_of_one_leg_the_other_is_missing():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    kept = ["Right" not in joint for joint in skeleton.joints]
    joints = [joint for joint, is_kept in zip(skeleton.joints, kept, strict=True) if is_kept]
    with pytest.raises(BipedError) as caught:
        find_biped(make_skeleton(joints, skeleton.rest_translations[kept]), {})
    assert caught.value.names == ("right hip", "right knee", "right ankle", "right ball")


def test_joints_that_are_not_connected_are_said():
    names = ["Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase", "RightUpLeg", "RightLeg", "RightFoot"]
    with pytest.raises(BipedError, match=r"none of its joints is below another. author joints as paths .* Hips/Left"):
        find_biped(make_skeleton(names, np.eye(8, 3)), {})


def test_something_without_legs_is_no_biped():
    skeleton = make_skeleton(["Shoulder", "Shoulder/Elbow", "Shoulder/Elbow/Hand"], [(0, 1, 0), (0, 0, 1), (0, 0, 1)])
    with pytest.raises(BipedError, match="left hip, left knee, left ankle, left ball, right hip"):
        find_biped(skeleton, {})


def test_proportions_come_from_the_rest_pose():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    biped = make_biped(skeleton, find_biped(skeleton, {}), {})
    assert biped.maximal_leg_length == pytest.approx(0.82)
    assert biped.nominal_leg_length == pytest.approx(0.95 * 0.82)
    assert_allclose(biped.ball_heights, 0.05)
    assert_allclose(biped.com, (0.0, -0.05 + 0.055 * 0.82, 0.0), atol=1e-12)


def test_balls_higher_than_the_legs_are_long_are_refused():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    with pytest.raises(BipedError, match=r"its balls are 5 m above the soles, its legs 0.82 m long"):
        make_biped(skeleton, find_biped(skeleton, {}), {"ball_height:left": 5.0})


@pytest.mark.parametrize(("measure", "name"), [("maximal", "max"), ("nominal", "nominal")])
@pytest.mark.parametrize("factor", [0.01, 1.0 / 0.0254])
def test_lengths_of_legs_in_other_units_than_the_bones_are_refused(measure, name, factor):
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    with pytest.raises(BipedError, match=rf"legLength:{name} says .* m, the bones of its legs are 0.82 m"):
        make_biped(skeleton, find_biped(skeleton, {}), {"maximal": 0.82, measure: 0.8 * factor})


def test_without_a_floor_the_ball_is_a_third_of_the_foot_above_the_sole():
    skeleton = rig(["Hips"], ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"])
    hanging = make_skeleton(skeleton.joints, np.vstack([np.zeros((1, 3)), skeleton.rest_translations[1:]]))
    biped = make_biped(hanging, find_biped(hanging, {}), {})
    assert_allclose(biped.ball_heights, 0.33 * np.hypot(0.08, 0.12))


def shoe(height=0.04):
    """Points of a foot: a heel block and a toe block whose soles are level."""
    heel = [(x, y, z) for x in (-0.04, 0.04) for y in (0.0, 0.12) for z in (-0.05, 0.06)]
    toes = [(x, y, z) for x in (-0.05, 0.05) for y in (0.0, 2.0 * height) for z in (0.06, 0.2)]
    return np.array(heel + toes), np.array([0.0, 0.1, 0.0]), np.array([0.0, height, 0.13])


@given(st.floats(-0.35, 0.35), st.floats(-0.2, 0.2), st.floats(0.02, 0.08))
def test_the_sole_is_found_however_the_foot_is_posed(pitch, roll, height):
    points, ankle, ball = shoe(height)
    c, s, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    assert ball_height_of_foot(points @ turn.T, turn @ ankle, turn @ ball) == pytest.approx(height)


def test_points_that_tell_nothing_give_no_height():
    _, ankle, ball = shoe()
    assert ball_height_of_foot(np.zeros((3, 3)), ankle, ball) is None
    assert ball_height_of_foot(np.zeros((10, 3)), ankle, ball) is None
    bone = np.array([end + side for end in (ankle, ball) for side in 0.03 * np.vstack([np.zeros(3), np.eye(3)])])
    assert ball_height_of_foot(bone - [0.0, 1e-9, 0.0], ankle, ball) is None
