"""Moving obstacles: those that are animated, where they are at any time."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import UsdfootError
from usdfoot.planning.moving import Moving, with_velocity
from usdfoot.planning.world import Obstacle
from usdfoot.readers.obstacles import obstacle_prims, obstacles_of
from usdfoot.readers.skeleton import is_moving
from usdfoot.readers.stage import StagePrims
from usdfoot.readers.transform_codes import transform_codes

__all__ = ["MovingObstacles"]

SPACING = 0.05
"""Between the times at which they are read [s]."""
AHEAD = 20
"""Their velocity is that to where they are so many times later: as far ahead as one looks who walks."""


class MovingObstacles:
    """The animated obstacles of a stage, each time of them read once.

    Args:
        prims: Of the stage.
        units: Its units.
    """

    def __init__(self, prims: StagePrims, units: StageUnits) -> None:
        self._moving, self._units = [prim for prim in obstacle_prims(prims) if _is_animated(prim)], units
        self._names = {str(prim.GetPath()) for prim in self._moving}
        self._read: dict[int, dict[str, list[Obstacle]]] = {}
        self._said: dict[int, tuple[Obstacle, ...]] = {}

    def __bool__(self) -> bool:
        return bool(self._moving)

    def others(self, obstacles: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
        """Those of the obstacles that are not animated."""
        return tuple(obstacle for obstacle in obstacles if obstacle.name not in self._names)

    def after(self, start: float) -> Moving | None:
        """They at times from a start [s] on, None if there are none."""
        if not self._moving:
            return None
        last = max((code for prim in self._moving for code in _codes(prim)), default=0.0)
        end = max(last / self._units.time_codes_per_second - start, 0.0)
        return Moving(at=lambda time: self.at(start + time), end=end)

    def at(self, time: float) -> tuple[Obstacle, ...]:
        """The animated ones where they are at a time of the stage [s], to a fortieth of a second, as they go on there.

        One that cannot be read there is in nobody's way then. Times of which the same is said get the same tuple.
        """
        number = round(time / SPACING)
        if number not in self._said:
            now, later = self._all(number), self._all(number + AHEAD)
            self._said[number] = tuple(
                obstacle
                for name, obstacles in now.items()
                for obstacle in with_velocity(obstacles, later.get(name, obstacles), seconds=SPACING * AHEAD)
            )
        return self._said[number]

    def _all(self, number: int) -> dict[str, list[Obstacle]]:
        if number not in self._read:
            code = Usd.TimeCode(number * SPACING * self._units.time_codes_per_second)
            self._read[number] = {}
            for prim in self._moving:
                try:
                    self._read[number][str(prim.GetPath())] = obstacles_of(prim, self._units, code)
                except UsdfootError:
                    continue
        return self._read[number]


def _codes(prim: Usd.Prim) -> list[float]:
    """Time codes at which its place or its shape is said."""
    shapes = [code for attribute in prim.GetAuthoredAttributes() for code in attribute.GetTimeSamples()]
    return [*transform_codes(prim).tolist(), *shapes]


def _is_animated(prim: Usd.Prim) -> bool:
    """Whether its place or its shape changes."""
    return is_moving(prim) or any(attribute.ValueMightBeTimeVarying() for attribute in prim.GetAuthoredAttributes())
