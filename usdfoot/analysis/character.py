"""A world clip on the character: its rest translations, the pelvis path scaled by leg length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from usdfoot.analysis.motion import partial_kinematics
from usdfoot.analysis.world import WorldClip
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contacts import FootContacts
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["CharacterMotion", "Stands", "foot_stands", "on_character"]

CONTACT_SAMPLES = 33
"""Samples of a contact over which the planted ball is averaged."""


@dataclass(frozen=True, kw_only=True)
class CharacterMotion:
    """C2 splines through the samples of a world clip; everything above the pelvis is folded into the pelvis."""

    library: ClipLibrary
    rotations: CubicSpline
    """Of time: joint-local quaternions, the pelvis's in the world, shape (J * 4,)."""
    pelvis: CubicSpline
    """Of time: pelvis joint in the world [m], shape (3,)."""

    def pose(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotations (N, J, 4), the pelvis's in the world, and pelvis positions (N, 3) at times (N,)."""
        joints = len(self.library.skeleton.joints)
        rotations = self.rotations(times).reshape(len(times), joints, 4)
        return quaternion.normalised(rotations), self.pelvis(times)

    def leg(self, rotations: FloatArray, pelvis: FloatArray, side: int) -> tuple[FloatArray, FloatArray]:
        """Ankle and ball joints of one leg [m], (N, 3) each, for poses as from `pose`."""
        skeleton, biped = self.library.skeleton, self.library.biped
        chain = list(skeleton.chain(biped.pelvis, biped.balls[side]))
        translations = np.repeat(skeleton.rest_translations[None, chain], len(pelvis), axis=0)
        translations[:, 0] = pelvis
        positions, _ = forward_kinematics(np.arange(-1, len(chain) - 1), translations, rotations[:, chain])
        return positions[:, chain.index(biped.ankles[side])], positions[:, -1]


@dataclass(frozen=True, kw_only=True)
class Stands:
    """Where one foot of the character stands in each of its contacts."""

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
    ratio = library.biped.maximal_leg_length / world.leg_length
    times = world.clip.times
    return CharacterMotion(
        library=library,
        rotations=CubicSpline(times, rotations.reshape(len(times), -1)),
        pelvis=CubicSpline(times, ratio * positions[:, 0]),
    )


def _ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """Joints above a joint."""
    above = []
    while skeleton.parents[joint] >= 0:
        joint = int(skeleton.parents[joint])
        above.append(joint)
    return above


def foot_stands(motion: CharacterMotion, foot: FootContacts, side: int) -> Stands:
    """Where the character's foot stands in all its contacts."""
    first, last = float(motion.pelvis.x[0]), float(motion.pelvis.x[-1])
    starts, ends = np.clip(foot.flat_times, first, last), np.clip(foot.liftoff_times, first, last)
    times = np.linspace(starts, ends, CONTACT_SAMPLES, axis=1)  # (K, C)
    ankles, balls = motion.leg(*motion.pose(times.ravel()), side)
    balls, forward = balls.reshape(*times.shape, 3), (balls - ankles).reshape(*times.shape, 3)
    means = balls.mean(axis=1)
    middle = balls[:, CONTACT_SAMPLES // 10 : -(CONTACT_SAMPLES // 10)] - means[:, None]
    return Stands(
        positions=means - np.array([0.0, motion.library.biped.ball_heights[side], 0.0]),
        yaws=planar.circular_mean(planar.yaw_of(forward[..., [0, 2]]), axis=1),
        slides=np.linalg.norm(middle, axis=-1).max(axis=1),
    )
