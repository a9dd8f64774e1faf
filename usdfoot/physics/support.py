"""What the legs offer at any time: which stand, where they press, where the ankles are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.biped import HUMAN_LEG
from usdfoot.physics.footing import Footing
from usdfoot.physics.leg_profile import foot_pitches, nominal_lengths, rolled_ankles

__all__ = ["Stance", "find_stance"]

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
    """Whether the foot carries weight, shape (F, 2)."""
    weights: FloatArray
    """Share of the weight on the foot, shape (F, 2)."""
    supports: FloatArray
    """[P]'s point of support: where the foot presses on the ground [m], world, shape (F, 2, 3)."""
    ankles: FloatArray
    """Ankles of the rolling feet, or of the flat ones as in [P] [m], world, shape (F, 2, 3)."""
    nominal_lengths: FloatArray
    """Comfortable lengths of the virtual legs [m], shape (F, 2)."""


def find_stance(footing: Footing, agents: IntArray, times: FloatArray) -> Stance:
    """Both legs of the agents (F,) at F times [s]."""
    contacts, biped, gaits, loading = footing.contacts, footing.biped, footing.gaits, footing.loading
    rows = _latest(footing, agents, times)
    when = times[:, None]
    strikes, liftoffs = contacts.strikes[rows], contacts.liftoffs[rows]
    progress = np.clip((when - strikes) / np.maximum(liftoffs - strikes, 1e-9), 0.0, 1.0)
    smooth = footing.options.support == "smooth"
    share = _pressing(footing, rows, when) if smooth else np.where(progress > HEEL_OFF, 1.0, 0.5)
    offsets = np.zeros((*rows.shape, 3))
    offsets[..., 2] = biped.heel + (biped.toe - biped.heel) * share
    places, turns = contacts.positions[rows], footing.turns[rows]
    lengths = np.full(rows.shape, biped.nominal_length)
    ankles = np.broadcast_to(biped.ankles, offsets.shape)
    play = footing.options.leg_play
    if play > 0.0:
        lengths = nominal_lengths(biped, gaits, rows, progress, play=play)
        ankles = rolled_ankles(biped, foot_pitches(gaits, rows, progress))
    return Stance(
        contacts=rows,
        standing=(when >= loading.begins[rows]) & (when <= loading.ends[rows]),
        weights=loading.weights(rows, when),
        supports=places + quaternion.rotate(turns, offsets),
        ankles=places + quaternion.rotate(turns, ankles),
        nominal_lengths=lengths,
    )


def _latest(footing: Footing, agents: IntArray, times: FloatArray) -> IntArray:
    """The contact that each foot carries in, or carried in last, shape (F, 2)."""
    contacts = footing.contacts
    latest = locate(contacts.agents, footing.loading.begins, contacts.starts, agents, times)
    previous = np.where(
        latest > contacts.first[agents], latest - 1, np.minimum(latest + 1, contacts.first[agents + 1] - 1)
    )
    swapped = contacts.sides[latest] == 1
    return np.where(swapped[:, None], np.stack([previous, latest], axis=1), np.stack([latest, previous], axis=1))


def _pressing(footing: Footing, rows: IntArray, times: FloatArray) -> FloatArray:
    """Where along the foot it presses at `times`, 0 heel to 1 toe, shape as `rows`.

    It goes from heel to toe in the direction of travel: from toe to heel in backward steps, nowhere in side steps. A
    foot that stands at the begin or end of the motion presses with its middle, and so does one that stands longer than
    it takes to roll twice.
    """
    gaits = footing.gaits
    begins, ends = footing.loading.begins[rows], footing.loading.ends[rows]
    longest = ROLL_TIME * np.sqrt(footing.biped.maximal_length / HUMAN_LEG)
    half = np.minimum(0.5 * np.maximum(ends - begins, 1e-9), longest)
    on = np.where(gaits.begins[rows], 1.0, np.clip((times - begins) / half, 0.0, 1.0))
    off = np.where(gaits.ends[rows], 1.0, np.clip((ends - times) / half, 0.0, 1.0))
    start = RUN_START * gaits.lands[rows]
    travelled = start + (1.0 - start) * (0.5 + 0.5 * (on - off))
    return 0.5 + (travelled - 0.5) * gaits.alignments[rows]
