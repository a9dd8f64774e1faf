"""Rhythm: what the steps do to the rest of the body at any time, straight from the contacts and without memory.

Secondary motion is what the body does, a little later: signals are functions of time, so a lag is an earlier time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["SIGNALS", "FootRows", "Rhythm", "lay_foot_rows", "rhythm_at"]

SIGNALS = ("stride", "lean", "bob", "turn", "rise", "haste")
"""Columns that joints answer to: left foot ahead of the right one in legs; left leg carries 1 to right leg -1; a leg
swings 0 to 1; what the heading changed since the lag before [rad]; the body's speed upward [m/s]; Froude number of
the speed ahead, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class FootRows:
    """Contacts sorted by foot (agent times two plus side) and time, shape (C,) each."""

    contacts: IntArray
    feet: IntArray
    strikes: FloatArray
    """[s]"""
    origins: FloatArray
    """A time near each foot's first contact [s], shape (2 A,)."""


@dataclass(frozen=True, kw_only=True)
class Rhythm:
    """Signals at F times, shape (F,) each."""

    stride: FloatArray
    lean: FloatArray
    bob: FloatArray


def lay_foot_rows(contacts: ContactTable) -> FootRows:
    """The contacts in the order of each foot."""
    feet = 2 * contacts.agents + contacts.sides
    order = np.lexsort((contacts.strikes, feet))
    return FootRows(
        contacts=order, feet=feet[order], strikes=contacts.strikes[order], origins=np.repeat(contacts.starts, 2)
    )


def rhythm_at(
    contacts: ContactTable, rows: FootRows, *, agents: IntArray, times: FloatArray, yaws: FloatArray, leg_length: float
) -> Rhythm:
    """Signals of `agents` (F,) that head for `yaws` [rad] (F,) at `times` [s] (F,)."""
    places, swings = [], []
    for side in (0, 1):
        latest = rows.contacts[locate(rows.feet, rows.strikes, rows.origins, agents=2 * agents + side, times=times)]
        following = np.where(contacts.has_swing[latest], latest + 2, latest)
        duration = np.maximum(contacts.strikes[following] - contacts.liftoffs[latest], 1e-6)
        swung = np.where(following > latest, times - contacts.liftoffs[latest], 0.0)
        share = np.clip(swung / duration, 0.0, 1.0)
        start, end = contacts.positions[latest], contacts.positions[following]
        places.append(start + (share**2 * (3.0 - 2.0 * share))[:, None] * (end - start))
        swings.append(16.0 * share**2 * (1.0 - share) ** 2)
    apart = (places[0] - places[1])[:, [0, 2]]
    stride = np.sum(apart * planar.direction(yaws), axis=1) / leg_length
    return Rhythm(stride=stride, lean=swings[1] - swings[0], bob=swings[0] + swings[1])
