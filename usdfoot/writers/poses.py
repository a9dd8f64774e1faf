"""Poses: a motion's canonical joints as they stand in the character's own skeleton, and how far they reach."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
import warp as wp

from usdfoot.bridge.scene import Character
from usdfoot.bridge.similarity import unfold_from_joints
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.carried import CarriedJoints, find_carried
from usdfoot.model.device import start_warp
from usdfoot.model.motion import Motion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.writers.extents import prim_extents
from usdfoot.writers.layers import rounded_codes
from usdfoot.writers.pose_kernels import keep_signs

__all__ = ["PosedAgent", "RestingCharacter", "pose_agents", "rest_character"]


@dataclass(frozen=True, kw_only=True)
class PosedAgent:
    """A motion as it is written, float32."""

    motion: Motion
    resting: RestingCharacter
    translations: FloatArray
    """Joint-local, in the units of the character's Skeleton, shape (F, J, 3)."""
    rotations: FloatArray
    """Joint-local unit xyzw, continuous in sign, shape (F, J, 4)."""
    extents: FloatArray
    """Box around the character in the space of the agent prim, shape (F, 2, 3)."""
    codes: FloatArray
    """Time codes of the F frames, shape (F,)."""


@dataclass(frozen=True, kw_only=True)
class RestingCharacter:
    """A character and what all its agents share."""

    character: Character
    places: FloatArray
    """Joints of the rest pose in the agent's space [m], shape (J, 3)."""
    turns: FloatArray
    """Their rotations, shape (J, 4)."""
    above: tuple[int, ...]
    """Joints above the pelvis."""
    carried: CarriedJoints
    """Joints beside the body that go along with it."""
    foot_length: float
    """Mean distance from ankle to ball [m]."""


def rest_character(character: Character) -> RestingCharacter:
    """The character with its rest pose worked out."""
    start_warp()
    skeleton, biped = character.skeleton, character.biped
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    above = skeleton.ancestors(biped.pelvis)
    across = places[list(biped.balls)] - places[list(biped.ankles)]
    return RestingCharacter(
        character=character,
        places=places,
        turns=turns,
        above=tuple(above),
        carried=find_carried(skeleton, biped),
        foot_length=float(np.linalg.norm(across, axis=1).mean()),
    )


def pose_agents(motions: Sequence[tuple[Motion, RestingCharacter]], units: StageUnits) -> Iterator[PosedAgent]:
    """Motions as they are written, those of neighbours with one character worked out together."""
    for _, group in groupby(motions, key=lambda pair: id(pair[1])):
        own = list(group)
        poses = _stacked([motion for motion, _ in own])
        translations, rotations = _skeleton_poses(poses, own[0][1])
        extents = prim_extents(own[0][1].character, translations, rotations, units=units)
        codes = rounded_codes(units.times_to_codes(np.concatenate([motion.times for motion, _ in own])))
        for (motion, resting), frames in zip(own, pairwise(poses.first.tolist()), strict=True):
            part = slice(*frames)
            yield PosedAgent(
                motion=motion,
                resting=resting,
                translations=translations[part],
                rotations=rotations[part],
                extents=extents[part],
                codes=codes[part],
            )


@dataclass(frozen=True, kw_only=True)
class _Poses:
    """Frames of A agents end to end, as in `Motion`, float32."""

    first: IntArray
    """First frame of each agent, then F, shape (A + 1,)."""
    pelvis_positions: FloatArray
    """Shape (F, 3)."""
    pelvis_rotations: FloatArray
    """Shape (F, 4)."""
    rotations: FloatArray
    """Shape (F, J, 4)."""


def _stacked(motions: Sequence[Motion]) -> _Poses:
    def joined(name: str) -> FloatArray:
        return np.concatenate([getattr(motion, name) for motion in motions], dtype=np.float32, casting="same_kind")

    return _Poses(
        first=np.concatenate([[0], np.cumsum([len(motion.times) for motion in motions])]),
        pelvis_positions=joined("pelvis_positions"),
        pelvis_rotations=joined("pelvis_rotations"),
        rotations=joined("rotations"),
    )


def _skeleton_poses(poses: _Poses, resting: RestingCharacter) -> tuple[FloatArray, FloatArray]:
    """Translations (F, J, 3) and rotations (F, J, 4) in the units and axes of the character's Skeleton.

    The pelvis goes below its ancestors, which rest, joints beside the body go along with it, all else is as the motion
    says. Only the roots differ between the agent's space and the Skeleton's by more than a scale.
    """
    character, above = resting.character, list(resting.above)
    skeleton, pelvis = character.skeleton, character.biped.pelvis
    frames = len(poses.rotations)
    rotations = poses.rotations.copy()
    rotations[:, above] = skeleton.rest_rotations[above]
    carried = resting.carried.joints
    joints = np.unique([*np.flatnonzero(skeleton.parents < 0), pelvis, *carried])
    own = int(np.searchsorted(joints, pelvis))
    moved = np.tile(skeleton.rest_translations[joints], (frames, 1, 1))
    turned = rotations[:, joints].astype(float)
    moved[:, own], turned[:, own] = _pelvis_local(poses, resting)
    if carried.size:
        local = np.tile(skeleton.rest_translations, (frames, 1, 1)), rotations.astype(float)
        local[0][:, pelvis], local[1][:, pelvis] = moved[:, own], turned[:, own]
        where = np.searchsorted(joints, carried)
        moved[:, where], turned[:, where] = resting.carried.carry(*local)
    parents = np.where(skeleton.parents[joints] < 0, -1, 0)
    moved, turned = unfold_from_joints(character.skeleton_to_agent, parents, translations=moved, rotations=turned)
    rotations[:, joints] = turned
    on_device = wp.array(rotations, dtype=wp.quatf, copy=False)
    first = wp.array(poses.first.astype(np.int32), dtype=wp.int32)
    wp.launch(keep_signs, dim=(len(poses.first) - 1, len(skeleton.joints)), inputs=[first, on_device])
    translations = np.empty((frames, len(skeleton.joints), 3), dtype=np.float32)
    scale = character.skeleton_to_agent.scale * character.inherited_scales[:, None]
    translations[:] = skeleton.rest_translations / scale
    translations[:, joints] = moved / character.inherited_scales[joints, None]
    return translations, on_device.numpy()


def _pelvis_local(poses: _Poses, resting: RestingCharacter) -> tuple[FloatArray, FloatArray]:
    """Pelvis below its parent at rest, translations [m] (F, 3) and rotations (F, 4)."""
    positions, turns = poses.pelvis_positions.astype(float), poses.pelvis_rotations.astype(float)
    if not resting.above:
        return positions, turns
    parent = resting.above[0]
    undo = quaternion.inverse(resting.turns[parent])
    return quaternion.rotate(undo, positions - resting.places[parent]), quaternion.compose(undo, turns)
