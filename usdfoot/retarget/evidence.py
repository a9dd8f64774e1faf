"""Evidence: what the clips of a rig tell that its rest pose does not: hinges of its limbs, how its feet stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.flat_feet import standing_turns
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.retarget.poses import WorldPoses
from usdfoot.retarget.rig import Rig

__all__ = ["Evidence", "find_evidence"]

MID_STANCE = 1.0 / 3.0
"""Part of a planted interval after which the foot is flat: before the heel rises."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What clips tell of their rig."""

    hinges: dict[int, FloatArray]
    """By joint at the begin of an upper arm or thigh: mean of (upper x lower) bone directions in that joint's frame,
    as long as the limb is bent (sine), shape (3,)."""
    flats: FloatArray
    """World rotations of the ankles with the feet flat, pointing along +Z, shape (2, 4)."""


def find_evidence(rig: Rig, poses: WorldPoses) -> Evidence:
    """Hinges and flat feet of the rig's clips."""
    body, biped = rig.body, rig.biped
    limbs = [(biped.hips[i], biped.knees[i], biped.ankles[i]) for i in (0, 1)]
    limbs += [(arm.upper, arm.lower, arm.hand) for arm in body.arms if arm is not None and arm.hand is not None]
    stances = [_stances(poses, biped.ankles[side], side) for side in (0, 1)]
    ankles, balls = list(biped.ankles), list(biped.balls)
    rest = rig.reference.turns[ankles]
    offsets = quaternion.rotate(quaternion.inverse(rest), rig.reference.places[balls] - rig.reference.places[ankles])
    return Evidence(
        hinges={limb[0]: _hinge(poses, *limb) for limb in limbs}, flats=standing_turns(rest, stances, offsets)
    )


def _hinge(poses: WorldPoses, upper: int, lower: int, end: int) -> FloatArray:
    """Mean axis about which a limb is bent, in the frame of its first joint, shape (3,)."""
    bones = np.diff(poses.places[:, [upper, lower, end]], axis=1)
    bones = bones / np.maximum(np.linalg.norm(bones, axis=-1, keepdims=True), 1e-9)
    axes = np.cross(bones[:, 0], bones[:, 1])
    return quaternion.rotate(quaternion.inverse(poses.turns[:, upper]), axes).mean(axis=0)


def _stances(poses: WorldPoses, ankle: int, side: int) -> FloatArray:
    """Rotations of an ankle in the middle of all contacts of its foot, shape (K, 4)."""
    rows = []
    for world, own in zip(poses.worlds, poses.samples, strict=True):
        foot, times = world.contacts[side], world.clip.times
        flats, liftoffs = np.maximum(foot.flat_times, times[0]), np.minimum(foot.liftoff_times, times[-1])
        middles = flats + MID_STANCE * (liftoffs - flats)
        rows.append(own.start + np.clip(np.searchsorted(times, middles), 0, len(times) - 1))
    return poses.turns[np.concatenate(rows).astype(int), ankle]
