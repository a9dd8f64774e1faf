"""Cornering: who runs slows down before it turns, and speeds up again behind the corner (extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from usdfoot.analysis.gaits import RUNNING_FROUDE
from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.scenario import Seeker

__all__ = ["Corners"]

SWERVE = 1.8
"""A velocity changes by so much in a turn at most [m/s]: that of a walker round a right angle."""
BRAKE = 2.0
"""By so much who runs gets slower or quicker [m/s^2]."""
TOGETHER = 1.0
"""Corners so near each other [m] are one."""
EARLY = 0.5
"""So far before the corner it is as slow as it has to be [m]."""


class Corners:
    """How fast N people may go before the corners of their ways; those who walk as fast as they like.

    JuPedSim's people turn on the spot at any speed. Smoothed, that cuts corners, the wider the faster they go.

    Args:
        seekers: The people.
    """

    def __init__(self, seekers: Sequence[Seeker]) -> None:
        self._wanted = np.array([seeker.speed for seeker in seekers])
        fastest_walks = np.sqrt([RUNNING_FROUDE * EARTH_GRAVITY * seeker.body.leg_length for seeker in seekers])
        self._runners: IntArray = np.flatnonzero(self._wanted > fastest_walks)
        self._fastest = self._wanted[self._runners]

    def paces(self, points: FloatArray, ways: Sequence[FloatArray], *, elapsed: float) -> FloatArray:
        """How fast each may go over how fast it likes to, shape (N,).

        Args:
            points: Where they are (x, z) [m], shape (N, 2).
            ways: From where each was, corner by corner to where it goes [m], shape (C, 2) each.
            elapsed: Since they were asked last [s].
        """
        paces = np.ones(len(self._wanted))
        if self._runners.size:
            lines = [ways[index] for index in self._runners.tolist()]
            allowed = _corner_speeds(points[self._runners], lines)
            self._fastest = np.minimum(
                np.minimum(allowed, self._fastest + BRAKE * elapsed), self._wanted[self._runners]
            )
            paces[self._runners] = self._fastest / self._wanted[self._runners]
        return paces


def _corner_speeds(points: FloatArray, ways: Sequence[FloatArray]) -> FloatArray:
    """Fastest speeds [m/s] at points (M, 2) from which the corners ahead on their ways can be taken, shape (M,)."""
    counts = np.array([len(way) for way in ways])
    corners, owners = np.concatenate(ways), np.repeat(np.arange(len(ways)), counts)
    legs = np.diff(corners, axis=0)
    lengths = np.where(np.diff(owners) == 0, np.linalg.norm(legs, axis=1), 0.0)
    arcs = np.concatenate([[0.0], np.cumsum(lengths)])
    arcs -= np.repeat(arcs[np.cumsum(counts) - counts], counts)
    bends = np.flatnonzero((lengths[:-1] > 0.0) & (lengths[1:] > 0.0)) + 1
    cosines = np.sum(legs[bends - 1] * legs[bends], axis=1) / (lengths[bends - 1] * lengths[bends])
    turns = np.arccos(np.clip(cosines, -1.0, 1.0))
    beside = (np.diff(arcs[bends]) < TOGETHER) & (np.diff(owners[bends]) == 0)
    turns[1:] += np.where(beside, turns[:-1], 0.0)
    bends = np.concatenate([bends, np.cumsum(counts) - 1])  # at the end everybody stops, as fast as who turns back
    turns = np.concatenate([turns, np.full(len(ways), np.pi)])
    slow = 0.5 * SWERVE / np.maximum(np.sin(0.5 * np.minimum(turns, np.pi)), 1e-6)
    gone = shapely.line_locate_point(np.array([shapely.LineString(way) for way in ways]), shapely.points(points))
    left = arcs[bends] - gone[owners[bends]]
    speeds = np.full(len(ways), np.inf)
    ahead = left > 0.0
    np.minimum.at(
        speeds, owners[bends][ahead], np.sqrt(slow[ahead] ** 2 + 2.0 * BRAKE * np.maximum(left[ahead] - EARLY, 0.0))
    )
    return speeds
