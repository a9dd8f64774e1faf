"""Phases of a gait: which feet stand at any time, and when that changes ([P] Figure 15)."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan

__all__ = ["DOUBLE", "FLIGHT", "LEFT_STANCE", "RIGHT_STANCE", "phase_changes", "stance_phases"]

LEFT_STANCE, RIGHT_STANCE, DOUBLE, FLIGHT = range(4)


def stance_phases(plan: FootstepPlan, times: FloatArray) -> IntArray:
    """LEFT_STANCE, RIGHT_STANCE, DOUBLE or FLIGHT at times [s] (T,); an instant of change belongs to what follows."""
    down = [_standing(plan, side, times) for side in (0, 1)]
    return np.select([down[0] & down[1], down[0], down[1]], [DOUBLE, LEFT_STANCE, RIGHT_STANCE], FLIGHT)


def phase_changes(plan: FootstepPlan) -> FloatArray:
    """Times within the plan at which a foot comes down or lifts off [s], increasing, shape (C,)."""
    times = np.unique(np.concatenate([plan.strike_times, plan.liftoff_times]))
    return times[(times > plan.start) & (times < plan.end)]


def _standing(plan: FootstepPlan, side: int, times: FloatArray) -> np.ndarray:
    """Whether a foot is down, shape (T,): it has come down more often than it has lifted off."""
    own = plan.sides == side
    strikes, liftoffs = plan.strike_times[own], plan.liftoff_times[own]
    return np.searchsorted(strikes, times, side="right") > np.searchsorted(liftoffs, times, side="right")
