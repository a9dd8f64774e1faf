"""Warp kernels that hold the stance feet on their footsteps and lead the swing feet from one to the next ([B] 4.5)."""

from __future__ import annotations

import warp as wp

from usdfoot.engine.easing import ramp, smootherstep, together
from usdfoot.engine.foot_rows import FootArrays
from usdfoot.engine.legs import Leg, LegRig, bend_leg, leg_kinematics, rotation_by
from usdfoot.engine.pelvis import longest_leg, moved_leg, pelvis_offset
from usdfoot.engine.standing_foot import FootPose, heel_raise, standing_foot

__all__ = ["measure_legs", "plant_feet", "swinging_foot"]

SLACK = wp.constant(0.12)
"""From how much before its reach a swinging leg takes its foot along, over the leg's reach."""
LEAST_SLACK = wp.constant(0.004)
"""The same where the pelvis keeps wholly to the foot [m]."""
EASE_TIME = wp.constant(0.25)
"""The pelvis sinks at most so long before a strike or liftoff that needs it low, and rises as long after [s]."""


@wp.func
def swinging_foot(rig: LegRig, feet: FootArrays, contact: int, side: int, time: float, leg: Leg) -> FootPose:
    """Foot in the air: the blended path, led from the footprint it leaves to the one it lands on."""
    own = feet.rows[contact]
    begin = own.liftoff
    fraction = wp.clamp((time - begin) / (feet.rows[own.following].strike - begin), 0.0, 1.0)
    weight = smootherstep(fraction)
    leave = own.leave_rotation
    land = own.land_rotation
    if wp.dot(leave, land) < 0.0:
        land = -land
    correction = wp.normalize(leave * (1.0 - weight) + land * weight)
    knots = feet.detours.shape[1] - 1
    place = fraction * float(knots)
    row = wp.min(int(place), knots - 1)
    x = place - float(row)
    before = feet.detours[contact, wp.max(row - 1, 0)]
    start = feet.detours[contact, row]
    end = feet.detours[contact, row + 1]
    after = feet.detours[contact, wp.min(row + 2, knots)]
    slope_start = 0.5 * (end - before)
    slope_end = 0.5 * (after - start)
    detour = start + x * slope_start
    detour += x * x * (3.0 * (end - start) - 2.0 * slope_start - slope_end)
    detour += x * x * x * (2.0 * (start - end) + slope_start + slope_end)
    ball = leg.ball + own.leave_offset * (1.0 - weight) + own.land_offset * weight + detour
    pose = FootPose()
    pose.rotation = correction * leg.rotation_of_ankle
    pose.ankle = ball - wp.quat_rotate(pose.rotation, rig.ball_offsets[side])
    ahead = feet.rows[own.following].frame
    if wp.dot(own.frame, ahead) < 0.0:
        ahead = -ahead
    pose.ground = wp.normalize(own.frame * (1.0 - weight) + ahead * weight)
    pose.toes = 1.0 - weight
    return pose


@wp.func
def foot_pose(rig: LegRig, feet: FootArrays, contact: int, side: int, time: float, leg: Leg) -> FootPose:
    """Foot of a contact or of the swing after it."""
    if time <= feet.rows[contact].liftoff:
        return standing_foot(rig, feet, contact, side, time, heel_raise(rig, side, leg), leg.hip, longest_leg(rig, leg))
    return swinging_foot(rig, feet, contact, side, time, leg)


@wp.func
def eased_drop(feet: FootArrays, contact: int, time: float) -> float:
    """How far the pelvis is lowered about a foot's strikes and liftoffs for what it needs there [m]."""
    own = feet.rows[contact]
    row = contact
    room = own.liftoff - own.strike
    from_strike = time - own.strike
    from_liftoff = wp.abs(time - own.liftoff)
    if time > own.liftoff:
        row = own.following
        room = feet.rows[row].strike - own.liftoff
        from_strike = feet.rows[row].strike - time
    longest = wp.max(wp.min(room, EASE_TIME), 1.0e-3)
    struck = feet.rows[row].drop * (1.0 - smootherstep(from_strike / longest))
    return struck + own.leave_drop * (1.0 - smootherstep(from_liftoff / longest))


@wp.func
def hold(feet: FootArrays, contact: int, time: float) -> float:
    """How far the pelvis keeps to what a foot needs, 0..1: wholly in contact, less and less away from it.

    In mid swing the foot comes along with the body instead.
    """
    own = feet.rows[contact]
    begin = own.liftoff
    end = feet.rows[own.following].strike
    away = wp.min(time - begin, end - time)
    return 1.0 - smootherstep(away / wp.max(wp.min(0.5 * (end - begin), EASE_TIME), 1.0e-3))


@wp.func
def taken_along(rig: LegRig, leg: Leg, pose: FootPose, hold: float) -> FootPose:
    """The foot where the leg reaches it, with the knee never quite straight where the pelvis does not keep to it."""
    reach = pose.ankle - leg.hip
    span = wp.length(reach)
    longest = longest_leg(rig, leg)
    near = FootPose()
    near.rotation = pose.rotation
    near.toes = pose.toes
    near.ground = pose.ground
    near.ankle = leg.hip + reach * (
        1.0 - ramp(span - longest, LEAST_SLACK + SLACK * (1.0 - hold) * longest) / wp.max(span, 1.0e-3)
    )
    return near


@wp.func
def finish_foot(
    rig: LegRig, side: int, pose: FootPose, leg: Leg, rotations: wp.array2d(dtype=wp.quatf), frame: int
) -> float:
    """Bends the leg and sets the foot; returns 0."""
    parent = bend_leg(rig, side, leg, pose.ankle, rotations, frame)
    rotations[frame, rig.roles[side, 2]] = wp.normalize(wp.quat_inverse(parent) * pose.rotation)
    ball_parent = pose.rotation * wp.quat_inverse(leg.rotation_of_ankle) * leg.parent_of_ball
    flat_toes = wp.quat_inverse(ball_parent) * pose.ground * rig.flat_toes[side]
    toes = wp.quat_inverse(leg.parent_of_ball) * leg.rotation_of_ball
    if wp.dot(flat_toes, toes) < 0.0:
        toes = -toes
    rotations[frame, rig.roles[side, 3]] = wp.normalize(toes * (1.0 - pose.toes) + flat_toes * pose.toes)
    return 0.0


@wp.func
def nudged_foot(rig: LegRig, side: int, pose: FootPose, shift: wp.vec3f, turn: wp.vec3f) -> FootPose:
    """The foot with its ball shifted and turned about it by a rotation vector."""
    ball = pose.ankle + wp.quat_rotate(pose.rotation, rig.ball_offsets[side]) + shift
    nudged = FootPose()
    nudged.rotation = rotation_by(turn) * pose.rotation
    nudged.ankle = ball - wp.quat_rotate(nudged.rotation, rig.ball_offsets[side])
    nudged.toes = pose.toes
    nudged.ground = pose.ground
    return nudged


@wp.kernel(enable_backward=False)
def plant_feet(
    rig: LegRig,
    feet: FootArrays,
    contacts: wp.array2d(dtype=wp.int32),
    times: wp.array(dtype=wp.float32),
    shifts: wp.array2d(dtype=wp.vec3f),
    turns: wp.array2d(dtype=wp.vec3f),
    pelvis_positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Lowers the pelvis as far as the legs need and bends the legs to the feet, both in place.

    Where there are any `shifts` and `turns` (F, 2), the feet are nudged by them.
    """
    frame = wp.tid()
    time = times[frame]
    pelvis = pelvis_positions[frame]
    turn = pelvis_rotations[frame]
    left = leg_kinematics(rig, 0, pelvis, turn, rotations, frame)
    right = leg_kinematics(rig, 1, pelvis, turn, rotations, frame)
    left_pose = foot_pose(rig, feet, contacts[frame, 0], 0, time, left)
    right_pose = foot_pose(rig, feet, contacts[frame, 1], 1, time, right)
    if shifts.shape[0] > 0:
        left_pose = nudged_foot(rig, 0, left_pose, shifts[frame, 0], turns[frame, 0])
        right_pose = nudged_foot(rig, 1, right_pose, shifts[frame, 1], turns[frame, 1])
    eased = together(eased_drop(feet, contacts[frame, 0], time), eased_drop(feet, contacts[frame, 1], time))
    left_hold = hold(feet, contacts[frame, 0], time)
    right_hold = hold(feet, contacts[frame, 1], time)
    offset = pelvis_offset(rig, left, right, left_pose.ankle, right_pose.ankle, left_hold, right_hold, eased)
    left = moved_leg(left, offset)
    right = moved_leg(right, offset)
    if time > feet.rows[contacts[frame, 0]].liftoff:
        left_pose = taken_along(rig, left, left_pose, left_hold)
    if time > feet.rows[contacts[frame, 1]].liftoff:
        right_pose = taken_along(rig, right, right_pose, right_hold)
    pelvis_positions[frame] = pelvis + offset
    finish_foot(rig, 0, left_pose, left, rotations, frame)
    finish_foot(rig, 1, right_pose, right, rotations, frame)


@wp.kernel(enable_backward=False)
def measure_legs(
    rig: LegRig,
    pelvis_positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
    ankles: wp.array2d(dtype=wp.vec3f),
    ankle_rotations: wp.array2d(dtype=wp.quatf),
    balls: wp.array2d(dtype=wp.vec3f),
    raises: wp.array2d(dtype=wp.float32),
    hips: wp.array2d(dtype=wp.vec3f),
    longest: wp.array2d(dtype=wp.float32),
) -> None:
    """Hips, ankles, balls, heel raise and reach of both legs by forward kinematics."""
    frame, side = wp.tid()
    leg = leg_kinematics(rig, side, pelvis_positions[frame], pelvis_rotations[frame], rotations, frame)
    ankles[frame, side] = leg.ankle
    ankle_rotations[frame, side] = leg.rotation_of_ankle
    balls[frame, side] = leg.ball
    raises[frame, side] = heel_raise(rig, side, leg)
    hips[frame, side] = leg.hip
    longest[frame, side] = longest_leg(rig, leg)
