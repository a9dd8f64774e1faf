"""Feet at single instants: as blended, and as their contacts hold them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.contact_feet import ContactFeet, device_feet
from usdfoot.engine.foot_rows import FootArrays
from usdfoot.engine.legs import LegRig
from usdfoot.engine.pose_source import Feet, Layout
from usdfoot.engine.standing_foot import standing_foot
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["HeldFeet", "hold_feet"]


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


def hold_feet(layout: Layout, feet: ContactFeet, rows: IntArray, *, times: FloatArray, blended: Feet) -> HeldFeet:
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
