"""Timing from footprints alone: how long each step and each contact lasts, by how far the steps go ([P] 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray

__all__ = [
    "EARTH_GRAVITY",
    "HUMAN_LEG",
    "QUICKENING",
    "STAND_TIME",
    "FootstepTimes",
    "StepTiming",
    "TimingRule",
    "contact_overlaps",
    "time_footsteps",
    "time_steps",
]

HUMAN_LEG = 0.86
"""Leg from hip to ankle of the people that times and weights were measured on [m]; bodies of other sizes move alike."""
EARTH_GRAVITY = 9.81
"""[m/s^2]."""
STAND_TIME = 0.5
"""Who starts standing does so for this long before the first step [s]."""
QUICKENING = 0.17
"""Running steps are quicker the longer they are, by this part of the shortest's time a metre, so that each runner's
cadence grows by as many steps a second for each m/s. People go from 2.6 a second at 2.5 m/s to 3.2 at 6, about 5 % off
what Minetti (1998) measured; Goto et al. (2021) found 3.0 at two thirds of the top speed."""
RUN_FROUDE = 0.5
"""Froude number, speed squared over gravity and leg length, at which people begin to run (Kram et al. 1997)."""


@dataclass(frozen=True, kw_only=True)
class TimingRule:
    """How people time their steps, for a leg of 0.86 m; other legs move alike (equal Froude numbers)."""

    leg_length: float = HUMAN_LEG
    """Hip to ankle with the knee straight [m]."""
    gravity: float = EARTH_GRAVITY
    """[m/s^2]."""
    walk_ratio: float = 0.006
    """Step length by cadence, constant in one person's walks [m per step/min] (Sekiya et al. 1996)."""
    longest_step: float = 0.7
    """A short step takes this long [s]."""
    flight_distance: float = 0.0
    """Steps longer than this have a flight [m]; 0 = where the walk would be faster than Froude number 0.5
    (Kram et al. 1997)."""
    run_step: float = 0.455
    """What the shortest running steps take, longer ones less, unless that is too fast [s]."""
    quickening: float = QUICKENING
    """By which part of that they take less, a metre [1/m]."""
    leap_speed: float = 4.0
    """Fastest that a step with flight carries the body [m/s]; longer leaps take longer."""
    leap_gain: float = 1.6
    """How much faster than the steps beside it such a step is at most, since a body cannot speed up at once."""
    highest_hop: float = 0.3
    """How high a body goes to take longer over such a step, over the leg length."""


@dataclass(frozen=True, kw_only=True)
class StepTiming:
    """Times of S steps, footprint to footprint."""

    step_times: FloatArray
    """Strike to strike [s], shape (S,)."""
    overlaps: FloatArray
    """Double support after the strike that ends the step, negative: flight before it [s], shape (S,)."""

    @property
    def flies(self) -> BoolArray:
        """Whether the step has a flight, shape (S,)."""
        return self.overlaps < 0.0


@dataclass(frozen=True, kw_only=True)
class FootstepTimes:
    """Times of N footsteps."""

    strike_times: FloatArray
    """[s], shape (N,)."""
    liftoff_times: FloatArray
    """[s], shape (N,)."""


def time_steps(distances: FloatArray, rule: TimingRule) -> StepTiming:
    """Step time and double support, or flight, of steps by their distance ([P] Figure 12).

    People keep the ratio of step length to cadence, so a walking step of L metres takes 0.36 / L seconds: longer steps
    are quicker, up to Froude number 0.5. A running step takes run_step (1 - quickening L). The share of a stride that a
    foot stands falls with speed, from 0.67 in a slow walk to 0.55 in the fastest (Grieve and Gear 1966), and in runs
    from 0.42 on (Minetti and Alexander 1997).

    Args:
        distances: From print to print [m], shape (S,).
        rule: Proportions and constants.
    """
    size = rule.leg_length / HUMAN_LEG
    clock = np.sqrt(size * EARTH_GRAVITY / rule.gravity)
    lengths = np.asarray(distances, dtype=float) / size
    froude_speed = np.sqrt(EARTH_GRAVITY * HUMAN_LEG)
    walking = np.minimum(60.0 * rule.walk_ratio / np.maximum(lengths, 1e-9), rule.longest_step)
    running = np.maximum(rule.run_step * (1.0 - rule.quickening * lengths), lengths / rule.leap_speed)
    fastest_walk = np.sqrt(RUN_FROUDE) * froude_speed
    flies = lengths > (rule.flight_distance / size or np.sqrt(60.0 * rule.walk_ratio * fastest_walk))
    times = np.where(flies, running, np.maximum(walking, lengths / fastest_walk))
    overlaps = times * contact_overlaps(lengths / times / froude_speed, flies)
    return StepTiming(step_times=clock * times, overlaps=clock * overlaps)


def contact_overlaps(speeds: FloatArray, flies: BoolArray) -> FloatArray:
    """Double support over step time at speeds over sqrt(gravity leg length), negative where steps fly, shape (S,).

    Straight lines through the shares of stance that `time_steps` names.
    """
    stance = np.where(flies, np.clip(0.54 - 0.14 * speeds, 0.2, 0.42), np.clip(0.715 - 0.23 * speeds, 0.53, 0.7))
    return 2.0 * stance - 1.0


def _at_speed(distances: FloatArray, steps: StepTiming, speed: float, rule: TimingRule, *, first: int) -> StepTiming:
    """The steps with all times stretched alike, so that the mean speed from the `first` on is as given [m/s]."""
    times = steps.step_times * (distances[first:].sum() / speed / steps.step_times[first:].sum())
    speeds = distances / times / np.sqrt(rule.gravity * rule.leg_length)
    flies = distances > rule.flight_distance if rule.flight_distance else speeds**2 > RUN_FROUDE
    return StepTiming(step_times=times, overlaps=times * contact_overlaps(speeds, flies))


def _with_run_ups(distances: FloatArray, steps: StepTiming, rule: TimingRule) -> StepTiming:
    """Timing of successive steps, those with flight no faster than the steps beside them allow.

    What they take longer they spend half on the ground and half in the air, where they go no higher than a hop.
    """
    fastest = rule.leap_gain * _beside(distances / steps.step_times)
    longer = np.where(steps.flies, np.maximum(distances / fastest - steps.step_times, 0.0), 0.0)
    hop = 2.0 * np.sqrt(2.0 * rule.highest_hop * rule.leg_length / rule.gravity)
    overlaps = np.maximum(steps.overlaps - 0.5 * longer, np.minimum(steps.overlaps, -hop))
    return StepTiming(step_times=steps.step_times + longer, overlaps=overlaps)


def _beside(speeds: FloatArray) -> FloatArray:
    """Mean of the values before and after each, its own where there is none, shape (S,)."""
    before, after = np.append(speeds[:1], speeds[:-1]), np.append(speeds[1:], speeds[-1:])
    return np.maximum(0.5 * (before + after), 1e-3)


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
    rule = rule or TimingRule()
    distances = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    steps = _with_run_ups(distances, time_steps(distances, rule), rule)
    first = int(starts_standing)
    if speed and len(distances) > first:
        if not distances[first:].any():
            raise PlanError("footprints", "are all in one place", "time them without a speed")
        steps = _at_speed(distances, steps, speed, rule, first=first)
    step_times = steps.step_times.copy()
    overlaps = steps.overlaps.copy()
    if starts_standing:
        step_times[0] = 0.0
        overlaps[0] = 0.5 * steps.step_times[0]
    stood = stand_time if starts_standing else 0.0
    if stood and len(overlaps) > 1:
        overlaps[0] = 0.5 * max(overlaps[1], 0.0)
    strikes = start_time + np.concatenate([[0.0], np.cumsum(step_times)])
    strikes[2:] += stood
    after = np.concatenate([step_times[1:], [np.inf]])
    liftoffs = strikes[1:] + np.minimum(overlaps, 0.5 * after)
    liftoffs[0] += stood
    liftoffs = np.maximum(liftoffs, strikes[:-1] + 0.25 * steps.step_times)
    last = strikes[-1] + steps.step_times[-1] + (0.0 if ends_standing else steps.overlaps[-1])
    liftoffs = np.append(liftoffs, max(last, liftoffs[-1]))
    if ends_standing:
        liftoffs[-2] = liftoffs[-1]
    return FootstepTimes(strike_times=strikes, liftoff_times=liftoffs)
