"""When each foot carries weight: longer than the plan's contacts say, which are those of its ball."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import HUMAN_LEG
from usdfoot.physics.leg_profile import ContactGaits

__all__ = ["Loading", "ball_loading", "lay_loading"]

DOUBLE_STANCE = 0.284
DOUBLE_STANCE_LOSS = 0.07
"""Part of a walking step in which both feet carry: this at no speed, and less by this for every m/s on a leg of 0.86 m
(Kirtley, Whittle and Jefferson 1985: a foot stands for 64.2 % of a stride, less 3.5 % for every m/s)."""
TOE_ALONE = 0.09
"""Longest part of a step for which the toe still presses when the ball has left the ground, or presses before the ball
does in steps backward. It is no published figure: those above would have the toe press for up to 0.2 of a step where
contacts are as short as detected ones of fast walks. Then the pelvis rises by 37 % more than in CMU's walk and by 6 %
more than in Bandai Namco's, with this bound by 23 % more and 14 % less."""
LONGEST_SHIFT = 0.4
"""The weight changes over in this time at most, on a leg of 0.86 m [s]."""
AT_ONCE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Loading:
    """When the feet of C contacts carry weight, shape (C,) each."""

    begins: FloatArray
    """The foot takes weight: at its strike, in steps backward when the toe comes down [s]."""
    ends: FloatArray
    """No weight is left on it: at its liftoff, in steps ahead when the toe leaves [s]."""
    taking: FloatArray
    """Time in which it takes over from the foot before [s]."""
    giving: FloatArray
    """Time in which it gives over to the foot after [s]."""

    def weights(self, contacts: IntArray, times: FloatArray) -> FloatArray:
        """Share of the weight that each foot of contacts (F, 2) carries at times (F, 1), sums 1 or 0, shape (F, 2)."""
        begins, ends = self.begins[contacts], self.ends[contacts]
        taken = np.clip((times - begins) / self.taking[contacts], 0.0, 1.0)
        left = np.clip((ends - times) / self.giving[contacts], 0.0, 1.0)
        weights = np.where((times >= begins) & (times <= ends), np.maximum(np.minimum(taken, left), AT_ONCE), 0.0)
        return weights / np.maximum(weights.sum(axis=1, keepdims=True), AT_ONCE)


def ball_loading(contacts: ContactTable) -> Loading:
    """Weight on every foot that stands, the same on both, as in [P]."""
    at_once = np.full(len(contacts.sides), AT_ONCE)
    return Loading(begins=contacts.strikes, ends=contacts.liftoffs, taking=at_once, giving=at_once)


def lay_loading(contacts: ContactTable, gaits: ContactGaits, leg_length: float) -> Loading:
    """Weight as people put it on their feet; flights of runs and leaps stay what they are.

    Args:
        contacts: Of all agents.
        gaits: Kinds of the contacts.
        leg_length: [m].
    """
    count, size = len(contacts.sides), leg_length / HUMAN_LEG
    rows = np.flatnonzero(contacts.has_next)
    durations = contacts.strikes[rows + 1] - contacts.strikes[rows]
    distances = np.linalg.norm(contacts.positions[rows + 1] - contacts.positions[rows], axis=1)
    speeds = np.divide(distances, durations, out=np.zeros_like(distances), where=durations > 0.0) / np.sqrt(size)
    known = contacts.liftoffs[rows] - contacts.strikes[rows + 1]
    missing = np.maximum(DOUBLE_STANCE - DOUBLE_STANCE_LOSS * speeds, 0.0) * durations - known
    missing = np.clip(missing, 0.0, TOE_ALONE * durations) * (1.0 - gaits.leaps[rows])
    ahead = 0.5 + 0.25 * (gaits.alignments[rows] + gaits.alignments[rows + 1])
    begins, ends = contacts.strikes.copy(), contacts.liftoffs.copy()
    ends[rows] += ahead * missing
    begins[rows + 1] -= (1.0 - ahead) * missing
    shift = np.full(count, AT_ONCE)
    shift[rows] = np.clip(ends[rows] - begins[rows + 1], AT_ONCE, LONGEST_SHIFT * np.sqrt(size))
    taking = np.where(contacts.has_previous & ~gaits.begins, np.roll(shift, 1), AT_ONCE)
    return Loading(begins=begins, ends=ends, taking=taking, giving=np.where(gaits.ends, AT_ONCE, shift))
