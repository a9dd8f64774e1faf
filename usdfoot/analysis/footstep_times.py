"""Footstep times: when feet strike and leave rows of footprints, from these alone ([P] 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.timing import RUN_FROUDE, StepTiming, TimingRule, contact_overlaps, time_steps
from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["FootstepTimes", "time_footsteps", "time_rows"]


@dataclass(frozen=True, kw_only=True)
class FootstepTimes:
    """Times of N footsteps."""

    strike_times: FloatArray
    """[s], shape (N,)."""
    liftoff_times: FloatArray
    """[s], shape (N,)."""


def time_footsteps(
    positions: FloatArray,
    rule: TimingRule | None = None,
    *,
    speed: float = 0.0,
    start_time: float = 0.0,
    starts_standing: bool = False,
    ends_standing: bool = False,
    stand_time: float = 0.0,
) -> FootstepTimes:
    """Strikes and liftoffs of a row of footprints.

    Args:
        positions: Prints in order, left and right in turn [m], shape (N, 3).
        rule: Proportions and constants.
        speed: Mean of all steps [m/s]; 0 = as fast as such steps are.
        start_time: Of the first strike [s].
        starts_standing: Both first feet strike together.
        ends_standing: Both last feet lift off together.
        stand_time: How long both feet stand before the first step of who starts standing, which then swings as long
            as in a walk [s]; 0 = they stand for half of it.

    Raises:
        PlanError: If there are fewer than two prints, their positions are not finite, or all are in one place though
            they have a speed.
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 2 or positions.shape[1] != 3 or len(positions) < 2:
        raise PlanError("footprints", f"have shape {positions.shape}", "timing needs two or more positions (N, 3)")
    if not np.isfinite(positions).all():
        raise PlanError("footprints", "have positions that are not finite", "author numbers")
    first = int(starts_standing)
    if speed and len(positions) > first + 1 and not np.diff(positions[first:], axis=0).any():
        raise PlanError("footprints", "are all in one place", "time them without a speed")
    return time_rows(
        positions,
        np.array([len(positions)]),
        rule=rule or TimingRule(),
        speeds=np.array([speed]),
        start_times=np.array([start_time]),
        starts_standing=starts_standing,
        ends_standing=np.array([ends_standing]),
        stand_time=stand_time,
    )


def time_rows(
    positions: FloatArray,
    counts: IntArray,
    *,
    rule: TimingRule,
    speeds: FloatArray,
    start_times: FloatArray,
    starts_standing: bool,
    ends_standing: BoolArray,
    stand_time: float,
) -> FootstepTimes:
    """Strikes and liftoffs of R rows of footprints, each as by `time_footsteps` alone.

    Args:
        positions: Prints of all rows, one row after the other [m], shape (N, 3).
        counts: How many each row has, two or more, shape (R,).
        rule: Proportions and constants.
        speeds: Mean of all steps of each row [m/s], shape (R,); 0 = as fast as such steps are.
        start_times: Of the first strikes [s], shape (R,).
        starts_standing: Both first feet strike together.
        ends_standing: Whether both last feet lift off together, shape (R,).
        stand_time: How long both feet stand at first [s].
    """
    rows, last = np.arange(len(counts)), counts - 2  # of the steps
    prints = np.arange(counts.max(initial=2)) < counts[:, None]  # (R, S + 1)
    laid = np.zeros((*prints.shape, 3))
    laid[prints] = positions
    distances = np.linalg.norm(np.diff(laid, axis=1), axis=2)  # (R, S)
    steps = _with_run_ups(distances, time_steps(distances, rule), rule, last=last)
    steps = _at_speeds(distances, steps, speeds, rule, first=int(starts_standing), last=last)
    step_times, overlaps = steps.step_times.copy(), steps.overlaps.copy()
    if starts_standing:
        step_times[:, 0] = 0.0
        overlaps[:, 0] = 0.5 * steps.step_times[:, 0]
    stood = stand_time if starts_standing else 0.0
    if stood and overlaps.shape[1] > 1:
        overlaps[:, 0] = np.where(last > 0, 0.5 * np.maximum(overlaps[:, 1], 0.0), overlaps[:, 0])
    strikes = start_times[:, None] + np.cumsum(np.insert(step_times, 0, 0.0, axis=1), axis=1)
    strikes[:, 2:] += stood
    after = np.insert(step_times[:, 1:], step_times.shape[1] - 1, np.inf, axis=1)
    after[rows, last] = np.inf
    liftoffs = strikes[:, 1:] + np.minimum(overlaps, 0.5 * after)
    liftoffs[:, 0] += stood
    liftoffs = np.maximum(liftoffs, strikes[:, :-1] + 0.25 * steps.step_times)
    ends = strikes[rows, last + 1] + steps.step_times[rows, last]
    ends += np.where(ends_standing, 0.0, steps.overlaps[rows, last])
    ends = np.maximum(ends, liftoffs[rows, last])
    liftoffs = np.insert(liftoffs, liftoffs.shape[1], 0.0, axis=1)
    liftoffs[rows, last + 1] = ends
    liftoffs[rows, last] = np.where(ends_standing, ends, liftoffs[rows, last])
    return FootstepTimes(strike_times=strikes[prints], liftoff_times=liftoffs[prints])


def _at_speeds(
    distances: FloatArray, steps: StepTiming, speeds: FloatArray, rule: TimingRule, *, first: int, last: IntArray
) -> StepTiming:
    """The steps (R, S) with the times of rows stretched alike, so that their mean speeds are as given [m/s] (R,).

    That is from the `first` on to the `last` (R,); where the speed is 0, or there is no such step, they stay.
    """
    chosen = np.flatnonzero((speeds > 0.0) & (last >= first))
    if not chosen.size:
        return steps
    ways, times = (values[chosen, first:] for values in (distances, steps.step_times))
    ends = np.arange(len(chosen)), last[chosen] - first
    far, long = np.cumsum(ways, axis=1)[ends], np.cumsum(times, axis=1)[ends]
    times = steps.step_times[chosen] * (far / speeds[chosen] / long)[:, None]
    rates = distances[chosen] / times / np.sqrt(rule.gravity * rule.leg_length)
    flies = distances[chosen] > rule.flight_distance if rule.flight_distance else rates**2 > RUN_FROUDE
    step_times, overlaps = steps.step_times.copy(), steps.overlaps.copy()
    step_times[chosen], overlaps[chosen] = times, times * contact_overlaps(rates, flies)
    return StepTiming(step_times=step_times, overlaps=overlaps)


def _with_run_ups(distances: FloatArray, steps: StepTiming, rule: TimingRule, *, last: IntArray) -> StepTiming:
    """Timing of successive steps (R, S), those with flight no faster than the steps beside them allow.

    What they take longer they spend half on the ground and half in the air, where they go no higher than a hop.
    """
    fastest = rule.leap_gain * _beside(distances / steps.step_times, last)
    longer = np.where(steps.flies, np.maximum(distances / fastest - steps.step_times, 0.0), 0.0)
    hop = 2.0 * np.sqrt(2.0 * rule.highest_hop * rule.leg_length / rule.gravity)
    overlaps = np.maximum(steps.overlaps - 0.5 * longer, np.minimum(steps.overlaps, -hop))
    return StepTiming(step_times=steps.step_times + longer, overlaps=overlaps)


def _beside(speeds: FloatArray, last: IntArray) -> FloatArray:
    """Mean of the values before and after each, its own where there is none, shape (R, S)."""
    rows, before, after = np.arange(len(speeds)), np.roll(speeds, 1, axis=1), np.roll(speeds, -1, axis=1)
    before[:, 0], after[rows, last] = speeds[:, 0], speeds[rows, last]
    return np.maximum(0.5 * (before + after), 1e-3)
