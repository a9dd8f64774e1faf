"""What the legs offer at any time: which stand, where they press, where the ankles are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped

__all__ = ["Stance", "find_stance", "print_orientations"]

ROLL_TIME = 0.4
"""Longest time from heel to flat and from flat to toe; a foot that stands longer is flat in between [s]."""
HEEL_OFF = 0.6
"""Part of the contact after which the foot is on its toes."""


@dataclass(frozen=True, kw_only=True)
class Stance:
    """Both legs at F times; the last axes are (left, right)."""

    contacts: IntArray
    """Contact of the foot: the one it stands in or stood in last, its first before that, shape (F, 2)."""
    standing: BoolArray
    """Whether the foot is on the ground, shape (F, 2)."""
    progress: FloatArray
    """Part of the contact passed, 0 strike to 1 liftoff, shape (F, 2)."""
    supports: FloatArray
    """[P]'s point of support: where the foot presses on the ground [m], world, shape (F, 2, 3)."""
    ankles: FloatArray
    """Where the ankle is with the foot flat on its print [m], world, shape (F, 2, 3)."""


def find_stance(
    contacts: ContactTable, biped: PhysicsBiped, agents: IntArray, times: FloatArray, *, smooth: bool = True
) -> Stance:
    """Both legs of the agents at F times.

    Args:
        contacts: Of all agents.
        biped: Shape of the feet.
        agents: Shape (F,).
        times: [s], shape (F,).
        smooth: The support moves from heel to toe over the contact; otherwise it is the middle of the print and, once
            the heel is off, the toe ([P] 2.4.1).
    """
    latest = locate(contacts.agents, contacts.strikes, contacts.starts, agents, times)
    first = contacts.first[agents]
    previous = np.where(latest > first, latest - 1, np.minimum(latest + 1, contacts.first[agents + 1] - 1))
    swapped = contacts.sides[latest] == 1
    rows = np.where(swapped[:, None], np.stack([previous, latest], axis=1), np.stack([latest, previous], axis=1))
    when = times[:, None]
    strikes, liftoffs = contacts.strikes[rows], contacts.liftoffs[rows]
    standing = (when >= strikes) & (when <= liftoffs)
    turns = print_orientations(contacts)[rows]
    progress = np.clip((when - strikes) / np.maximum(liftoffs - strikes, 1e-9), 0.0, 1.0)
    share = _roll(contacts, rows, when) if smooth else np.where(progress > HEEL_OFF, 1.0, 0.5)
    offsets = np.zeros((*rows.shape, 3))
    offsets[..., 2] = 0.5 * (biped.heel + biped.toe) + (biped.toe - biped.heel) * (share - 0.5)
    places = contacts.positions[rows]
    return Stance(
        contacts=rows,
        standing=standing,
        progress=progress,
        supports=places + quaternion.rotate(turns, offsets),
        ankles=places + quaternion.rotate(turns, np.broadcast_to(biped.ankles, offsets.shape)),
    )


def print_orientations(contacts: ContactTable) -> FloatArray:
    """Print frames to world, xyzw, shape (C, 4): +Y along the ground's normal, +Z the foot's heading."""
    tilt = quaternion.between(np.array([0.0, 1.0, 0.0]), contacts.normals)
    return quaternion.compose(tilt, quaternion.yaw_quaternion(contacts.yaws))


def _roll(contacts: ContactTable, rows: IntArray, times: FloatArray) -> FloatArray:
    """Where along the foot it presses at `times`, 0 heel to 1 toe, shape as `rows`.

    It goes from heel to toe in the direction of travel: from toe to heel in backward steps, nowhere in side steps. A
    foot that stands at the begin or end of the motion presses with its middle.
    """
    strikes, liftoffs = contacts.strikes[rows], contacts.liftoffs[rows]
    half = np.minimum(0.5 * np.maximum(liftoffs - strikes, 1e-9), ROLL_TIME)
    agents = contacts.agents[rows]
    on = np.clip((times - strikes) / half, 0.0, 1.0)
    off = np.clip((liftoffs - times) / half, 0.0, 1.0)
    on = np.where((strikes <= contacts.starts[agents]) & ~contacts.has_previous[rows], 1.0, on)
    on = np.where(_strikes_together(contacts)[rows], 1.0, on)
    off = np.where((liftoffs >= contacts.ends[agents]) & ~contacts.has_swing[rows], 1.0, off)
    return 0.5 + 0.5 * (on - off) * _alignment(contacts)[rows]


def _strikes_together(contacts: ContactTable) -> BoolArray:
    """Whether a contact begins with the motion in a stand on both feet, shape (C,)."""
    previous = np.maximum(np.arange(len(contacts.sides)) - 1, 0)
    return contacts.has_previous & (contacts.strikes == contacts.strikes[previous])


def _alignment(contacts: ContactTable) -> FloatArray:
    """Cosine between the foot's heading and the way the body travels over it, shape (C,)."""
    index = np.arange(len(contacts.sides))
    before = np.where(contacts.has_previous, index - 1, index)
    after = np.where(contacts.has_next, index + 1, index)
    travel = (contacts.positions[after] - contacts.positions[before])[:, [0, 2]]
    length = np.linalg.norm(travel, axis=1)
    along = np.sum(travel * planar.direction(contacts.yaws), axis=1)
    return np.divide(along, length, out=np.zeros_like(along), where=length > 1e-9)
