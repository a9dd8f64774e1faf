"""Passages: where it is narrow people keep right, shoulders turned, or go through one way at a time, or sideways."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import shapely

from usdfoot.analysis.timing import HUMAN_LEG
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
NARROW, ABREAST, WEDGE = 3.0, 1.9, 1.5
"""A passage is less than so many bodies wide; two get past each other in this many; in fewer two wedge side by side."""
SPACE = 0.7
"""Between those who go in one after the other where two have no room [m]."""
AHEAD = 1.0
"""Who keeps right looks so far ahead [m]."""
BESIDE = 1.6
"""Whoever comes so near [m] the other way is a reason to turn the shoulders."""
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
    lanes: bool
    """Whether two get past each other, shoulders turned."""
    lane: shapely.Geometry
    """In the lanes of both sides, and between them."""
    middle: shapely.Geometry
    """Where the middle of a body is that keeps off the walls."""


def find_passages(levels: tuple[shapely.Polygon, ...], radius: float) -> list[Passage]:
    """Parts of levels in which three bodies of a radius [m] have no room abreast, from one mouth to another."""
    found = []
    for number, level in enumerate(levels):
        narrow = NARROW * radius + ELBOWS
        wide = level.buffer(-narrow).buffer(1.001 * narrow, join_style="mitre")
        for part in shapely.get_parts(level.difference(wide)):
            if part.geom_type != "Polygon" or part.area <= radius**2 / 4.0:
                continue
            x0, z0, x1, z1 = part.bounds
            around = x0 - 4.0 * narrow, z0 - 4.0 * narrow, x1 + 4.0 * narrow, z1 + 4.0 * narrow
            mouths = shapely.get_parts(part.buffer(NEAR_MOUTH).intersection(shapely.clip_by_rect(wide, *around)))
            if len(mouths) == 2:
                beside = shapely.clip_by_rect(level, *around)
                local = beside.intersection(part.buffer(2.0 * narrow))
                half = _half_width(local, mouths, narrow)
                found.append(
                    Passage(
                        level=number,
                        shape=part,
                        mouths=(mouths[0], mouths[1]),
                        places=_waiting_places(level, mouths, radius),
                        half_width=half,
                        lanes=half >= ABREAST * radius,
                        lane=local.buffer(-0.5 * half),
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
        joined = any(all(room.intersects(mouth) for mouth in mouths) for room in rooms)
        low, high = (radius, high) if joined else (low, radius)
    return low


@dataclass(kw_only=True)
class _Turn:
    """Whose turn it is at a passage, and who is near it."""

    mouth: int = 0
    """From which people come through now."""
    first: int = -1
    """Who began the turn."""
    going: list[int] = field(default_factory=list)
    """Who goes through."""
    places: dict[int, int] = field(default_factory=dict)
    """Which place of its mouth each who waits has, -1 = none."""
    away: dict[int, float] = field(default_factory=dict)
    """How far those near are from the passage [m]."""
    mouths: dict[int, int] = field(default_factory=dict)
    """From which mouth those come who are on their way through."""


class Gates:
    """Who goes through which passage, who waits, who keeps right and who turns its shoulders, of N people.

    Where two get past each other, those who meet others go one after the other along the right side. Elsewhere people
    come through from one mouth until the first of them is out. Then it is the other's turn, if anybody waits there.
    Who waits does so beside the way out, or where it is while nobody comes the other way.

    Args:
        passages: Of all levels.
        radii: Of the bodies [m], shape (N,).
        speeds: At which they like to walk [m/s], shape (N,).
        legs: Their length [m], shape (N,).
    """

    def __init__(self, passages: list[Passage], *, radii: FloatArray, speeds: FloatArray, legs: FloatArray) -> None:
        self._passages, self._radii = passages, radii
        self._sideways = np.minimum(SIDE_SPEED * np.sqrt(legs / HUMAN_LEG) / speeds, 1.0)
        self._turns = [_Turn() for _ in passages]
        self._since = np.full(len(radii), np.inf)
        self._shapes = np.array([passage.shape for passage in passages])
        self._levels = np.array([passage.level for passage in passages], dtype=np.intp)
        shapely.prepare(self._shapes)
        self.held: BoolArray = np.zeros(len(radii), dtype=bool)
        """Who waits before a passage, shape (N,)."""
        self.led: BoolArray = np.zeros(len(radii), dtype=bool)
        """Who keeps right in one, shape (N,)."""
        self.places: FloatArray = np.zeros((len(radii), 2))
        """Where those who wait or keep right are sent (x, z) [m], shape (N, 2)."""
        self.turned: FloatArray = np.zeros(len(radii))
        """How far each has to turn its shoulders: 0 = not, 1 = sideways, shape (N,)."""
        self.thin = radii.copy()
        """Radii of the bodies in the simulation [m], shape (N,)."""

    def paces(self, turned: FloatArray) -> FloatArray:
        """How fast each of those who have turned so far (N,), 1 = sideways, may go over how fast it likes to, (N,)."""
        return np.where(self.held, 1.0, 1.0 - turned * (1.0 - self._sideways))

    def advance(
        self, points: FloatArray, floors: Floors, *, targets: FloatArray, arrived: BoolArray, now: float
    ) -> list[int]:
        """Let people at points (N, 2) on their way to targets (N, 2) in, or wait; gives back for whom that changed."""
        before = self.held | self.led
        self.held[:], self.led[:], self.turned[:], self.thin = False, False, 0.0, self._radii.copy()
        if self._passages:
            gates, people = shapely.STRtree(shapely.points(points)).query(self._shapes, "dwithin", distance=HOLD)
            here = (floors.levels[people] == self._levels[gates]) & ~arrived[people]
            for gate in {*gates[here].tolist(), *(number for number, turn in enumerate(self._turns) if turn.going)}:
                self._admit(gate, people[here & (gates == gate)], points, floors, targets, now)
        self._since[~self.held] = np.inf
        return np.flatnonzero(before | self.held | self.led).tolist()

    def _admit(
        self, gate: int, near: IntArray, points: FloatArray, floors: Floors, targets: FloatArray, now: float
    ) -> None:
        """Bring those who go through one passage, near which some are, up to date."""
        passage, turn = self._passages[gate], self._turns[gate]
        gaps = shapely.distance(passage.shape, shapely.points(points[near]))
        self.turned[near[(self._radii[near] > passage.half_width) & (gaps <= TURNING)]] = 1.0
        turn.away = dict(zip(near.tolist(), gaps.tolist(), strict=True))
        ways = {index: floors.way(index, targets[index]) for index in turn.away}
        ways = {index: way for index, way in ways.items() if way.intersects(passage.shape)}
        turn.mouths = {index: _comes_from(passage, way) for index, way in ways.items()}
        turn.going = [one for one in turn.going if one in ways or turn.away.get(one, np.inf) <= self._radii[one]]
        single = self._is_single(passage, turn)
        turn.going = _unwedged(turn) if single else turn.going
        coming = [index for index in ways if index not in turn.going]
        self._since[coming] = np.minimum(self._since[coming], now)
        self._let_in(passage, turn, sorted(coming, key=lambda index: self._since[index]), points, single=single)
        turn.places = {index: place for index, place in turn.places.items() if index not in turn.going}
        meet = len(set(turn.mouths.values())) > 1
        for index in coming:
            if index not in turn.going:
                self._hold(index, passage, turn, points, aside=meet)
        going = np.array(turn.going, dtype=np.intp)
        if passage.lanes and meet:
            self._keep_right(passage, turn, ways, points)
        else:
            self.thin[going] = np.clip(passage.half_width - ELBOWS, THINNEST, self._radii[going])

    def _is_single(self, passage: Passage, turn: _Turn) -> bool:
        """Whether people go in one after the other."""
        meet = len(set(turn.mouths.values())) > 1
        return bool(passage.half_width < WEDGE * self._radii.max() or (passage.lanes and meet))

    def _let_in(self, passage: Passage, turn: _Turn, waiting: list[int], points: FloatArray, *, single: bool) -> None:
        """Have those who wait, the longest first, go through whose turn it is, where they have room behind others."""
        meet = len(set(turn.mouths.values())) > 1
        begins = not turn.going
        if begins and waiting:
            inside = [index for index in waiting if turn.away[index] <= 0.0]
            turn.mouth = turn.mouths[(inside or waiting)[0]]
        if meet and not passage.lanes and turn.going and turn.first not in turn.going:
            turn.going = [one for one in turn.going if turn.away.get(one, 0.0) <= SPACE]
            return
        for index in sorted(waiting, key=lambda index: turn.away[index]):
            mouth = turn.mouths[index]
            if mouth == turn.mouth or passage.lanes:
                before = [one for one in turn.going if turn.mouths.get(one, turn.mouth) == mouth]
                gaps = np.linalg.norm(points[before] - points[index], axis=1)
                ahead = np.array([turn.away.get(one, 0.0) for one in before])
                room = (gaps >= SPACE) & ((ahead <= 0.0) | (turn.away[index] - ahead >= SPACE))
                if not single or np.all(room | (ahead > turn.away[index])):
                    turn.going.append(index)
        if begins:
            turn.first = next((one for one in waiting if one in turn.going), -1)

    def _hold(self, index: int, passage: Passage, turn: _Turn, points: FloatArray, *, aside: bool) -> None:
        """Let one wait aside, at the nearest of the places of its mouth that nobody has, or else where it is."""
        mouth = turn.mouths[index]
        places = passage.places[mouth]
        if not aside:
            turn.places[index] = -1
        elif turn.places.get(index, -1) < 0:
            taken = {place for one, place in turn.places.items() if turn.mouths.get(one) == mouth}
            free = [place for place in range(len(places)) if place not in taken]
            gaps = np.linalg.norm(places[free] - points[index], axis=1)
            turn.places[index] = free[int(np.argmin(gaps))] if free else -1
        self.places[index] = places[turn.places[index]] if turn.places[index] >= 0 else points[index]
        self.held[index] = True

    def _keep_right(
        self, passage: Passage, turn: _Turn, ways: dict[int, shapely.LineString], points: FloatArray
    ) -> None:
        """Send those who go through along the right side, shoulders turned as far as they have to be beside others.

        Seen along the way a body of radius r, half as deep as broad and turned by t, is r sqrt(1 - 3/4 sin(t)^2) wide.
        """
        people = np.array([one for one in turn.going if one in ways], dtype=np.intp)
        ahead = shapely.get_coordinates([shapely.line_interpolate_point(ways[one], AHEAD) for one in people.tolist()])
        along = (ahead - points[people]) / np.maximum(np.linalg.norm(ahead - points[people], axis=1), 1e-9)[:, None]
        right = passage.half_width * np.stack([-along[:, 1], along[:, 0]], axis=1)
        self.places[people], self.led[people] = move_inside(passage.lane, ahead + right), True
        self.thin[people] = np.clip(0.5 * (passage.half_width - ELBOWS), THINNEST, self._radii[people])
        sides = np.array([turn.mouths[one] for one in people.tolist()])
        gaps = np.linalg.norm(points[people][:, None] - points[people], axis=2)
        meets = np.any((gaps <= BESIDE) & (sides[:, None] != sides), axis=1)
        width = np.clip(self.thin[people] / self._radii[people], 0.5, 1.0)
        self.turned[people] = np.where(meets, np.arcsin(np.sqrt((1.0 - width**2) / 0.75)) / (0.5 * np.pi), 0.0)

    def centred(self, points: FloatArray, levels: IntArray) -> FloatArray:
        """The points (N, 2) on levels (N,), those in passages off the walls as far as these allow."""
        moved = points.copy()
        for passage in self._passages:
            inside = (levels == passage.level) & shapely.contains_xy(passage.shape, points[:, 0], points[:, 1])
            if inside.any():
                moved[inside] = move_inside(passage.middle, points[inside])
        return moved


def _unwedged(turn: _Turn) -> list[int]:
    """Those who go through, without those who are as near to a mouth as the one before them, who would wedge there."""
    outside = [one for one in turn.going if one in turn.mouths and turn.away[one] > 0.0]
    outside.sort(key=lambda one: (turn.mouths[one], turn.away[one]))
    wedged = {
        other
        for one, other in pairwise(outside)
        if turn.mouths[one] == turn.mouths[other] and turn.away[other] - turn.away[one] < 0.5 * SPACE
    }
    return [one for one in turn.going if one not in wedged]


def _comes_from(passage: Passage, way: shapely.LineString) -> int:
    """The mouth from which a way comes that leads through a passage, or into it."""
    crossed = [way.intersects(mouth) for mouth in passage.mouths]
    if all(crossed):
        return int(np.argmin([shapely.line_locate_point(way, shapely.centroid(mouth)) for mouth in passage.mouths]))
    if not any(crossed):
        return int(np.argmin(shapely.distance(np.array(passage.mouths), shapely.Point(way.coords[0]))))
    inside = shapely.contains_xy(passage.shape, *way.coords[0])
    return int(np.argmin(crossed)) if inside else int(np.argmax(crossed))
