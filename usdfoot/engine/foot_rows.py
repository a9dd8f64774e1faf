"""The contacts of feet as rows on the device."""

from __future__ import annotations

import warp as wp

__all__ = ["FOOT_ROW", "FootArrays", "FootRow"]


@wp.struct
class FootRow:
    """A contact on the device."""

    following: wp.int32  # next contact of the same foot
    strike: wp.float32  # agent's clock [s]
    flat: wp.float32
    liftoff: wp.float32
    flat_pitch: wp.float32  # left in the blended foot when it has to be flat [rad]
    settle: wp.float32  # heel raise of the blended foot where it all but stands flat [rad]
    roll_time: wp.float32  # from flat until the clip's pitch counts again [s]
    drop: wp.float32  # how far the pelvis has to come down at the strike [m]
    leave_drop: wp.float32  # the same at the liftoff
    leave_raise: wp.float32  # how much more than blended the heel is raised at the liftoff [rad]
    position: wp.vec3f  # ground under the ball, from the agent's origin
    normal: wp.vec3f  # of the print as planned
    pitch_axis: wp.vec3f  # heels rise about it: the yaw, seen along the plan's normal, stays
    leave_offset: wp.vec3f  # planted minus blended ball at the liftoff
    land_offset: wp.vec3f  # the same at the next strike of this foot
    frame: wp.quatf  # print to world: +Z forward, +Y normal
    flat_rotation: wp.quatf  # ankle joint in the world, foot flat on the print
    leave_rotation: wp.quatf  # planted times inverse blended ankle at the liftoff
    land_rotation: wp.quatf


FOOT_ROW = FootRow.numpy_dtype()  # type: ignore[attr-defined]
"""The same for numpy."""


@wp.struct
class FootArrays:
    """Contacts on the device, C of them."""

    rows: wp.array(dtype=FootRow)
    detours: wp.array2d(dtype=wp.vec3f)  # (C, K) added to the swing that follows, even in its time
