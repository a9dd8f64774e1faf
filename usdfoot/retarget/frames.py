"""Frames: what the axes of two rigs' joints mean, so that rotations of one say something about the other.

A joint's anatomical frame is fixed in the joint. Two joints that play the same part in two bodies have the same
anatomical frame in the world when the bodies are in the same pose, whatever axes and rest poses the rigs have.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.retarget.counterparts import find_counterparts
from usdfoot.retarget.evidence import Evidence
from usdfoot.retarget.limb_frames import arm_frames, foot_frames, frame_of_axes, leg_frames
from usdfoot.retarget.rig import Rig

__all__ = ["Frames", "build_frames"]

Frames = Mapping[int, FloatArray]
"""By joint: rotation from the anatomical frame to the joint's own, shape (4,)."""

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
PLACEMENT = np.radians(15.0)
"""Rigs place the joints of trunk and neck differently by up to this; what exceeds it is posture [rad]."""


def build_frames(source: Rig, target: Rig, evidence: Evidence) -> tuple[Frames, Frames]:
    """Anatomical frames of the source's and the target's joints that have a place in their bodies.

    Args:
        source: Rig of the clips.
        target: Rig of the character.
        evidence: What the clips tell of the source.
    """
    trunk, neck = _postures(source, target)
    worlds = (_upper_body(source, trunk, neck), _upper_body(target, IDENTITY, IDENTITY))
    for side in (0, 1):
        parts = [leg_frames(source, target, evidence, side=side), foot_frames(source, target, evidence, side=side)]
        if source.body.arms[side] is not None and target.body.arms[side] is not None:
            parts.append(arm_frames(source, target, evidence, side=side))
        for found in parts:
            for own, more in zip(worlds, found, strict=True):
                own |= more
    for joint, partner in find_counterparts(source, target)[1].items():  # parents first; at rest they are alike
        worlds[0][partner] = worlds[0][int(source.skeleton.parents[partner])]
        worlds[1][joint] = worlds[1][int(target.skeleton.parents[joint])]
    frames = [
        {joint: quaternion.compose(quaternion.inverse(rig.turn(joint)), frame) for joint, frame in own.items()}
        for rig, own in zip((source, target), worlds, strict=True)
    ]
    return frames[0], frames[1]


def _upper_body(rig: Rig, trunk: FloatArray, neck: FloatArray) -> dict[int, FloatArray]:
    """Frames of pelvis, trunk, collars, neck and head in the reference pose, which leans by these rotations (4,)."""
    across = rig.direction(rig.biped.hips[1], rig.biped.hips[0])
    collars = [joint for arm in rig.body.arms if arm is not None for joint in arm.collar]
    frames = {rig.biped.pelvis: frame_of_axes(np.array([0.0, 1.0, 0.0]), across, keep="x")}
    frames |= {joint: trunk for joint in (*rig.body.trunk, *collars)}
    return frames | {joint: neck for joint in rig.body.neck}


def _postures(source: Rig, target: Rig) -> tuple[FloatArray, FloatArray]:
    """How trunk and neck of the source's reference pose lean against the target's, shape (4,) each."""
    trunk = _lean(_trunk_direction(source), _trunk_direction(target))
    necks = [_neck_direction(rig) for rig in (source, target)]
    upright = quaternion.rotate(quaternion.inverse(trunk), necks[0])
    return trunk, quaternion.compose(trunk, _lean(upright, necks[1]))


def _trunk_direction(rig: Rig) -> FloatArray:
    """From between the hips to between the shoulders in the reference pose, shape (3,); zero without arms."""
    left, right = rig.body.arms
    if left is None or right is None:
        return np.zeros(3)
    hips = rig.reference.places[list(rig.biped.hips)].mean(axis=0)
    way = 0.5 * (rig.place(left.upper) + rig.place(right.upper)) - hips
    return way / max(float(np.linalg.norm(way)), 1e-12)


def _neck_direction(rig: Rig) -> FloatArray:
    """From the begin of the neck to the head, shape (3,); zero where the neck is one joint."""
    return rig.direction(rig.body.neck[0], rig.body.neck[-1]) if rig.body.neck else np.zeros(3)


def _lean(own: FloatArray, other: FloatArray) -> FloatArray:
    """Rotation of `own` (3,) against `other` (3,) less what may be the placement of joints, shape (4,)."""
    if not own.any() or not other.any():
        return IDENTITY
    vector = quaternion.to_rotation_vector(quaternion.between(other, own))
    angle = float(np.linalg.norm(vector))
    return quaternion.from_rotation_vector(vector * max(angle - PLACEMENT, 0.0) / max(angle, 1e-12))
