"""Scenario: who wants to go where among which obstacles, before anyone has moved."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.planning.moving import Moving
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle

__all__ = ["Scenario", "Seeker"]


@dataclass(frozen=True, kw_only=True)
class Seeker:
    """One agent with goals.

    Raises:
        PlanError: If a number is not finite, or the speed or radius is not positive.
    """

    name: str
    """Prim path or name of the agent, for messages."""
    start: FloatArray
    """Where it stands [m], shape (3,)."""
    yaw: float | None = None
    """Where it looks at the start [rad]; None = at its first goal."""
    goals: FloatArray
    """Where it goes, one after the other [m], shape (G, 3); none = it only stands there."""
    speed: float = 1.3
    """At which it likes to walk [m/s]."""
    radius: float = 0.25
    """Of its body seen from above [m]."""
    body: Proportions = field(default_factory=Proportions)
    """Of its legs."""

    @property
    def narrowest(self) -> float:
        """Half the width it needs sideways [m]."""
        return self.body.half_depth(self.radius)

    def __post_init__(self) -> None:
        numbers = np.concatenate([self.start, self.goals.ravel(), [self.yaw or 0.0, self.speed, self.radius]])
        if not np.isfinite(numbers).all():
            raise PlanError(self.name, "has a start, goal, speed or radius that is not finite", "give numbers")
        if self.speed <= 0.0 or self.radius <= 0.0:
            what = f"has a speed of {self.speed:g} m/s and a radius of {self.radius:g} m"
            raise PlanError(self.name, what, "both must be more than 0")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Seekers and what is in their way."""

    seekers: tuple[Seeker, ...]
    obstacles: tuple[Obstacle, ...]
    """That stay where they are."""
    bounds: FloatArray | None
    """Outline to stay in (x, z) [m], shape (K, 2); None = there is none."""
    moving: Moving | None = None
    """Others, at times from the start on; None = there are none."""
