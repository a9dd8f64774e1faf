"""Takes: what a recorded clip really did, and the footsteps it left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.clip_plans import plan_of
from usdfoot.analysis.motion import partial_kinematics
from usdfoot.analysis.smoothness import body_joints
from usdfoot.analysis.world import WorldClip, world_clip
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.motion import Motion
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["Take", "motion_positions", "read_take"]


@dataclass(frozen=True, kw_only=True)
class Take:
    """A clip on the character, on a clock that starts with its first sample."""

    name: str
    """Name of the clip."""
    index: int
    """Index of the clip in its library."""
    style: str
    rate: float
    """Samples a second [Hz]."""
    positions: FloatArray
    """Joints from the pelvis down, in the order of `body_joints` [m], world, shape (T, B, 3)."""
    plan: FootstepPlan
    """The footsteps it left in its range and in one stride on either side."""


def read_take(library: ClipLibrary, index: int, *, whole: bool) -> Take:
    """The truth about a clip of a library.

    Args:
        library: Character and clips; a clip of other proportions is scaled by leg length, as the engine does.
        index: Which clip.
        whole: All footsteps of the clip; otherwise those of its range and of one stride on either side.

    Raises:
        ClipError: If its contacts cannot be found.
        PlanError: If they are no plan, for want of footsteps or in their order.
    """
    clip = library.clips[index]
    world = world_clip(clip, library.skeleton, library.biped)
    scale = library.biped.maximal_leg_length / world.leg_length
    return Take(
        name=clip.name,
        index=index,
        style=clip.style,
        rate=round(clip.rate, 6),
        positions=_positions(library, world, scale),
        plan=plan_of(world, scale=scale, whole=whole),
    )


def _positions(library: ClipLibrary, world: WorldClip, scale: float) -> FloatArray:
    pelvis = library.biped.pelvis
    places, turns = partial_kinematics(library.skeleton, world.clip, np.array([pelvis]))
    return _below_pelvis(library.skeleton, library.biped, scale * places[:, 0], turns[:, 0], world.clip.rotations)


def motion_positions(library: ClipLibrary, motion: Motion) -> FloatArray:
    """Joints of a motion from the pelvis down, in the order of `body_joints` [m], world, shape (F, B, 3)."""
    turn = quaternion.yaw_quaternion(motion.root_yaws)
    pelvis = motion.root_positions + quaternion.rotate(turn, motion.pelvis_positions.astype(float))
    rotation = quaternion.compose(turn, motion.pelvis_rotations.astype(float))
    return _below_pelvis(library.skeleton, library.biped, pelvis, rotation, motion.rotations)


def _below_pelvis(
    skeleton: Skeleton, biped: Biped, pelvis: FloatArray, pelvis_rotation: FloatArray, rotations: FloatArray
) -> FloatArray:
    """Joints of the body (F, B, 3) from the pelvis's place (F, 3) and world rotation (F, 4) and the joints' own."""
    translations = np.repeat(skeleton.rest_translations[None], len(pelvis), axis=0)
    turns = np.array(rotations, dtype=float)
    translations[:, biped.pelvis], turns[:, biped.pelvis] = pelvis, pelvis_rotation
    parents = np.where(np.arange(len(skeleton.joints)) == biped.pelvis, -1, skeleton.parents)
    return forward_kinematics(parents, translations, turns)[0][:, body_joints(skeleton, biped)]
