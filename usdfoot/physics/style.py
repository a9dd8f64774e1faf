"""Style: how a body moves over its footprints ([P] 2.6)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from usdfoot.errors import UsdfootError

__all__ = ["BodyStyle"]


@dataclass(frozen=True, kw_only=True)
class BodyStyle:
    """Amounts; angles are for a step as long as the leg and shrink with shorter ones.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    pitch: float = 0.03
    """The body nods by this to either side, twice a stride [rad]."""
    sway: float = 0.07
    """The hip of the swinging leg sinks by this [rad]."""
    turn: float = 0.10
    """The hip of the leading leg goes ahead by this to either side [rad]."""
    lean: float = 0.08
    """The body leans forward by this at Froude number 1 [rad]."""
    retraction: float = 0.88
    """Length of the virtual leg in mid swing, as a part of the nominal one."""
    run_retraction: float = 0.68
    """The same in swings over a flight."""
    strike_pitch: float = 0.32
    """Toes up at the strike of feet with a heel [rad]."""
    liftoff_pitch: float = 0.85
    """Heel up at the liftoff [rad]."""
    arms: float = 0.45
    """Arms swing by this to either side [rad]."""
    tail: float = 0.12
    """The tail sways by this at each joint's share [rad]."""
    tail_lag: float = 0.10
    """Each joint of the tail does what the body did this much earlier [s]."""
    carriage: bool = True
    """Walks carry the pelvis as the character's clips do, if it has any; otherwise as average people."""

    def __post_init__(self) -> None:
        for name in ("pitch", "sway", "turn", "lean", "arms", "tail"):
            if not math.isfinite(getattr(self, name)):
                raise UsdfootError(name, f"is {getattr(self, name)}", "give a number")
        for name, low, high in (
            ("retraction", 0.3, 1.0),
            ("run_retraction", 0.3, 1.0),
            ("strike_pitch", 0.0, 1.0),
            ("liftoff_pitch", 0.0, 1.2),
            ("tail_lag", 0.0, 1.0),
        ):
            if not low <= getattr(self, name) <= high:
                raise UsdfootError(name, f"is {getattr(self, name):g}", f"{low:g} to {high:g} is possible")
