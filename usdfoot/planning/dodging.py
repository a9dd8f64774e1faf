"""Dodging: people let obstacles that move pass, or get out of their way (extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.floors import Floors
from usdfoot.planning.moving import Moving
from usdfoot.planning.places import Party
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.world import Obstacle

__all__ = ["Dodges", "is_met"]

AHEAD = 3.0
"""People see so far ahead where obstacles will be [s]."""
INSTANTS = np.arange(0.0, AHEAD + 0.01, 0.2)
"""At which they look [s]."""
LONG = np.arange(0.0, 2.0 * AHEAD + 0.01, 0.2)
"""At which those look who get out of the way: not to where they would be in the way again [s]."""
STEP = 0.3
"""Feet come down so long before the body is above them, and stay so long after [s]."""
BESIDE = 0.15
"""From obstacles that move, and their margins, people keep so far [m]."""
ROUND = 0.1
"""Ways round what rests are so much farther from it [m]."""
HAIR = 5e-3
"""Rooms so much smaller [m] are the same."""
LATE = 0.9
"""Others may keep people, who get where they want to be so much later [s]."""
PACES = np.array([1.0, 0.7, 0.4, 0.0])
"""Parts of its speed at which somebody might go on."""
ASIDE = (0.4, 0.8, 1.4, 2.2)
"""Who cannot stay gets out of the way by so much [m]."""
DIRECTIONS = np.stack([np.sin(np.pi * np.arange(16) / 8.0), np.cos(np.pi * np.arange(16) / 8.0)], axis=1)
HURRY = 1.0
"""At least at this speed [m/s]."""
CROWDED, BACKWARDS = 1.0, 0.2
"""Getting out of the way to where somebody is costs so much more [m]; back instead of ahead by so much."""
IMPATIENT = 1.0
"""Who has waited for so long [s] looks for a way on one side."""
SIDEWAYS = (0.25, -0.25, 0.5, -0.5, 1.0, -1.0, 1.6, -1.6)
"""So far aside [m], left positive."""
BACK = 3.0
"""Who stood and got out of the way is back after so long [s]."""
LEAST = 1e-4
"""Less of an obstacle than that [m2] is in nobody's way."""
SPACING = 0.2
"""Between the instants at which those who have arrived look for what is still to come [s]."""
STOOD = 0.02
"""Who has gone no farther stands there [m]."""
RESTS, ASKED = 6.0, 0.5
"""What does not move for so long [s], looked at so often [s], is gone round, if there is a way."""


class Dodges:
    """Who of N people slows down, stands still or gets out of the way because of obstacles that move.

    Everybody knows where these will be soon. Who would not be clear of them on its way goes slower or waits; who is
    not even clear where it is gets out of their way, no farther than it has to. What rests is gone round.

    Args:
        seekers: The people.
        moving: Obstacles; None = there are none.
        levels: Where people can be; what is in walls is in nobody's way.
    """

    def __init__(self, seekers: Sequence[Seeker], moving: Moving | None, levels: Sequence[shapely.Polygon]) -> None:
        self._moving = moving and _on_levels(moving, levels)
        self._speeds = np.array([seeker.speed for seeker in seekers])
        self._radii = np.array([seeker.radius for seeker in seekers])
        self._starts = np.array([seeker.start[1] for seeker in seekers])
        self._needed = self._radii + BESIDE
        self._asked, self._resting = -np.inf, frozenset[str]()
        self._since: FloatArray = np.zeros(len(seekers))
        self._stood: FloatArray | None = None
        self._met = self._waited = -np.inf
        self.active: BoolArray = np.zeros(len(seekers), dtype=bool)
        """Who gets out of the way, shape (N,)."""
        self.targets: FloatArray = np.zeros((len(seekers), 2))
        """Where to (x, z) [m], shape (N, 2)."""
        self.paces: FloatArray = np.ones(len(seekers))
        """How fast each goes over how fast it likes to, shape (N,)."""

    @property
    def waits(self) -> BoolArray:
        """Who waits or gets out of the way, shape (N,)."""
        return self.active | (self.paces < 1.0)

    def expects(self, points: FloatArray, heights: FloatArray, *, now: float) -> bool:
        """Whether there is something to wait for: an obstacle still moves, and somebody waits or stands in its way.

        Args:
            points: Where they are (x, z) [m], shape (N, 2).
            heights: Of the ground there, as far as it is known [m], shape (N,).
            now: [s]
        """
        if self._moving is None:
            return False
        if now < self._waited + BACK:
            return True
        if now >= self._moving.end:
            return False
        if self.waits.any():
            return True
        if self._stood is None or np.abs(points - self._stood).max() > STOOD:
            times = np.arange(now, self._moving.end + SPACING, SPACING)
            places = np.broadcast_to(points, (len(times), *points.shape))
            rooms = self._moving.clearances(places, self._heights(heights), times)
            self._stood, self._met = points.copy(), times[np.any(rooms < self._radii, axis=1)].max(initial=-np.inf)
        return bool(now <= self._met)

    def advance(
        self, points: FloatArray, heights: FloatArray, floors: Floors, *, targets: FloatArray, now: float
    ) -> list[int]:
        """Bring up to date who waits, and who gets out of the way; gives back who has to be sent somewhere.

        Args:
            points: Where they are (x, z) [m], shape (N, 2).
            heights: Of the ground there, as far as it is known [m], shape (N,).
            floors: On which they are.
            targets: Where they want to go (x, z) [m], shape (N, 2).
            now: [s]
        """
        if self._moving is None:
            return []
        heights, before = self._heights(heights), self.active.copy()
        self._look_round(floors, now)
        self.active[:] = False
        paces = np.ones(len(points))
        near = self._near(points, heights, now)
        if near.size:
            ways = np.array(
                [
                    floors.way(index, targets[index]) if before[index] else shapely.LineString(floors.ways[index])
                    for index in near.tolist()
                ]
            )
            rooms = self._along(near, ways, points[near], heights[near], now)
            needed = self._enough(near, points, heights, now)
            clear = rooms >= needed[near]
            goes = clear.any(axis=0)
            paces[near] = np.where(goes, PACES[np.argmax(clear, axis=0)], 1.0)
            self._since[near] = np.where(paces[near] > 0.0, now, self._since[near])
            impatient = goes & (now - self._since[near] >= IMPATIENT) & (now == self._asked)
            for index in near[impatient].tolist():
                if self._pass(index, points, heights, floors, targets[index], now, needed[index]):
                    paces[index] = 1.0
            for index in near[~goes].tolist():
                paces[index] = self._dodge(index, points, heights, floors, now, going=bool(before[index]))
        self.paces = paces
        if self.waits.any() and now < self._moving.end:
            self._waited = now
        return list(range(len(points))) if floors.goes_round else np.flatnonzero(before | self.active).tolist()

    def _heights(self, heights: FloatArray) -> FloatArray:
        return np.where(np.isnan(heights), self._starts, heights)

    def _clearances(self, places: FloatArray, heights: FloatArray, times: FloatArray) -> FloatArray:
        """Least distance of places (T, M, 2) at times (T,) [s] from obstacles, as they are then [m], shape (M,)."""
        assert self._moving is not None
        return np.asarray(self._moving.clearances(places, heights, times).min(axis=0))

    def _enough(self, people: IntArray, points: FloatArray, heights: FloatArray, now: float) -> FloatArray:
        """How far people (M,) keep from obstacles [m], shape (N,): no farther than they are, nor into them."""
        here = self._clearances(points[None, people], heights[people], np.array([now]))
        enough = self._needed.copy()
        enough[people] = np.clip(here - HAIR, self._radii[people], self._needed[people])
        return enough

    def _near(self, points: FloatArray, heights: FloatArray, now: float) -> IntArray:
        """Who may meet an obstacle soon."""
        places = np.broadcast_to(points, (len(INSTANTS), *points.shape))
        reach = self._needed + self._speeds * (AHEAD + STEP)
        return np.flatnonzero(self._clearances(places, heights, now + INSTANTS) < reach)

    def _along(
        self, people: IntArray, ways: FloatArray, points: FloatArray, heights: FloatArray, now: float
    ) -> FloatArray:
        """Least distance [m] of people (M,) from obstacles along their ways at each of `PACES`, shape (P, M).

        With the steps that they have just made and will make next: an obstacle meets the feet before the body.
        """
        arcs = shapely.line_locate_point(ways, shapely.points(points))
        off = points - shapely.get_coordinates(shapely.line_interpolate_point(ways, arcs))
        speeds = PACES[:, None] * self._speeds[people]  # (P, M)
        times = INSTANTS[:, None] + np.array([-LATE, -STEP, 0.0, STEP])
        gone = arcs + times[..., None, None] * speeds  # (T, 4, P, M)
        on_way = shapely.line_interpolate_point(ways, np.maximum(gone, 0.0))
        places = shapely.get_coordinates(on_way).reshape(len(INSTANTS), -1, len(people), 2) + off
        count = places.shape[1]
        found = self._clearances(places.reshape(len(INSTANTS), -1, 2), np.tile(heights, count), now + INSTANTS)
        return np.asarray(found.reshape(4, len(PACES), len(people)).min(axis=0))

    def _pass(
        self,
        index: int,
        points: FloatArray,
        heights: FloatArray,
        floors: Floors,
        target: FloatArray,
        now: float,
        enough: float,
    ) -> bool:
        """Whether one who waits gets on if it first goes to one side; it does then."""
        here = points[index]
        ahead = floors.aims[index] - here
        ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
        places = here + np.array(SIDEWAYS)[:, None] * np.array([ahead[1], -ahead[0]])
        places = places[floors.has_room(index, places)]
        if not len(places):
            return False
        ways = np.array(
            [shapely.LineString([here, *floors.way(index, target, start=place).coords]) for place in places]
        )
        count = len(places)
        rooms = self._along(np.full(count, index), ways, points[[index] * count], heights[[index] * count], now)[0]
        clear = np.flatnonzero(rooms >= enough)
        if clear.size:
            self.active[index], self.targets[index] = True, places[clear[0]]
        return bool(clear.size)

    def _dodge(
        self, index: int, points: FloatArray, heights: FloatArray, floors: Floors, now: float, *, going: bool
    ) -> float:
        """Have one get out of the way, to the nearest place that is clear or else most nearly; gives back its pace."""
        here, radius = points[index], self._radii[index]
        places = np.concatenate([here[None], *(here + far * DIRECTIONS for far in ASIDE)])
        if going:
            places = np.concatenate([self.targets[index][None], places])
        places = places[floors.has_room(index, places)]
        if not len(places):
            return 0.0
        gaps = np.linalg.norm(places - here, axis=1)
        speed = max(float(self._speeds[index]), HURRY)
        shares = np.minimum(LONG[:, None] * speed / np.maximum(gaps, 1e-9), 1.0)
        rooms = self._clearances(
            here + shares[..., None] * (places - here), np.full(len(places), heights[index]), now + LONG
        )
        others = points[(floors.levels == floors.levels[index]) & (np.arange(len(points)) != index)]
        apart = np.min(np.linalg.norm(places[:, None] - others, axis=2), axis=1, initial=np.inf)
        ahead = floors.aims[index] - here
        ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
        costs = gaps + CROWDED * (apart < 2.0 * radius) - BACKWARDS * ((places - here) @ ahead) / np.maximum(gaps, 1e-9)
        lacking = np.round(np.maximum(self._needed[index] - rooms, 0.0), 2)
        best = int(np.lexsort((costs, lacking))[0])
        self.active[index], self.targets[index] = True, places[best]
        return speed / float(self._speeds[index])

    def _look_round(self, floors: Floors, now: float) -> None:
        """Have everybody go round what rests now."""
        assert self._moving is not None
        if now < self._asked + ASKED:
            return
        self._asked, resting = now, self._moving.resting(now, seconds=RESTS)
        names = frozenset(obstacle.name for obstacle in resting)
        if names != self._resting:
            self._resting = names
            floors.go_round(resting, float(self._needed.max()) + ROUND)


def is_met(party: Party, moving: Moving, *, seconds: float) -> bool:
    """Whether an obstacle comes near one of the people where they are at first, for so long [s]."""
    starts = np.array([seeker.start for seeker in party.seekers])
    times = np.arange(0.0, seconds + 1e-9, SPACING)
    places = np.broadcast_to(starts[:, [0, 2]], (len(times), len(starts), 2))
    rooms = _on_levels(moving, party.area.levels).clearances(places, starts[:, 1], times)
    return bool(np.any(rooms < [seeker.radius + BESIDE for seeker in party.seekers]))


def _on_levels(moving: Moving, levels: Sequence[shapely.Polygon]) -> Moving:
    """What of the obstacles is on levels."""
    ground = shapely.union_all(levels)
    shapely.prepare(ground)

    def at(time: float) -> list[Obstacle]:
        found: list[Obstacle] = []
        for obstacle in moving.at(time):
            shape = shapely.Polygon(obstacle.outline)
            if shape.is_valid and not ground.covers(shape):
                parts = shapely.get_parts(ground.intersection(shape))
                outlines = [shapely.get_coordinates(part.exterior)[:-1] for part in parts if part.area > LEAST]
                found += [replace(obstacle, outline=outline) for outline in outlines]
            else:
                found.append(obstacle)
        return found

    return replace(moving, at=at)
