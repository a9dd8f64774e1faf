"""The feet of contacts: prints, rolls, and what leads their swings; the table that the device takes of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from usdfoot.engine.foot_rows import FOOT_ROW, FootArrays, FootRow
from usdfoot.engine.pose_source import Layout
from usdfoot.engine.slopes import planned_forwards
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["ContactFeet", "device_feet", "foot_table", "unplanted_feet", "with_values"]


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
