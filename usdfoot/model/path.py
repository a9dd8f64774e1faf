"""WalkingPath: a curve to walk along, and how."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray

__all__ = ["WalkingPath"]


@dataclass(frozen=True, kw_only=True)
class WalkingPath:
    """A curve sampled densely, in the canonical world (design.md section 2: UsdfootPathAPI).

    Raises:
        PlanError: If the curve has no length on the ground, is not finite, or a number is negative.
    """

    name: str
    """Prim path of the curve, for messages."""
    points: FloatArray
    """Along the curve [m], shape (K, 3). Heights choose the level of the terrain where there are several."""
    speed: float = 0.0
    """[m/s]; 0 = derive."""
    step_length: float = 0.0
    """[m]; 0 = derive."""
    step_width: float = 0.0
    """[m]; 0 = derive."""
    quickest_step: float = 0.0
    """No step takes less [s]; 0 = whatever they should take."""
    start_time: float = 0.0
    """Time of the first strike [s]."""
    style: str = ""
    """Style to walk in; empty = the agent's own."""

    def distances(self, places: FloatArray) -> FloatArray:
        """How far from the path places (N, 2) are, seen from above [m], shape (N,)."""
        starts, ends = self.points[:-1, [0, 2]], self.points[1:, [0, 2]]
        along = ends - starts  # (K, 2)
        offsets = places[:, None] - starts
        lengths = np.maximum(np.sum(along**2, axis=1), np.finfo(float).tiny)
        shares = np.clip(np.sum(offsets * along, axis=2) / lengths, 0.0, 1.0)
        return np.asarray(np.linalg.norm(offsets - shares[..., None] * along, axis=2).min(axis=1))

    def __post_init__(self) -> None:
        for label, value in (
            ("speed", self.speed),
            ("stepLength", self.step_length),
            ("stepWidth", self.step_width),
        ):
            if not (np.isfinite(value) and value >= 0.0):
                raise PlanError(self.name, f"usdfoot:path:{label} is {value:g}", "author 0 or a positive number")
        if not np.isfinite(self.start_time):
            raise PlanError(self.name, f"usdfoot:path:startTime is {self.start_time:g}", "author a time code")
        if not np.isfinite(self.points).all():
            raise PlanError(self.name, "has points that are not finite", "repair the curve")
        if len(self.points) < 2 or self.length <= 0.0:
            raise PlanError(self.name, "is a path of zero length", "draw a curve to walk along")

    @property
    def length(self) -> float:
        """Seen from above [m]."""
        return float(np.linalg.norm(np.diff(self.points[:, [0, 2]], axis=0), axis=1).sum())
