"""FootstepPlan: which foot stands where, when."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.model.plan_rules import check_plan

__all__ = ["FootstepPlan"]


@dataclass(frozen=True, kw_only=True)
class FootstepPlan(PlanDraft):
    """Footsteps in order of strike, in the canonical world: a draft that is in order.

    Raises:
        PlanError: If arrays differ in length, hold values that are not finite, are out of order, a contact has no
            duration, contacts of one foot overlap, or one foot steps twice in a row.
    """

    def __post_init__(self) -> None:
        check_plan(self)

    @classmethod
    def checked(cls, draft: PlanDraft) -> FootstepPlan:
        """The plan that the draft is.

        Raises:
            PlanError: If it is none.
        """
        return cls(**vars(draft))

    def __len__(self) -> int:
        return len(self.sides)

    @property
    def yaws(self) -> FloatArray:
        """Direction of each foot as yaw [rad], shape (N,)."""
        forward = quaternion.rotate(self.orientations, np.array([0.0, 0.0, 1.0]))
        return planar.yaw_of(forward[:, [0, 2]])

    @property
    def normals(self) -> FloatArray:
        """Ground normals the prints were laid on, shape (N, 3)."""
        return quaternion.rotate(self.orientations, np.array([0.0, 1.0, 0.0]))

    def later(self, delay: float) -> FootstepPlan:
        """The plan, all times this much later [s]."""
        return replace(self, strike_times=self.strike_times + delay, liftoff_times=self.liftoff_times + delay)

    @property
    def start(self) -> float:
        """First strike [s]."""
        return float(self.strike_times[0])

    @property
    def end(self) -> float:
        """Last liftoff [s]."""
        return float(self.liftoff_times.max())

    @property
    def starts_standing(self) -> bool:
        """Whether the first two footsteps strike together."""
        return bool(self.strike_times[0] == self.strike_times[1])

    @property
    def ends_standing(self) -> bool:
        """Whether the last two footsteps lift off together."""
        return bool(self.liftoff_times[-1] == self.liftoff_times[-2])
