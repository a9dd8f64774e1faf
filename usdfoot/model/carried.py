"""Carried: joints beside the body that go along with the one of its joints in whose place they rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["CarriedJoints", "find_carried"]

SAME_PLACE = 1e-3
"""Joints that rest nearer to each other than this part of the leg are in one place."""


@dataclass(frozen=True, kw_only=True)
class CarriedJoints:
    """C joints that are neither above nor below the pelvis, as Unreal's ik_foot_l, and what carries each: foot_l."""

    joints: IntArray
    """Parents first, shape (C,)."""
    carriers: IntArray
    """Joint of the body in whose place each rests, shape (C,)."""
    offsets: FloatArray
    """From the carrier to the joint, in the carrier's axes [m], shape (C, 3)."""
    turns: FloatArray
    """Rotation of the joint in the carrier's axes, shape (C, 4)."""
    parents: IntArray
    """Of all joints of the skeleton, shape (J,)."""
    chain: tuple[int, ...]
    """The joints that tell where the carried ones are, with these, parents and carriers first."""

    def carry(self, translations: FloatArray, rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where poses carry the joints.

        Args:
            translations: Joint-local [m], shape (N, J, 3).
            rotations: Joint-local, shape (N, J, 4).

        Returns:
            Joint-local translations [m] (N, C, 3) and rotations (N, C, 4) of the carried joints.
        """
        rows = {joint: row for row, joint in enumerate(self.joints.tolist())}
        places, turns = {-1: np.zeros(3)}, {-1: np.array([0.0, 0.0, 0.0, 1.0])}
        moved = np.empty((len(translations), len(rows), 3))
        turned = np.empty((len(rotations), len(rows), 4))
        for joint in self.chain:
            parent, row = int(self.parents[joint]), rows.get(joint)
            if row is None:
                turns[joint] = quaternion.compose(turns[parent], rotations[:, joint])
                places[joint] = places[parent] + quaternion.rotate(turns[parent], translations[:, joint])
                continue
            carrier, back = int(self.carriers[row]), quaternion.inverse(turns[parent])
            turns[joint] = quaternion.compose(turns[carrier], self.turns[row])
            places[joint] = places[carrier] + quaternion.rotate(turns[carrier], self.offsets[row])
            moved[:, row] = quaternion.rotate(back, places[joint] - places[parent])
            turned[:, row] = quaternion.compose(back, turns[joint])
        return moved, turned


def find_carried(skeleton: Skeleton, biped: Biped) -> CarriedJoints:
    """The joints that a skeleton's body carries, each by the first joint of the body in its place."""
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    above = {biped.pelvis, *skeleton.ancestors(biped.pelvis)}
    below = np.array([biped.pelvis in (joint, *skeleton.ancestors(joint)) for joint in range(len(places))])
    beside = [joint for joint in np.flatnonzero(~below).tolist() if joint not in above]
    body = np.flatnonzero(below)
    together = np.linalg.norm(places[beside][:, None] - places[body], axis=-1) < SAME_PLACE * biped.maximal_leg_length
    has_carrier = together.any(axis=1)
    joints = np.array(beside, dtype=np.intp)[has_carrier]
    carriers = body[np.argmax(together[has_carrier], axis=1)]
    asked = {joint for end in (*joints.tolist(), *carriers.tolist()) for joint in (end, *skeleton.ancestors(end))}
    undo = quaternion.inverse(turns[carriers])
    return CarriedJoints(
        joints=joints,
        carriers=carriers,
        offsets=quaternion.rotate(undo, places[joints] - places[carriers]),
        turns=quaternion.compose(undo, turns[joints]),
        parents=skeleton.parents,
        chain=tuple(sorted(asked, key=lambda joint: (joint in beside, joint))),
    )
