"""Options of the physics engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.errors import UsdfootError

__all__ = ["SOLVERS", "SUPPORTS", "PhysicsOptions"]

SOLVERS = ("lm", "greedy")
SUPPORTS = ("smooth", "print")


@dataclass(frozen=True, kw_only=True)
class PhysicsOptions:
    """How the centre of mass is optimised.

    Raises:
        UsdfootError: If an option is not possible.
    """

    solver: str = "lm"
    """lm = reweighted least squares by Levenberg and Marquardt; greedy = [P] Figure 10."""
    tolerance: float = 1e-4
    """Relative decrease of E in a step at which lm has converged."""
    gravity: float = EARTH_GRAVITY
    """[m/s^2]."""
    comfort: float = 3000.0
    """[P]'s k: weight of comfort against physics, for a leg of 0.86 m [1/(m s^2)]."""
    support: str = "smooth"
    """smooth = from heel to toe over the contact; print = [P]: the middle of the print, at last the toe."""
    leg_play: float = 1.0
    """How much the comfortable length of a leg varies over its contact as people's does; 0 = constant over a flat foot,
    as in [P]."""
    parts: int = 2
    """Segments a step, beside one a flight; 1 as in [P], which leaves too few values for the rise over mid stance."""
    longest_segment: float = 1.0
    """Longer ones are divided [s]."""
    run_up: int = 2
    """Strides by which motions that begin or end in mid gait are continued while they are optimised."""
    heading_window: float = 0.6
    """Window of the moving mean of the feet's headings [s]."""

    def __post_init__(self) -> None:
        if self.solver not in SOLVERS:
            raise UsdfootError("solver", f"{self.solver!r} is not known", "use one of these", SOLVERS)
        if self.support not in SUPPORTS:
            raise UsdfootError("support", f"{self.support!r} is not known", "use one of these", SUPPORTS)
        if not 0.0 <= self.leg_play <= 2.0:
            raise UsdfootError("leg_play", f"is {self.leg_play:.4g}", "0 to 2 is possible")
        for name, least in (("run_up", 0), ("parts", 1)):
            if getattr(self, name) < least:
                raise UsdfootError(name, f"is {getattr(self, name)}", f"{least} or more is possible")
        for name in ("tolerance", "gravity", "comfort", "longest_segment", "heading_window"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise UsdfootError(name, f"is {value:.4g}", "a positive number is possible")
