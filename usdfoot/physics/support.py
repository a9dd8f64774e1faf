"""What the legs offer at any time: which stand, where they press, where the ankles are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import HUMAN_LEG, PhysicsBiped
from usdfoot.physics.leg_profile import ContactGaits, foot_pitches, measure_gaits, nominal_lengths, rolled_ankles
from usdfoot.physics.options import PhysicsOptions

__all__ = ["Stance", "find_stance", "print_orientations"]

ROLL_TIME = 0.4
"""Longest time from heel to flat and from flat to toe on a leg of 0.86 m; a foot that stands longer is flat in between
[s]."""
HEEL_OFF = 0.6
"""Part of the contact after which the foot is on its toes."""
RUN_START = 0.5
"""Where along the foot it presses first after a flight, 0 heel to 1 toe (Cavanagh and Lafortune 1980)."""


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
    """Ankles of the rolling feet, or of the flat ones as in [P] [m], world, shape (F, 2, 3)."""
    nominal_lengths: FloatArray
    """Comfortable lengths of the virtual legs [m], shape (F, 2)."""


def find_stance(
    contacts: ContactTable, biped: PhysicsBiped, agents: IntArray, times: FloatArray, options: PhysicsOptions
) -> Stance:
    """Both legs of the agents (F,) at F times [s]."""
    latest = locate(contacts.agents, contacts.strikes, contacts.starts, agents, times)
    first = contacts.first[agents]
    previous = np.where(latest > first, latest - 1, np.minimum(latest + 1, contacts.first[agents + 1] - 1))
    swapped = contacts.sides[latest] == 1
    rows = np.where(swapped[:, None], np.stack([previous, latest], axis=1), np.stack([latest, previous], axis=1))
    when = times[:, None]
    strikes, liftoffs = contacts.strikes[rows], contacts.liftoffs[rows]
    progress = np.clip((when - strikes) / np.maximum(liftoffs - strikes, 1e-9), 0.0, 1.0)
    gaits = measure_gaits(contacts, biped.maximal_length)
    smooth = options.support == "smooth"
    longest = ROLL_TIME * np.sqrt(biped.maximal_length / HUMAN_LEG)
    share = _pressing(gaits, contacts, rows, when, longest) if smooth else np.where(progress > HEEL_OFF, 1.0, 0.5)
    offsets = np.zeros((*rows.shape, 3))
    offsets[..., 2] = biped.heel + (biped.toe - biped.heel) * share
    places, turns = contacts.positions[rows], print_orientations(contacts)[rows]
    lengths = np.full(rows.shape, biped.nominal_length)
    ankles = np.broadcast_to(biped.ankles, offsets.shape)
    if options.leg_play > 0.0:
        lengths = nominal_lengths(biped, gaits, rows, progress, play=options.leg_play)
        ankles = rolled_ankles(biped, foot_pitches(gaits, rows, progress))
    return Stance(
        contacts=rows,
        standing=(when >= strikes) & (when <= liftoffs),
        progress=progress,
        supports=places + quaternion.rotate(turns, offsets),
        ankles=places + quaternion.rotate(turns, ankles),
        nominal_lengths=lengths,
    )


def print_orientations(contacts: ContactTable) -> FloatArray:
    """Print frames to world, xyzw, shape (C, 4): +Y along the ground's normal, +Z the foot's heading."""
    x, y, z = contacts.normals.T
    tilt = quaternion.normalised(np.stack([z, np.zeros_like(x), -x, 1.0 + y], axis=1))
    return quaternion.compose(tilt, quaternion.yaw_quaternion(contacts.yaws))


def _pressing(
    gaits: ContactGaits, contacts: ContactTable, rows: IntArray, times: FloatArray, longest: float
) -> FloatArray:
    """Where along the foot it presses at `times`, 0 heel to 1 toe, shape as `rows`.

    It goes from heel to toe in the direction of travel: from toe to heel in backward steps, nowhere in side steps. A
    foot that stands at the begin or end of the motion presses with its middle, and so does one that stands longer than
    it takes twice the `longest` time [s] to roll.
    """
    strikes, liftoffs = contacts.strikes[rows], contacts.liftoffs[rows]
    half = np.minimum(0.5 * np.maximum(liftoffs - strikes, 1e-9), longest)
    on = np.where(gaits.begins[rows], 1.0, np.clip((times - strikes) / half, 0.0, 1.0))
    off = np.where(gaits.ends[rows], 1.0, np.clip((liftoffs - times) / half, 0.0, 1.0))
    start = RUN_START * gaits.lands[rows]
    travelled = start + (1.0 - start) * (0.5 + 0.5 * (on - off))
    return 0.5 + (travelled - 0.5) * gaits.alignments[rows]
