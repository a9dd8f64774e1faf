"""Steps of many clips as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from usdfoot.analysis.steps import Step
from usdfoot.analysis.world import WorldClip
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["ROLES", "StepTable", "tabulate"]

ROLES = ("departure", "support", "landing")
"""Of the contacts that a step joins."""


@dataclass(frozen=True, kw_only=True)
class StepTable:
    """E steps in order of clips and time."""

    clips: IntArray
    """Index of the clip, shape (E,)."""
    runs: IntArray
    """The same, counted over the clips that have steps, shape (E,)."""
    swing_sides: IntArray
    """0 = left, 1 = right, shape (E,)."""
    starts: FloatArray
    """Strike of the support foot [s], shape (E,)."""
    ends: FloatArray
    """Strike of the swing foot [s], shape (E,)."""
    support_flats: FloatArray
    """Support foot is flat [s], shape (E,)."""
    swing_liftoffs: FloatArray
    """Swing foot leaves its departure [s], shape (E,)."""
    support_liftoffs: FloatArray
    """Support foot leaves the ground [s], shape (E,)."""
    contacts: IntArray
    """Numbers of the contacts joined, by role, each among those of its side, shape (E, 3)."""
    flats: FloatArray
    """When these are flat [s], shape (E, 3)."""
    liftoffs: FloatArray
    """When the ball leaves them [s], shape (E, 3)."""

    def __len__(self) -> int:
        return len(self.clips)

    def contacts_of(self, role: str) -> IntArray:
        """Run, side and number of the contacts of a role, shape (E, 3)."""
        sides = 1 - self.swing_sides if role == "support" else self.swing_sides
        return np.stack([self.runs, sides, self.contacts[:, ROLES.index(role)]], axis=1)

    def mirrored(self, keep: BoolArray) -> StepTable:
        """The mirror images of the steps at which `keep` (E,) is True."""
        kept = {field.name: getattr(self, field.name)[keep] for field in fields(self)}
        return StepTable(**{**kept, "swing_sides": 1 - kept["swing_sides"]})


def tabulate(worlds: Mapping[int, WorldClip], steps: Mapping[int, Sequence[Step]]) -> StepTable:
    """The table of the steps of clips, both by the clips' index."""
    clips = [clip for clip, own in steps.items() for _ in own]
    every = [step for own in steps.values() for step in own]
    contacts = np.array([(step.departure, step.support, step.landing) for step in every], dtype=int).reshape(-1, 3)
    planted = np.zeros((len(every), len(ROLES), 2))
    for row, (clip, step) in enumerate(zip(clips, every, strict=True)):
        for role, side in enumerate((step.swing_side, 1 - step.swing_side, step.swing_side)):
            foot, number = worlds[clip].contacts[side], contacts[row, role]
            planted[row, role] = foot.flat_times[number], foot.liftoff_times[number]
    return StepTable(
        clips=np.array(clips, dtype=np.int64),
        runs=np.unique(clips, return_inverse=True)[1].reshape(-1),
        swing_sides=np.array([step.swing_side for step in every], dtype=int),
        starts=np.array([step.start for step in every]),
        ends=np.array([step.end for step in every]),
        support_flats=np.array([step.flat for step in every]),
        swing_liftoffs=np.array([step.swing_liftoff for step in every]),
        support_liftoffs=np.array([step.support_liftoff for step in every]),
        contacts=contacts,
        flats=planted[..., 0],
        liftoffs=planted[..., 1],
    )
