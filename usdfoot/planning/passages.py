"""Passages: where two have no room beside each other, or one only sideways, so people go through one way at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.floors import Floors
from usdfoot.planning.walkable import move_inside

__all__ = ["Gates", "Passage", "find_passages"]

HOLD = 1.2
"""Who comes so near [m] goes in or waits."""
ASIDE = 0.75
"""Who waits does so at this distance from the mouth, and to the side of it [m]."""
SPACE = 1.0
"""Between those who go through one after the other [m]."""
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
    waiting: FloatArray
    """Where one waits at either mouth, to the left and to the right of it (x, z), not a number = nowhere, (2, 2, 2)."""
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
                middle = local.buffer(-0.95 * min(half, radius))
                found.append(
                    Passage(
                        level=number,
                        shape=part,
                        mouths=(mouths[0], mouths[1]),
                        waiting=_waiting(beside.buffer(-radius), mouths),
                        half_width=half,
                        middle=middle,
                    )
                )
    return found


def _waiting(room: shapely.Geometry, mouths: FloatArray) -> FloatArray:
    """Places in a room beside the ways out of two mouths, shape (2, 2, 2)."""
    ends = shapely.get_coordinates(shapely.centroid(mouths))
    out = ends - ends[::-1]
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    across = np.stack([out[:, 1], -out[:, 0]], axis=1)
    places = (ends + ASIDE * out)[:, None] + np.array([1.0, -1.0])[:, None] * ASIDE * across[:, None]
    free = shapely.contains_xy(room, places[..., 0], places[..., 1])
    return np.where(free[..., None], places, np.nan)


def _half_width(local: shapely.Geometry, mouths: FloatArray, most: float) -> float:
    """Radius of the largest disc that gets from one mouth to the other [m]."""
    low, high = 0.0, most
    for _ in range(HALVINGS):
        radius = 0.5 * (low + high)
        rooms = shapely.get_parts(local.buffer(-radius))
        joined = any(all(room.distance(mouth) <= radius for mouth in mouths) for room in rooms)
        low, high = (radius, high) if joined else (low, radius)
    return low


def _nearest(places: FloatArray, point: FloatArray) -> FloatArray:
    """The place (P, 2) nearest to a point, itself where there is none."""
    gaps = np.linalg.norm(places - point, axis=1)
    return point if np.isnan(gaps).all() else places[int(np.nanargmin(gaps))]


class Gates:
    """Who goes through which passage, who waits, and who goes sideways, of N people.

    Args:
        passages: Of all levels.
        radii: Of the bodies [m], shape (N,).
        speeds: At which they like to walk [m/s], shape (N,).
        legs: Their length [m], shape (N,).
    """

    def __init__(self, passages: list[Passage], *, radii: FloatArray, speeds: FloatArray, legs: FloatArray) -> None:
        self._passages, self._radii = passages, radii
        self._sideways = np.minimum(SIDE_SPEED * np.sqrt(legs / 0.86) / speeds, 1.0)
        self._passing: list[dict[int, int]] = [{} for _ in passages]
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
        before = self.held.copy()
        self.held[:], self.side_on[:], self.thin = False, False, self._radii.copy()
        if self._passages:
            gates, people = shapely.STRtree(shapely.points(points)).query(self._shapes, "dwithin", distance=HOLD)
            here = (floors.levels[people] == self._levels[gates]) & ~arrived[people]
            for gate in {*gates[here].tolist(), *(number for number, one in enumerate(self._passing) if one)}:
                self._admit(gate, people[here & (gates == gate)], points, floors, targets, now)
        self._since[~self.held] = np.inf
        return np.flatnonzero(self.held != before).tolist()

    def _admit(
        self, gate: int, near: IntArray, points: FloatArray, floors: Floors, targets: FloatArray, now: float
    ) -> None:
        """Bring those who go through one passage, near which some are, up to date."""
        passage, passing = self._passages[gate], self._passing[gate]
        away = dict(zip(near.tolist(), shapely.distance(passage.shape, shapely.points(points[near])), strict=True))
        if passage.half_width < self._radii.max():
            tight = near[(self._radii[near] > passage.half_width) & (np.array([*away.values()]) <= TURNING)]
            self.side_on[tight] = True
        coming = [
            index
            for index, gap in away.items()
            if gap > 0.0 and floors.way(index, targets[index]).intersects(passage.shape)
        ]
        for index in [*passing]:
            if away.get(index, np.inf) > 2.0 * self._radii[index] and index not in coming:
                del passing[index]
        for index in [index for index, gap in away.items() if gap <= 0.0]:
            passing.setdefault(index, self._mouth(passage, points[index]))
        self._since[coming] = np.minimum(self._since[coming], now)
        waiting = sorted((index for index in coming if index not in passing), key=lambda index: self._since[index])
        mouths = {index: self._mouth(passage, points[index]) for index in waiting}
        for index in waiting:
            mouth, others = mouths[index], [*passing]
            follows = all(one == mouth for one in (*mouths.values(), *passing.values()))
            if not others or (follows and np.linalg.norm(points[others] - points[index], axis=1).min() >= SPACE):
                passing[index] = mouth
            elif not self.held[index]:
                self.held[index] = True
                self.places[index] = _nearest(passage.waiting[mouth], points[index])
        going = np.array([*passing], dtype=np.intp)
        self.thin[going] = np.clip(passage.half_width - ELBOWS, THINNEST, self._radii[going])

    def _mouth(self, passage: Passage, point: FloatArray) -> int:
        """The mouth that is nearer to a point (2,)."""
        return int(np.argmin(shapely.distance(np.array(passage.mouths), shapely.Point(point))))

    def centred(self, points: FloatArray, levels: IntArray) -> FloatArray:
        """The points (N, 2) on levels (N,), those in passages off the walls as far as these allow."""
        moved = points.copy()
        for passage in self._passages:
            inside = (levels == passage.level) & shapely.contains_xy(passage.shape, points[:, 0], points[:, 1])
            if inside.any():
                moved[inside] = move_inside(passage.middle, points[inside])
        return moved
