"""Gait: how long, wide and quick the steps of a plan are, authored or derived from each other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from usdfoot.analysis.gaits import RUNNING_FROUDE
from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG, TimingRule, contact_overlaps, time_steps
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.habits import SPAN
from usdfoot.planning.proportions import Proportions

__all__ = ["TOE_OUT", "Gait", "derive_gait", "longest_time", "natural_lengths", "overlap_shares"]

TOE_OUT = 0.1
"""How far feet point outward of the heading [rad]."""
LONGEST_TABLED = 3.5
"""Longest step looked up, over the leg length."""


@dataclass(frozen=True, kw_only=True)
class Gait:
    """Even steps on level ground."""

    step_length: float
    """Ball to ball along the way [m]."""
    step_time: float
    """Strike to strike [s]."""
    step_width: float
    """Ball to ball across the way [m]."""
    walked_length: float
    """How far a step without a flight goes along the way at most [m]."""
    quickest_time: float = 0.0
    """No step takes less, however short [s]."""
    toe_out: float = TOE_OUT
    """[rad]."""
    rule: TimingRule = field(default_factory=TimingRule)
    """How this body times its steps."""

    @property
    def speed(self) -> float:
        """[m/s]."""
        return self.step_length / self.step_time

    @property
    def fastest_walk(self) -> float:
        """From this speed on steps have a flight [m/s]."""
        return float(np.sqrt(RUNNING_FROUDE * self.rule.gravity * self.rule.leg_length))

    @property
    def longest_time(self) -> float:
        """What a short step takes [s]."""
        return longest_time(self.rule)


def derive_gait(
    proportions: Proportions | None = None,
    *,
    speed: float = 0.0,
    step_length: float = 0.0,
    step_width: float = 0.0,
    quickest_time: float = 0.0,
) -> Gait:
    """The gait with what is given; what is 0 is derived as people of these proportions would ([P] 2.1, 4.1).

    Args:
        proportions: Of the character; None = a person.
        speed: [m/s].
        step_length: [m].
        step_width: [m].
        quickest_time: Of a step [s]; 0 = any.
    """
    body = proportions or Proportions()
    rule, width = body.timing, step_width or body.step_width
    step_length = step_length or _unasked_length(body, rule, speed=speed, width=width)
    step_time = step_length / speed if speed else float(time_steps(np.array([step_length]), rule).step_times[0])
    walked = _walked_length(body, width)
    return Gait(
        step_length=step_length,
        step_time=step_time,
        step_width=width,
        walked_length=walked,
        quickest_time=quickest_time,
        rule=rule,
    )


def _unasked_length(body: Proportions, rule: TimingRule, *, speed: float, width: float) -> float:
    """Length of a step at a speed [m/s], 0 = of an easy one; in a walk no longer than the legs span [m]."""
    easy = body.habits.easy_step * body.leg_length
    length = float(natural_lengths(np.array([speed]), rule)[0]) if speed else easy
    if speed and _runs(np.array([speed]), rule)[0]:
        return length
    return min(length, _walked_length(body, width))


def _walked_length(body: Proportions, width: float) -> float:
    """How far legs go along the way [m] with their feet `width` [m] apart across it."""
    span = body.span(SPAN)
    return float(np.sqrt(max(span**2 - width**2, 0.25 * span**2)))


def longest_time(rule: TimingRule) -> float:
    """What a short step takes [s]."""
    return float(time_steps(np.array([1e-3 * rule.leg_length]), rule).step_times[0])


def natural_lengths(speeds: FloatArray, rule: TimingRule) -> FloatArray:
    """Step lengths [m] people of a timing rule choose at speeds [m/s], shape (N,).

    Steps of a run are the quicker the longer they are, also where it is faster than leaps carry anybody.
    """
    lengths = rule.leg_length * np.linspace(0.0, LONGEST_TABLED, 2000)[1:]
    timing = time_steps(lengths, rule)
    walks = ~timing.flies
    lengths, known, slowest = lengths[walks], (lengths / timing.step_times)[walks], timing.step_times[0]
    walked = np.where(speeds < known[0], speeds * slowest, np.interp(speeds, known, lengths, left=0.0))
    size = rule.leg_length / HUMAN_LEG
    pace = np.asarray(speeds) / np.sqrt(size * rule.gravity / EARTH_GRAVITY)
    run = size * pace / (1.0 / rule.run_step + rule.quickening * pace)
    return np.where(_runs(speeds, rule), run, walked)


def overlap_shares(speeds: FloatArray, rule: TimingRule, *, leaps: BoolArray | None = None) -> FloatArray:
    """Double support over step time at speeds [m/s], negative where people fly, shape (N,): where they run or leap."""
    flies = _runs(speeds, rule) if leaps is None else _runs(speeds, rule) | leaps
    return contact_overlaps(np.asarray(speeds) / np.sqrt(rule.gravity * rule.leg_length), flies)


def _runs(speeds: FloatArray, rule: TimingRule) -> BoolArray:
    """Whether people run at speeds [m/s], shape (N,)."""
    return np.asarray(np.asarray(speeds) > np.sqrt(RUNNING_FROUDE * rule.gravity * rule.leg_length))
