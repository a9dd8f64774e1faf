"""Transfer: the rotations of a source's joints as those of a target's, in the world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.retarget.counterparts import find_counterparts
from usdfoot.retarget.frames import Frames
from usdfoot.retarget.rig import Rig

__all__ = ["pose_target", "transfer_rotations"]


@dataclass(frozen=True, kw_only=True)
class _Chain:
    """Joints of a rig that bend as one: trunk, neck or a collar."""

    joints: tuple[int, ...]
    start: int
    """The joint they hang on."""
    places: FloatArray
    """How far along the chain each joint lies, by length, the last one at 1; shape (K,)."""


def transfer_rotations(
    source: Rig, target: Rig, frames: tuple[Frames, Frames], *, turns: FloatArray
) -> dict[int, FloatArray]:
    """World rotations of the target's joints, by joint, shape (N, 4).

    Joints of legs and arms take over those of their counterparts. Joints of trunk, neck and collars take over what lies
    at their part of the chain's length, so that chains of different length bend alike.

    Args:
        source: Rig of the clips.
        target: Rig of the character.
        frames: Anatomical frames of both.
        turns: World rotations of the source's joints, shape (N, J, 4).
    """
    meaning = {joint: quaternion.compose(turns[:, joint], frame) for joint, frame in frames[0].items()}
    limbs, named = find_counterparts(source, target)
    wanted = {joint: meaning[partner] for joint, partner in (limbs | named).items()}
    for own, other in zip(_chains(source), _chains(target), strict=True):
        if own.joints:
            wanted |= _spread(own, other, meaning)
    return {
        joint: quaternion.compose(rotation, quaternion.inverse(frames[1][joint])) for joint, rotation in wanted.items()
    }


def _chains(rig: Rig) -> list[_Chain]:
    """Trunk, neck and both collars of a rig, without joints where it has none."""
    body = rig.body
    chest = body.trunk[-1] if body.trunk else rig.biped.pelvis
    collars = [() if arm is None else arm.collar for arm in body.arms]
    return [
        _chain(rig, rig.biped.pelvis, body.trunk),
        *(_chain(rig, chest, joints) for joints in (body.neck, *collars)),
    ]


def _chain(rig: Rig, start: int, joints: Sequence[int]) -> _Chain:
    lengths = np.cumsum(np.linalg.norm(np.diff(rig.reference.places[[start, *joints]], axis=0), axis=1))
    places = lengths / lengths[-1] if len(joints) and lengths[-1] > 1e-9 else np.ones(len(joints))
    return _Chain(joints=tuple(joints), start=start, places=places)


def _spread(source: _Chain, target: _Chain, meaning: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
    """Rotations (N, 4) of the target's joints, interpolated between those of the source's before and after them."""
    nodes = [meaning[joint] for joint in (source.start, *source.joints)]
    places = np.concatenate([[0.0], source.places])
    spread = {}
    for joint, place in zip(target.joints, target.places.tolist(), strict=True):
        before = int(np.searchsorted(places, place + 1e-9, side="right")) - 1
        after = min(before + 1, len(nodes) - 1)
        part = (place - places[before]) / max(places[after] - places[before], 1e-9)
        exact = part < 1e-6
        spread[joint] = nodes[before] if exact else quaternion.slerp(nodes[before], nodes[after], np.array(part))
    return spread


def pose_target(
    target: Rig, wanted: dict[int, FloatArray], pelvis: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The target posed: joint-local rotations (N, J, 4), world positions [m] (N, J, 3) and rotations (N, J, 4).

    Joints without a wanted rotation keep the rest pose.

    Args:
        target: Rig of the character.
        wanted: World rotations by joint, shape (N, 4).
        pelvis: Pelvis joint in the world [m], shape (N, 3).
    """
    skeleton = target.skeleton
    local = np.repeat(skeleton.rest_rotations[None], len(pelvis), axis=0)
    places = np.repeat(skeleton.rest_translations[None], len(pelvis), axis=0)
    turns = local.copy()
    for joint, parent in enumerate(skeleton.parents.tolist()):
        above = turns[:, parent] if parent >= 0 else None
        if joint in wanted:
            turns[:, joint] = wanted[joint]
            undo = np.array([0.0, 0.0, 0.0, 1.0]) if above is None else quaternion.inverse(above)
            local[:, joint] = quaternion.compose(undo, wanted[joint])
        elif above is not None:
            turns[:, joint] = quaternion.compose(above, local[:, joint])
        if joint == target.biped.pelvis:
            places[:, joint] = pelvis
        elif above is not None:
            places[:, joint] = places[:, parent] + quaternion.rotate(above, places[:, joint])
    return local, places, turns
