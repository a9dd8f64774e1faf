"""PlanDraft: the arrays of a footstep plan as somebody left them, not yet checked."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan

__all__ = ["PlanDraft"]


@dataclass(frozen=True, kw_only=True)
class PlanDraft:
    """What becomes a `FootstepPlan` if it is in order; fields as there."""

    name: str
    sides: IntArray
    positions: FloatArray
    orientations: FloatArray
    strike_times: FloatArray
    liftoff_times: FloatArray
    root_weights: FloatArray
    styles: tuple[str, ...] = ()

    def checked(self) -> FootstepPlan:
        """The plan.

        Raises:
            PlanError: If it is inconsistent.
        """
        return FootstepPlan(**vars(self))
