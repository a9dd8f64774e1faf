"""Motion of the feet and pelvis of a clip in its own proportions, by forward kinematics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.feet import heel_offsets
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = [
    "FootMotion",
    "clip_leg_lengths",
    "foot_motions",
    "joint_kinematics",
    "moved",
    "moved_motion",
    "partial_kinematics",
    "rest_leg_length",
    "with_heels",
]


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
    ankle_rotations: FloatArray
    """Ankle joints, xyzw, continuous in sign, shape (T, 2, 4)."""
    pelvis: FloatArray
    """Pelvis joint [m], shape (T, 3)."""
    pelvis_rotations: FloatArray
    """Pelvis joint, xyzw, shape (T, 4)."""


def clip_leg_lengths(clips: Sequence[Clip], skeleton: Skeleton, biped: Biped) -> FloatArray:
    """Hip to ankle with the knee straight, in each clip's own proportions, mean of both legs [m], shape (C,)."""
    chains = [skeleton.chain(biped.hips[side], biped.ankles[side]) for side in range(2)]
    joints = np.array([joint for chain in chains for joint in chain])
    translations = np.concatenate([clip.translations[:, joints] for clip in clips])
    rotations = np.concatenate([clip.rotations[:, joints] for clip in clips])
    lengths = _leg_lengths(skeleton, biped, joints, translations, rotations)
    ends = np.cumsum([len(clip.rotations) for clip in clips])[:-1]
    return np.array([np.median(part) for part in np.split(lengths, ends)])


def rest_leg_length(skeleton: Skeleton, biped: Biped) -> float:
    """The same of the character's rest pose, whatever length an artist allows its legs [m]."""
    chains = [skeleton.chain(biped.hips[side], biped.ankles[side]) for side in range(2)]
    joints = np.array([joint for chain in chains for joint in chain])
    rest = skeleton.rest_translations[joints], skeleton.rest_rotations[joints]
    return float(_leg_lengths(skeleton, biped, joints, *rest))


def _leg_lengths(
    skeleton: Skeleton, biped: Biped, joints: IntArray, translations: FloatArray, rotations: FloatArray
) -> FloatArray:
    """Thigh and shin, mean of both legs [m] (...), of poses of the joints from each hip to its ankle (..., K)."""
    order = joints.tolist()
    parents = np.array([-1 if j in biped.hips else order.index(skeleton.parents[j]) for j in order])
    positions, _ = forward_kinematics(parents, translations, rotations)
    hips, knees, ankles = (
        positions[..., [order.index(joint) for joint in role], :] for role in (biped.hips, biped.knees, biped.ankles)
    )
    return (np.linalg.norm(knees - hips, axis=-1) + np.linalg.norm(ankles - knees, axis=-1)).mean(axis=-1)


def partial_kinematics(skeleton: Skeleton, clip: Clip, joints: IntArray) -> tuple[FloatArray, FloatArray]:
    """World positions (T, K, 3) and rotations (T, K, 4) of K joints of a clip, from its own translations."""
    return joint_kinematics(skeleton, [clip.translations], [clip.rotations], joints=joints)


def joint_kinematics(
    skeleton: Skeleton, translations: Sequence[FloatArray], rotations: Sequence[FloatArray], *, joints: IntArray
) -> tuple[FloatArray, FloatArray]:
    """World positions (N, K, 3) and rotations (N, K, 4) of K joints in all poses of several clips, end to end.

    Args:
        skeleton: Of the clips.
        translations: Joint-local, of each clip (T, J, 3).
        rotations: Joint-local, of each clip (T, J, 4).
        joints: Wanted, shape (K,).
    """
    needed = set()
    for joint in joints:
        while joint >= 0 and joint not in needed:
            needed.add(int(joint))
            joint = int(skeleton.parents[joint])
    subset = np.array(sorted(needed))
    parents = np.where(skeleton.parents[subset] < 0, -1, np.searchsorted(subset, skeleton.parents[subset]))
    poses = (np.concatenate([values[:, subset] for values in parts]) for parts in (translations, rotations))
    positions, turned = forward_kinematics(parents, *poses)
    places = np.searchsorted(subset, joints)
    return positions[:, places], turned[:, places]


def foot_motions(
    clips: Sequence[Clip], skeleton: Skeleton, biped: Biped, *, leg_lengths: FloatArray
) -> list[FootMotion]:
    """World trajectories of pelvis, ankles, balls and heels of C clips whose legs have these lengths [m], (C,)."""
    joints = np.array([biped.pelvis, *biped.ankles, *biped.balls])
    translations, rotations = [clip.translations for clip in clips], [clip.rotations for clip in clips]
    positions, turned = joint_kinematics(skeleton, translations, rotations, joints=joints)
    first = np.concatenate([[0], np.cumsum([len(clip.rotations) for clip in clips])])
    heights = leg_lengths[:, None] / rest_leg_length(skeleton, biped) * biped.ball_heights  # (C, 2)
    motions = []
    for index, clip in enumerate(clips):
        own = slice(first[index], first[index + 1])
        ankles, balls = positions[own, 1:3], positions[own, 3:5]
        ankle_rotations = quaternion.continuous(turned[own, 1:3])
        motion = FootMotion(
            times=clip.times,
            balls=balls,
            heels=ankles,
            ankles=ankles,
            ankle_rotations=ankle_rotations,
            pelvis=positions[own, 0],
            pelvis_rotations=turned[own, 0],
        )
        motions.append(with_heels(motion, heights[index]))
    return motions


def with_heels(motion: FootMotion, ball_heights: FloatArray) -> FootMotion:
    """The motion with heels found anew, for ball joints so high above the sole [m], (2,)."""
    rate = (len(motion.times) - 1) / (motion.times[-1] - motion.times[0])
    offsets = heel_offsets(motion.ankles, motion.balls, motion.ankle_rotations, ball_heights=ball_heights, rate=rate)
    return replace(motion, heels=motion.ankles + quaternion.rotate(motion.ankle_rotations, offsets))


def moved_motion(motion: FootMotion, positions: FloatArray, yaws: FloatArray) -> FootMotion:
    """The motion of the clip that `moved` gives."""
    turns = quaternion.yaw_quaternion(yaws)
    shifts = np.stack([positions[:, 0], np.zeros(len(positions)), positions[:, 1]], axis=1)

    def at(points: FloatArray) -> FloatArray:
        return quaternion.rotate(turns[:, None], points) + shifts[:, None]

    return FootMotion(
        times=motion.times,
        balls=at(motion.balls),
        heels=at(motion.heels),
        ankles=at(motion.ankles),
        ankle_rotations=quaternion.continuous(quaternion.compose(turns[:, None], motion.ankle_rotations)),
        pelvis=at(motion.pelvis[:, None])[:, 0],
        pelvis_rotations=quaternion.compose(turns, motion.pelvis_rotations),
    )


def moved(clip: Clip, skeleton: Skeleton, *, positions: FloatArray, yaws: FloatArray) -> Clip:
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
    turned = quaternion.compose(quaternion.yaw_quaternion(yaws), rotations[:, roots])
    rotations[:, roots] = quaternion.continuous(turned)
    return replace(clip, translations=translations, rotations=rotations)
