"""Motion of the feet and pelvis of a clip in its own proportions, by forward kinematics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.feet import heel_offsets
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["FootMotion", "clip_leg_length", "foot_motion", "moved", "partial_kinematics", "rest_leg_length"]


@dataclass(frozen=True, kw_only=True)
class FootMotion:
    """World trajectories of the points that contacts are detected on, (left, right) along axis 1."""

    times: FloatArray
    """Sample times [s], shape (T,)."""
    balls: FloatArray
    """Ball joints [m], shape (T, 2, 3)."""
    heels: FloatArray
    """Heel points of the soles (design.md section 2) [m], shape (T, 2, 3)."""
    ankles: FloatArray
    """Ankle joints [m], shape (T, 2, 3)."""
    pelvis: FloatArray
    """Pelvis joint [m], shape (T, 3)."""
    pelvis_rotations: FloatArray
    """Pelvis joint, xyzw, shape (T, 4)."""


def clip_leg_length(clip: Clip, skeleton: Skeleton, biped: Biped) -> float:
    """Hip to ankle with the knee straight, in the clip's own proportions, mean of both legs [m]."""
    joints = np.array([*biped.hips, *biped.knees, *biped.ankles])
    positions, _ = partial_kinematics(skeleton, clip, joints)
    return float(np.median(_leg_lengths(positions)))


def rest_leg_length(skeleton: Skeleton, biped: Biped) -> float:
    """The same of the character's rest pose, whatever length an artist allows its legs [m]."""
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    return float(_leg_lengths(positions[[*biped.hips, *biped.knees, *biped.ankles]]))


def _leg_lengths(positions: FloatArray) -> FloatArray:
    """Thigh and shin, mean of both legs [m], of hips, knees and ankles (..., 6, 3); there may be joints between."""
    hips, knees, ankles = (positions[..., i : i + 2, :] for i in (0, 2, 4))
    return (np.linalg.norm(knees - hips, axis=-1) + np.linalg.norm(ankles - knees, axis=-1)).mean(axis=-1)


def partial_kinematics(skeleton: Skeleton, clip: Clip, joints: IntArray) -> tuple[FloatArray, FloatArray]:
    """World positions (T, K, 3) and rotations (T, K, 4) of K joints of a clip, from its own translations."""
    needed = set()
    for joint in joints:
        while joint >= 0 and joint not in needed:
            needed.add(int(joint))
            joint = int(skeleton.parents[joint])
    subset = np.array(sorted(needed))
    parents = np.where(skeleton.parents[subset] < 0, -1, np.searchsorted(subset, skeleton.parents[subset]))
    positions, rotations = forward_kinematics(parents, clip.translations[:, subset], clip.rotations[:, subset])
    places = np.searchsorted(subset, joints)
    return positions[:, places], rotations[:, places]


def foot_motion(clip: Clip, skeleton: Skeleton, biped: Biped) -> FootMotion:
    """World trajectories of pelvis, ankles, balls and heels of a clip."""
    joints = np.array([biped.pelvis, *biped.ankles, *biped.balls])
    positions, rotations = partial_kinematics(skeleton, clip, joints)
    ankles, balls, ankle_rotations = positions[:, 1:3], positions[:, 3:5], quaternion.continuous(rotations[:, 1:3])
    ball_heights = biped.ball_heights * clip_leg_length(clip, skeleton, biped) / rest_leg_length(skeleton, biped)
    offsets = heel_offsets(ankles, balls, ankle_rotations, ball_heights, rate=clip.rate)
    return FootMotion(
        times=clip.times,
        balls=balls,
        heels=ankles + quaternion.rotate(ankle_rotations, offsets),
        ankles=ankles,
        pelvis=positions[:, 0],
        pelvis_rotations=rotations[:, 0],
    )


def moved(clip: Clip, skeleton: Skeleton, positions: FloatArray, yaws: FloatArray) -> Clip:
    """The clip with every pose turned about the world's +Y and then shifted on the ground.

    Args:
        clip: Clip of T samples.
        skeleton: Its skeleton; all root joints are moved.
        positions: Shifts (x, z) [m], shape (T, 2) or (2,).
        yaws: Turns about the world's origin [rad], shape (T,) or ().
    """
    roots = np.flatnonzero(skeleton.parents < 0)
    frames = len(clip.rotations)
    yaws = np.broadcast_to(yaws, (frames,))[:, None]
    shifts = np.broadcast_to(positions, (frames, 2))[:, None]
    translations, rotations = clip.translations.copy(), clip.rotations.copy()
    ground = planar.rotate(yaws, translations[:, roots][..., [0, 2]]) + shifts
    translations[:, roots, 0] = ground[..., 0]
    translations[:, roots, 2] = ground[..., 1]
    rotations[:, roots] = quaternion.compose(quaternion.yaw_quaternion(yaws), rotations[:, roots])
    return replace(clip, translations=translations, rotations=quaternion.continuous(rotations))
