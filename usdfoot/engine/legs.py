"""Warp functions of one leg: forward kinematics and two-bone inverse kinematics."""

from __future__ import annotations

import warp as wp

__all__ = ["Leg", "LegRig", "bend_leg", "leg_kinematics", "rotation_by"]

STRAIGHT = wp.constant(0.0025)
"""Squared sine of a knee's bend about below which the hinge says in which plane it bends."""
SHORTEST, LONGEST = wp.constant(1.0e-3), wp.constant(0.9999)
"""A leg is folded and stretched short of what is possible by this, or to this, part of thigh and shin."""


@wp.struct
class LegRig:
    """Both legs of a character on the device; index 0 = left, 1 = right."""

    translations: wp.array(dtype=wp.vec3f)  # (J,) rest
    chains: wp.array2d(dtype=wp.int32)  # (2, C) joints below the pelvis down to each ball, padded with -1
    roles: wp.array2d(dtype=wp.int32)  # (2, 4) hip, knee, ankle, ball
    ball_offsets: wp.array(dtype=wp.vec3f)  # (2,) ball in the ankle's frame
    heel_offsets: wp.array(dtype=wp.vec3f)  # (2,) heel's sole point in the ankle's frame
    flat_forwards: wp.array(dtype=wp.vec3f)  # (2,) level direction ahead of the flat foot in the ankle's frame
    flat_toes: wp.array(dtype=wp.quatf)  # (2,) ball joint in the print's frame, foot flat
    ball_heights: wp.array(dtype=wp.float32)  # (2,)
    knee_axes: wp.array(dtype=wp.vec3f)  # (2,) hinge in the hip joint's frame, for a straight leg
    reach: wp.float32  # largest part of the straight leg to use


@wp.struct
class Leg:
    """One leg's joints in the agent's world; `parent_*` are the frames their local rotations live in."""

    hip: wp.vec3f
    knee: wp.vec3f
    ankle: wp.vec3f
    ball: wp.vec3f
    parent_of_hip: wp.quatf
    rotation_of_hip: wp.quatf
    parent_of_knee: wp.quatf
    rotation_of_knee: wp.quatf
    parent_of_ankle: wp.quatf
    rotation_of_ankle: wp.quatf
    parent_of_ball: wp.quatf
    rotation_of_ball: wp.quatf


@wp.func
def leg_kinematics(
    rig: LegRig,
    side: int,
    pelvis: wp.vec3f,
    pelvis_rotation: wp.quatf,
    rotations: wp.array2d(dtype=wp.quatf),
    frame: int,
) -> Leg:
    """Leg joints from the pelvis and the joint-local rotations of a frame."""
    leg = Leg()
    position = pelvis
    rotation = pelvis_rotation
    for c in range(rig.chains.shape[1]):
        joint = rig.chains[side, c]
        if joint >= 0:
            parent = rotation
            position += wp.quat_rotate(parent, rig.translations[joint])
            rotation = parent * rotations[frame, joint]
            if joint == rig.roles[side, 0]:
                leg.hip = position
                leg.parent_of_hip = parent
                leg.rotation_of_hip = rotation
            if joint == rig.roles[side, 1]:
                leg.knee = position
                leg.parent_of_knee = parent
                leg.rotation_of_knee = rotation
            if joint == rig.roles[side, 2]:
                leg.ankle = position
                leg.parent_of_ankle = parent
                leg.rotation_of_ankle = rotation
            if joint == rig.roles[side, 3]:
                leg.ball = position
                leg.parent_of_ball = parent
                leg.rotation_of_ball = rotation
    return leg


@wp.func
def rotation_by(vector: wp.vec3f) -> wp.quatf:
    """Rotation of a rotation vector [rad]."""
    half = 0.5 * wp.length(vector)
    share = wp.where(half > 1.0e-6, wp.sin(half) / wp.max(half, 1.0e-6), 1.0)
    axis = 0.5 * share * vector
    return wp.quatf(axis[0], axis[1], axis[2], wp.cos(half))


@wp.func
def rotation_between(start: wp.vec3f, end: wp.vec3f) -> wp.quatf:
    """Smallest rotation that turns unit vector `start` onto unit vector `end` (not opposite)."""
    axis = wp.cross(start, end)
    return wp.normalize(wp.quatf(axis[0], axis[1], axis[2], 1.0 + wp.dot(start, end)))


@wp.func
def bend_leg(
    rig: LegRig, side: int, leg: Leg, target: wp.vec3f, rotations: wp.array2d(dtype=wp.quatf), frame: int
) -> wp.quatf:
    """Bends hip and knee so that the ankle comes to `target`; writes their local rotations.

    The knee stays in the plane of the clip's pose ([B] 4.5); for a nearly straight leg that plane fades into the one of
    the hinge axis, and a knee that the blend bends the wrong way is bent the right one. A target beyond reach is
    approached along the straight leg.

    Returns:
        The frame that the ankle joint's local rotation lives in, after bending.
    """
    thigh = leg.knee - leg.hip
    shin = leg.ankle - leg.knee
    upper = wp.length(thigh)
    lower = wp.length(shin)
    along = thigh / upper
    axis = wp.cross(along, shin / lower)
    hinge = wp.quat_rotate(leg.rotation_of_hip, rig.knee_axes[side])
    hinge = wp.normalize(hinge - wp.dot(hinge, along) * along)
    bend = wp.dot(axis, hinge)
    axis = wp.normalize(axis + (wp.sqrt(bend * bend + STRAIGHT) - bend) * hinge)
    reach = target - leg.hip
    span = wp.length(reach)
    shortest = wp.abs(upper - lower) + SHORTEST * (upper + lower)
    length = wp.clamp(span, shortest, LONGEST * (upper + lower))
    cosine = (length * length - upper * upper - lower * lower) / (2.0 * upper * lower)
    cosine = wp.clamp(cosine, -1.0, 1.0)
    sine = wp.sqrt(1.0 - cosine * cosine)
    bent = cosine * along + sine * wp.cross(axis, along)
    knee_turn = rotation_between(shin / lower, bent)
    swung = thigh + lower * bent
    hip_turn = rotation_between(wp.normalize(swung), reach / span)
    hip = rig.roles[side, 0]
    knee = rig.roles[side, 1]
    rotations[frame, hip] = wp.normalize(wp.quat_inverse(leg.parent_of_hip) * hip_turn * leg.rotation_of_hip)
    rotations[frame, knee] = wp.normalize(wp.quat_inverse(leg.parent_of_knee) * knee_turn * leg.rotation_of_knee)
    return hip_turn * knee_turn * leg.parent_of_ankle
