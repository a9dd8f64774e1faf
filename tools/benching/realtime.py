"""How many agents a controller poses in real time, footsteps given two ahead."""

from __future__ import annotations

import time

import numpy as np

from benching.rigs import straight_plan, with_joints
from usdfoot.engine.animate import prepare_library
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.realtime.controller import Controller
from usdfoot.realtime.footsteps import Footsteps
from usdfoot.realtime.walks import ControllerOptions

__all__ = ["realtime_times"]

RATE = 25.0
"""Frames a second: the paper's 60 agents were posed at 25 ([B] 6)."""
LONGEST_DELAY = 0.6
"""The agents start within so much time, so that they do not march in step [s]."""


def realtime_times(library: ClipLibrary, joints: int, *, agents: int, seconds: float = 6.0) -> dict[str, float]:
    """Processor time of a crowd that walks while its footsteps come, on one core.

    Args:
        library: Clips.
        joints: Of the skeleton.
        agents: In the crowd.
        seconds: Of walking, of which the first two are not counted.

    Returns:
        Microseconds an agent-frame all in, milliseconds of the mean and the longest frame, and how many agents that
        makes at RATE.
    """
    options = ControllerOptions()
    prepared = prepare_library(with_joints(library, joints), options.engine)
    places = np.stack([2.0 * np.arange(agents), np.zeros(agents), np.zeros(agents)], axis=1)
    controller = Controller(prepared, positions=places, yaws=np.zeros(agents), options=options)
    feed = _Feed(agents, seconds)
    spent = []
    for frame in range(int(seconds * RATE)):
        begin = time.process_time()
        feed.give(controller, frame / RATE)
        controller.pose(frame / RATE)
        spent.append(time.process_time() - begin)
    counted = np.array(spent[int(2.0 * RATE) :])
    return {
        "agent-frame [us]": 1e6 * counted.mean() / agents,
        "frame [ms]": 1e3 * counted.mean(),
        "longest frame [ms]": 1e3 * counted.max(),
        "agents at 25 frames a second": agents / (RATE * counted.mean()),
    }


class _Feed:
    """Footsteps of straight walks, each given a frame before the one two before it strikes."""

    def __init__(self, agents: int, seconds: float) -> None:
        plans = [straight_plan(number, seconds + 2.0) for number in range(agents)]
        count = min(len(plan) for plan in plans)
        delays = 0.5 + np.random.default_rng(0).uniform(0.0, LONGEST_DELAY, (agents, 1))

        def table(name: str) -> FloatArray:
            return np.stack([getattr(plan, name)[:count] for plan in plans])

        self._sides, self._positions, self._yaws = table("sides"), table("positions"), table("yaws")
        self._strikes, self._liftoffs = table("strike_times") + delays, table("liftoff_times") + delays
        self._given = np.zeros(agents, dtype=int)

    def give(self, controller: Controller, now: float) -> None:
        """Gives all footsteps whose time has come."""
        agents = np.arange(len(self._given))
        while True:
            next_ = np.minimum(self._given, self._sides.shape[1] - 1)
            due = self._strikes[agents, np.maximum(next_ - 2, 0)] <= now + 1.0 / RATE
            own = agents[(due | (self._given < 2)) & (self._given < self._sides.shape[1])]
            if not own.size:
                return
            place = own, self._given[own]
            steps = Footsteps(
                sides=self._sides[place],
                positions=self._positions[place],
                yaws=self._yaws[place],
                strike_times=self._strikes[place],
                liftoff_times=self._liftoffs[place],
            )
            for problem in controller.plan(own, steps):
                raise RuntimeError(str(problem))
            self._given[own] += 1
