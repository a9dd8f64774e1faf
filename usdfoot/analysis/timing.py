"""Timing of steps: how long each and its double support last, by how far it goes ([P] 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray

__all__ = [
    "EARTH_GRAVITY",
    "HUMAN_LEG",
    "QUICKENING",
    "RUN_FROUDE",
    "STAND_TIME",
    "StepTiming",
    "TimingRule",
    "contact_overlaps",
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
