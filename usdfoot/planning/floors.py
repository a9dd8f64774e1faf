"""Floors: a JuPedSim simulation for each level, in lockstep; who is where two join is in both (extra `crowd`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import jupedsim
import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.gaps import without_gaps
from usdfoot.planning.places import Party
from usdfoot.planning.scenario import Seeker
from usdfoot.planning.world import Obstacle, is_beside

__all__ = ["TIME_STEP", "Floors"]

TIME_STEP = 0.05
"""Of the simulations [s]."""
TIME_GAP = 0.5
"""In which people let nobody into the space ahead [s]."""
SAME = 0.3
"""A level as near above another [m] is the same ground."""
ASTRAY = 0.5
"""Who is so far [m] from where it is on its own level is taken off the other."""
AHEAD = 4.0
"""People are sent to corners of their ways that are at least so far away [m]."""
SLIP = 0.06
"""Radius with which somebody slips back between wall and crowd [m]."""
ROUND = 0.3
"""Where they go round what rests, to corners at least so far away [m]."""
OUTSIDE = 1.0 / np.cos(np.pi / 8.0)
"""Radius of an octagon around a circle over the circle's."""
NEAR = 0.6
"""Who is so near [m] to the ways round what rests goes there first."""
HAIR = 1e-3
"""Who is so near [m] to the ways round what rests is on them."""
PACE = 0.03
"""Changes of speed smaller than this part of it are left out."""


class Floors:
    """N people on the levels of an area.

    JuPedSim knows no heights. So each level is simulated for itself; on the apron that two levels have in common
    everyone is on both, as its own self on one and as a shadow of itself on the other, so that those behind and those
    who come the other way see it.

    Args:
        party: The people and where they start.
    """

    def __init__(self, party: Party) -> None:
        self._area, self._seekers = party.area, party.seekers
        self.rooms = tuple(without_gaps(level, party.narrowest) for level in party.area.levels)
        """What of each level is wide enough: JuPedSim sends anybody through the smallest gap, shape (L,)."""
        self._floors = [_Floor(room) for room in self.rooms]
        self.levels: IntArray = party.starts.copy()
        """Level each is on, shape (N,)."""
        self._ids = [
            self._floors[level].enter(seeker, seeker.start[[0, 2]])
            for seeker, level in zip(party.seekers, self.levels, strict=True)
        ]
        self._shadows: dict[int, tuple[int, int]] = {}
        self._points = np.array([seeker.start[[0, 2]] for seeker in party.seekers])
        self.aims: FloatArray = self._points.copy()
        """Corner of its way each is sent to, or its target (x, z) [m], shape (N, 2)."""
        self.ways: list[FloatArray] = [np.stack([point, point]) for point in self._points]
        """Of each, from where it was sent there last, corner by corner to its target (x, z) [m], shape (C, 2)."""
        self._paces = np.ones(len(party.seekers))
        self._radii = np.array([seeker.radius for seeker in party.seekers])

    def iterate(self, count: int) -> FloatArray:
        """Where everyone is (x, z) after so many time steps [m], shape (N, 2)."""
        for level, floor in enumerate(self._floors):
            try:
                floor.simulation.iterate(count)
            except RuntimeError:  # in the thick of a crowd JuPedSim pushes people through walls, and then stops
                self._put_back(level)
                floor.simulation.iterate(count)
        ids = zip(self.levels.tolist(), self._ids, strict=True)
        self._points = np.array([self._floors[level].agent(identity).position for level, identity in ids])
        return self._points

    def steer(self, people: Iterable[int], targets: FloatArray) -> None:
        """Send people to their targets (N, 2) on the levels they are on."""
        for index in people:
            floor = self._floors[self.levels[index]]
            self.ways[index] = floor.corners(self._points[index], targets[index])
            self.aims[index] = floor.aim(self._points[index], self.ways[index])
            floor.agent(self._ids[index]).target = tuple(self.aims[index].tolist())

    def way(self, index: int, target: FloatArray, *, start: FloatArray | None = None) -> shapely.LineString:
        """The way of one from where it is, or a start (2,), to a target (2,) on its level."""
        start = self._points[index] if start is None else start
        return shapely.LineString(self._floors[self.levels[index]].corners(start, target))

    def has_room(self, index: int, places: FloatArray) -> BoolArray:
        """Whether one can go straight to places (P, 2) of its level, and its body has room there, shape (P,)."""
        floor = self._floors[self.levels[index]]
        here = np.broadcast_to(self._points[index], places.shape)
        return floor.has_room(places, self._seekers[index].radius) & floor.is_straight(here, places)

    def go_round(self, obstacles: Sequence[Obstacle], distance: float) -> None:
        """Send people round obstacles that rest, at a distance [m], where there is a way."""
        for number, floor in enumerate(self._floors):
            middles = np.array([obstacle.outline.mean(axis=0) for obstacle in obstacles]).reshape(-1, 2)
            heights = self._area.height_at(np.full(len(middles), number), middles)
            here = [
                obstacle
                for obstacle, height in zip(obstacles, heights, strict=True)
                if np.isnan(height) or is_beside(obstacle, height)
            ]
            floor.go_round(here, distance)

    @property
    def goes_round(self) -> bool:
        """Whether anything is gone round."""
        return any(floor.goes_round for floor in self._floors)

    def slim(self, radii: FloatArray) -> None:
        """Make bodies as wide as radii (N,) [m] say."""
        for index in np.flatnonzero(radii != self._radii).tolist():
            self._floors[self.levels[index]].agent(self._ids[index]).model.radius = float(radii[index])
        self._radii = radii.copy()

    def pace(self, paces: FloatArray) -> None:
        """Let everyone go as much slower than it likes as paces (N,) say."""
        for index in np.flatnonzero(np.abs(paces - self._paces) > PACE).tolist():
            self._paces[index] = paces[index]
            own = self._floors[self.levels[index]].agent(self._ids[index])
            own.model.desired_speed = paces[index] * self._seekers[index].speed

    def go_over(self, next_levels: IntArray) -> BoolArray:
        """Take those who are where their next level (N,) begins over to it, -1 = none; gives back who went."""
        over = np.zeros(len(next_levels), dtype=bool)
        if not self._shadows and np.all(next_levels < 0):
            return over
        heights = self._area.height_at(self.levels, self._points)
        for index in np.flatnonzero(next_levels >= 0).tolist():
            level = int(next_levels[index])
            if self._has(level, index, heights[index]):
                over[index] = self._enter(index, level)
        for index, (level, shadow) in list(self._shadows.items()):
            place, floor = self._points[index], self._floors[level]
            apart = np.linalg.norm(np.array(floor.agent(shadow).position) - place)
            if apart > ASTRAY or not self._has(level, index, heights[index]):
                floor.leave(shadow)
                del self._shadows[index]
            elif floor.covers(place):
                floor.agent(shadow).target = tuple(place.tolist())
        return over

    def _put_back(self, level: int) -> None:
        """Bring those on a level who are outside it back to where it is nearest."""
        floor = self._floors[level]
        for index in np.flatnonzero(self.levels == level).tolist():
            place = np.array(floor.agent(self._ids[index]).position)
            if not floor.covers(place):
                before = self._ids[index]
                self._ids[index] = floor.enter(self._seekers[index], place, radius=SLIP)
                own = floor.agent(self._ids[index])
                own.target = floor.agent(before).target
                own.model.radius = float(self._radii[index])
                own.model.desired_speed = self._paces[index] * self._seekers[index].speed
                floor.leave(before)

    def _has(self, level: int, index: int, height: float) -> bool:
        """Whether the ground one is on at a height [m] belongs to a level."""
        own = self._area.height_at(np.array([level]), self._points[index : index + 1])[0]
        return bool(abs(own - height) <= SAME)

    def _enter(self, index: int, level: int) -> bool:
        """Whether one has gone over to a level; its self on the level it was on becomes a shadow."""
        before = int(self.levels[index]), self._ids[index]
        shadow = self._shadows.pop(index, None)
        if shadow is not None and shadow[0] == level:
            identity = shadow[1]
        else:
            if shadow is not None:
                self._floors[shadow[0]].leave(shadow[1])
            try:
                identity = self._floors[level].enter(self._seekers[index], self._points[index])
            except RuntimeError:  # somebody stands there; again in a moment
                return False
        self._shadows[index] = before
        self.levels[index], self._ids[index], self._paces[index] = level, identity, 1.0
        self._radii[index] = self._seekers[index].radius
        return True


class _Floor:
    """The simulation of one level."""

    def __init__(self, level: shapely.Polygon) -> None:
        model = jupedsim.CollisionFreeSpeedModelV2()
        self.simulation = jupedsim.Simulation(model=model, geometry=level, dt=TIME_STEP)
        self.agent = self.simulation.agent
        self._level, self._rooms = level, dict[float, shapely.Geometry]()
        self._steering = self.simulation.add_direct_steering_stage()
        self._journey = self.simulation.add_journey(jupedsim.JourneyDescription([self._steering]))
        self._inside = level.buffer(-0.05)
        shapely.prepare(self._inside)
        self._routing = jupedsim.RoutingEngine(level)
        self._ways_round: list[tuple[shapely.Polygon, jupedsim.RoutingEngine]] = []

    @property
    def goes_round(self) -> bool:
        """Whether anything is gone round."""
        return bool(self._ways_round)

    def go_round(self, obstacles: Sequence[Obstacle], distance: float) -> None:
        """Find ways round obstacles, at a distance [m] from them and their margins."""
        shapes = [
            shapely.Polygon(one.outline).buffer(OUTSIDE * (one.margin + distance), quad_segs=2) for one in obstacles
        ]
        shapes = [shape for shape in shapes if shape.intersects(self._level)]
        free = shapely.get_parts(self._level.difference(shapely.union_all(shapes))) if shapes else ()
        self._ways_round = [(part, jupedsim.RoutingEngine(part)) for part in free]

    def aim(self, place: FloatArray, corners: FloatArray) -> FloatArray:
        """The first of the corners (C, 2) of the way from a place (2,) at least `AHEAD` away, or the last.

        JuPedSim looks for the way of everybody in every time step; to a corner it is short. Round corners it is sent no
        farther than `AHEAD` beyond the last of them: it might know another way to what is farther.
        """
        least = ROUND if self.goes_round else AHEAD
        far = np.flatnonzero(np.linalg.norm(corners - place, axis=1) >= least)
        if not far.size or far[0] < 2:
            return corners[far[0]] if far.size else corners[-1]
        before, after = corners[far[0] - 1], corners[far[0]]
        return before + min(1.0, AHEAD / float(np.linalg.norm(after - before))) * (after - before)

    def corners(self, place: FloatArray, target: FloatArray) -> FloatArray:
        """The way from a place to a target (2,), round what rests if there is one, shape (C, 2)."""
        for part, routing in self._ways_round:
            on_it = shapely.get_coordinates(shapely.shortest_line(part, shapely.points([place, target])))[::2]
            away, left = np.linalg.norm(on_it - (place, target), axis=1)
            if away <= NEAR and left <= HAIR:
                try:
                    round_it = np.array(routing.compute_waypoints(tuple(on_it[0].tolist()), tuple(target.tolist())))
                except RuntimeError:  # on its edge, by a hair
                    continue
                return round_it if away <= HAIR else np.concatenate([place[None], round_it])
        try:
            return np.array(self._routing.compute_waypoints(tuple(place.tolist()), tuple(target.tolist())))
        except RuntimeError:  # one of them is in a wall, by a hair
            return np.stack([place, target])

    def enter(self, seeker: Seeker, place: FloatArray, *, radius: float | None = None) -> int:
        """Put somebody at a place (2,), or as near to it as the walls let it stand; gives back its number here.

        Args:
            seeker: Who.
            place: (x, z) [m], shape (2,).
            radius: Of its body at first [m]; None = its own.

        Raises:
            RuntimeError: If somebody stands there.
        """
        room = self._room(radius or seeker.radius)
        if not (shapely.contains_xy(room, *place) or room.is_empty):
            place = shapely.get_coordinates(shapely.shortest_line(room, shapely.Point(place)))[0]
        return self.simulation.add_agent(
            jupedsim.CollisionFreeSpeedModelV2AgentParameters(
                position=tuple(place.tolist()),
                journey_id=self._journey,
                stage_id=self._steering,
                radius=radius or seeker.radius,
                desired_speed=seeker.speed,
                time_gap=TIME_GAP,
            )
        )

    def has_room(self, places: FloatArray, radius: float) -> BoolArray:
        """Whether a body of a radius [m] has room at places (P, 2), shape (P,)."""
        return np.asarray(shapely.contains_xy(self._room(radius), places[:, 0], places[:, 1]))

    def is_straight(self, here: FloatArray, places: FloatArray) -> BoolArray:
        """Whether nothing is between points (P, 2) and places (P, 2), shape (P,)."""
        return np.asarray(shapely.covers(self._level, shapely.linestrings(np.stack([here, places], axis=1))))

    def _room(self, radius: float) -> shapely.Geometry:
        """Where the middle of a body of a radius [m] can be."""
        if radius not in self._rooms:
            self._rooms[radius] = self._level.buffer(-radius - 1e-4)
            shapely.prepare(self._rooms[radius])
        return self._rooms[radius]

    def leave(self, identity: int) -> None:
        """Take somebody off."""
        self.simulation.mark_agent_for_removal(identity)

    def covers(self, place: FloatArray) -> bool:
        """Whether a place (2,) can be walked to."""
        return bool(shapely.contains_xy(self._inside, *place))
