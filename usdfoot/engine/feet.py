"""Set-up of the feet: roll of each contact, and how swings are led from print to print."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.engine.contact_feet import ContactFeet, with_values
from usdfoot.engine.held_feet import HeldFeet, hold_feet
from usdfoot.engine.pelvis import MOST_DROP
from usdfoot.engine.pose_source import Feet, Layout
from usdfoot.engine.slopes import lie_in_slopes
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.ground import Ground

__all__ = ["FLAT_SHARE", "FLAT_TIME", "lead_swings", "lower_pelvis", "raise_heels", "roll_contacts", "settle_heels"]

FLAT_TIME = 0.12
FLAT_SHARE = 0.25
"""Flat comes at most this long [s], and at most this part of the contact, after the strike (design.md section 2)."""
TOES_UP = 0.01
"""Feet whose toes are up by more than this at the strike come down with the heel first [rad]."""
ROLL_SHARE = 0.3
"""Part of the time from flat to the liftoff until the clip's pitch counts again."""

HOVERING = np.radians([6.0, 12.0])
"""Heels that are never lower hover up to the first, from the second on they are meant to be up [rad]."""
STANDING = np.radians(2.0)
"""So much farther they come down, so that they stand for more than an instant [rad]."""
ENDLESS = 1e3
"""Length of a leg that reaches everything [m]."""
BENT = 0.98
"""Part of the longest leg that is left to one for which the pelvis comes down: its knee is bent by 20 degrees."""


def roll_contacts(
    layout: Layout, feet: ContactFeet, rows: IntArray, *, raises: FloatArray, ground: Ground
) -> ContactFeet:
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
    heel_first = (raises < -TOES_UP) & ~_from_standing(layout.contacts)[rows]
    flats = contacts.strikes + np.where(heel_first, np.minimum(FLAT_TIME, FLAT_SHARE * durations), 0.0)
    rolled = {
        "frames": frames,
        "flat_rotations": quaternion.compose(frames, flat_feet[contacts.sides]),
        "flats": flats,
        "roll_times": np.maximum(ROLL_SHARE * (contacts.liftoffs - flats), 1e-3),
        "on_ground": on_ground,
    }
    return with_values(feet, rows, rolled)


def _from_standing(contacts: ContactTable) -> BoolArray:
    """Contacts that an agent starts standing on: they are flat at once, shape (C,)."""
    first = contacts.first[:-1]
    flags = np.zeros(len(contacts.sides), dtype=bool)
    flags[first] = flags[first + 1] = contacts.strikes[first] == contacts.strikes[first + 1]
    return flags


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


def raise_heels(layout: Layout, feet: ContactFeet, rows: IntArray, *, times: FloatArray, blended: Feet) -> ContactFeet:
    """The feet with how much more than blended some heels are raised when they leave.

    Args:
        layout: Contacts as executed.
        feet: Prints and rolls; none of these heels is raised yet.
        rows: Contacts that are left, shape (N,).
        times: Their liftoffs [s], shape (N,).
        blended: Feet at these instants, one frame each.
    """
    endless = replace(blended, longest=np.full_like(blended.longest, ENDLESS))
    needed, wanted = (hold_feet(layout, feet, rows, times=times, blended=legs).rotations for legs in (blended, endless))
    turns = quaternion.to_rotation_vector(quaternion.compose(needed, quaternion.inverse(wanted)))
    return with_values(feet, rows, {"leave_raises": np.linalg.norm(turns, axis=1)})


def lead_swings(layout: Layout, feet: ContactFeet, rows: IntArray, *, leaves: HeldFeet, lands: HeldFeet) -> ContactFeet:
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
    layout: Layout, feet: ContactFeet, *, rows: IntArray, lands: HeldFeet, left: IntArray, leaves: HeldFeet
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
