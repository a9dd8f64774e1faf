"""Habits: how long, quick and wide somebody's steps are, as the clips show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.gaits import RUNNING_FROUDE, has_flight
from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG, QUICKENING, TimingRule
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.examples import Examples
from usdfoot.spaces.landings import end_landings, left_landings, root_velocities

__all__ = ["PEOPLE", "Habits", "fastest_step", "find_habits"]

STEADY = 0.3
"""A steady step is as long as the one before it, up to this part of their mean, and goes no more than this part of its
way aside."""
STRAIGHT = 0.25
"""And turns by no more than this [rad]."""
LEVEL = 0.06
"""And rises or falls by no more than this, over the leg length."""
SLOWEST = 0.25
"""Speed over sqrt(gravity leg length) from which people keep their walk ratio; slower steps all take as long."""
LONGEST = 3.0
"""Longer running steps say nothing of shorter ones, for a leg of 0.86 m [m]."""


@dataclass(frozen=True, kw_only=True)
class Habits:
    """How somebody steps, as if the leg had 0.86 m (equal Froude numbers); the defaults are people's."""

    walk_ratio: float = TimingRule.walk_ratio
    """Step length by cadence in walks [m per step/min]."""
    run_step: float = TimingRule.run_step
    """What the shortest running steps take [s]."""
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
    shortest = durations / np.sqrt(size) / (1.0 - QUICKENING * np.minimum(speeds * durations / size, LONGEST))
    ratio = _median(speeds * durations**2 / 60.0 / size**1.5, walks, PEOPLE.walk_ratio)
    return Habits(
        walk_ratio=ratio,
        run_step=_median(shortest, runs, PEOPLE.run_step * float(np.sqrt(ratio / PEOPLE.walk_ratio))),
        easy_step=_median(speeds * durations / leg_length, walks, PEOPLE.easy_step),
        step_width=_median(landings[:, 0] / leg_length, walks, PEOPLE.step_width),
    )


def fastest_step(examples: Examples) -> float:
    """Speed of the fastest step of clips [m/s]; without any step there is no limit."""
    speeds = np.linalg.norm(examples.landings, axis=1) / examples.durations
    return float(speeds.max(initial=0.0)) or float("inf")


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
