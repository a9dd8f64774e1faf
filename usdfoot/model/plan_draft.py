"""PlanDraft: footsteps as somebody authored them, right or wrong."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["PlanDraft"]


@dataclass(frozen=True, kw_only=True)
class PlanDraft:
    """What becomes a `FootstepPlan` if it is in order."""

    name: str
    """Prim path of the plan, for messages."""
    sides: IntArray
    """0 = left, 1 = right, shape (N,)."""
    positions: FloatArray
    """Point of the ground under the ball of the planted foot [m], shape (N, 3)."""
    orientations: FloatArray
    """Turns +Z into the foot's forward and +Y into the ground's normal, unit xyzw, shape (N, 4)."""
    strike_times: FloatArray
    """First contact [s], shape (N,), not decreasing."""
    liftoff_times: FloatArray
    """Ball leaves the ground [s], shape (N,)."""
    root_weights: FloatArray
    """[B]'s lambda4 of each step, 0 exact footsteps .. 1 exact root velocity, shape (N,)."""
    styles: tuple[str, ...] = ()
    """Style of each step, N of them, "" = the library's own; none at all if no step names one."""
