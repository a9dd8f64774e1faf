"""Joining: footsteps that came one at a time become plans."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from usdfoot.analysis.footstep_times import time_rows
from usdfoot.analysis.timing import STAND_TIME
from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import cut_plans
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.wanderer import Footstep, Footsteps

__all__ = ["join_footsteps", "join_plans"]


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
    steps = list(footsteps)
    together = Footsteps(
        sides=np.array([step.side for step in steps], dtype=int),
        positions=np.array([step.position for step in steps]).reshape(-1, 3),
        orientations=np.array([step.orientation for step in steps]).reshape(-1, 4),
        strike_times=np.array([step.strike_time for step in steps]),
    )
    (plan,) = join_plans(
        together,
        np.array([len(steps)]),
        names=[name],
        body=body,
        ends_standing=np.array([ends_standing]),
        stand_time=stand_time,
    )
    return plan


def join_plans(
    footsteps: Footsteps,
    counts: IntArray,
    *,
    names: Sequence[str],
    ends_standing: BoolArray,
    body: Proportions | None = None,
    stand_time: float = STAND_TIME,
) -> list[FootstepPlan]:
    """The plans of so many footsteps each (P,), those of one after those of the other, as by `join_footsteps`.

    Raises:
        PlanError: If one has fewer than two footsteps.
    """
    for name, count in zip(names, counts.tolist(), strict=True):
        if count < 2:
            raise PlanError(name, f"has {count} footstep(s)", "let it take at least two")
    times = time_rows(
        footsteps.positions,
        counts,
        rule=(body or Proportions()).timing,
        speeds=np.zeros(len(counts)),
        start_times=footsteps.strike_times[np.cumsum(counts) - counts],
        starts_standing=True,
        ends_standing=ends_standing,
        stand_time=stand_time,
    )
    table = PlanDraft(
        name="",
        sides=footsteps.sides,
        positions=footsteps.positions,
        orientations=footsteps.orientations,
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(len(footsteps.sides)),
    )
    return cut_plans(table, counts, names=names)
