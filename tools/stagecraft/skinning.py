"""Skin weights: each joint takes over from its parent across a soft plane through the joint."""

import numpy as np
from numpy.typing import NDArray

from stagecraft.rig import Rig
from stagecraft.rotation import FloatArray

INFLUENCES = 4

SOFTNESS = {
    "UpLeg": 0.075,
    "Leg": 0.055,
    "Foot": 0.03,
    "Toe": 0.028,
    "Spine": 0.07,
    "Spine1": 0.07,
    "Chest": 0.07,
    "Neck": 0.04,
    "Head": 0.03,
    "Shoulder": 0.05,
    "Arm": 0.055,
    "ForeArm": 0.04,
    "Hand": 0.022,
    "Fingers": 0.016,
}
"""Half the width of the plane's soft zone [m], by joint."""
ARMPIT = 0.9 * 0.150 + 0.43 * 1.33
"""The slanted plane 0.9 |x| + 0.43 y through the armpits: arms lie outside it, the trunk inside [m]."""


def skin_weights(points: FloatArray, rig: Rig) -> tuple[NDArray[np.int64], FloatArray]:
    """Joint indices and weights (sum 1, largest first) of `points`, shape (N, 4) each."""
    share = np.zeros((len(points), len(rig.names)))
    share[:, 0] = 1.0
    for parent in range(len(rig.names)):
        children = [joint for joint, above in enumerate(rig.parents) if above == parent]
        if children:
            taken = np.stack([_takes_over(points, rig.names[joint], rig) for joint in children], axis=1)
            taken /= np.maximum(taken.sum(axis=1, keepdims=True), 1.0)
            share[:, children] = share[:, parent, None] * taken
            share[:, parent] *= 1.0 - taken.sum(axis=1)
    order = np.argsort(-share, axis=1, kind="stable")[:, :INFLUENCES]
    weights = np.take_along_axis(share, order, axis=1)
    weights[weights < 0.004] = 0.0
    weights /= weights.sum(axis=1, keepdims=True)
    return np.where(weights > 0.0, order, 0), weights


def _takes_over(points: FloatArray, name: str, rig: Rig) -> FloatArray:
    """Part of the parent's hold that goes to the joint, 0..1, shape (N,)."""
    bare = name.removeprefix("Left").removeprefix("Right")
    sign = np.sign(rig.place(name)[0]) if bare != name else 0.0
    beyond = _ramp((points - rig.place(name)) @ _normal(name, bare, rig), SOFTNESS[bare])
    if bare == "UpLeg":
        apart = np.interp(points[:, 1], (0.80, 0.90), (0.012, 0.045))  # soft in the seat, sharp between the legs
        return beyond * _ramp(sign * points[:, 0], apart)
    arms = _ramp(np.abs(points[:, 0]) * 0.9 + points[:, 1] * 0.43 - ARMPIT, 0.048)
    if bare in ("Spine", "Spine1", "Chest"):
        return np.maximum(beyond, arms)
    if bare == "Shoulder":
        return beyond * np.maximum(arms, _ramp(points[:, 1] - 1.36, 0.06))
    if bare == "Arm":
        return beyond * arms
    return beyond


def _normal(name: str, bare: str, rig: Rig) -> FloatArray:
    """Direction in which the joint's own part lies: halfway between the bones before and after it."""
    if bare == "UpLeg":
        return np.array([0.35 * np.sign(rig.place(name)[0]), -0.94, 0.0])
    if bare == "Shoulder":
        return np.array([np.sign(rig.place(name)[0]), 0.0, 0.0])
    if bare == "Arm":
        return np.array([np.sign(rig.place(name)[0]) * 0.87, -0.5, 0.0])
    if bare == "Foot":
        return np.array([0.0, -0.8, 0.6])
    if bare == "Toe":
        return np.array([0.0, 0.0, 1.0])
    children = [
        rig.bone(other)
        for other, parent in zip(rig.names, rig.parents, strict=True)
        if parent == rig.index(name) and not other.endswith("Shoulder")
    ]
    bones = [rig.bone(name), *children[:1]]
    total = sum(bone / np.linalg.norm(bone) for bone in bones)
    return total / np.linalg.norm(total)


def _ramp(distance: FloatArray, softness: FloatArray | float) -> FloatArray:
    """Smooth step from 0 at -softness to 1 at +softness."""
    u = np.clip(0.5 + 0.5 * distance / softness, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def deform(
    points: FloatArray, joints: NDArray[np.int64], weights: FloatArray, rig: Rig, places: FloatArray, turns: FloatArray
) -> FloatArray:
    """Skinned `points` [m], shape (N, 3), with the joints at `places` (J, 3) and turned by `turns` (J, 3, 3)."""
    moved = np.zeros_like(points)
    for influence in range(joints.shape[1]):
        joint = joints[:, influence]
        offset = np.einsum("nij,nj->ni", turns[joint], points - rig.positions[joint])
        moved += weights[:, influence, None] * (places[joint] + offset)
    return moved
