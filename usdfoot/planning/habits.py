"""Habits: how long, quick and wide somebody's steps are, as the clips show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.gaits import RUNNING_FROUDE, has_flight
from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG, QUICKENING, TimingRule
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.examples import Examples
from usdfoot.spaces.landings import end_landings, left_landings, root_velocities

__all__ = ["PEOPLE", "SPAN", "Habits", "fastest_step", "find_habits", "narrowest_step"]

STEADY = 0.3
"""A steady step is as long as the one before it, up to this part of their mean, and goes no more than this part of its
way aside."""
STRAIGHT = 0.25
"""And turns by no more than this [rad]."""
LEVEL = 0.06
"""And rises or falls by no more than this, over the leg length."""
SLOWEST = 0.25
"""Speed over sqrt(gravity leg length) from which people keep their walk ratio; slower steps all take as long."""
SPAN = 1.4
"""Longest step without a flight that nobody asked for, foot to foot over the leg length where the hips were none apart;
legs reach 1.5."""
WALKED = float(np.sqrt(RUNNING_FROUDE * EARTH_GRAVITY * HUMAN_LEG))
"""Speed from which people do not walk [m/s]."""
LONGEST = 3.0
"""Longer running steps say nothing of shorter ones, for a leg of 0.86 m [m]."""


@dataclass(frozen=True, kw_only=True)
class Habits:
    """How somebody steps, as if the leg had 0.86 m (equal Froude numbers); the defaults are people's."""

    walk_ratio: float = TimingRule.walk_ratio
    """Step length by cadence in walks [m per step/min]."""
    run_step: float = TimingRule.run_step
    """What the shortest running steps take [s]."""
    quickening: float = TimingRule.quickening
    """By which part of that longer ones take less, a metre [1/m]."""
    easy_step: float = 0.8
    """Length of an easy walking step over the leg length."""
    step_width: float = 0.0
    """Between the feet in walks over the leg length; 0 = as the hips are wide."""

    def timing(self, leg_length: float) -> TimingRule:
        """The times of the steps of such a body; who keeps a larger walk ratio also is slower where steps are short."""
        slower = np.sqrt(self.walk_ratio / TimingRule.walk_ratio)
        return TimingRule(
            leg_length=leg_length,
            walk_ratio=self.walk_ratio,
            longest_step=float(slower * TimingRule.longest_step),
            run_step=self.run_step,
            quickening=self.quickening,
        )


PEOPLE = Habits()


def find_habits(examples: Examples, *, leg_length: float) -> Habits:
    """The habits that clips show: medians over their steady, straight and level steps ahead, else people's.

    Who shows no run runs as much slower than people as they walk.

    Args:
        examples: Steps of the clips.
        leg_length: Of the character, straight [m].
    """
    size = leg_length / HUMAN_LEG
    durations = np.asarray(examples.durations, dtype=float)
    landings = left_landings(end_landings(examples), examples.swing_sides)
    speeds = np.linalg.norm(root_velocities(examples), axis=1)
    froude = speeds / np.sqrt(EARTH_GRAVITY * leg_length)
    steady = _steady(examples, leg_length)
    flies = has_flight(durations, examples.support_liftoffs, landings, leg_length=leg_length)
    walks = steady & ~flies & (froude >= SLOWEST)
    runs = steady & flies & (froude > np.sqrt(RUNNING_FROUDE))
    ratio = _median(speeds * durations**2 / 60.0 / size**1.5, walks, PEOPLE.walk_ratio)
    run_step, quickening = PEOPLE.run_step * float(np.sqrt(ratio / PEOPLE.walk_ratio)), PEOPLE.quickening
    if runs.any():
        run_step, quickening = _running(durations[runs] / np.sqrt(size), speeds[runs] * durations[runs] / size)
    return Habits(
        walk_ratio=ratio,
        run_step=run_step,
        quickening=quickening,
        easy_step=_median(speeds * durations / leg_length, walks, PEOPLE.easy_step),
        step_width=_median(landings[:, 0] / leg_length, walks, PEOPLE.step_width),
    )


def _running(times: FloatArray, lengths: FloatArray) -> tuple[float, float]:
    """`run_step` [s] and `quickening` [1/m] of running steps of times [s] and lengths [m] (N,), for a leg of 0.86 m.

    Where steps as slow as a walk would be longer than legs span, as by the fast and slow-paced runs of cartoons, slower
    runs keep more of their pace than people's.
    """
    run_step = float(np.median(times / (1.0 - QUICKENING * np.minimum(lengths, LONGEST))))
    spanned = WALKED / (SPAN * HUMAN_LEG)  # steps a second at which those as slow as a walk are that long
    if 1.0 / run_step + QUICKENING * WALKED >= spanned:
        return run_step, QUICKENING
    pace, speed = float(np.median(1.0 / times)), float(np.median(lengths / times))
    quickening = max((pace - spanned) / (speed - WALKED), 0.0)
    return 1.0 / (pace - quickening * speed), quickening


def fastest_step(examples: Examples) -> float:
    """Speed of the fastest step of clips [m/s]; without any step there is no limit."""
    speeds = np.linalg.norm(examples.landings, axis=1) / examples.durations
    return float(speeds.max(initial=0.0)) or float("inf")


def narrowest_step(examples: Examples) -> float:
    """Between the feet in the narrowest step of clips [m], negative where they cross; 0 without any step."""
    landings = left_landings(end_landings(examples), examples.swing_sides)
    return float(landings[:, 0].min(initial=np.inf)) if len(examples) else 0.0


def _steady(examples: Examples, leg_length: float) -> BoolArray:
    """Which steps are as long as those before them, straight ahead on level ground, shape (E,)."""
    ahead, before = end_landings(examples)[:, 1], -np.asarray(examples.departures, dtype=float)[:, 1]
    velocities = root_velocities(examples)
    even = np.abs(ahead - before) <= 0.5 * STEADY * (ahead + before)
    straight = np.abs(velocities[:, 0]) <= STEADY * velocities[:, 1]
    level = np.abs(examples.landing_heights) <= LEVEL * leg_length
    return np.asarray(even & straight & level & (np.abs(examples.turns) <= STRAIGHT) & (ahead > 0.0))


def _median(values: FloatArray, chosen: BoolArray, otherwise: float) -> float:
    """Median of the values (E,) chosen, if there are any."""
    return float(np.median(values[chosen])) if chosen.any() else otherwise
