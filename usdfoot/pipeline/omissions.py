"""Omissions: what the files of an agent do not hold, so that figures would pass for want of anything to measure."""

from __future__ import annotations

import numpy as np

from usdfoot.bridge.tokens import Schema
from usdfoot.model.report import Problem
from usdfoot.pipeline.written_feet import LONGEST_ROLL
from usdfoot.readers.written import WrittenAgent, WrittenCrowd

__all__ = ["find_omissions"]

ROUNDING = 1e-6
"""Of times written as time codes [time codes]."""
FRAME = 1.0
"""Motions begin and end on whole frames, so within one of their footsteps [time codes]."""


def find_omissions(agent: WrittenAgent, crowd: WrittenCrowd) -> list[Problem]:
    """What is missing in the crowd's time range of an agent with samples: some of them and contacts, results.

    Missing results are a warning, the others errors.
    """
    plan, units = agent.plan, crowd.units
    start, end = crowd.stage.GetStartTimeCode(), crowd.stage.GetEndTimeCode()
    begins = max(float(units.times_to_codes(plan.strike_times.min())), start)
    ends = min(float(units.times_to_codes(plan.liftoff_times.max())), end)
    first, last = agent.frame_codes[[0, -1]]
    where, problems = agent.animation, []
    if ends > begins and (first > begins + FRAME + ROUNDING or last < ends - FRAME - ROUNDING):
        message = f"{where}: is sampled from {first:g} to {last:g}. its footsteps need {begins:g} to {ends:g}"
        problems.append(Problem(severity="error", where=where, message=message))
    strikes = units.times_to_codes(plan.strike_times)
    flat = units.times_to_codes(plan.strike_times + LONGEST_ROLL)
    untold = np.flatnonzero(np.isnan(agent.flat_times) & (strikes >= start - ROUNDING) & (flat <= end))
    if untold.size:
        names = f"{Schema.CONTACT_INSTANCES[0]} and {Schema.CONTACT_INSTANCES[1]}"
        message = (
            f"{where}: {untold.size} footstep(s) have no contact at their strike, first footstep {untold[0]}. "
            f"{names} tell when the feet stand"
        )
        problems.append(Problem(severity="error", where=where, message=message))
    if not agent.status:
        message = f"{plan.name}: has no {Schema.RESULT}. every footstep is taken as promised"
        problems.append(Problem(severity="warning", where=plan.name, message=message))
    return problems
