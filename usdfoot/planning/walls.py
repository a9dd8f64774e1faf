"""Walls: roots, soles and bodies of simulated people that are in a wall are moved out of it (extra `crowd`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.walkable import Area, move_inside

__all__ = ["Walls"]

ROUNDS = 4
"""How often a foot is moved off the walls that its heel and toe are in, and a body off those it is led through."""
BODY = 0.02
"""From a wall to the middle of a body that is led past it, at least [m]."""
WAY = np.linspace(0.0, 1.0, 5)[:, None, None]
"""Places of the body in a step, over the way between those at its ends."""


class Walls:
    """The walls round an area of one level; on several, where it is not said which wall is on which, there are none.

    Args:
        area: Where people may be.
    """

    def __init__(self, area: Area) -> None:
        self._level = area.levels[0] if len(area.levels) == 1 else None
        self._rooms: dict[float, shapely.Geometry] = {}

    def keep_off(self, points: FloatArray, *, distance: float) -> FloatArray:
        """Points (K, 2), those nearer to a wall than a distance [m] moved to where they are not."""
        if self._level is None:
            return points
        if distance not in self._rooms:
            self._rooms[distance] = self._level.buffer(-distance)
        return move_inside(self._rooms[distance], points)

    def keep_feet_off(self, feet: FootTable, rows: IntArray) -> FootTable:
        """The table with feet moved until no sole of rows (K,) is in a wall, and no body of a step from or to them.

        Or as far out as they come.
        """
        if self._level is None or not rows.size:
            return feet
        steps = np.unique(np.concatenate([rows, rows + 1, rows + 2]))
        steps = steps[steps < len(feet.owners)]
        steps = steps[(feet.numbers[steps] > 1)]
        feet, led = self._bodies_off(feet, steps)
        return self._soles_off(feet, np.union1d(rows, led))

    def _bodies_off(self, feet: FootTable, steps: IntArray) -> tuple[FootTable, IntArray]:
        """The table with the feet of steps (K,) moved that lead the body, midway between them, through a wall; which.

        The three feet of such a step are moved by as much as the body has to.
        """
        points, moved = feet.positions[:, [0, 2]], np.zeros(len(feet.owners), dtype=bool)
        for _ in range(ROUNDS):
            began, ended = (0.5 * (points[steps - 1] + points[steps - back]) for back in (2, 0))
            ways = began + WAY * (ended - began)  # (5, K, 2)
            outs = self.keep_off(ways.reshape(-1, 2), distance=BODY).reshape(ways.shape) - ways
            worst = np.argmax(np.linalg.norm(outs, axis=2), axis=0)
            push = outs[worst, np.arange(len(steps))]
            led = np.flatnonzero(np.any(push != 0.0, axis=1))
            if not led.size:
                break
            sums, counts = np.zeros_like(points), np.zeros(len(points))
            for back in range(3):
                np.add.at(sums, steps[led] - back, push[led])
                np.add.at(counts, steps[led] - back, 1.0)
            points = points + sums / np.maximum(counts, 1.0)[:, None]
            moved |= counts > 0.0
        return _placed(feet, points), np.flatnonzero(moved)

    def _soles_off(self, feet: FootTable, rows: IntArray) -> FootTable:
        """The table with feet (K,) moved until their soles are in no wall, or as far out as they come."""
        points, forward = feet.positions[rows][:, [0, 2]], planar.direction(feet.yaws[rows])
        width = feet.half_widths[rows]
        heels, toes = width - feet.heels[rows], feet.toes[rows] - width
        reaches = np.stack([heels, 0.5 * heels, np.zeros(len(rows)), toes])
        for _ in range(ROUNDS):
            soles = points + reaches[..., None] * forward  # (4, K, 2)
            inside = self.keep_off(soles.reshape(-1, 2), distance=float(feet.half_widths.max())).reshape(soles.shape)
            out = inside - soles
            count = np.any(out != 0.0, axis=2).sum(axis=0)
            if not count.any():
                break
            points = points + out.sum(axis=0) / np.maximum(count, 1)[:, None]
        placed = feet.positions[:, [0, 2]]
        placed[rows] = points
        return _placed(feet, placed)


def _placed(feet: FootTable, points: FloatArray) -> FootTable:
    positions = feet.positions.copy()
    positions[:, [0, 2]] = points
    return replace(feet, positions=positions)
