"""Warp kernels over frames: joints that answer to the rhythm, legs that lead the feet from print to print ([P] 2.5)."""

from __future__ import annotations

import warp as wp

from usdfoot.engine.easing import smootherstep, soft_positive
from usdfoot.engine.legs import Leg, LegRig, bend_leg, leg_kinematics
from usdfoot.engine.pelvis import longest_leg

__all__ = ["GaitArrays", "pose_legs", "pose_upper_body"]


@wp.struct
class GaitArrays:
    """Contacts and the character on the device; a foot's next contact is two further."""

    balls: wp.array(dtype=wp.vec3f)  # (C,) ball joint on its print, agent's origin
    yaws: wp.array(dtype=wp.float32)  # (C,)
    strikes: wp.array(dtype=wp.float32)  # (C,) agent's clock [s]
    flats: wp.array(dtype=wp.float32)
    heel_offs: wp.array(dtype=wp.float32)
    liftoffs: wp.array(dtype=wp.float32)  # +inf without a swing after
    strike_pitches: wp.array(dtype=wp.float32)  # heel up > 0 [rad]
    liftoff_pitches: wp.array(dtype=wp.float32)
    launches: wp.array(dtype=wp.float32)  # (C,) speed of the pitch at the liftoff, of its mean speed since heel-off
    retracted: wp.array(dtype=wp.float32)  # (C,) length of the virtual leg in the middle of the swing after [m]
    flat_rotations: wp.array(dtype=wp.quatf)  # (2,) ankle of the flat foot that points along +Z
    nominal: wp.float32  # length of the virtual leg [m]


@wp.func
def yaw_rotation(yaw: float) -> wp.quatf:
    """Turn about +Y."""
    return wp.quat_from_axis_angle(wp.vec3f(0.0, 1.0, 0.0), yaw)


@wp.func
def stance_pitch(gait: GaitArrays, contact: int, time: float) -> float:
    """Pitch of a standing foot: from the strike's to flat, and from heel-off to the liftoff's, on into the swing."""
    flat, heel_off = gait.flats[contact], gait.heel_offs[contact]
    settled = smootherstep((time - gait.strikes[contact]) / wp.max(flat - gait.strikes[contact], 1.0e-4))
    share = wp.clamp((time - heel_off) / wp.max(gait.liftoffs[contact] - heel_off, 1.0e-4), 0.0, 1.0)
    rising = share * share * (3.0 - 2.0 * share - gait.launches[contact] * (1.0 - share))
    return gait.strike_pitches[contact] * (1.0 - settled) + gait.liftoff_pitches[contact] * rising


@wp.func
def swing_pitch(gait: GaitArrays, contact: int, share: float) -> float:
    """Pitch of the foot after `share` of the swing that follows a contact: it goes on rising, then comes down."""
    rise = wp.max(gait.liftoffs[contact] - gait.heel_offs[contact], 1.0e-4)
    swing = gait.strikes[contact + 2] - gait.liftoffs[contact]
    start, end = gait.liftoff_pitches[contact], gait.strike_pitches[contact + 2]
    passed, left = share * share * (3.0 - 2.0 * share), 1.0 - share
    return start * (1.0 - passed + gait.launches[contact] * swing / rise * share * left * left) + end * passed


@wp.func
def foot_rotation(gait: GaitArrays, side: int, yaw: float, pitch: float) -> wp.quatf:
    """Ankle joint of a foot that points along `yaw`."""
    nod = wp.quat_from_axis_angle(wp.vec3f(1.0, 0.0, 0.0), pitch)
    return yaw_rotation(yaw) * nod * gait.flat_rotations[side]


@wp.func
def lead_foot(rig: LegRig, gait: GaitArrays, side: int, contact: int, time: float, leg: Leg) -> wp.transformf:
    """Ankle of a foot that stands or swings, in the agent's world.

    In the swing the ball goes from print to print, the foot turns about one axis, and the virtual leg is retracted: it
    is no longer than a length that shrinks to the retracted one in mid swing ([P] 2.5). Nor is a leg that stands longer
    than where a swing begins or ends: what is too far away is planted by and by, not with a jerk at the strike.
    """
    liftoff = gait.liftoffs[contact]
    longest = longest_leg(rig, leg)
    if time <= liftoff:
        rotation = foot_rotation(gait, side, gait.yaws[contact], stance_pitch(gait, contact, time))
        standing = gait.balls[contact] - wp.quat_rotate(rotation, rig.ball_offsets[side]) - leg.hip
        stretched = wp.max(wp.length(standing) / longest, 1.0)
        return wp.transformf(leg.hip + standing / stretched, rotation)
    share = wp.clamp((time - liftoff) / (gait.strikes[contact + 2] - liftoff), 0.0, 1.0)
    turn = gait.yaws[contact + 2] - gait.yaws[contact]
    yaw = gait.yaws[contact] + smootherstep(share) * wp.atan2(wp.sin(turn), wp.cos(turn))
    turned = foot_rotation(gait, side, yaw, swing_pitch(gait, contact, share))
    passed = share * share * (3.0 - 2.0 * share)
    ball = gait.balls[contact] * (1.0 - passed) + gait.balls[contact + 2] * passed
    ankle = ball - wp.quat_rotate(turned, rig.ball_offsets[side])
    bump = 16.0 * share * share * (1.0 - share) * (1.0 - share)
    across = ankle - leg.hip
    length = wp.length(across)
    allowed = longest + bump * (gait.retracted[contact] - longest)
    shortened = length - soft_positive(length - allowed, 0.04 * gait.nominal * bump)
    return wp.transformf(leg.hip + across * (shortened / wp.max(length, 1.0e-6)), turned)


@wp.kernel(enable_backward=False)
def pose_upper_body(
    local: wp.array(dtype=wp.quatf),
    in_body: wp.array(dtype=wp.quatf),
    gains: wp.array2d(dtype=wp.vec3f),
    lags: wp.array(dtype=wp.int32),
    signals: wp.array3d(dtype=wp.float32),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Joint-local rotations: the hung pose, turned about the body's axes as the signals (F, lags, S) say."""
    frame, joint = wp.tid()
    turn = wp.vec3f(0.0, 0.0, 0.0)
    for s in range(gains.shape[1]):
        turn += gains[joint, s] * signals[frame, lags[joint], s]
    angle = wp.length(turn)
    rotation = local[joint]
    if angle > 1.0e-6:
        change = wp.quat_from_axis_angle(turn / angle, angle)
        rotation = rotation * wp.quat_inverse(in_body[joint]) * change * in_body[joint]
    rotations[frame, joint] = wp.normalize(rotation)


@wp.kernel(enable_backward=False)
def pose_legs(
    rig: LegRig,
    gait: GaitArrays,
    contacts: wp.array2d(dtype=wp.int32),
    times: wp.array(dtype=wp.float32),
    yaws: wp.array(dtype=wp.float32),
    pelvis_positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Legs bent to the feet; the knee looks halfway between body and foot."""
    frame, side = wp.tid()
    pelvis, turn = pelvis_positions[frame], pelvis_rotations[frame]
    leg = leg_kinematics(rig, side, pelvis, turn, rotations, frame)
    contact = contacts[frame, side]
    foot = lead_foot(rig, gait, side, contact, times[frame], leg)
    rotation = wp.transform_get_rotation(foot)
    ahead = wp.quat_rotate(rotation * wp.quat_inverse(gait.flat_rotations[side]), wp.vec3f(0.0, 0.0, 1.0))
    apart = wp.atan2(ahead[0], ahead[2]) - yaws[frame]
    apart = wp.atan2(wp.sin(apart), wp.cos(apart))
    hip = rig.roles[side, 0]
    rotations[frame, hip] = wp.quat_inverse(leg.parent_of_hip) * yaw_rotation(0.5 * apart) * leg.rotation_of_hip
    leg = leg_kinematics(rig, side, pelvis, turn, rotations, frame)
    parent = bend_leg(rig, side, leg, wp.transform_get_translation(foot), rotations, frame)
    rotations[frame, rig.roles[side, 2]] = wp.normalize(wp.quat_inverse(parent) * rotation)
