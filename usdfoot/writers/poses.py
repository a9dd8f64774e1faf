"""Poses: a motion's canonical joints as they stand in the character's own skeleton, and how far they reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.bridge.scene import Character
from usdfoot.bridge.similarity import unfold_from_joints
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.motion import Motion
from usdfoot.model.skeleton import forward_kinematics

__all__ = ["JointPoses", "joint_poses", "prim_extents", "skeleton_poses"]


@dataclass(frozen=True, kw_only=True)
class JointPoses:
    """Joint-local transforms of every frame."""

    translations: FloatArray
    """Shape (F, J, 3)."""
    rotations: FloatArray
    """Unit xyzw, shape (F, J, 4)."""


def joint_poses(motion: Motion, character: Character) -> JointPoses:
    """Canonical joint-local poses [m]: the pelvis below its ancestors, which rest; all else as the motion says."""
    skeleton, pelvis = character.skeleton, character.biped.pelvis
    frames = len(motion.times)
    translations = np.tile(skeleton.rest_translations, (frames, 1, 1))
    rotations = np.array(motion.rotations, dtype=float)
    positions, turns = motion.pelvis_positions, motion.pelvis_rotations
    parent = int(skeleton.parents[pelvis])
    if parent >= 0:
        above = skeleton.chain(_root_of(skeleton.parents, parent), parent)
        rotations[:, above] = skeleton.rest_rotations[list(above)]
        rest_positions, rest_turns = forward_kinematics(
            skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations
        )
        undo = quaternion.inverse(rest_turns[parent])
        positions = quaternion.rotate(undo, positions - rest_positions[parent])
        turns = quaternion.compose(undo, turns)
    translations[:, pelvis] = positions
    rotations[:, pelvis] = turns
    return JointPoses(translations=translations, rotations=rotations)


def skeleton_poses(poses: JointPoses, character: Character) -> JointPoses:
    """Canonical poses in the units and axes of the character's Skeleton, as its SkelAnimation holds them."""
    translations, rotations = unfold_from_joints(
        character.skeleton_to_agent, character.skeleton.parents, poses.translations, poses.rotations
    )
    return JointPoses(translations=translations / character.inherited_scales[:, None], rotations=rotations)


def prim_extents(poses: JointPoses, character: Character, units: StageUnits) -> FloatArray:
    """Box around the character in the space of the agent prim, whatever its joints do, shape (F, 2, 3).

    Every joint stands for a ball as large as the skin it moves; geometry that is not skinned keeps its own box.
    """
    positions, _ = forward_kinematics(character.skeleton.parents, poses.translations, poses.rotations)
    skinned = np.flatnonzero(character.joint_radii > 0.0)
    if not skinned.size:
        skinned = np.arange(positions.shape[1])
    prim_to_agent_rotation = quaternion.compose(units.axes_to_canonical, character.agent_rotation)
    agent_to_prim_rotation = quaternion.inverse(prim_to_agent_rotation)
    agent_to_prim_scale = 1.0 / (units.meters_per_unit * character.agent_scale)
    places = quaternion.rotate(agent_to_prim_rotation, positions[:, skinned]) * agent_to_prim_scale
    reach = character.joint_radii[skinned, None] * agent_to_prim_scale
    lowest, highest = (places - reach).min(axis=1), (places + reach).max(axis=1)
    if character.still_extent is not None:
        corners = np.stack(np.meshgrid(*character.still_extent.T, indexing="ij"), axis=-1).reshape(-1, 3)
        corners = quaternion.rotate(agent_to_prim_rotation, corners) * agent_to_prim_scale
        lowest, highest = np.minimum(lowest, corners.min(axis=0)), np.maximum(highest, corners.max(axis=0))
    return np.stack([lowest, highest], axis=1)


def _root_of(parents: IntArray, joint: int) -> int:
    while parents[joint] >= 0:
        joint = int(parents[joint])
    return joint
