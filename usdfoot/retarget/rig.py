"""Rig: one of the two skeletons of a retargeting, with its body and a pose that stands."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.body import Body, find_body
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.analysis.joint_words import is_helper
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Pose, Skeleton, forward_kinematics

__all__ = ["Rig", "build_rig", "legs_as_rigged", "same_legs", "standing_pose"]

CLEARLY = 0.02
"""The bind pose is taken where it is more symmetric than the rest pose by this part of the leg."""
SAME_SHAPE = 1e-3
"""Legs whose bones differ by less, as parts of their length, have one shape."""


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A skeleton and its body."""

    skeleton: Skeleton
    biped: Biped
    body: Body
    reference: Pose
    """A standing pose, facing +Z: what rotations are compared with."""

    def place(self, joint: int) -> FloatArray:
        """Where a joint is in the reference pose [m], shape (3,)."""
        return self.reference.places[joint]

    def turn(self, joint: int) -> FloatArray:
        """Its rotation there, shape (4,)."""
        return self.reference.turns[joint]

    def direction(self, start: int, end: int) -> FloatArray:
        """Unit vector from one joint to another in the reference pose, shape (3,); zero where they are in one place."""
        way = self.place(end) - self.place(start)
        length = float(np.linalg.norm(way))
        return way / length if length > 1e-6 else np.zeros(3)


def build_rig(skeleton: Skeleton, biped: Biped, bind: Pose | None = None) -> Rig:
    """The rig of a skeleton.

    Args:
        skeleton: Canonical.
        biped: Its legs.
        bind: Its bind pose, if it has one.
    """
    reference = _facing(standing_pose(skeleton, biped, bind), biped)
    return Rig(skeleton=skeleton, biped=biped, body=find_body(skeleton, biped, reference.places), reference=reference)


def standing_pose(skeleton: Skeleton, biped: Biped, bind: Pose | None) -> Pose:
    """The more symmetric one of rest and bind pose, the rest pose where they hardly differ in that.

    Exporters write whatever frame was current as the rest pose; a pose made to be rigged is symmetric. Arguments as of
    `build_rig`.
    """
    rest = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    pose = Pose(places=rest[0], turns=rest[1])
    if bind is None:
        return pose
    own, bound = (_asymmetry(skeleton, biped, _facing(each, biped)) for each in (pose, bind))
    return bind if own - bound > CLEARLY * biped.maximal_leg_length else pose


def legs_as_rigged(skeleton: Skeleton, biped: Biped, bind: Pose | None) -> Skeleton:
    """The skeleton with the joints of its legs where they were rigged, if its rest pose is a frame of some animation.

    Animators move joints as well as turn them: a hip that is lower than the other one in that frame would be so in
    every pose. Arguments as of `build_rig`.
    """
    if bind is None or standing_pose(skeleton, biped, bind) is not bind:
        return skeleton
    legs = sorted({joint for ball in biped.balls for joint in skeleton.chain(biped.pelvis, ball)[1:]})
    above = skeleton.parents[legs]
    translations = skeleton.rest_translations.copy()
    offsets = bind.places[legs] - bind.places[above]
    translations[legs] = quaternion.rotate(quaternion.inverse(bind.turns[above]), offsets)
    return replace(skeleton, rest_translations=translations)


def _facing(pose: Pose, biped: Biped) -> Pose:
    """The pose turned about the vertical until its left hip is to the left of the right one as seen along +Z."""
    across = pose.places[biped.hips[0]] - pose.places[biped.hips[1]]
    turn = quaternion.yaw_quaternion(0.5 * np.pi - planar.yaw_of(across[[0, 2]]))
    return Pose(places=quaternion.rotate(turn, pose.places), turns=quaternion.compose(turn, pose.turns))


def _asymmetry(skeleton: Skeleton, biped: Biped, pose: Pose) -> float:
    """Root mean square distance of the joints from the mirror images of their partners [m]."""
    bones = np.array([not is_helper(joint) for joint in skeleton.joints])
    partners = joint_pairs(skeleton, biped)
    places = pose.places - pose.places[list(biped.hips)].mean(axis=0)
    images = places[partners] * np.array([-1.0, 1.0, 1.0])
    return float(np.sqrt(np.mean(np.sum((places - images)[bones] ** 2, axis=1))))


def same_legs(first: Rig, second: Rig) -> bool:
    """Whether the legs of two rigs have one shape, whatever their size: feet then come down where they came down."""
    shapes = []
    for rig in (first, second):
        pairs = (rig.biped.hips, rig.biped.knees, rig.biped.ankles, rig.biped.balls)
        legs = np.array([rig.reference.places[list(pair)] for pair in pairs])  # (4, 2, 3)
        bones = np.linalg.norm(np.diff(legs, axis=0), axis=-1).ravel()
        width = np.linalg.norm(legs[0, 1] - legs[0, 0])
        shapes.append(np.array([width, *bones, *rig.biped.ball_heights]) / bones[:4].sum())
    return bool(np.abs(shapes[0] - shapes[1]).max() < SAME_SHAPE)
