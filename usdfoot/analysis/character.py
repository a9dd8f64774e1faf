"""A world clip on the character: its rest translations, the pelvis path scaled by leg length."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from usdfoot.analysis.mirror import REFLECTION, MirrorMap, mirrored_rotations
from usdfoot.analysis.motion import partial_kinematics, rest_leg_length
from usdfoot.analysis.world import WorldClip
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["CharacterMotion", "Stands", "foot_stands", "on_character"]

CONTACT_SAMPLES = 33
"""Samples of a contact over which the planted ball is averaged."""


@dataclass(frozen=True, kw_only=True)
class CharacterMotion:
    """C2 splines through the samples of a world clip; everything above the pelvis is folded into the pelvis."""

    library: ClipLibrary
    rotations: PPoly
    """Of time: joint-local quaternions, the pelvis's in the world, shape (J, 4)."""
    pelvis: PPoly
    """Of time: pelvis joint in the world [m], shape (3,)."""

    def mirrored(self, mirror: MirrorMap) -> CharacterMotion:
        """The motion's mirror image in the plane x = 0 of the world, on the same character.

        Mirroring is linear in the quaternions, so the images of the splines' coefficients are those of the image.
        """
        skeleton, pelvis = self.library.skeleton, self.library.biped.pelvis
        own = self.rotations.c
        images = mirrored_rotations(own, mirror)
        images[..., pelvis, :] = quaternion.compose(quaternion.mirror_x(own[..., pelvis, :]), mirror.relations[pelvis])
        above = _ancestors(skeleton, pelvis)
        images[..., above, :] = own[..., above, :]
        return replace(
            self,
            rotations=PPoly(images, self.rotations.x),
            pelvis=PPoly(self.pelvis.c * REFLECTION, self.pelvis.x),
        )

    def pose(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotations (N, J, 4), the pelvis's in the world, and pelvis positions (N, 3) at times (N,)."""
        return quaternion.normalised(self.rotations(times)), self.pelvis(times)

    def feet(self, rotations: FloatArray, pelvis: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ankle and ball joints [m], (N, 2, 3) each, for poses as from `pose`."""
        skeleton, biped = self.library.skeleton, self.library.biped
        legs = np.unique([joint for ball in biped.balls for joint in skeleton.chain(biped.pelvis, ball)])
        own = int(np.searchsorted(legs, biped.pelvis))
        parents = np.searchsorted(legs, skeleton.parents[legs])
        parents[own] = -1
        translations = np.repeat(skeleton.rest_translations[None, legs], len(pelvis), axis=0)
        translations[:, own] = pelvis
        positions, _ = forward_kinematics(parents, translations, rotations[:, legs])
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


def on_character(library: ClipLibrary, world: WorldClip) -> CharacterMotion:
    """Splines of a world clip on the character of a library."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    positions, world_rotations = partial_kinematics(skeleton, world.clip, np.array([pelvis]))
    rotations = world.clip.rotations.copy()
    for joint in _ancestors(skeleton, pelvis):
        rotations[:, joint] = skeleton.rest_rotations[joint]
    rotations[:, pelvis] = quaternion.continuous(world_rotations[:, 0])
    ratio = rest_leg_length(skeleton, library.biped) / world.leg_length
    times = world.clip.times
    return CharacterMotion(
        library=library,
        rotations=CubicSpline(times, rotations),
        pelvis=CubicSpline(times, ratio * positions[:, 0]),
    )


def _ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Joints above a joint."""
    above = []
    while skeleton.parents[joint] >= 0:
        joint = int(skeleton.parents[joint])
        above.append(joint)
    return above


def foot_stands(motion: CharacterMotion, flats: FloatArray, liftoffs: FloatArray, sides: IntArray) -> Stands:
    """Where the character's feet `sides` (K,) stand from flat to liftoff [s], shapes (K,)."""
    first, last = float(motion.pelvis.x[0]), float(motion.pelvis.x[-1])
    times = np.linspace(np.clip(flats, first, last), np.clip(liftoffs, first, last), CONTACT_SAMPLES, axis=1)  # (K, C)
    ankles, balls = motion.feet(*motion.pose(times.ravel()))
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
