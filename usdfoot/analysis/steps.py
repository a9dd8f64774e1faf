"""Steps: strike of the support foot to strike of the swing foot ([B] 4.1, design.md section 5).

From liftoff to strike, as [B]'s text has it, both double supports would be left out and steps be a fifth too short.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from usdfoot.analysis.world import WorldClip
from usdfoot.model.biped import SIDES

__all__ = ["Step", "StepLimits", "cut_steps"]


@dataclass(frozen=True, kw_only=True)
class StepLimits:
    """What a usable step is."""

    shortest: float = 0.1
    """Strike to strike [s]."""
    longest: float = 2.5
    """Strike to strike [s]."""
    slide: float = 0.05
    """Largest drift of the support ball while planted, for a leg of 0.8 m [m]."""
    reach: float = 2.2
    """Farthest landing but for what the body flies, in leg lengths."""
    rise: float = 0.5
    """Highest a body flies, in leg lengths; a longer flight is a contact that was not found."""
    overlap: float = 0.5
    """Part of a step's duration that must lie in the clip's range: of about one stride, two steps are used."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step of a clip by the contacts it joins, as indices into the world clip's contacts of either side."""

    swing_side: int
    """0 = left, 1 = right."""
    support: int
    """Contact of the support foot, which begins the step."""
    departure: int
    """Contact the swing foot leaves."""
    landing: int
    """Contact of the swing foot that ends the step."""
    start: float
    """Strike of the support foot [s]."""
    end: float
    """Strike of the swing foot [s]."""
    swing_liftoff: float
    """Swing foot leaves its departure [s]."""
    support_liftoff: float
    """Support foot leaves the ground, at the latest where the clip ends [s]."""
    flat: float
    """Support foot is flat [s]."""


def cut_steps(world: WorldClip, *, limits: StepLimits | None = None) -> tuple[tuple[Step, ...], tuple[str, ...]]:
    """Steps of a clip that can be used, in order of time, and why others in its range cannot.

    Args:
        world: The clip and its contacts.
        limits: What a usable step is; reach and slide are not judged here.

    Returns:
        Steps, and one reason for each step that was dropped.
    """
    limits = limits or StepLimits()
    strikes = sorted(
        (float(time), side, index)
        for side in range(2)
        for index, time in enumerate(world.contacts[side].strike_times)
        if np.isfinite(time)
    )
    steps, reasons = [], []
    for (start, side, support), (end, other, landing) in pairwise(strikes):
        if not _in_range(world, start, end, limits.overlap):
            continue
        fault = ""
        if other == side:
            fault = f"the {SIDES[side]} foot steps twice in a row"
        elif landing == 0:
            fault = "the swing foot's earlier contact is not in the clip"
        elif end - start < limits.shortest:
            fault = f"both feet strike within {end - start:.2f} s"
        elif end - start > limits.longest:
            fault = f"a stand of {end - start:.1f} s"
        elif _is_jump(world, side, support, landing, start):
            fault = "both feet leave the ground together"
        if fault:
            reasons.append(f"step at {start:.2f} s dropped: {fault}")
            continue
        steps.append(
            Step(
                swing_side=other,
                support=support,
                departure=landing - 1,
                landing=landing,
                start=start,
                end=end,
                swing_liftoff=float(world.contacts[other].liftoff_times[landing - 1]),
                support_liftoff=min(float(world.contacts[side].liftoff_times[support]), float(world.clip.times[-1])),
                flat=float(world.contacts[side].flat_times[support]),
            )
        )
    return tuple(steps), tuple(reasons)


def _is_jump(world: WorldClip, side: int, support: int, landing: int, start: float) -> bool:
    """Whether the support foot leaves no later than the swing foot: it never carries the body alone."""
    swing_liftoff = max(float(world.contacts[1 - side].liftoff_times[landing - 1]), start)
    return float(world.contacts[side].liftoff_times[support]) < swing_liftoff + 0.02


def _in_range(world: WorldClip, start: float, end: float, overlap: float) -> bool:
    """Whether enough of a step lies in the clip's range; of a loop each step once."""
    low = world.start if world.clip.range_start is None else world.clip.range_start
    high = world.end if world.clip.range_end is None else world.clip.range_end
    if world.period is not None and high - low > 0.9 * world.period:
        return world.start - 1e-9 <= start < world.end - 1e-9
    return min(end, high) - max(start, low) > overlap * (end - start)
