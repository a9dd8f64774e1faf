"""Standing pose: how the character stands still, left and right alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from usdfoot.analysis.grids import ROUNDING
from usdfoot.analysis.mirror import MirrorMap, mirror_map, mirrored_rotations
from usdfoot.analysis.motion import joint_kinematics
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.model.skeleton import forward_kinematics

__all__ = ["StandLimits", "StandingPose", "find_standing_pose"]


@dataclass(frozen=True, kw_only=True)
class StandLimits:
    """What standing is; lengths and speeds are for a leg of 0.8 m and scale with the leg."""

    shortest: float = 0.3
    """Duration [s]."""
    ball_speed: float = 0.1
    """Of both balls [m/s]."""
    pelvis_speed: float = 0.15
    """[m/s]."""
    level: float = 0.05
    """Difference in height of the balls [m]."""
    apart: float = 0.25
    """One ball ahead of the other, in the heading [m]."""


@dataclass(frozen=True, kw_only=True)
class StandingPose:
    """The character standing with its heading along +Z, the midpoint under both balls at the origin."""

    rotations: FloatArray
    """Joint-local rotations xyzw (the pelvis's entry is not used), shape (J, 4)."""
    pelvis: int
    """Joint index of the pelvis."""
    pelvis_rotation: FloatArray
    """Relative to the heading, xyzw, shape (4,)."""
    pelvis_position: FloatArray
    """From the ground midway between the balls [m], shape (3,)."""
    clip: int
    """Index of the clip it comes from; of one of the nearest clip if none stands."""


def find_standing_pose(library: ClipLibrary, examples: Examples, *, limits: StandLimits | None = None) -> StandingPose:
    """A symmetric standing pose: the calmest stand in the clips, else put together from the examples.

    Without a stand the legs are those of mid stance, when the pelvis is highest, in the steps whose feet stand longest,
    set upright below the hips; the rest of the body is the mean over all examples and phases.

    Args:
        library: Skeleton, biped and clips.
        examples: Steps cut from the clips.
        limits: What standing is.
    """
    limits = limits or StandLimits()
    feet = list(_body_points(library))
    stands = [_calmest(clip, own, library.biped, limits) for clip, (own, _) in zip(library.clips, feet, strict=True)]
    costs = np.array([cost for cost, _ in stands])
    if costs.size and np.isfinite(costs.min()):
        index = int(np.argmin(costs))
        rotations = _pose_at(library.clips[index], *feet[index], library.biped.pelvis, stands[index][1])
    elif len(examples):
        rotations, index = _composed(library, examples)
    else:
        rotations, index = _upright_rest(library), 0
    mirror = mirror_map(library.skeleton, library.biped)
    return _grounded(library, _symmetric(rotations, mirror, library.biped), index)


def _calmest(clip: Clip, points: FloatArray, biped: Biped, limits: StandLimits) -> tuple[float, int]:
    """Cost and sample of a clip's calmest stand, infinite if it never stands; points as from `_body_points`."""
    scale = biped.maximal_leg_length / 0.8
    speeds = np.linalg.norm(np.gradient(points, 1.0 / clip.rate, axis=0), axis=-1)
    balls, pelvis = speeds[:, 3:].max(axis=1), speeds[:, 0]
    stands = (balls < scale * limits.ball_speed) & (pelvis < scale * limits.pelvis_speed)
    if not stands.any():
        return np.inf, 0
    across = points[:, 3] - points[:, 4]
    ahead = np.abs(np.sum(planar.direction(_headings(points)) * across[:, [0, 2]], axis=-1))
    stands &= (np.abs(across[:, 1]) < scale * limits.level) & (ahead < scale * limits.apart)
    size = 2 * int(np.ceil(0.5 * limits.shortest * clip.rate - ROUNDING)) + 1
    lasting = minimum_filter1d(stands.astype(np.uint8), size, mode="constant", cval=0).astype(bool)
    cost = np.where(lasting, pelvis / limits.pelvis_speed + ahead / limits.apart, np.inf)
    sample = int(np.argmin(cost))
    return float(cost[sample]), sample


def _body_points(library: ClipLibrary) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Pelvis, both ankles and both balls in the world [m] (T, 5, 3) and their rotations (T, 5, 4), of each clip."""
    biped, clips = library.biped, library.clips
    parts = [clip.translations for clip in clips], [clip.rotations for clip in clips]
    joints = np.array([biped.pelvis, *biped.ankles, *biped.balls])
    if clips:
        ends = np.cumsum([len(clip.rotations) for clip in clips])[:-1]
        found = joint_kinematics(library.skeleton, *parts, joints=joints)
        yield from zip(*(np.split(values, ends) for values in found), strict=True)


def _headings(points: FloatArray) -> FloatArray:
    """Mean direction of both feet as yaw [rad], shape (T,), for points as from `_body_points`."""
    return planar.circular_mean(planar.yaw_of((points[:, 3:] - points[:, 1:3])[..., [0, 2]]))


def _pose_at(clip: Clip, points: FloatArray, turns: FloatArray, pelvis: int, sample: int) -> FloatArray:
    """Joint-local rotations (J, 4) at a sample, the pelvis's relative to the heading; feet as from `_body_points`."""
    rotations = clip.rotations[sample].copy()
    heading = _headings(points)[sample]
    rotations[pelvis] = quaternion.compose(quaternion.yaw_quaternion(-heading), turns[sample, 0])
    return rotations


def _composed(library: ClipLibrary, examples: Examples) -> tuple[FloatArray, int]:
    """Rotations (J, 4) from the examples: body on average, legs in mid stance; and the slowest example's clip."""
    poses = examples.rotations.astype(float)
    everything = poses.reshape(-1, *poses.shape[2:])
    rotations = quaternion.mean(everything, np.ones(len(everything)))
    highest = np.argmax(examples.pelvis_positions[..., 1], axis=1)
    shares = examples.support_liftoffs / examples.durations
    standing = shares >= 0.9 * min(float(shares.max()), 1.0)
    for side in range(2):
        leg = np.array(library.skeleton.chain(library.biped.pelvis, library.biped.balls[side])[1:])
        mine = np.flatnonzero(standing & (examples.swing_sides == 1 - side))
        if mine.size:
            stance = poses[mine, highest[mine]][:, leg]
            rotations[leg] = quaternion.mean(stance, np.ones(len(mine)))
    rotations = _with_upright_legs(library, rotations)
    slowest = int(np.argmin(np.linalg.norm(examples.landings - examples.departures, axis=1) / examples.durations))
    return rotations, int(examples.clip_indices[slowest])


def _with_upright_legs(library: ClipLibrary, rotations: FloatArray) -> FloatArray:
    """Rotations (J, 4) with each leg turned at the hip so that the ankle is below it; the foot keeps its direction."""
    skeleton, biped = library.skeleton, library.biped
    result = rotations.copy()
    for side in range(2):
        chain = list(skeleton.chain(biped.pelvis, biped.ankles[side]))
        positions, worlds = forward_kinematics(
            np.arange(-1, len(chain) - 1), skeleton.rest_translations[chain], rotations[chain]
        )
        hip = chain.index(biped.hips[side])
        across = positions[-1] - positions[hip]
        upright = quaternion.between(across / np.linalg.norm(across), np.array([0.0, -1.0, 0.0]))
        above_hip, above_ankle = quaternion.inverse(worlds[hip - 1]), quaternion.inverse(worlds[-2])
        result[biped.hips[side]] = quaternion.compose(above_hip, quaternion.compose(upright, worlds[hip]))
        result[biped.ankles[side]] = quaternion.compose(
            above_ankle, quaternion.compose(quaternion.inverse(upright), worlds[-1])
        )
    return result


def _upright_rest(library: ClipLibrary) -> FloatArray:
    """Rest rotations (J, 4), the pelvis's in skeleton space."""
    skeleton = library.skeleton
    rotations = skeleton.rest_rotations.copy()
    _, world = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    rotations[library.biped.pelvis] = world[library.biped.pelvis]
    return rotations


def _symmetric(rotations: FloatArray, mirror: MirrorMap, biped: Biped) -> FloatArray:
    """Mean of a pose (J, 4), the pelvis's rotation relative to the heading, and its mirror image."""
    image = mirrored_rotations(rotations, mirror)
    pelvis = quaternion.mirror_x(rotations[biped.pelvis])
    image[biped.pelvis] = quaternion.compose(pelvis, mirror.relations[biped.pelvis])
    return quaternion.mean(np.stack([rotations, image]), np.ones(2))


def _grounded(library: ClipLibrary, rotations: FloatArray, clip: int) -> StandingPose:
    """The pose with its balls at their height above the ground, the midpoint between them at the origin."""
    biped, skeleton = library.biped, library.skeleton
    balls = []
    for side in range(2):
        chain = np.array(skeleton.chain(biped.pelvis, biped.balls[side]))
        offsets = skeleton.rest_translations[chain].copy()
        offsets[0] = 0.0
        positions, _ = forward_kinematics(np.arange(-1, len(chain) - 1), offsets, rotations[chain])
        balls.append(positions[-1] - np.array([0.0, biped.ball_heights[side], 0.0]))
    pelvis_rotation = rotations[biped.pelvis].copy()
    return StandingPose(
        rotations=rotations,
        pelvis=biped.pelvis,
        pelvis_rotation=pelvis_rotation,
        pelvis_position=-0.5 * (balls[0] + balls[1]),
        clip=clip,
    )
