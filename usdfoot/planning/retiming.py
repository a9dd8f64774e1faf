"""Retiming: footprints get the times of people who would walk them ([P] 4.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from usdfoot.analysis.footstep_times import time_footsteps
from usdfoot.analysis.timing import STAND_TIME
from usdfoot.errors import PlanError
from usdfoot.model.limits import BODILY, LATEST, SPANS, check_range
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.proportions import Proportions

__all__ = ["TimingOptions", "plan_times"]


@dataclass(frozen=True, kw_only=True)
class TimingOptions:
    """How prints are timed.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    speed: float = 0.0
    """Mean of all steps [m/s]; 0 = as the length of each step asks for."""
    flight_distance: float = 0.0
    """Steps longer than this are leaps or runs [m]; 0 = where a walk would be faster than Froude number 0.5."""
    start_time: float | None = None
    """Of the first strike [s]; None = the stage's start, 0 where there is no stage."""
    starts_standing: bool = True
    """Both first feet stand from the start."""
    ends_standing: bool = True
    """Both last feet stand to the end."""
    stand_time: float = STAND_TIME
    """How long who starts standing does so before the first step [s]."""

    def __post_init__(self) -> None:
        check_range("speed", self.speed, BODILY, unit="m/s", or_zero=True)
        check_range("flight_distance", self.flight_distance, BODILY, unit="m", or_zero=True)
        check_range("start_time", self.start_time or 0.0, (-LATEST, LATEST), unit="s")
        check_range("stand_time", self.stand_time, SPANS, unit="s")


def plan_times(prints: PlanDraft, body: Proportions, options: TimingOptions | None = None) -> FootstepPlan:
    """The plan over footprints without times.

    Args:
        prints: Whose times do not count.
        body: Who walks them.
        options: How.

    Raises:
        PlanError: If the prints are inconsistent, fewer than two, or in one place though they have a speed.
    """
    options = options or TimingOptions()
    try:
        times = time_footsteps(
            prints.positions,
            replace(body.timing, flight_distance=options.flight_distance),
            speed=options.speed,
            start_time=options.start_time or 0.0,
            starts_standing=options.starts_standing,
            ends_standing=options.ends_standing,
            stand_time=options.stand_time,
        )
    except PlanError as error:
        raise PlanError(prints.name, error.what, error.remedy) from error
    timed = replace(prints, strike_times=times.strike_times, liftoff_times=times.liftoff_times)
    return FootstepPlan.checked(timed)
