"""Simulation: JuPedSim moves seekers to their goals past obstacles and each other (extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.cornering import Corners
from usdfoot.planning.dodging import Dodges
from usdfoot.planning.floors import TIME_STEP, Floors
from usdfoot.planning.itineraries import Itinerary
from usdfoot.planning.moving import Moving
from usdfoot.planning.passages import Gates, find_passages
from usdfoot.planning.places import Party
from usdfoot.planning.slipping import HELD_UP, Slips
from usdfoot.planning.walkable import Area

__all__ = ["Tracks", "simulate"]

SAMPLE_STEP = 0.1
"""Between positions kept [s]."""
ARRIVAL = 0.2
"""A goal is reached at this distance [m]."""
AROUND, HALTED = 0.4, 0.1
"""So is a place around a goal of several at this one [m], by who goes no faster [m/s] for those who stand there."""
SETTLE = 2.0
"""Who is so close [m] to the places around a goal of several takes one."""
STAY, NEARER, BESIDE = 8.0, 0.1, 1.0
"""Who has for so long [s] come no nearer [m] to its place there, so close [m] to somebody who stands at his, stays."""
PATIENCE, STUCK = 25.0, 0.5
"""It ends when nobody has moved so far [m] for so long [s]."""
LOOK_AHEAD = 2.0
"""Between the instants at which everybody looks for its way [s]."""
BLOCKED, ASIDE = 2.0, 1.0
"""Who has hardly moved for so long [s] steps aside by so much [m] for as long."""
ASKED = 0.5
"""Between the instants at which people ask themselves whether they are blocked [s]."""
QUEUE, SAME_WAY = 0.5, 0.5
"""Who is so close to another [m], and this cosine of the angle between their ways or more: who is before the other."""
ALONE = 2.0
"""A queue has none but those who go its way so close to it [m]."""
APART = 1e3
"""Between levels in the search tree [m]: more than any distance looked for."""
DIRECTIONS = np.stack([np.sin(np.pi * np.arange(8) / 4.0), np.cos(np.pi * np.arange(8) / 4.0)], axis=1)
CLIMB = 1.5
"""Time over which the slope of the way is measured [s]."""


@dataclass(frozen=True, kw_only=True)
class Tracks:
    """Where N seekers were."""

    times: FloatArray
    """[s], shape (T,)."""
    points: FloatArray
    """(x, z) [m], shape (T, N, 2)."""
    heights: FloatArray
    """Of the ground where they were, to a cell's width; not a number without terrain [m], shape (T, N)."""
    turned: FloatArray
    """How far they had to turn their shoulders: 0 = not, 1 = sideways, shape (T, N)."""
    arrived: BoolArray
    """Whether they reached their last goal, shape (N,)."""
    left: FloatArray
    """How far from it they stopped [m], shape (N,)."""


def simulate(party: Party, *, duration: float, moving: Moving | None = None, hold: float = 0.0) -> Tracks:
    """Tracks of people in one area (collision free speed model), until all have arrived or nobody gets on.

    Who has arrived stays there, and comes back if others push past. Up and down they go as much slower as walkers do.

    Args:
        party: Who, and where.
        duration: At most [s].
        moving: Obstacles that do, and that people wait for or get out of the way of; None = there are none.
        hold: So long they only get out of the way of these, before they go [s].
    """
    legs, floors = _Legs(party.itineraries, party.goals), Floors(party)
    detours = _Detours(party.area, max(seeker.radius for seeker in party.seekers), len(party.seekers))
    everyone = list(range(len(party.seekers)))
    gates, slips, corners = _gates(party, floors), Slips(party.seekers), Corners(party.seekers)
    dodges = Dodges(party.seekers, moving, party.area.levels)
    floors.steer(everyone, legs.targets)
    turned = [gates.turned.copy()]
    samples = [np.array([seeker.start[[0, 2]] for seeker in party.seekers])]
    heights = [party.area.height_at(party.starts, samples[0])]
    every = round(SAMPLE_STEP / TIME_STEP)
    while len(samples) * SAMPLE_STEP < duration:
        now = (len(samples) - 1) * SAMPLE_STEP
        ends = legs.arrived.all() or _is_stuck(samples)
        if ends and not dodges.expects(samples[-1], heights[-1], now=now):
            break
        points = floors.iterate(every)
        samples.append(gates.centred(points, floors.levels))
        changed = legs.advance(points, floors.go_over(legs.next_levels))
        changed += gates.advance(
            points, floors, targets=legs.targets, arrived=legs.arrived, now=len(samples) * SAMPLE_STEP
        )
        held_up = max(0, len(samples) - 1 - round(HELD_UP / SAMPLE_STEP))
        slips.advance(
            points,
            np.linalg.norm(points - samples[held_up], axis=1),
            floors.levels,
            standing=legs.arrived,
            waits=gates.held | gates.led,
            now=len(samples) * SAMPLE_STEP,
        )
        floors.slim(np.minimum(gates.thin, slips.thin))
        turned.append(np.maximum(gates.turned, slips.turned))
        waits = legs.arrived | gates.held | slips.active | dodges.waits | (now < hold)
        changed += detours.advance(samples, waits, floors)
        if len(samples) % round(LOOK_AHEAD / SAMPLE_STEP) == 0:
            changed = everyone
        targets = np.where((gates.held | gates.led)[:, None], gates.places, legs.targets)
        targets = np.where(detours.active[:, None], detours.targets, targets)
        heights.append(party.area.height_at(floors.levels, points))
        changed += dodges.advance(points, heights[-1], floors, targets=targets, now=(len(samples) - 1) * SAMPLE_STEP)
        floors.steer(sorted({*changed}), np.where(dodges.active[:, None], dodges.targets, targets))
        slopes, bends = _paces(samples, heights), corners.paces(points, floors.ways, elapsed=SAMPLE_STEP)
        floors.pace(
            slopes
            * np.minimum(gates.paces(turned[-1]), bends)
            * np.where((now < hold) & ~dodges.active, 0.0, dodges.paces)
        )
    times = SAMPLE_STEP * np.arange(len(samples))
    return Tracks(
        times=times,
        points=np.array(samples),
        heights=np.array(heights),
        turned=np.array(turned),
        arrived=legs.arrived,
        left=legs.left(samples[-1]),
    )


def _gates(party: Party, floors: Floors) -> Gates:
    """The passages of an area, for those who walk in it."""
    radii, speeds, legs = np.array([(one.radius, one.speed, one.body.leg_length) for one in party.seekers]).T
    return Gates(find_passages(floors.rooms, float(radii.max())), radii=radii, speeds=speeds, legs=legs)


def _paces(samples: list[FloatArray], heights: list[FloatArray]) -> FloatArray:
    """How fast each goes on the slope it has just come over, over how fast it goes on the level, shape (N,).

    Tobler's hiking function.
    """
    before = -min(len(samples), 1 + round(CLIMB / SAMPLE_STEP))
    moved = np.linalg.norm(samples[-1] - samples[before], axis=1)
    rise = np.nan_to_num(heights[-1] - heights[before])
    grade = np.where(moved > 0.2, rise / np.maximum(moved, 0.2), 0.0)
    return np.exp(-1.75 * np.maximum(np.abs(grade + 0.05) - 0.05, 0.0))


def _is_stuck(samples: list[FloatArray]) -> bool:
    """Whether nobody got anywhere lately."""
    before = round(PATIENCE / SAMPLE_STEP)
    if len(samples) <= before:
        return False
    moved = np.linalg.norm(samples[-1] - samples[-1 - before], axis=1)
    return bool(np.all(moved < STUCK))


class _Legs:
    """Which point of its itinerary each seeker is on its way to.

    Those with one last goal take the places around it from the middle outwards as they come: nobody has to get past
    those who stand. Who does not get through to its place has arrived in the thick of them.

    Args:
        itineraries: One a seeker, to a place of its own at its last goal.
        goals: Last goals (x, z) [m], shape (N, 2).
    """

    def __init__(self, itineraries: Sequence[Itinerary], goals: FloatArray) -> None:
        most = max(len(itinerary.stops) for itinerary in itineraries)

        def padded(values: np.ndarray) -> np.ndarray:
            return np.concatenate([values, np.repeat(values[-1:], most - len(values), axis=0)])

        self._points = np.array([padded(itinerary.points) for itinerary in itineraries])  # (N, K, 2)
        self._stops = np.array([padded(itinerary.stops) for itinerary in itineraries])
        self._levels = np.array([padded(itinerary.levels) for itinerary in itineraries])
        self._last = np.array([len(itinerary.stops) - 1 for itinerary in itineraries])
        self._current = np.zeros(len(itineraries), dtype=int)
        self.arrived = np.zeros(len(itineraries), dtype=bool)
        self._settled = np.zeros(len(itineraries), dtype=bool)
        self._before = np.full((len(itineraries), 2), np.inf)
        self._nearest, self._waited = np.full(len(itineraries), np.inf), np.zeros(len(itineraries))
        ends = np.column_stack([goals, self._levels[:, -1]])
        sharing = np.unique(ends, axis=0, return_inverse=True)[1].reshape(-1)
        self._circles = [np.flatnonzero(sharing == one) for one in np.flatnonzero(np.bincount(sharing) > 1)]
        self._goals, self._away = goals, np.linalg.norm(self._points[:, -1] - goals, axis=1)

    @property
    def targets(self) -> FloatArray:
        """Point each is on its way to, shape (N, 2)."""
        return self._points[np.arange(len(self._points)), self._current]

    @property
    def next_levels(self) -> IntArray:
        """Level to which each goes over where it is going now, -1 = it has a goal there, shape (N,)."""
        rows = np.arange(len(self._points))
        following = self._levels[rows, np.minimum(self._current + 1, self._last)]
        return np.where(self._stops[rows, self._current], -1, following)

    def advance(self, points: FloatArray, over: BoolArray) -> list[int]:
        """Those at their goal or on their next level go on; gives back who did, or arrived at the last."""
        away, moved = (np.linalg.norm(points - before, axis=1) for before in (self.targets, self._before))
        self._before = points
        there = (away <= ARRIVAL) | (self._settled & (away <= AROUND) & (moved <= HALTED * SAMPLE_STEP))
        there |= self._stays(points, away)
        there &= ~self.arrived & (self.next_levels < 0)
        self.arrived |= there & (self._current == self._last)
        self._current[(there & ~self.arrived) | over] += 1
        return [*np.flatnonzero(there | over).tolist(), *self._settle(points)]

    def left(self, points: FloatArray) -> FloatArray:
        """How far seekers at points (N, 2) are from their last goals [m], shape (N,)."""
        return np.asarray(np.linalg.norm(points - self._points[:, -1], axis=1))

    def _stays(self, points: FloatArray, away: FloatArray) -> BoolArray:
        """Whether each, so far from its place (N,) [m], stays among those who stand; its place is there now."""
        nearer = away < self._nearest - NEARER
        self._nearest = np.where(nearer, away, self._nearest)
        self._waited = np.where(nearer | ~self._settled, 0.0, self._waited + SAMPLE_STEP)
        stays = (self._waited > STAY) & ~self.arrived
        for circle in self._circles:
            own, standing = circle[stays[circle]], points[circle[self.arrived[circle]]]
            gaps = np.linalg.norm(points[own][:, None] - standing, axis=2)
            stays[own] = np.min(gaps, axis=1, initial=np.inf) <= BESIDE
        for one in np.flatnonzero(stays).tolist():
            self._points[one, self._last[one] :] = points[one]
        return stays

    def _settle(self, points: FloatArray) -> list[int]:
        """Have those near a goal of several take the innermost place that nobody there has; gives back who changed."""
        near = np.linalg.norm(points - self._goals, axis=1)
        last = ~self._settled & (self._current == self._last)
        changed: list[int] = []
        for circle in self._circles:
            own = circle[last[circle]]
            for one in own[near[own] <= self._away[circle].max() + SETTLE].tolist():
                free = circle[~self._settled[circle]]
                other = int(free[np.argmin(self._away[free])])
                self._swap(one, other)
                self._settled[one] = True
                changed += [one, other]
        return changed

    def _swap(self, one: int, other: int) -> None:
        """Have two exchange their places."""
        places = self._points[[other, one], -1]
        for index, place in zip((one, other), places, strict=True):
            self._points[index, self._last[index] :] = place
        self._away[[one, other]] = self._away[[other, one]]
        self._nearest[[one, other]] = np.inf


class _Detours:
    """Who gets nowhere steps aside to where there is room, one of those who stand in each other's way at a time.

    Nobody does in a queue: who is held up by those who go the same way waits, unless others are near.
    """

    def __init__(self, area: Area, radius: float, count: int) -> None:
        self._rooms = [level.buffer(-radius) for level in area.levels]
        for room in self._rooms:
            shapely.prepare(room)
        self._width = 2.0 * radius
        self._until = np.full(count, -np.inf)
        self.active = np.zeros(count, dtype=bool)
        self.targets = np.zeros((count, 2))

    def advance(self, samples: list[FloatArray], waits: BoolArray, floors: Floors) -> list[int]:
        """Those who go on from now on, or step aside on the levels they are on; none who waits, or did just now."""
        now, points, before = len(samples) * SAMPLE_STEP, samples[-1], round(BLOCKED / SAMPLE_STEP)
        over = self.active & ((now > self._until) | waits)
        self._until[waits] = now
        self.active &= ~over
        if len(samples) <= before or len(samples) % round(ASKED / SAMPLE_STEP):
            return np.flatnonzero(over).tolist()
        moved = np.linalg.norm(points - samples[-1 - before], axis=1)
        blocked = (moved < ASIDE * 0.2) & (now > self._until + BLOCKED)
        blocked &= ~self._queues(points, waits, floors) if blocked.any() else False
        aside = [index for index in np.flatnonzero(blocked).tolist() if self._step_aside(index, points, floors, now)]
        return [*np.flatnonzero(over).tolist(), *aside]

    def _queues(self, points: FloatArray, waits: BoolArray, floors: Floors) -> BoolArray:
        """Whether somebody close before each of N people goes the same way, and all near by do, shape (N,)."""
        ways = floors.aims - points
        ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
        places = np.column_stack([points, APART * floors.levels])
        pairs = cKDTree(places).query_pairs(self._width + ALONE, output_type="ndarray")
        one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
        gaps = points[other] - points[one]
        before = (np.sum(gaps * ways[one], axis=1) > 0.0) & (np.linalg.norm(gaps, axis=1) <= self._width + QUEUE)
        same = (np.sum(ways[one] * ways[other], axis=1) > SAME_WAY) & ~waits[other]
        before &= ~np.roll(before, len(pairs))  # two who wedge side by side hold up nobody but themselves
        held_up = np.bincount(one, weights=before & same, minlength=len(points)) > 0.0
        return np.asarray(held_up & (np.bincount(one, weights=~same, minlength=len(points)) == 0.0))

    def _step_aside(self, index: int, points: FloatArray, floors: Floors, now: float) -> bool:
        """Whether this one does, which it does not beside another who does."""
        level = floors.levels[index]
        distances = np.where(floors.levels == level, np.linalg.norm(points - points[index], axis=1), np.inf)
        if np.any(self.active & (distances < 2.0 * ASIDE)):
            return False
        places = points[index] + ASIDE * DIRECTIONS
        near = points[(distances < 4.0 * ASIDE) & (distances > 0.0)]
        gaps = np.min(np.linalg.norm(places[:, None] - near, axis=2), axis=1, initial=4.0 * ASIDE)
        gaps[~shapely.contains_xy(self._rooms[level], places[:, 0], places[:, 1])] = -1.0
        best = int(np.argmax(gaps))
        if gaps[best] < 0.0:
            return False
        self.active[index], self.targets[index], self._until[index] = True, places[best], now + BLOCKED
        return True
