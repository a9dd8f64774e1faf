"""Simulation: JuPedSim moves seekers to their goals past obstacles and each other (extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jupedsim
import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.scenario import Seeker

__all__ = ["Tracks", "simulate"]

TIME_STEP = 0.05
"""Of the simulation [s]."""
TIME_GAP = 0.5
"""In which people let nobody into the space ahead [s]."""
SAMPLE_STEP = 0.1
"""Between positions kept [s]."""
ARRIVAL = 0.2
"""A goal is reached at this distance [m]."""
PATIENCE, STUCK = 25.0, 0.5
"""It ends when nobody on the way has moved so far [m] for so long [s]."""


BLOCKED, ASIDE = 2.0, 1.0
"""Who has hardly moved for so long [s] steps aside by so much [m] for as long."""
DIRECTIONS = np.stack([np.sin(np.pi * np.arange(8) / 4.0), np.cos(np.pi * np.arange(8) / 4.0)], axis=1)


@dataclass(frozen=True, kw_only=True)
class Tracks:
    """Where N seekers were."""

    times: FloatArray
    """[s], shape (T,)."""
    points: FloatArray
    """(x, z) [m], shape (T, N, 2)."""
    arrived: BoolArray
    """Whether they reached their last goal, shape (N,)."""


def simulate(area: shapely.Polygon, seekers: Sequence[Seeker], *, duration: float) -> Tracks:
    """Tracks of seekers in one area (collision free speed model), until all have arrived or nobody gets on.

    Who has arrived stays there, and comes back if others push past.

    Args:
        area: Where they walk (x, z) [m]; all starts and goals are in it.
        seekers: Who.
        duration: At most [s].
    """
    simulation = jupedsim.Simulation(model=jupedsim.CollisionFreeSpeedModelV2(), geometry=area, dt=TIME_STEP)
    steering = simulation.add_direct_steering_stage()
    journey = simulation.add_journey(jupedsim.JourneyDescription([steering]))
    ids = [
        simulation.add_agent(
            jupedsim.CollisionFreeSpeedModelV2AgentParameters(
                position=tuple(seeker.start[[0, 2]].tolist()),
                journey_id=journey,
                stage_id=steering,
                radius=seeker.radius,
                desired_speed=seeker.speed,
                time_gap=TIME_GAP,
            )
        )
        for seeker in seekers
    ]
    legs, detours = _Legs(seekers), _Detours(area, max(seeker.radius for seeker in seekers), len(seekers))
    for identity, target in zip(ids, legs.targets, strict=True):
        simulation.agent(identity).target = tuple(target.tolist())
    samples = [np.array([seeker.start[[0, 2]] for seeker in seekers])]
    every = round(SAMPLE_STEP / TIME_STEP)
    while len(samples) * SAMPLE_STEP < duration and not legs.arrived.all() and not _is_stuck(samples, legs.arrived):
        simulation.iterate(every)
        points = np.array([simulation.agent(identity).position for identity in ids])
        samples.append(points)
        changed = legs.advance(points) + detours.advance(samples, legs.arrived)
        targets = np.where(detours.active[:, None], detours.targets, legs.targets)
        for index in changed:
            simulation.agent(ids[index]).target = tuple(targets[index].tolist())
    return Tracks(times=SAMPLE_STEP * np.arange(len(samples)), points=np.array(samples), arrived=legs.arrived)


def _is_stuck(samples: list[FloatArray], arrived: BoolArray) -> bool:
    """Whether nobody who has not arrived got anywhere lately."""
    before = round(PATIENCE / SAMPLE_STEP)
    if len(samples) <= before:
        return False
    moved = np.linalg.norm(samples[-1] - samples[-1 - before], axis=1)
    return bool(np.all(moved[~arrived] < STUCK))


class _Legs:
    """Which goal each seeker is on its way to."""

    def __init__(self, seekers: Sequence[Seeker]) -> None:
        most = max(len(seeker.goals) for seeker in seekers)
        padded = [np.concatenate([w.goals, np.repeat(w.goals[-1:], most - len(w.goals), axis=0)]) for w in seekers]
        self._goals = np.array(padded)[..., [0, 2]]  # (N, G, 2)
        self._last = np.array([len(seeker.goals) - 1 for seeker in seekers])
        self._current = np.zeros(len(seekers), dtype=int)
        self.arrived = np.zeros(len(seekers), dtype=bool)

    @property
    def targets(self) -> FloatArray:
        """Goal each is on its way to, shape (N, 2)."""
        return self._goals[np.arange(len(self._goals)), self._current]

    def advance(self, points: FloatArray) -> list[int]:
        """Those at their goal take the next; gives back who did, or arrived at the last."""
        there = (np.linalg.norm(points - self.targets, axis=1) <= ARRIVAL) & ~self.arrived
        self.arrived |= there & (self._current == self._last)
        self._current[there & ~self.arrived] += 1
        return np.flatnonzero(there).tolist()


class _Detours:
    """Who gets nowhere steps aside to where there is room, one of those who stand in each other's way at a time."""

    def __init__(self, area: shapely.Polygon, radius: float, count: int) -> None:
        self._room = area.buffer(-radius)
        shapely.prepare(self._room)
        self._until = np.full(count, -np.inf)
        self.active = np.zeros(count, dtype=bool)
        self.targets = np.zeros((count, 2))

    def advance(self, samples: list[FloatArray], arrived: BoolArray) -> list[int]:
        """Those who go on from now on, or step aside."""
        now, points, before = len(samples) * SAMPLE_STEP, samples[-1], round(BLOCKED / SAMPLE_STEP)
        over = self.active & (now > self._until)
        self.active &= ~over
        if len(samples) <= before:
            return []
        moved = np.linalg.norm(points - samples[-1 - before], axis=1)
        blocked = np.flatnonzero((moved < ASIDE * 0.2) & ~arrived & (now > self._until + BLOCKED))
        aside = [index for index in blocked.tolist() if self._step_aside(index, points, now)]
        return [*np.flatnonzero(over).tolist(), *aside]

    def _step_aside(self, index: int, points: FloatArray, now: float) -> bool:
        """Whether this one does, which it does not beside another who does."""
        distances = np.linalg.norm(points - points[index], axis=1)
        if np.any(self.active & (distances < 2.0 * ASIDE)):
            return False
        places = points[index] + ASIDE * DIRECTIONS
        near = points[(distances < 4.0 * ASIDE) & (distances > 0.0)]
        gaps = np.min(np.linalg.norm(places[:, None] - near, axis=2), axis=1, initial=4.0 * ASIDE)
        gaps[~shapely.contains_xy(self._room, places[:, 0], places[:, 1])] = -1.0
        best = int(np.argmax(gaps))
        if gaps[best] < 0.0:
            return False
        self.active[index], self.targets[index], self._until[index] = True, places[best], now + BLOCKED
        return True
