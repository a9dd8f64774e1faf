"""Passages: where two have no room beside each other, or one only sideways, so people go through one way at a time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.floors import Floors
from usdfoot.planning.walkable import move_inside

__all__ = ["Gates", "Passage", "find_passages"]

HOLD = 2.5
"""Who comes so near [m] goes in or waits."""
PLACES = 0.6
"""Between places where people wait [m]."""
FAN = 0.5
"""How much broader the way out that is kept free gets on either side, for each metre from the mouth [m]."""
SPACE, WEDGE = 0.7, 1.5
"""Who goes in keeps so far [m] behind the one before where a passage is narrower than so many bodies: two would wedge."""
SIDE_SPEED = 0.35
"""Of side steps, for a leg of 0.86 m [m/s]."""
ELBOWS = 0.1
"""In a passage a radius is less than half its width by this: JuPedSim lets nobody as near to a wall as that [m]."""
THINNEST = 0.05
"""Least radius of a body in the simulation [m]."""
NEAR_MOUTH = 0.02
"""Where a passage and what it leads to meet, they overlap by so much [m]."""
HALVINGS = 8
"""How often the range of a passage's width is halved."""
TURNING = 0.4
"""Who has to go sideways has turned this far before it is tight [m]."""


@dataclass(frozen=True, kw_only=True)
class Passage:
    """A narrow part of a level with a mouth at either end."""

    level: int
    shape: shapely.Polygon
    """(x, z) [m]."""
    mouths: tuple[shapely.Geometry, shapely.Geometry]
    places: tuple[FloatArray, FloatArray]
    """Where people wait at either mouth, beside the way out of it (x, z) [m], shape (P, 2)."""
    half_width: float
    """Of the narrowest place [m]."""
    middle: shapely.Geometry
    """Where the middle of a body is that keeps off the walls."""


def find_passages(levels: tuple[shapely.Polygon, ...], radius: float) -> list[Passage]:
    """Parts of levels in which two bodies of a radius [m] have no room beside each other, from one mouth to another."""
    found = []
    for number, level in enumerate(levels):
        two = 2.0 * radius + ELBOWS
        wide = level.buffer(-two).buffer(1.001 * two, join_style="mitre")
        for part in shapely.get_parts(level.difference(wide)):
            if part.geom_type != "Polygon" or part.area <= radius**2 / 4.0:
                continue
            x0, z0, x1, z1 = part.bounds
            around = x0 - 4.0 * two, z0 - 4.0 * two, x1 + 4.0 * two, z1 + 4.0 * two
            mouths = shapely.get_parts(part.buffer(NEAR_MOUTH).intersection(shapely.clip_by_rect(wide, *around)))
            if len(mouths) == 2:
                beside = shapely.clip_by_rect(level, *around)
                local = beside.intersection(part.buffer(2.0 * two))
                half = _half_width(local, mouths, two)
                found.append(
                    Passage(
                        level=number,
                        shape=part,
                        mouths=(mouths[0], mouths[1]),
                        places=_waiting_places(level, mouths, radius),
                        half_width=half,
                        middle=local.buffer(-0.95 * min(half, radius)),
                    )
                )
    return found


def _waiting_places(level: shapely.Polygon, mouths: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Places on a level near two mouths but beside the ways out of them, for bodies of a radius [m]."""
    ends = shapely.get_coordinates(shapely.centroid(mouths))
    found = []
    for mouth, end, out in zip(mouths, ends, ends - ends[::-1], strict=True):
        out = out / max(float(np.linalg.norm(out)), 1e-9)
        across = np.array([out[1], -out[0]])
        beside = 0.5 * float(np.ptp(shapely.get_coordinates(mouth) @ across)) + 2.0 * radius
        ahead, aside = np.meshgrid(np.arange(radius + 0.1, HOLD, PLACES), np.arange(0.0, HOLD, PLACES))
        aside += beside + FAN * ahead
        steps = np.concatenate([np.stack([ahead, side * aside], axis=-1).reshape(-1, 2) for side in (-1.0, 1.0)])
        places = end + steps @ np.stack([out, across])
        room = shapely.clip_by_rect(level, *(end - 2.0 * HOLD), *(end + 2.0 * HOLD)).buffer(-radius)
        found.append(places[shapely.contains_xy(room, places[:, 0], places[:, 1])])
    return found[0], found[1]


def _half_width(local: shapely.Geometry, mouths: FloatArray, most: float) -> float:
    """Radius of the largest disc that gets from one mouth to the other [m]."""
    low, high = 0.0, most
    for _ in range(HALVINGS):
        radius = 0.5 * (low + high)
        rooms = shapely.get_parts(local.buffer(-radius))
        joined = any(all(room.distance(mouth) <= radius for mouth in mouths) for room in rooms)
        low, high = (radius, high) if joined else (low, radius)
    return low


@dataclass(kw_only=True)
class _Turn:
    """Whose turn it is at a passage."""

    mouth: int = 0
    """From which people come through now."""
    first: int = -1
    """Who began the turn."""
    going: list[int] = field(default_factory=list)
    """Who goes through."""
    places: dict[int, int] = field(default_factory=dict)
    """Which place of its mouth each who waits has."""


class Gates:
    """Who goes through which passage, who waits, and who goes sideways, of N people.

    People come through from one mouth until the first of them is out. Then it is the other's turn, if anybody waits
    there.

    Args:
        passages: Of all levels.
        radii: Of the bodies [m], shape (N,).
        speeds: At which they like to walk [m/s], shape (N,).
        legs: Their length [m], shape (N,).
    """

    def __init__(self, passages: list[Passage], *, radii: FloatArray, speeds: FloatArray, legs: FloatArray) -> None:
        self._passages, self._radii = passages, radii
        self._sideways = np.minimum(SIDE_SPEED * np.sqrt(legs / 0.86) / speeds, 1.0)
        self._turns = [_Turn() for _ in passages]
        self._since = np.full(len(radii), np.inf)
        self._shapes = np.array([passage.shape for passage in passages])
        self._levels = np.array([passage.level for passage in passages], dtype=np.intp)
        shapely.prepare(self._shapes)
        self.held: BoolArray = np.zeros(len(radii), dtype=bool)
        """Who waits before a passage, shape (N,)."""
        self.places: FloatArray = np.zeros((len(radii), 2))
        """Where those who wait do so (x, z) [m], shape (N, 2)."""
        self.side_on: BoolArray = np.zeros(len(radii), dtype=bool)
        """Who is where it is too tight to go straight on, shape (N,)."""
        self.thin = radii.copy()
        """Radii of the bodies in the simulation [m], shape (N,)."""

    @property
    def paces(self) -> FloatArray:
        """How fast each may go over how fast it likes to, shape (N,)."""
        return np.where(self.side_on & ~self.held, self._sideways, 1.0)

    def advance(
        self, points: FloatArray, floors: Floors, targets: FloatArray, arrived: BoolArray, now: float
    ) -> list[int]:
        """Let people at points (N, 2) on their way to targets (N, 2) in, or wait; gives back for whom that changed."""
        before, places = self.held.copy(), self.places.copy()
        self.held[:], self.side_on[:], self.thin = False, False, self._radii.copy()
        if self._passages:
            gates, people = shapely.STRtree(shapely.points(points)).query(self._shapes, "dwithin", distance=HOLD)
            here = (floors.levels[people] == self._levels[gates]) & ~arrived[people]
            for gate in {*gates[here].tolist(), *(number for number, turn in enumerate(self._turns) if turn.going)}:
                self._admit(gate, people[here & (gates == gate)], points, floors, targets, now)
        self._since[~self.held] = np.inf
        return np.flatnonzero((self.held != before) | (self.places != places).any(axis=1)).tolist()

    def _admit(
        self, gate: int, near: IntArray, points: FloatArray, floors: Floors, targets: FloatArray, now: float
    ) -> None:
        """Bring those who go through one passage, near which some are, up to date."""
        passage, turn = self._passages[gate], self._turns[gate]
        gaps = shapely.distance(passage.shape, shapely.points(points[near]))
        tight = (self._radii[near] > passage.half_width) & (gaps <= TURNING)
        self.side_on[near[tight]] = True
        away = dict(zip(near.tolist(), gaps.tolist(), strict=True))
        mouths = {}
        for index, gap in away.items():
            way = floors.way(index, targets[index])
            if way.intersects(passage.shape):
                mouths[index] = _comes_from(passage, way)
        turn.going = [one for one in turn.going if away.get(one, np.inf) <= self._radii[one] or one in mouths]
        coming = np.array([index for index in mouths if index not in turn.going], dtype=np.intp)
        self._since[coming] = np.minimum(self._since[coming], now)
        waiting = sorted(coming.tolist(), key=lambda index: self._since[index])
        if not turn.going and waiting:
            inside = [index for index in waiting if away[index] <= 0.0]
            turn.first = (inside or waiting)[0]
            turn.mouth = mouths[turn.first]
        others = any(mouths[index] != turn.mouth for index in waiting)
        if not others or turn.first in turn.going or not turn.going:
            for index in sorted(waiting, key=lambda index: away[index]):
                clear = passage.half_width >= WEDGE * self._radii[index] or self._is_behind(index, turn, away, points)
                if mouths[index] == turn.mouth and clear:
                    turn.going.append(index)
        waiting = [index for index in waiting if index not in turn.going]
        turn.places = {index: place for index, place in turn.places.items() if index in waiting}
        for index in waiting:
            self._hold(index, passage.places[mouths[index]], turn, points, mouths)
        going = np.array(turn.going, dtype=np.intp)
        self.thin[going] = np.clip(passage.half_width - ELBOWS, THINNEST, self._radii[going])

    def _is_behind(self, index: int, turn: _Turn, away: dict[int, float], points: FloatArray) -> bool:
        """Whether one is behind all who go through, by the space there is between them."""
        gaps = np.linalg.norm(points[turn.going] - points[index], axis=1)
        before = np.array([away.get(one, 0.0) for one in turn.going])
        return bool(np.all((gaps >= SPACE) & ((before <= 0.0) | (away[index] - before >= SPACE))))

    def _hold(self, index: int, places: FloatArray, turn: _Turn, points: FloatArray, mouths: dict[int, int]) -> None:
        """Let one wait at the nearest of the places (P, 2) of its mouth that nobody has, or else where it is."""
        if index not in turn.places:
            taken = {place for one, place in turn.places.items() if mouths[one] == mouths[index]}
            free = [place for place in range(len(places)) if place not in taken]
            gaps = np.linalg.norm(places[free] - points[index], axis=1)
            turn.places[index] = free[int(np.argmin(gaps))] if free else -1
        own = turn.places[index]
        if own >= 0:
            self.places[index] = places[own]
        elif not self.held[index]:
            self.places[index] = points[index]
        self.held[index] = True

    def centred(self, points: FloatArray, levels: IntArray) -> FloatArray:
        """The points (N, 2) on levels (N,), those in passages off the walls as far as these allow."""
        moved = points.copy()
        for passage in self._passages:
            inside = (levels == passage.level) & shapely.contains_xy(passage.shape, points[:, 0], points[:, 1])
            if inside.any():
                moved[inside] = move_inside(passage.middle, points[inside])
        return moved


def _comes_from(passage: Passage, way: shapely.LineString) -> int:
    """The mouth from which a way comes that leads through a passage, or into it."""
    crossed = [way.intersects(mouth) for mouth in passage.mouths]
    if all(crossed):
        return int(np.argmin([shapely.line_locate_point(way, shapely.centroid(mouth)) for mouth in passage.mouths]))
    if not any(crossed):
        return int(np.argmin(shapely.distance(np.array(passage.mouths), shapely.Point(way.coords[0]))))
    inside = shapely.contains_xy(passage.shape, *way.coords[0])
    return int(np.argmin(crossed)) if inside else int(np.argmax(crossed))
