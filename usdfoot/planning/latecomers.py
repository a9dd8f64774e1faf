"""Latecomers: who of a crowd has not arrived when the simulation ends, where, and what helps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.report import Problem
from usdfoot.planning.scenario import Seeker

if TYPE_CHECKING:
    from usdfoot.planning.simulation import Tracks

__all__ = ["find_latecomers"]

LATELY, HARDLY = 5.0, 0.5
"""Who has lately, in so many seconds, moved by less than this [m] is held up."""
TOGETHER = 3.0
"""Held up in one place are those so near each other [m]."""


def find_latecomers(seekers: Sequence[Seeker], tracks: Tracks, *, duration: float) -> list[Problem]:
    """A warning for everybody who has not arrived, after one that says how many they are, where, and what helps.

    Args:
        seekers: All people.
        tracks: Where they were.
        duration: Simulated at most [s].
    """
    late = np.flatnonzero(~tracks.arrived)
    if not late.size:
        return []
    before = max(0, int(np.searchsorted(tracks.times, tracks.times[-1] - LATELY)))
    moved = np.linalg.norm(tracks.points[-1] - tracks.points[before], axis=1)
    found = [_summary(tracks.points[-1], tracks, moved < HARDLY, duration)] if len(seekers) > 1 else []
    for index in late.tolist():
        x, z = tracks.points[-1, index]
        what = f"does not get to its goal; it stops {tracks.left[index]:.2f} m before it, at ({x:.2f}, {z:.2f}) m"
        found.append(_warning(seekers[index].name, f"{seekers[index].name}: {what}"))
    return found


def _summary(points: FloatArray, tracks: Tracks, stands: BoolArray, duration: float) -> Problem:
    """How many have not arrived, whether they walk or are held up, where most are, and what helps."""
    late = ~tracks.arrived
    walking, held_up = int(np.sum(late & ~stands)), points[late & stands]
    what = f"{int(late.sum())} of {len(late)} agents do not get to their goals in {tracks.times[-1]:.0f} s"
    parts, remedies = [], []
    if walking:
        parts.append(f"{walking} are on their way")
    if walking and tracks.times[-1] + 1.0 >= duration:
        remedies.append("simulate longer (--duration)")
    if len(held_up):
        near = cKDTree(held_up).query_ball_point(held_up, TOGETHER, return_length=True)
        x, z = held_up[int(np.argmax(near))]
        parts.append(f"{len(held_up)} are held up, {int(near.max())} of them near ({x:.1f}, {z:.1f}) m")
        remedies.append("widen the way there, or give them narrower bodies (--radius)")
    return _warning("crowd", f"{what}: {', '.join(parts)}; {', '.join(remedies) or 'move their goals'}")


def _warning(where: str, what: str) -> Problem:
    return Problem(severity="warning", where=where, message=what)
