"""Faults: what lint says of footsteps, and what it takes for right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable

__all__ = ["ERROR", "WARNING", "Fault", "LintLimits", "faults_at"]

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True, kw_only=True)
class LintLimits:
    """What is still right."""

    longest_step: float = 1.5
    """Of a walking step, over the leg length, beside what the hips are apart."""
    highest_step: float = 0.6
    """Rise of a walking step, over the leg length."""
    fastest: float = 10.0
    """Speed of a step with flight, for a leg of 0.86 m [m/s]."""
    fastest_walk: float = 2.9
    """Speed of a step without, for a leg of 0.86 m [m/s]: beyond gravity cannot hold the body to it."""
    highest_jump: float = 0.8
    """Rise of the body in flight, over the leg length."""
    shortest_swing: float = 0.1
    """[s]"""
    most_hurry: float = 1.5
    """A step may be this many times as quick as the clips it is blended from."""
    crossing: float = 0.25
    """A foot may come down this far on the other one's side, over the foot length."""
    twist: float = np.radians(100.0)
    """Most between the directions of consecutive feet [rad]."""
    off_ground: float = 0.05
    """A print may be this far above or below the ground [m]."""
    steepest: float = np.radians(40.0)
    """[rad]"""
    poke: float = 0.05
    """Ground may rise this much through the sole [m]."""
    headroom: float = 1.8
    """Free height above a print, over the leg length."""
    collision: float = 0.005
    """Feet of two people may overlap this much [m]."""
    bump: float = 0.03
    """A sole may be this far in an obstacle [m]."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something wrong with one footstep."""

    plan: str
    """Name of the plan."""
    footstep: int
    """Index; -1 = of the plan as a whole."""
    kind: str
    """unreachable | flight | crossing | twisted | hurried | offTerrain | offGround | steep | obstructed | obstacle |
    collision | malformed"""
    severity: str
    """error = cannot be walked as planned, warning = will look wrong."""
    value: float
    """How much, in the unit the message names."""
    message: str

    def to_json(self) -> dict[str, object]:
        """A plain dictionary."""
        return dict(vars(self))


def faults_at(
    names: Sequence[str],
    feet: FootTable,
    rows: IntArray,
    *,
    kind: str,
    values: FloatArray,
    message: str,
    severity: str = ERROR,
) -> list[Fault]:
    """One fault a footstep.

    Args:
        names: Of the plans.
        feet: Footsteps of all plans.
        rows: Footsteps that are wrong, shape (K,).
        kind: Of the faults.
        values: How much, shape (K,).
        message: With a place for the value.
        severity: Of the faults.
    """
    return [
        Fault(
            plan=names[owner],
            footstep=int(number),
            kind=kind,
            severity=severity,
            value=float(value),
            message=message.format(float(value)),
        )
        for owner, number, value in zip(feet.owners[rows], feet.numbers[rows], values, strict=True)
    ]
