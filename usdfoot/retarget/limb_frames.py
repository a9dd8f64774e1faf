"""Frames of arms, legs and feet in the reference poses of two rigs: along the bones, and about the hinges."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from usdfoot.analysis.flat_feet import ahead
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.retarget.evidence import Evidence
from usdfoot.retarget.rig import Rig

__all__ = ["arm_frames", "foot_frames", "frame_of_axes", "leg_frames"]

ALIKE = np.radians(5.0)
"""Limbs whose bones differ by less in direction are in one pose, and what tells of one rig tells of the other [rad]."""
STRAIGHT = np.sin(np.radians(5.0))
"""A limb of the reference pose that is bent by less (sine) does not tell its hinge."""
COMMON_HINGE = 0.1
"""How much the usual hinge counts beside the sine of the bend: joints of straight limbs are off by as much."""


@dataclass(frozen=True, kw_only=True)
class _Limb:
    """Two bones of a limb in the reference pose of a rig."""

    rig: Rig
    joints: tuple[int, int]
    """Where they begin."""
    bones: FloatArray
    """Unit directions, shape (2, 3)."""
    usual: FloatArray
    """The axis such a limb bends about where nothing tells more, shape (3,)."""

    @property
    def bend(self) -> FloatArray:
        """Axis it is bent about, as long as the sine of the bend, shape (3,)."""
        return np.cross(self.bones[0], self.bones[1])

    def frames(self, hinge: FloatArray) -> FloatArray:
        """Frames of both bones: +Y along the bone, +X near the hinge (3,); shape (2, 4)."""
        return np.stack([frame_of_axes(bone, hinge, keep="y") for bone in self.bones])


def frame_of_axes(y: FloatArray, x: FloatArray, *, keep: str) -> FloatArray:
    """Rotation whose +Y and +X point along two unit vectors (3,), the one not kept as near as it can be; shape (4,)."""
    kept, other = (y, x) if keep == "y" else (x, y)
    other = other - (other @ kept) * kept
    other = other / max(float(np.linalg.norm(other)), 1e-12)
    y, x = (kept, other) if keep == "y" else (other, kept)
    return quaternion.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1))


def leg_frames(
    source: Rig, target: Rig, evidence: Evidence, *, side: int
) -> tuple[dict[int, FloatArray], dict[int, FloatArray]]:
    """Frames (4,) of thigh and shin by joint, of either rig. Knees of legs that hang down bend about +X."""
    limbs = []
    for rig in (source, target):
        hip, knee, ankle = rig.biped.hips[side], rig.biped.knees[side], rig.biped.ankles[side]
        bones = np.stack([rig.direction(hip, knee), rig.direction(knee, ankle)])
        usual = _swung(np.array([0.0, -1.0, 0.0]), bones[0], np.array([1.0, 0.0, 0.0]))
        limbs.append(_Limb(rig=rig, joints=(hip, knee), bones=bones, usual=usual))
    frames = _limb_frames(limbs[0], limbs[1], evidence.hinges.get(limbs[0].joints[0]))
    first, second = (dict(zip(limb.joints, own, strict=True)) for limb, own in zip(limbs, frames, strict=True))
    return first, second


def arm_frames(
    source: Rig, target: Rig, evidence: Evidence, *, side: int
) -> tuple[dict[int, FloatArray], dict[int, FloatArray]]:
    """The same of upper arm, lower arm and hand.

    Elbows of spread arms bend forward. Resting wrists are straight and not turned: palms of spread arms look down,
    those of hanging arms at the body, whatever axis the elbow has.
    """
    limbs = []
    outward = np.array([1.0 if side == 0 else -1.0, 0.0, 0.0])
    down = np.cross(outward, [0.0, 0.0, 1.0])  # up on the right, where hinges are the other way round
    for rig in (source, target):
        arm = rig.body.arms[side]
        if arm is None:
            return {}, {}
        first = rig.direction(arm.upper, arm.lower)
        second = rig.direction(arm.lower, arm.hand) if arm.hand is not None else first
        bones = np.stack([first, second if second.any() else first])
        usual = _swung(outward, first, down)
        limbs.append(_Limb(rig=rig, joints=(arm.upper, arm.lower), bones=bones, usual=usual))
    frames = _limb_frames(limbs[0], limbs[1], evidence.hinges.get(limbs[0].joints[0]))
    found = []
    for limb, own in zip(limbs, frames, strict=True):
        arm = limb.rig.body.arms[side]
        found.append(dict(zip(limb.joints, own, strict=True)))
        if arm is not None and arm.hand is not None:
            palm = _swung(outward, limb.bones[1], down)
            found[-1][arm.hand] = frame_of_axes(limb.bones[1], palm, keep="y")
    return found[0], found[1]


def _swung(start: FloatArray, end: FloatArray, axis: FloatArray) -> FloatArray:
    """An axis (3,) taken along as `start` swings to `end` (3,)."""
    return quaternion.rotate(quaternion.between(start, end), axis)


def _limb_frames(source: _Limb, target: _Limb, told: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Frames of both bones of a limb on either rig, shape (2, 4) each.

    The hinge is the axis about which the reference pose is bent. Where the source's is straight and the target's is
    bent, the clips say what it is. Limbs that are in one pose are taken to be turned alike.
    """
    cosines = np.sum(source.bones * target.bones, axis=1)
    alike = bool(np.all(cosines > np.cos(ALIKE)))
    hinges = [limb.bend + COMMON_HINGE * limb.usual for limb in (source, target)]
    bends = [float(np.linalg.norm(limb.bend)) for limb in (source, target)]
    if not alike and bends[0] < STRAIGHT <= bends[1] and told is not None and np.linalg.norm(told) > STRAIGHT:
        hinges[0] = quaternion.rotate(source.rig.turn(source.joints[0]), told)
    own = source.frames(hinges[0])
    if alike:
        return own, quaternion.compose(quaternion.between(source.bones, target.bones), own)
    return own, target.frames(hinges[1])


def foot_frames(
    source: Rig, target: Rig, evidence: Evidence, *, side: int
) -> tuple[dict[int, FloatArray], dict[int, FloatArray]]:
    """Frames (4,) of foot and toes by joint: +Y up and +Z along the foot when it is flat.

    The source's foot is flat as it stands in the clips, the target's as in the reference pose, unless both rigs' legs
    are in one pose.
    """
    legs = [(rig.biped.hips, rig.biped.knees, rig.biped.ankles, rig.biped.balls) for rig in (source, target)]
    bones = []
    flats = []
    for rig, leg in zip((source, target), legs, strict=True):
        joints = [pair[side] for pair in leg]
        bones.append(np.stack([rig.direction(*ends) for ends in pairwise(joints)]))
        turn = rig.turn(joints[2])
        offset = quaternion.rotate(quaternion.inverse(turn), rig.place(joints[3]) - rig.place(joints[2]))
        flats.append(ahead(turn, offset))
    told = evidence.flats[side]
    if np.all(np.sum(bones[0] * bones[1], axis=1) > np.cos(ALIKE)):
        flats[1] = quaternion.compose(quaternion.compose(told, quaternion.inverse(flats[0])), flats[1])
    flats[0] = told
    found = []
    for rig, leg, flat in zip((source, target), legs, flats, strict=True):
        ankle, ball = leg[2][side], leg[3][side]
        frame = quaternion.compose(rig.turn(ankle), quaternion.inverse(flat))
        found.append({ankle: frame, ball: frame})
    return found[0], found[1]
