"""World clips on the character: its rest translations, the pelvis path scaled by leg length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.mirror import REFLECTION, MirrorMap
from usdfoot.analysis.motion import rest_leg_length
from usdfoot.analysis.world import WorldClip
from usdfoot.maths import planar, quaternion
from usdfoot.maths.splines import Splines, build_splines
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import forward_kinematics

__all__ = ["CharacterMotion", "Stands", "foot_stands", "on_character"]

CONTACT_SAMPLES = 33
"""Samples of a contact over which the planted ball is averaged."""


@dataclass(frozen=True, kw_only=True)
class CharacterMotion:
    """C2 splines through the samples of world clips; everything above the pelvis is folded into the pelvis."""

    library: ClipLibrary
    rotations: Splines
    """Joint-local quaternions, the pelvis's in the world, a joint's four components side by side: 4 J columns."""
    pelvis: Splines
    """Pelvis joint in the world [m]."""
    mirror: MirrorMap | None = None
    """If given, the poses are those of the mirror images in the plane x = 0 of the world, on the same character."""

    def pose(self, clips: IntArray, times: FloatArray, joints: IntArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Poses at times (N,) of the world clips (N,).

        Returns:
            Rotations of K joints (all if none are given) (N, K, 4), the pelvis's in the world, and pelvis positions
            (N, 3).
        """
        joints = np.arange(len(self.library.skeleton.joints)) if joints is None else joints
        sources = joints if self.mirror is None else self.mirror.partners[joints]
        above = np.isin(joints, self.library.skeleton.ancestors(self.library.biped.pelvis))
        columns = (4 * np.where(above, joints, sources)[:, None] + np.arange(4)).ravel()
        rotations = quaternion.normalised(self.rotations.at(clips, times, columns).reshape(len(times), -1, 4))
        pelvis = self.pelvis.at(clips, times)
        if self.mirror is None:
            return rotations, pelvis
        parents = self.mirror.parent_inverses[joints]
        parents[joints == self.library.biped.pelvis] = [0.0, 0.0, 0.0, 1.0]
        turned = quaternion.compose(quaternion.mirror_x(np.eye(4)), self.mirror.relations[joints, None])
        images = np.einsum("nki,kij->nkj", rotations, quaternion.compose(parents[:, None], turned))  # linear: (K, 4, 4)
        images[:, above] = rotations[:, above]
        return images, pelvis * REFLECTION

    @property
    def legs(self) -> IntArray:
        """The pelvis and all joints below it down to both balls, in order."""
        skeleton, biped = self.library.skeleton, self.library.biped
        return np.unique([joint for ball in biped.balls for joint in skeleton.chain(biped.pelvis, ball)])

    def feet(self, rotations: FloatArray, pelvis: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ankle and ball joints [m], (N, 2, 3) each, for rotations (N, K, 4) of `legs` and pelvis positions (N, 3)."""
        skeleton, biped, legs = self.library.skeleton, self.library.biped, self.legs
        own = int(np.searchsorted(legs, biped.pelvis))
        parents = np.searchsorted(legs, skeleton.parents[legs])
        parents[own] = -1
        translations = np.repeat(skeleton.rest_translations[None, legs], len(pelvis), axis=0)
        translations[:, own] = pelvis
        positions, _ = forward_kinematics(parents, translations, rotations)
        return positions[:, np.searchsorted(legs, biped.ankles)], positions[:, np.searchsorted(legs, biped.balls)]


@dataclass(frozen=True, kw_only=True)
class Stands:
    """Where the character's feet stand in K contacts."""

    positions: FloatArray
    """Ground under the planted ball, mean over the planted interval, in the world [m], shape (K, 3)."""
    yaws: FloatArray
    """Direction from ankle to ball [rad], shape (K,)."""
    slides: FloatArray
    """Largest distance of the ball to its mean over the middle of the contact [m], shape (K,)."""


def on_character(library: ClipLibrary, worlds: Sequence[WorldClip]) -> CharacterMotion:
    """Splines of world clips on the character of a library."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    rotations = np.concatenate([world.clip.rotations for world in worlds])
    for joint in skeleton.ancestors(pelvis):
        rotations[:, joint] = skeleton.rest_rotations[joint]
    rotations[:, pelvis] = np.concatenate([quaternion.continuous(world.pelvis_rotations) for world in worlds])
    leg = rest_leg_length(skeleton, library.biped)
    path = np.concatenate([leg / world.leg_length * world.pelvis_positions for world in worlds])
    first = np.concatenate([[0], np.cumsum([len(world.clip.rotations) for world in worlds])])
    starts = np.array([world.clip.start_time for world in worlds])
    rates = np.array([world.clip.rate for world in worlds])
    return CharacterMotion(
        library=library,
        rotations=build_splines(rotations.reshape(len(rotations), -1), first=first, starts=starts, rates=rates),
        pelvis=build_splines(path, first=first, starts=starts, rates=rates),
    )


def foot_stands(
    motion: CharacterMotion, clips: IntArray, *, flats: FloatArray, liftoffs: FloatArray, sides: IntArray
) -> Stands:
    """Where the character's feet stand in contacts of the clips (K,) with these sides (K,).

    Args:
        motion: On the character.
        clips: World clip of each contact, shape (K,).
        flats: Begin of each planted interval [s], shape (K,).
        liftoffs: End [s], shape (K,).
        sides: 0 = left, 1 = right, shape (K,).
    """
    first, last = motion.pelvis.starts[clips], motion.pelvis.ends[clips]
    times = np.linspace(np.clip(flats, first, last), np.clip(liftoffs, first, last), CONTACT_SAMPLES, axis=1)  # (K, C)
    poses = motion.pose(np.repeat(clips, CONTACT_SAMPLES), times.ravel(), motion.legs)
    ankles, balls = motion.feet(*poses)
    own = np.arange(times.size), np.repeat(sides, CONTACT_SAMPLES)
    balls, forward = balls[own].reshape(*times.shape, 3), (balls - ankles)[own].reshape(*times.shape, 3)
    means = balls.mean(axis=1)
    middle = balls[:, CONTACT_SAMPLES // 10 : -(CONTACT_SAMPLES // 10)] - means[:, None]
    means[:, 1] -= motion.library.biped.ball_heights[sides]
    return Stands(
        positions=means,
        yaws=planar.circular_mean(planar.yaw_of(forward[..., [0, 2]]), axis=1),
        slides=np.linalg.norm(middle, axis=-1).max(axis=1),
    )
