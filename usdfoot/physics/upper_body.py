"""The body above the legs: the pose it hangs in, and how its joints answer to the steps ([P] 2.5, 2.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.body import Body, find_body
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.rhythm import SIGNALS
from usdfoot.physics.style import BodyStyle

__all__ = ["UpperBody", "build_upper_body"]

SPREAD = np.radians(15.0)
"""Arms that stand off the body by more hang down [rad]."""
HANGING = np.radians(9.0)
"""How far hanging arms stand off [rad]."""
ELBOW = np.radians(18.0)
"""Elbows of hanging arms stay bent by this [rad]."""
RUNNING_ELBOW = np.radians(65.0)
"""They bend by this more at Froude number 1 [rad]."""
COUNTER_TURN = 2.2
"""The shoulders turn against the pelvis by as much as it turns, times this less one (Murray et al. 1964: equally)."""
RISE = 0.08
"""A tail's joint stays behind by this at an upward speed of 1 m/s [rad]."""
MOST_LAGS = 8


@dataclass(frozen=True, kw_only=True)
class UpperBody:
    """Every joint of a character in the pose it hangs in, and its answers to the signals of `rhythm`."""

    local: FloatArray
    """Joint-local rotations of that pose, shape (J, 4)."""
    in_body: FloatArray
    """The joints' rotations in the body's frame, shape (J, 4)."""
    gains: FloatArray
    """Rotation vector about the body's axes for each signal [rad], shape (J, len(SIGNALS), 3)."""
    lags: IntArray
    """How many tail lags each joint is late, shape (J,)."""

    @property
    def lag_count(self) -> int:
        """Number of different lags, none included."""
        return int(self.lags.max()) + 1


def build_upper_body(skeleton: Skeleton, biped: Biped, physics: PhysicsBiped, *, style: BodyStyle) -> UpperBody:
    """The upper body of a character in a style."""
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    to_body = quaternion.compose(physics.pelvis_rotation, quaternion.inverse(turns[biped.pelvis]))
    places, turns = quaternion.rotate(to_body, places), quaternion.compose(to_body, turns)
    body = find_body(skeleton, biped, places)
    local, in_body = _hung(skeleton, body, places, turns)
    gains = np.zeros((len(skeleton.joints), len(SIGNALS), 3))
    lags = np.zeros(len(skeleton.joints), dtype=int)
    _answer_trunk(gains, body, style, upright=_is_upright(body, places, biped.pelvis))
    _answer_arms(gains, body, style, _hanging(skeleton, body, local, to_body))
    for order, joint in enumerate(body.tail):
        lags[joint] = min(order + 1, MOST_LAGS)
        share = 1.0 / len(body.tail)
        gains[joint, SIGNALS.index("stride")] = [0.0, 3.0 * share * style.tail, 0.0]
        gains[joint, SIGNALS.index("turn")] = [0.0, 1.0, 0.0]
        gains[joint, SIGNALS.index("rise")] = [-RISE * share * 3.0, 0.0, 0.0]
        gains[joint, SIGNALS.index("bob")] = [0.5 * share * style.tail, 0.0, 0.0]
    return UpperBody(local=local, in_body=in_body, gains=gains, lags=lags)


def _is_upright(body: Body, places: FloatArray, pelvis: int) -> bool:
    """Whether the trunk stands rather than lies, as those of people do."""
    across = places[body.trunk[-1]] - places[pelvis] if body.trunk else np.zeros(3)
    return bool(across[1] > abs(across[2]))


def _answer_trunk(gains: FloatArray, body: Body, style: BodyStyle, *, upright: bool) -> None:
    """Spine and neck undo what the pelvis does, so that the head goes level; upright shoulders turn against it."""
    stride, lean, bob = (SIGNALS.index(name) for name in ("stride", "lean", "bob"))
    counter = COUNTER_TURN if upright and body.neck else 1.0
    for chain, part, turned in ((body.trunk, 0.8, counter), (body.neck, 0.2, 1.0 - counter)):
        for joint in chain:
            gains[joint, stride, 1] += turned * style.turn / len(chain)
            gains[joint, lean, 2] -= part * style.sway / len(chain)
            gains[joint, bob, 0] -= part * style.pitch / len(chain)


def _hanging(skeleton: Skeleton, body: Body, local: FloatArray, to_body: FloatArray) -> float:
    """How much the arms hang down, 1 straight down, 0 level or folded like wings."""
    arms = [(arm.upper, arm.end) for arm in body.arms if arm is not None]
    if not arms:
        return 0.0
    uppers, ends = np.array(arms).T
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, local)
    along = quaternion.rotate(to_body, places[ends] - places[uppers])
    lengths = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    return float(np.clip(np.mean(-along[:, 1] / lengths), 0.0, 1.0) ** 2)


def _answer_arms(gains: FloatArray, body: Body, style: BodyStyle, hanging: float) -> None:
    """Arms that hang swing against the legs, elbows bend as they come forward."""
    stride, lean = SIGNALS.index("stride"), SIGNALS.index("lean")
    for arm, sign in zip(body.arms, (1.0, -1.0), strict=True):
        if arm is not None:
            gains[arm.upper, stride, 0] += sign * hanging * style.arms
            gains[arm.upper, lean, 2] -= 0.5 * style.sway
            gains[arm.lower, SIGNALS.index("haste"), 0] -= hanging * RUNNING_ELBOW
            gains[arm.lower, stride, 0] += 0.5 * sign * hanging * style.arms


def _hung(skeleton: Skeleton, body: Body, places: FloatArray, turns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Joint-local rotations (J, 4) with spread arms hanging, and the joints' rotations in the body's frame (J, 4)."""
    moved = np.tile([0.0, 0.0, 0.0, 1.0], (len(places), 1))
    for arm, outward in zip(body.arms, (1.0, -1.0), strict=True):
        along = places[arm.end] - places[arm.upper] if arm is not None else np.zeros(3)
        if arm is not None and outward * along[0] > np.sin(SPREAD) * np.linalg.norm(along):
            angle = np.arctan2(along[0], -along[1])  # off straight down
            hang = quaternion.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.array(outward * HANGING - angle))
            moved[arm.upper] = hang
            bent = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(-ELBOW))
            moved[arm.lower] = quaternion.compose(quaternion.compose(quaternion.inverse(hang), bent), hang)
    change = quaternion.compose(quaternion.compose(quaternion.inverse(turns), moved), turns)
    local = quaternion.compose(skeleton.rest_rotations, change)
    _, hung = forward_kinematics(skeleton.parents, skeleton.rest_translations, local)
    _, rest = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    to_body = quaternion.compose(turns[0], quaternion.inverse(rest[0]))
    return local, quaternion.compose(to_body, hung)
