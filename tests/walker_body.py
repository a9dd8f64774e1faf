"""The walker's body: a small biped, and the rotations of its joints by analytic inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics

THIGH, SHIN = 0.42, 0.40
HIP_WIDTH, HIP_DROP = 0.09, 0.06
ANKLE_HEIGHT, BALL_HEIGHT, BALL_FORWARD = 0.10, 0.04, 0.14
HEEL_BACK = 0.4 * float(np.hypot(BALL_FORWARD, ANKLE_HEIGHT - BALL_HEIGHT))

JOINTS = (
    ("Root", None, (0.0, 0.0, 0.0)),
    ("Root/Hips", "Root", (0.0, THIGH + SHIN + ANKLE_HEIGHT + HIP_DROP, 0.0)),
    ("Root/Hips/Spine", "Root/Hips", (0.0, 0.2, -0.02)),
    ("Root/Hips/Spine/Head", "Root/Hips/Spine", (0.0, 0.4, 0.03)),
    ("Root/Hips/Spine/LeftArm", "Root/Hips/Spine", (0.18, 0.3, 0.0)),
    ("Root/Hips/Spine/LeftArm/LeftHand", "Root/Hips/Spine/LeftArm", (0.1, -0.5, 0.0)),
    ("Root/Hips/Spine/RightArm", "Root/Hips/Spine", (-0.18, 0.3, 0.0)),
    ("Root/Hips/Spine/RightArm/RightHand", "Root/Hips/Spine/RightArm", (-0.1, -0.5, 0.0)),
    ("Root/Hips/LeftUpLeg", "Root/Hips", (HIP_WIDTH, -HIP_DROP, 0.0)),
    ("Root/Hips/LeftUpLeg/LeftLeg", "Root/Hips/LeftUpLeg", (0.0, -THIGH, 0.0)),
    ("Root/Hips/LeftUpLeg/LeftLeg/LeftFoot", "Root/Hips/LeftUpLeg/LeftLeg", (0.0, -SHIN, 0.0)),
    (
        "Root/Hips/LeftUpLeg/LeftLeg/LeftFoot/LeftToe",
        "Root/Hips/LeftUpLeg/LeftLeg/LeftFoot",
        (0.0, BALL_HEIGHT - ANKLE_HEIGHT, BALL_FORWARD),
    ),
    ("Root/Hips/RightUpLeg", "Root/Hips", (-HIP_WIDTH, -HIP_DROP, 0.0)),
    ("Root/Hips/RightUpLeg/RightLeg", "Root/Hips/RightUpLeg", (0.0, -THIGH, 0.0)),
    ("Root/Hips/RightUpLeg/RightLeg/RightFoot", "Root/Hips/RightUpLeg/RightLeg", (0.0, -SHIN, 0.0)),
    (
        "Root/Hips/RightUpLeg/RightLeg/RightFoot/RightToe",
        "Root/Hips/RightUpLeg/RightLeg/RightFoot",
        (0.0, BALL_HEIGHT - ANKLE_HEIGHT, BALL_FORWARD),
    ),
)


@dataclass(frozen=True, kw_only=True)
class FootCurves:
    """How one foot moves."""

    ankle: FloatArray
    """[m], shape (N, 3)."""
    pitch: FloatArray
    """Toes up [rad], shape (N,)."""
    yaw: FloatArray
    """[rad], shape (N,)."""


def walker_rig(*, twisted: bool = False, size: float = 1.0) -> tuple[Skeleton, Biped]:
    """Skeleton and biped of the walker.

    Args:
        twisted: Give every joint rest axes of its own, unrelated on the two sides.
        size: Factor on all lengths.
    """
    names = [name for name, _, _ in JOINTS]
    parents = np.array([-1 if parent is None else names.index(parent) for _, parent, _ in JOINTS])
    offsets = size * np.array([offset for _, _, offset in JOINTS])
    axes = np.tile([0.0, 0.0, 0.0, 1.0], (len(names), 1))
    if twisted:
        axes[1:] = quaternion.normalised(np.random.default_rng(7).normal(size=(len(names) - 1, 4)))
    above = np.where(parents < 0, 0, parents)
    inverses = np.where((parents < 0)[:, None], [0.0, 0.0, 0.0, 1.0], quaternion.inverse(axes[above]))
    skeleton = Skeleton(
        name="/Walker/Skeleton",
        joints=tuple(names),
        parents=parents,
        rest_translations=quaternion.rotate(inverses, offsets),
        rest_rotations=quaternion.compose(inverses, axes),
    )
    leaves = [name.rsplit("/", 1)[-1] for name in names]

    def pair(role: str) -> tuple[int, int]:
        return leaves.index(f"Left{role}"), leaves.index(f"Right{role}")

    biped = Biped(
        pelvis=1,
        hips=pair("UpLeg"),
        knees=pair("Leg"),
        ankles=pair("Foot"),
        balls=pair("Toe"),
        ball_heights=np.full(2, size * BALL_HEIGHT),
        com=np.zeros(3),
        nominal_leg_length=0.96 * size * (THIGH + SHIN),
        maximal_leg_length=size * (THIGH + SHIN),
    )
    return skeleton, biped


def _hips(pelvis: FloatArray, yaws: FloatArray, side: int) -> FloatArray:
    offset = np.array([HIP_WIDTH if side == 0 else -HIP_WIDTH, -HIP_DROP, 0.0])
    return pelvis + quaternion.rotate(quaternion.yaw_quaternion(yaws), np.broadcast_to(offset, pelvis.shape))


def lowered(pelvis: FloatArray, yaws: FloatArray, ankles: list[FloatArray]) -> FloatArray:
    """Pelvis lowered by one constant so that both legs always reach."""
    reach = 0.985 * (THIGH + SHIN)
    drops = []
    for side in range(2):
        across = _hips(pelvis, yaws, side) - ankles[side]
        flat = np.sum(across[:, [0, 2]] ** 2, axis=1)
        drops.append(across[:, 1] - np.sqrt(np.maximum(reach**2 - flat, 0.01)))
    return pelvis - np.array([0.0, max(0.0, float(np.max(drops))), 0.0])


def pose_walker(
    pelvis: FloatArray,
    yaws: FloatArray,
    ankles: list[FloatArray],
    *,
    feet: list[FootCurves],
    arm_swing: FloatArray,
) -> FloatArray:
    """World rotations of all joints from the plain rest pose, shape (T, J, 4)."""
    names = [name.rsplit("/", 1)[-1] for name, _, _ in JOINTS]
    body = quaternion.yaw_quaternion(yaws)
    rotations = np.repeat(body[:, None], len(names), axis=1)
    rotations[:, 0] = [0.0, 0.0, 0.0, 1.0]
    for side, label in enumerate(("Left", "Right")):
        sign = 1.0 if side == 0 else -1.0
        arm = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), sign * arm_swing)
        rotations[:, names.index(f"{label}Arm")] = quaternion.compose(body, arm)
        rotations[:, names.index(f"{label}Hand")] = quaternion.compose(body, arm)
        thigh, shin = _two_bones(_hips(pelvis, yaws, side), ankles[side], yaws)
        rotations[:, names.index(f"{label}UpLeg")] = thigh
        rotations[:, names.index(f"{label}Leg")] = shin
        tilt = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), -feet[side].pitch)
        foot = quaternion.compose(quaternion.yaw_quaternion(feet[side].yaw), tilt)
        rotations[:, names.index(f"{label}Foot")] = foot
        rotations[:, names.index(f"{label}Toe")] = foot
    return rotations


def _two_bones(hips: FloatArray, ankles: FloatArray, yaws: FloatArray) -> tuple[FloatArray, FloatArray]:
    """World rotations of thigh and shin that hang down at rest, knees forward."""
    across = ankles - hips
    distance = np.linalg.norm(across, axis=1)
    cosine = (THIGH**2 + distance**2 - SHIN**2) / (2.0 * THIGH * distance)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    lateral = quaternion.rotate(quaternion.yaw_quaternion(yaws), np.broadcast_to([1.0, 0.0, 0.0], across.shape))
    down = across / distance[:, None]
    lateral = lateral - np.sum(lateral * down, axis=1, keepdims=True) * down
    lateral = lateral / np.linalg.norm(lateral, axis=1, keepdims=True)
    forward = np.cross(lateral, -down)
    thigh = np.cos(angle)[:, None] * down + np.sin(angle)[:, None] * forward
    shin = (across - THIGH * thigh) / SHIN
    return _hanging(thigh, lateral), _hanging(shin, lateral)


def _hanging(direction: FloatArray, lateral: FloatArray) -> FloatArray:
    """Rotations that turn -Y onto `direction` and keep +X on `lateral`."""
    matrices = np.stack([lateral, -direction, np.cross(lateral, -direction)], axis=-1)
    return quaternion.from_matrix(matrices)


def walker_clip(skeleton: Skeleton, from_rest: FloatArray, pelvis: FloatArray, rate: float, start_time: float) -> Clip:
    """Joint-local clip from world rotations relative to the rest pose."""
    _, rest = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    world = quaternion.compose(from_rest, rest)
    above = np.where(skeleton.parents < 0, 0, skeleton.parents)
    inverses = np.where((skeleton.parents < 0)[:, None], [0.0, 0.0, 0.0, 1.0], quaternion.inverse(world[:, above]))
    translations = np.repeat(skeleton.rest_translations[None], len(pelvis), axis=0)
    translations[:, 1] = quaternion.rotate(inverses[:, 1], pelvis)
    return Clip(
        name="/Walker/Clips/walk",
        rate=rate,
        start_time=start_time,
        translations=translations,
        rotations=quaternion.continuous(quaternion.compose(inverses, world)),
        synthetic=True,
    )
