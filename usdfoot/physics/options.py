"""Options of the physics engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
    gravity: float = 9.81
    """[m/s^2]."""
    comfort: float = 100.0
    """[P]'s k: weight of comfort against physics [1/(m s^2)]."""
    support: str = "smooth"
    """smooth = from heel to toe over the contact; print = [P]: the middle of the print, at last the toe."""
    longest_segment: float = 1.0
    """Steps that last longer have several segments [s]."""
    heading_window: float = 0.6
    """Window of the moving mean of the feet's headings [s]."""

    def __post_init__(self) -> None:
        if self.solver not in SOLVERS:
            raise UsdfootError("solver", f"{self.solver!r} is not known", "use one of these", SOLVERS)
        if self.support not in SUPPORTS:
            raise UsdfootError("support", f"{self.support!r} is not known", "use one of these", SUPPORTS)
        for name in ("gravity", "comfort", "longest_segment", "heading_window"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise UsdfootError(name, f"is {value:.4g}", "a positive number is possible")
