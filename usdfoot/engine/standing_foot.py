"""Warp functions of the foot on the ground, which rolls from the heel onto the ball (design.md section 2)."""

from __future__ import annotations

import warp as wp

from usdfoot.engine.easing import ramp, smootherstep, soft_positive
from usdfoot.engine.foot_rows import FootArrays
from usdfoot.engine.legs import Leg, LegRig

__all__ = ["SHORT_OF_UPRIGHT", "FootPose", "heel_raise", "standing_foot"]

MOST_RAISE = wp.constant(1.2)
"""Largest pitch of a foot on its ball [rad]."""
SHORT_OF_UPRIGHT = wp.constant(0.05)
"""How far the ankle of a foot that is raised to reach stays behind its ball [rad], so that it keeps its heading."""
JOIN = wp.constant(0.02)
"""Width over which a heel's reasons to rise pass into each other [rad]."""
UPRIGHT_WIDTH = wp.constant(0.03)
"""Half the width over which SHORT_OF_UPRIGHT comes in [rad]."""
REACHED = wp.constant(0.004)
"""Width, in the cosine, over which a leg comes to be too short."""
RAISE_TIME = wp.constant(0.15)
"""A heel that a liftoff needs higher than blended rises for at most so long before it [s]."""


@wp.struct
class FootPose:
    """Where a foot has to be."""

    ankle: wp.vec3f
    rotation: wp.quatf
    toes: wp.float32  # how far the toes stay parallel to the ground, 0..1
    ground: wp.quatf  # that ground to world: the print, in the air on the way to the next


@wp.func
def heel_raise(rig: LegRig, side: int, leg: Leg) -> float:
    """Pitch of the blended foot against flat [rad], > 0 with the heel raised."""
    forward = wp.quat_rotate(leg.rotation_of_ankle, rig.flat_forwards[side])
    return -wp.asin(wp.clamp(forward[1], -1.0, 1.0))


@wp.func
def raise_onto(foot: wp.vec3f, direction: wp.vec3f, lateral: wp.vec3f) -> float:
    """Pitch about `lateral` that brings a foot, from ball to ankle, into a direction [rad]."""
    across = direction - wp.dot(direction, lateral) * lateral
    return wp.atan2(wp.dot(wp.cross(foot, across), lateral), wp.dot(foot, across))


@wp.func
def reaching_raise(
    ankle: wp.vec3f, ball: wp.vec3f, hip: wp.vec3f, normal: wp.vec3f, lateral: wp.vec3f, longest: float
) -> float:
    """Pitch about the ball that brings the ankle of a flat foot within `longest` of the hip, as far as feet go.

    The ankle moves on a circle about the ball in the plane across `lateral`; the nearest pitch on it that reaches.
    It stays behind the ball as seen from above and along the print's `normal`, where else it would point backwards.
    """
    foot = ankle - ball
    leg = hip - ball
    square = wp.length_sq(foot) + wp.length_sq(leg) - longest * longest
    square -= 2.0 * wp.dot(foot, lateral) * wp.dot(leg, lateral)
    foot -= wp.dot(foot, lateral) * lateral
    leg -= wp.dot(leg, lateral) * lateral
    lengths = wp.max(wp.length(foot) * wp.length(leg), 1.0e-6)
    short = soft_positive(1.0 - square / (2.0 * lengths), REACHED)  # acos is infinitely steep where nothing is short
    apart = wp.acos(wp.max(1.0 - short, -1.0))
    now = raise_onto(foot, leg, lateral)
    upright = wp.min(raise_onto(foot, wp.vec3f(0.0, 1.0, 0.0), lateral), raise_onto(foot, normal, lateral))
    return wp.min(now - apart, wp.min(MOST_RAISE, upright - SHORT_OF_UPRIGHT))


@wp.func
def standing_foot(
    rig: LegRig, feet: FootArrays, contact: int, side: int, time: float, pitch: float, hip: wp.vec3f, longest: float
) -> FootPose:
    """Foot in contact: the heel stays put until flat, the ball from flat to the liftoff (design.md section 2).

    The heel rises as in the clip, and as far as a leg that would be too short behind the body needs, early enough for
    the liftoff; the ankle stays behind the ball, where on steep prints it would come over it and the foot point back.
    """
    own = feet.rows[contact]
    print_to_world = own.frame
    flat = own.flat_rotation
    lateral = own.pitch_axis
    normal = wp.quat_rotate(print_to_world, wp.vec3f(0.0, 1.0, 0.0))
    ball = own.position + wp.vec3f(0.0, rig.ball_heights[side] / normal[1], 0.0)
    pose = FootPose()
    pose.ground = print_to_world
    rolling = own.flat - own.strike
    if time < own.flat and rolling > 0.0:
        fraction = smootherstep((time - own.strike) / rolling)
        turn = wp.quat_from_axis_angle(lateral, wp.min(pitch - fraction * own.flat_pitch, 0.0))
        pose.rotation = turn * flat
        heel = ball + wp.quat_rotate(flat, rig.heel_offsets[side] - rig.ball_offsets[side])
        pose.ankle = heel - wp.quat_rotate(pose.rotation, rig.heel_offsets[side])
        pose.toes = 0.0
        return pose
    gain = float(1.0)
    if rolling > 0.0:
        gain = smootherstep((time - own.flat) / own.roll_time)
    level = ball - wp.quat_rotate(flat, rig.ball_offsets[side])
    raised = soft_positive(pitch - own.settle, JOIN)
    raised -= ramp(raised - raise_onto(level - ball, own.normal, lateral) + SHORT_OF_UPRIGHT, UPRIGHT_WIDTH)
    needed = reaching_raise(level, ball, hip, own.normal, lateral, longest)
    reaching = raised + soft_positive(needed - raised, JOIN)
    left = (own.liftoff - time) / wp.clamp(own.liftoff - own.flat, 1.0e-3, RAISE_TIME)
    leaving = raised + own.leave_raise * (1.0 - smootherstep(left))
    turn = wp.quat_from_axis_angle(lateral, gain * wp.max(reaching, leaving))
    pose.rotation = turn * flat
    pose.ankle = ball - wp.quat_rotate(pose.rotation, rig.ball_offsets[side])
    pose.toes = smootherstep((time - own.flat) / own.roll_time)
    return pose
