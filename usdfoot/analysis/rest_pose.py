"""Rest poses: how a body whose file does not say so stands, upright, facing +Z, on level feet.

Motion capture files have a zero pose in which all joint angles are 0. In some it is a T-pose; in others, as Bandai
Namco's, the bones lie along the axes of their joints, and nobody can stand so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from usdfoot.analysis.biped import BALL_HEIGHT, BALL_HEIGHTS
from usdfoot.analysis.biped_names import LEG_ROLES
from usdfoot.analysis.feet import unrest
from usdfoot.analysis.flat_feet import ahead
from usdfoot.analysis.motion import joint_kinematics
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import SIDES
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["mean_stand", "set_on_ground", "stands"]

STEEPEST_LEG = np.radians(40.0)
"""Legs of somebody who stands lean by less; those of T-poses by 20 degrees."""
STRAIGHT = 0.93
"""Distance from hip to ankle of a leg that stands, as a fraction of thigh and shin; the knee is bent by 43 degrees."""
STRAIGHTENED = 0.99
"""The same of a leg that is made to stand: enough bend to show where the knee points."""
STEEPEST_FOOT = np.radians(60.0)
"""Feet of somebody who stands point down by less, from ankle to ball."""
HEAD_HEIGHT = 0.2
"""Something of somebody who stands is higher than the hips by more than this fraction of the leg."""
LEVEL = 0.1
"""Difference in height of the balls of somebody who stands, as a fraction of the leg."""
CALM = 0.05
"""Part of the samples in which a foot rests most."""
ENOUGH = 2000
"""Samples that a mean pose is taken from."""


def stands(skeleton: Skeleton, roles: Mapping[str, int]) -> bool:
    """Whether the rest pose stands: legs straight down, feet ahead and level, left on the left.

    Args:
        skeleton: Canonical.
        roles: Joint index by role, as from `find_biped`.
    """
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    hips, knees, ankles, balls = positions[_legs(roles)].transpose(1, 0, 2)
    legs = np.linalg.norm(knees - hips, axis=1) + np.linalg.norm(ankles - knees, axis=1)
    down, feet = ankles - hips, balls - ankles
    reach, size = np.linalg.norm(down, axis=1), np.linalg.norm(feet, axis=1)
    level = np.linalg.norm(feet[:, [0, 2]], axis=1)
    if min(legs.min(), reach.min(), size.min()) < 1e-9 or level.min() < np.cos(STEEPEST_FOOT) * size.min():
        return False
    forward = (feet[:, [0, 2]] / level[:, None]).sum(axis=0)
    to_left = (hips[0] - hips[1])[[0, 2]]
    return bool(
        np.all(reach > STRAIGHT * legs)
        and np.all(-down[:, 1] > np.cos(STEEPEST_LEG) * reach)
        and np.ptp(balls[:, 1]) < LEVEL * legs.mean()
        and np.linalg.norm(forward) > 1.0
        and to_left @ [forward[1], -forward[0]] > 0.0
        and positions[:, 1].max() > hips[:, 1].max() + HEAD_HEIGHT * legs.mean()
    )


def mean_stand(skeleton: Skeleton, clips: Sequence[Clip], roles: Mapping[str, int]) -> Skeleton:
    """The skeleton with a rest pose made of its clips.

    Body and arms are as on average, the legs straight below the hips in the plane in which they bend, and each foot as
    it is pitched where it rests most.

    Args:
        skeleton: Canonical; bones have the lengths of its own rest pose.
        clips: With samples for all of its joints.
        roles: Joint index by role.
    """
    legs = _legs(roles)
    joints = np.array([roles["pelvis"], *legs[:, 2], *legs[:, 3], *legs[:, 0]])
    everything = [clip.translations for clip in clips], [clip.rotations for clip in clips]
    places, turns = joint_kinematics(skeleton, *everything, joints=joints)
    to_left = places[:, 5] - places[:, 6]
    headings = planar.yaw_of(np.stack([-to_left[:, 2], to_left[:, 0]], axis=-1))
    step = -(-len(headings) // ENOUGH)
    poses = np.concatenate(everything[1])[::step]
    rotations = quaternion.mean(poses, np.ones(len(poses)))
    above, within = _way_down(skeleton, roles["pelvis"])
    rotations[list(above)] = skeleton.rest_rotations[list(above)]
    rotations[list(within)] = poses[0, list(within)]
    facing = quaternion.compose(quaternion.yaw_quaternion(-headings[::step]), turns[::step, 0])
    pelvis = quaternion.mean(facing, np.ones(len(facing)))
    pelvis = quaternion.compose(quaternion.yaw_quaternion(headings[0]), pelvis)
    rotations = _with_world(skeleton, rotations, roles["pelvis"], pelvis)
    calm = _calm_samples(clips, places, turns)
    for side in range(2):
        toes = np.concatenate([clip.rotations[:, legs[side, 3]] for clip in clips])[calm[side]]
        rotations[legs[side, 3]] = quaternion.mean(toes, np.ones(len(toes)))
        rotations = _with_straight_leg(skeleton, rotations, legs[side])
        flat = ahead(turns[calm[side], 1 + side], skeleton.rest_translations[legs[side, 3]])
        flat = quaternion.mean(flat, np.ones(len(flat)))
        flat = quaternion.compose(quaternion.yaw_quaternion(headings[0]), flat)
        rotations = _with_world(skeleton, rotations, int(legs[side, 2]), flat)
    return replace(skeleton, rest_rotations=quaternion.normalised(rotations))


def set_on_ground(skeleton: Skeleton, clips: Sequence[Clip], roles: Mapping[str, int]) -> Skeleton:
    """The skeleton with its rest pose turned to face +Z, the pelvis over the origin and the soles on the ground.

    What moves is the joint that the whole body hangs on; joints above it keep their rest. The balls are as high above
    the ground as where they rest in the clips, or where that is no height of a foot, as high as on average people's.

    Args:
        skeleton: Canonical, with a rest pose that stands.
        clips: With samples for all of its joints.
        roles: Joint index by role.
    """
    above, (mover, *_) = _way_down(skeleton, roles["pelvis"])
    rotations = skeleton.rest_rotations
    positions, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, rotations)
    legs = _legs(roles)
    feet = positions[legs[:, 3]] - positions[legs[:, 2]]
    turn = quaternion.yaw_quaternion(-planar.circular_mean(planar.yaw_of(feet[:, [0, 2]])))
    drop = positions[roles["pelvis"]].copy()
    drop[1] = positions[legs[:, 3], 1].mean() - _ball_height(skeleton, clips, legs)
    place = quaternion.rotate(turn, positions[mover] - drop)
    world = quaternion.compose(turn, turns[mover])
    if above:
        back = quaternion.inverse(turns[above[-1]])
        place, world = quaternion.rotate(back, place - positions[above[-1]]), quaternion.compose(back, world)
    translations, rotations = skeleton.rest_translations.copy(), rotations.copy()
    translations[mover], rotations[mover] = place, world
    return replace(skeleton, rest_translations=translations, rest_rotations=rotations)


def _legs(roles: Mapping[str, int]) -> IntArray:
    """Hip, knee, ankle and ball of both legs, shape (2, 4)."""
    return np.array([[roles[f"{side} {role}"] for role in LEG_ROLES] for side in SIDES])


def _way_down(skeleton: Skeleton, pelvis: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Joints above the one that the whole body hangs on, and from that one to the pelvis."""
    root = pelvis
    while skeleton.parents[root] >= 0:
        root = int(skeleton.parents[root])
    way = skeleton.chain(root, pelvis)
    bearer = next(i for i, joint in enumerate(way) if joint == pelvis or np.sum(skeleton.parents == joint) > 1)
    return way[:bearer], way[bearer:]


def _calm_samples(clips: Sequence[Clip], places: FloatArray, turns: FloatArray) -> list[IntArray]:
    """Samples of all clips end to end in which each foot rests most; for pelvis, ankles and balls (N, 5, ...)."""
    parts, first = [], 0
    for clip in clips:
        own = slice(first, first + len(clip.rotations))
        parts.append(unrest(places[own, 1:3], places[own, 3:5], quaternion.continuous(turns[own, 1:3]), rate=clip.rate))
        first = own.stop
    restless = np.concatenate(parts)
    return [np.flatnonzero(restless[:, side] <= np.quantile(restless[:, side], CALM)) for side in range(2)]


def _ball_height(skeleton: Skeleton, clips: Sequence[Clip], legs: IntArray) -> float:
    """Height of the ball joints where the feet rest [m], of both feet."""
    joints = np.array([legs[0, 0], *legs[:, 2], *legs[:, 3]])
    size = float(np.linalg.norm(skeleton.rest_translations[legs[:, 3]], axis=1).mean())
    if clips:
        everything = [clip.translations for clip in clips], [clip.rotations for clip in clips]
        places, turns = joint_kinematics(skeleton, *everything, joints=joints)
        calm = _calm_samples(clips, places, turns)
        height = float(np.mean([np.median(places[calm[side], 3 + side, 1]) for side in range(2)]))
        if BALL_HEIGHTS[0] * size < height < BALL_HEIGHTS[1] * size:
            return height
    return BALL_HEIGHT * size


def _with_world(skeleton: Skeleton, rotations: FloatArray, joint: int, world: FloatArray) -> FloatArray:
    """Joint-local rotations (J, 4) with one joint turned as wanted in the world (4,)."""
    _, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, rotations)
    parent = int(skeleton.parents[joint])
    result = rotations.copy()
    result[joint] = quaternion.compose(quaternion.inverse(turns[parent]), world) if parent >= 0 else world
    return result


def _with_straight_leg(skeleton: Skeleton, rotations: FloatArray, leg: IntArray) -> FloatArray:
    """Joint-local rotations (J, 4) with the ankle straight below the hip and the knee nearly straight.

    Args:
        skeleton: Canonical.
        rotations: Joint-local, shape (J, 4).
        leg: Hip, knee, ankle and ball, shape (4,).
    """
    positions, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, rotations)
    hip, knee, ankle = positions[leg[:3]]
    thigh, shin = knee - hip, ankle - knee
    lengths = np.linalg.norm(thigh), np.linalg.norm(shin)
    axis = np.cross(thigh, shin)
    if np.linalg.norm(axis) > 1e-6 * lengths[0] * lengths[1]:
        reach = STRAIGHTENED * (lengths[0] + lengths[1])
        wanted = np.arccos(
            np.clip((reach**2 - lengths[0] ** 2 - lengths[1] ** 2) / (2 * lengths[0] * lengths[1]), -1, 1)
        )
        bend = np.arctan2(np.linalg.norm(axis), thigh @ shin)
        turn = quaternion.from_axis_angle(axis / np.linalg.norm(axis), np.array(wanted - bend))
        rotations = _with_world(skeleton, rotations, int(leg[1]), quaternion.compose(turn, turns[leg[1]]))
        ankle = knee + quaternion.rotate(turn, shin)
    down = (ankle - hip) / np.linalg.norm(ankle - hip)
    upright = quaternion.between(down, np.array([0.0, -1.0, 0.0]))
    return _with_world(skeleton, rotations, int(leg[0]), quaternion.compose(upright, turns[leg[0]]))
