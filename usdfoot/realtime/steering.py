"""Steering: velocities as they come become the next footsteps, one step of everybody at a time ([B] 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.planning.predictions import Gaits
from usdfoot.planning.prints import settle_landings
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.rounds import LONGEST_STEP
from usdfoot.planning.strides import Stances, next_steps
from usdfoot.realtime.footsteps import Footsteps
from usdfoot.realtime.slots import Slots
from usdfoot.realtime.windows import RING, Windows

__all__ = ["Steering"]

STILL = 0.05
"""Who is to go slower than this stands [m/s]."""
CLOSED = 0.08
"""Feet that stand farther from side by side than this are closed [m]."""
TURN_RATE = 2.0
"""How fast a body turns into the heading it is given [rad/s]."""
START_TIME = 0.05
"""From when a standing body learns that it is to go to its first liftoff [s]."""


@dataclass(frozen=True, kw_only=True)
class _Course:
    """Straight on at the velocities wanted, turning into the headings wanted; of N agents."""

    origins: FloatArray  # [m], (N, 3)
    times: FloatArray  # when the root is there [s], (N,)
    velocities: FloatArray  # [m/s], (N, 2)
    headings: FloatArray  # at first [rad], (N,)
    begins: FloatArray  # of turning [s], (N,)
    turns: FloatArray  # wanted [rad], (N,)

    def at(self, agents: IntArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (M, 3) [m] and headings (M,) [rad] of agents (M,) at times (M,) [s]."""
        positions = self.origins[agents].copy()
        positions[:, [0, 2]] += (times - self.times[agents])[:, None] * self.velocities[agents]
        most = TURN_RATE * np.maximum(times - self.begins[agents], 0.0)
        return positions, self.headings[agents] + np.clip(self.turns[agents], -most, most)


class Steering(Slots):
    """What agents were last told about where to go.

    Args:
        agents: Number of agents.
        gaits: What the clips can do.
        body: Sizes of the character.
        options: Of following.
    """

    def __init__(self, agents: int, gaits: Gaits, *, body: Proportions, options: FollowOptions) -> None:
        self._gaits, self._body, self._options = gaits, body, options
        self._velocities, self._yaws = np.zeros((agents, 2)), np.zeros(agents)
        self._runs = np.zeros(agents, dtype=bool)
        self.active = np.zeros(agents, dtype=bool)
        """Who is steered."""

    def set(self, agents: IntArray, velocities: FloatArray, yaws: FloatArray) -> None:
        """Velocities (M, 2) [m/s] and headings (M,) [rad] of agents from now on."""
        self._velocities[agents], self._yaws[agents] = velocities, yaws
        self.active[agents] = True

    def step(self, windows: Windows, ground: Ground, *, now: float) -> int:
        """Gives everyone who is steered the next footstep if it needs one; how many did."""
        wanting = np.zeros(len(windows), dtype=bool)
        wanting[windows.wanting(now)] = True
        agents = np.flatnonzero(self.active & (wanting | windows.halted) & (windows.room > 0))
        agents = agents[self._goes(windows, agents)]
        if agents.size:
            self._step(windows, agents, ground, now)
        return len(agents)

    def _goes(self, windows: Windows, agents: IntArray) -> BoolArray:
        """Whether agents have somewhere to go, to turn, or to put their foot."""
        last, before, headings = _feet(windows, agents)
        apart = planar.rotate(-headings, (last - before)[:, [0, 2]])
        speeds = np.linalg.norm(self._velocities[agents], axis=1)
        turned = np.abs(planar.wrap_angle(self._yaws[agents] - headings)) > self._options.leave_turn
        return (speeds > STILL) | turned | (np.abs(apart[:, 1]) > CLOSED)

    def _step(self, windows: Windows, agents: IntArray, ground: Ground, now: float) -> None:
        last, before, headings = _feet(windows, agents)
        number = windows.last[agents]
        rested = windows.halted[agents]
        strikes = windows.at(windows.strikes, agents, number)
        rested &= strikes <= now
        begins = np.where(rested, now + START_TIME, strikes)
        durations = np.clip(strikes - windows.at(windows.strikes, agents, number - 1), 0.3, 0.8)
        durations = np.where(rested, 0.5, durations)
        middle = 0.5 * (last + before)
        ahead = planar.direction(headings)
        along = np.sum((last - middle)[:, [0, 2]] * ahead, axis=1)
        origins = middle.copy()
        origins[:, [0, 2]] += np.where(rested, 0.0, along)[:, None] * ahead
        course = _Course(
            origins=origins,
            times=np.where(rested, begins, begins + 0.5 * durations),
            velocities=self._velocities[agents],
            headings=headings,
            begins=begins,
            turns=planar.wrap_angle(self._yaws[agents] - headings),
        )
        own = np.arange(len(agents))
        stances = Stances(
            agents=own,
            times=begins,
            sides=windows.sides[agents, number % RING],
            supports=last,
            support_yaws=windows.at(windows.yaws, agents, number),
            others=before,
            other_yaws=windows.at(windows.yaws, agents, number - 1),
            runs=self._runs[agents],
            durations=durations,
        )
        steps = next_steps(
            self._gaits,
            course,
            stances,
            begins=begins,
            rested=rested,
            longest=LONGEST_STEP * self._body.leg_length,
            options=self._options,
        )
        self._runs[agents] = steps.runs
        windows.leave(agents[rested], steps.liftoffs[rested])
        stance_times = steps.support_liftoffs - (steps.strikes - steps.durations)
        footsteps = Footsteps(
            sides=steps.sides,
            positions=settle_landings(ground, last, steps.positions, yaws=steps.yaws, body=self._body),
            yaws=steps.yaws,
            strike_times=steps.strikes,
            liftoff_times=steps.strikes + stance_times,
        )
        windows.append(agents, footsteps, now=now)


def _feet(windows: Windows, agents: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places of the last contact and of the one before it [m] (N, 3), and their mean yaw [rad] (N,)."""
    number = windows.last[agents]
    yaws, other_yaws = (windows.at(windows.yaws, agents, number - back) for back in (0, 1))
    headings = planar.midway_yaw(yaws, other_yaws)
    last, before = (windows.at(windows.positions, agents, number - back) for back in (0, 1))
    return last, before, headings
