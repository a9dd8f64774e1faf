"""Joining: footsteps that came one at a time become plans."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from usdfoot.analysis.timing import STAND_TIME, time_footsteps
from usdfoot.errors import PlanError
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.wanderer import Footstep

__all__ = ["join_footsteps"]


def join_footsteps(
    footsteps: Iterable[Footstep],
    *,
    name: str,
    body: Proportions | None = None,
    ends_standing: bool = False,
    stand_time: float = STAND_TIME,
) -> FootstepPlan:
    """The plan of footsteps as they came, as fast as such steps are.

    Args:
        footsteps: From `wander`, the first two of which stand.
        name: Of the plan.
        body: That walks.
        ends_standing: Whether it stands at the end, as `wander` does at its last goal.
        stand_time: How long it stands before the first step [s].
    """
    body = body or Proportions()
    steps = list(footsteps)
    if len(steps) < 2:
        raise PlanError(name, f"has {len(steps)} footstep(s)", "let it take at least two")
    positions = np.array([step.position for step in steps])
    times = time_footsteps(
        positions,
        body.timing,
        start_time=steps[0].strike_time,
        starts_standing=True,
        ends_standing=ends_standing,
        stand_time=stand_time,
    )
    return FootstepPlan(
        name=name,
        sides=np.array([step.side for step in steps]),
        positions=positions,
        orientations=np.array([step.orientation for step in steps]),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(len(steps)),
    )
