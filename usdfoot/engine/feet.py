"""Set-up of the feet: roll of each contact, and how swings are led from print to print."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from usdfoot.engine.legs import LegRig
from usdfoot.engine.pelvis import MOST_DROP
from usdfoot.engine.plant import FOOT_ROW, FootArrays, FootRow, standing_foot
from usdfoot.engine.poses import Feet, Layout
from usdfoot.engine.slopes import lie_in_slopes, planned_forwards
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.ground import Ground

__all__ = [
    "ContactFeet",
    "HeldFeet",
    "device_feet",
    "foot_table",
    "hold_feet",
    "lead_swings",
    "lower_pelvis",
    "raise_heels",
    "roll_contacts",
    "settle_heels",
    "unplanted_feet",
    "with_values",
]

FLAT_TIME = 0.12
FLAT_SHARE = 0.25
"""Flat comes at most this long [s], and at most this part of the contact, after the strike (design.md section 2)."""

HOVERING = np.radians([6.0, 12.0])
"""Heels that are never lower hover up to the first, from the second on they are meant to be up [rad]."""
STANDING = np.radians(2.0)
"""So much farther they come down, so that they stand for more than an instant [rad]."""
ENDLESS = 1e3
"""Length of a leg that reaches everything [m]."""
BENT = 0.98
"""Part of the longest leg that is left to one for which the pelvis comes down: its knee is bent by 20 degrees."""


@dataclass(frozen=True, kw_only=True)
class ContactFeet:
    """Feet of the contacts (C,), what the device table is made of."""

    frames: FloatArray
    """Print to world, shape (C, 4)."""
    flat_rotations: FloatArray
    """Ankle joint in the world, foot flat, shape (C, 4)."""
    flats: FloatArray
    """Times the ball is down [s], shape (C,)."""
    flat_pitches: FloatArray
    """Pitch left in the blended foot when it has to be flat, toes up < 0 [rad], shape (C,)."""
    settles: FloatArray
    """Heel raise of the blended foot where it all but stands flat [rad], shape (C,)."""
    roll_times: FloatArray
    """From flat until the clip's pitch counts again [s], shape (C,)."""
    leave_offsets: FloatArray
    land_offsets: FloatArray
    """Planted minus blended ball at the liftoff, and at the next strike of the foot [m], shape (C, 3)."""
    leave_rotations: FloatArray
    land_rotations: FloatArray
    """Planted times inverse blended ankle rotation, likewise, shape (C, 4)."""
    drops: FloatArray
    leave_drops: FloatArray
    """How far the pelvis has to come down for the leg to reach its print, at its strike and at its liftoff [m],
    shape (C,)."""
    leave_raises: FloatArray
    """How much more than blended the heel is raised at the liftoff, for the leg to reach [rad], shape (C,)."""
    on_ground: BoolArray
    """Whether there is walkable ground under the ball, shape (C,)."""


def unplanted_feet(count: int) -> ContactFeet:
    """Feet of `count` contacts that are yet to be laid, rolled and led."""
    still = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    nowhere, zero = np.zeros((count, 3)), np.zeros(count)
    return ContactFeet(
        frames=still,
        flat_rotations=still,
        flats=zero,
        flat_pitches=zero,
        settles=zero,
        roll_times=np.ones(count),
        leave_offsets=nowhere,
        land_offsets=nowhere,
        leave_rotations=still,
        land_rotations=still,
        drops=zero,
        leave_drops=zero,
        leave_raises=zero,
        on_ground=np.zeros(count, dtype=bool),
    )


def with_values(feet: ContactFeet, rows: IntArray, values: Mapping[str, FloatArray | BoolArray]) -> ContactFeet:
    """The feet with other values, by field, of the contacts `rows` (N,)."""
    filled = {name: getattr(feet, name).copy() for name in values}
    for name, new in values.items():
        filled[name][rows] = new
    return replace(feet, **filled)


def roll_contacts(layout: Layout, feet: ContactFeet, rows: IntArray, raises: FloatArray, ground: Ground) -> ContactFeet:
    """The feet with the prints of some contacts laid and how they roll from heel to ball.

    Args:
        layout: Contacts as executed.
        feet: Of all contacts.
        rows: Contacts to roll, shape (N,).
        raises: Pitch of their blended feet at the strike [rad], shape (N,).
        ground: For the prints.
    """
    contacts = layout.contacts[rows]
    frames, on_ground = lie_in_slopes(replace(layout, contacts=contacts), ground)
    flat_feet = np.array([foot.flat_rotation for foot in layout.rig.feet])
    durations = contacts.liftoffs - contacts.strikes
    heel_first = (raises < -0.01) & ~_from_standing(layout.contacts)[rows]
    flats = contacts.strikes + np.where(heel_first, np.minimum(FLAT_TIME, FLAT_SHARE * durations), 0.0)
    rolled = {
        "frames": frames,
        "flat_rotations": quaternion.compose(frames, flat_feet[contacts.sides]),
        "flats": flats,
        "roll_times": np.maximum(0.3 * (contacts.liftoffs - flats), 1e-3),
        "on_ground": on_ground,
    }
    return with_values(feet, rows, rolled)


def _from_standing(contacts: ContactTable) -> BoolArray:
    """Contacts that an agent starts standing on: they are flat at once, shape (C,)."""
    first = contacts.first[:-1]
    flags = np.zeros(len(contacts.sides), dtype=bool)
    flags[first] = flags[first + 1] = contacts.strikes[first] == contacts.strikes[first + 1]
    return flags


def foot_table(layout: Layout, feet: ContactFeet) -> Any:
    """Contacts as rows of the device table, on the host, shape (C,)."""
    contacts = layout.contacts
    clock = contacts.starts[contacts.agents]
    table: Any = np.empty(len(clock), dtype=FOOT_ROW)
    table["following"] = np.minimum(np.arange(len(clock)) + 2, len(clock) - 1)
    table["strike"], table["flat"] = contacts.strikes - clock, feet.flats - clock
    table["liftoff"] = np.where(contacts.has_swing, contacts.liftoffs, np.inf) - clock
    table["flat_pitch"], table["roll_time"] = feet.flat_pitches, feet.roll_times
    table["settle"] = feet.settles
    table["drop"], table["leave_drop"] = feet.drops, feet.leave_drops
    table["leave_raise"] = feet.leave_raises
    table["position"] = contacts.positions - layout.origins[contacts.agents]
    table["normal"] = contacts.normals
    table["pitch_axis"] = np.cross(contacts.normals, planned_forwards(contacts))
    table["leave_offset"], table["land_offset"] = feet.leave_offsets, feet.land_offsets
    table["frame"], table["flat_rotation"] = feet.frames, feet.flat_rotations
    table["leave_rotation"], table["land_rotation"] = feet.leave_rotations, feet.land_rotations
    return table


def device_feet(layout: Layout, feet: ContactFeet, detours: FloatArray) -> FootArrays:
    """Contacts as device arrays; `detours` [m] (C, K, 3) are added to the swings."""
    arrays = FootArrays()
    arrays.rows = wp.array(foot_table(layout, feet), dtype=FootRow, copy=False)
    arrays.detours = wp.array(np.ascontiguousarray(detours, dtype=np.float32), dtype=wp.vec3f, copy=False)
    return arrays


@wp.kernel(enable_backward=False)
def pose_contacts(
    rig: LegRig,
    feet: FootArrays,
    contacts: wp.array(dtype=wp.int32),
    sides: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float32),
    pitches: wp.array(dtype=wp.float32),
    hips: wp.array(dtype=wp.vec3f),
    longest: wp.array(dtype=wp.float32),
    balls: wp.array(dtype=wp.vec3f),
    rotations: wp.array(dtype=wp.quatf),
) -> None:
    """Ball and ankle rotation of feet in contact."""
    k = wp.tid()
    pose = standing_foot(rig, feet, contacts[k], sides[k], times[k], pitches[k], hips[k], longest[k])
    rotations[k] = pose.rotation
    balls[k] = pose.ankle + wp.quat_rotate(pose.rotation, rig.ball_offsets[sides[k]])


@dataclass(frozen=True, kw_only=True)
class HeldFeet:
    """Feet at one instant each, as blended and as their contacts hold them."""

    hips: FloatArray
    """From the agents' origins [m], shape (N, 3)."""
    longest: FloatArray
    """Distance from hip to ankle that the leg may be stretched to [m], shape (N,)."""
    blended_balls: FloatArray
    balls: FloatArray
    """From the agents' origins [m], shape (N, 3)."""
    blended_rotations: FloatArray
    rotations: FloatArray
    """Ankle joints, shape (N, 4)."""

    def __getitem__(self, rows: IntArray | slice) -> HeldFeet:
        return HeldFeet(**{name: values[rows] for name, values in vars(self).items()})

    @property
    def offsets(self) -> FloatArray:
        """Held minus blended balls [m], shape (N, 3)."""
        return self.balls - self.blended_balls

    @property
    def turns(self) -> FloatArray:
        """Held times inverse blended rotations, shape (N, 4)."""
        turned = quaternion.compose(self.rotations, quaternion.inverse(self.blended_rotations))
        return quaternion.align_signs(turned, np.array([0.0, 0.0, 0.0, 1.0]))


def hold_feet(layout: Layout, feet: ContactFeet, rows: IntArray, times: FloatArray, blended: Feet) -> HeldFeet:
    """The feet of contacts `rows` (N,) at `times` [s] (N,), when they are on the ground.

    Args:
        layout: Contacts as executed.
        feet: Prints and rolls.
        rows: Contacts.
        times: One instant each.
        blended: Feet at these instants, one frame each.
    """
    contacts = layout.contacts
    sides, clock = contacts.sides[rows], times - contacts.starts[contacts.agents[rows]]
    own = np.arange(len(rows)), sides
    balls = wp.empty(len(rows), dtype=wp.vec3f)
    rotations = wp.empty(len(rows), dtype=wp.quatf)
    wp.launch(
        pose_contacts,
        dim=len(rows),
        inputs=[
            layout.rig.arrays,
            device_feet(layout, feet, np.zeros((len(contacts.sides), 2, 3))),
            wp.array(rows.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(sides.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(clock.astype(np.float32), dtype=wp.float32, copy=False),
            wp.array(blended.raises[own].astype(np.float32), dtype=wp.float32, copy=False),
            wp.array(blended.hips[own].astype(np.float32), dtype=wp.vec3f, copy=False),
            wp.array(blended.longest[own].astype(np.float32), dtype=wp.float32, copy=False),
        ],
        outputs=[balls, rotations],
    )
    return HeldFeet(
        hips=blended.hips[own],
        longest=blended.longest[own],
        blended_balls=blended.balls[own],
        balls=balls.numpy().astype(float),
        blended_rotations=blended.rotations[own],
        rotations=rotations.numpy().astype(float),
    )


def settle_heels(feet: ContactFeet, rows: IntArray, raises: FloatArray) -> ContactFeet:
    """The feet with how far the heels of contacts `rows` (N,) come down that all but do so as blended.

    Mocap and blends let heels hover by a few degrees in some stances, where people stand on the whole sole; a heel that
    stays higher, as in runs on the forefoot, stays as it is.

    Args:
        feet: Of all contacts.
        rows: Contacts, shape (N,).
        raises: Pitches of their blended feet at instants of the stance [rad], heel up > 0, shape (N, S).
    """
    least = np.maximum(raises.min(axis=1, initial=np.inf), 0.0)
    x = np.clip((HOVERING[1] - least) / (HOVERING[1] - HOVERING[0]), 0.0, 1.0)
    return with_values(feet, rows, {"settles": (least + np.minimum(least, STANDING)) * x * x * (3.0 - 2.0 * x)})


def raise_heels(layout: Layout, feet: ContactFeet, rows: IntArray, times: FloatArray, blended: Feet) -> ContactFeet:
    """The feet with how much more than blended some heels are raised when they leave.

    Args:
        layout: Contacts as executed.
        feet: Prints and rolls; none of these heels is raised yet.
        rows: Contacts that are left, shape (N,).
        times: Their liftoffs [s], shape (N,).
        blended: Feet at these instants, one frame each.
    """
    endless = replace(blended, longest=np.full_like(blended.longest, ENDLESS))
    needed, wanted = (hold_feet(layout, feet, rows, times, legs).rotations for legs in (blended, endless))
    turns = quaternion.to_rotation_vector(quaternion.compose(needed, quaternion.inverse(wanted)))
    return with_values(feet, rows, {"leave_raises": np.linalg.norm(turns, axis=1)})


def lead_swings(layout: Layout, feet: ContactFeet, rows: IntArray, leaves: HeldFeet, lands: HeldFeet) -> ContactFeet:
    """The feet with offsets that lead some swings from the print they leave to the one they land on.

    Args:
        layout: Contacts as executed.
        feet: Prints and rolls.
        rows: Contacts whose swings are led, shape (N,).
        leaves: The feet at their liftoffs.
        lands: The feet at the strikes that end the swings.
    """
    contacts = layout.contacts
    flying = (contacts.liftoffs[rows] < contacts.starts[contacts.agents[rows]])[:, None]  # left before the motion
    led = {
        "leave_offsets": np.where(flying, 0.0, leaves.offsets),
        "leave_rotations": np.where(flying, [0.0, 0.0, 0.0, 1.0], leaves.turns),
        "land_offsets": lands.offsets,
        "land_rotations": lands.turns,
    }
    return with_values(feet, rows, led)


def lower_pelvis(
    layout: Layout, feet: ContactFeet, rows: IntArray, lands: HeldFeet, left: IntArray, leaves: HeldFeet
) -> ContactFeet:
    """The feet with how far the pelvis has to come down for the legs to reach some prints at strikes and liftoffs.

    Args:
        layout: Contacts as executed.
        feet: Prints and rolls.
        rows: Contacts that are struck, shape (N,).
        lands: The feet at their strikes.
        left: Contacts that are left, shape (M,).
        leaves: The feet at their liftoffs.
    """
    feet = with_values(feet, rows, {"drops": _missing_reach(layout, rows, lands)})
    return with_values(feet, left, {"leave_drops": _missing_reach(layout, left, leaves)})


def _missing_reach(layout: Layout, rows: IntArray, held: HeldFeet) -> FloatArray:
    """How far the pelvis has to come down for held feet of contacts `rows` (N,), as far as it may [m], shape (N,).

    As much again, but no more than bends the knee: a leg that is straight for an instant only would snap.
    """
    ball_offsets = layout.rig.arrays.ball_offsets.numpy()[layout.contacts.sides[rows]]
    apart = held.hips - (held.balls - quaternion.rotate(held.rotations, ball_offsets))
    lengths = np.stack([held.longest, BENT * held.longest])
    heights = np.sqrt(np.maximum(lengths**2 - np.sum(apart[:, [0, 2]] ** 2, axis=1), 0.0))
    straight, bent = np.clip(apart[:, 1] - heights, 0.0, MOST_DROP * held.longest)
    return np.minimum(2.0 * straight, bent)
