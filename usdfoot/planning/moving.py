"""Moving obstacles: how fast they go, and where they are later."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.planning.world import Obstacle, World, clearances

__all__ = ["Moving", "measure_velocities", "moved_on", "with_velocity"]

FASTEST = 10.0
"""What seems to go faster than that has been put elsewhere [m/s]."""
INSTANT = 0.05
"""Obstacles are known at multiples of it [s]."""
STILL = 0.01
"""Corners that have gone no farther [m] rest."""


@dataclass(frozen=True, kw_only=True)
class Moving:
    """Obstacles whose movements are known."""

    at: Callable[[float], Sequence[Obstacle]]
    """They at a time [s]."""
    end: float
    """From then on they all rest [s]."""
    _worlds: dict[int, World] = field(init=False, default_factory=dict, compare=False, repr=False)

    def later(self, seconds: float) -> Moving:
        """The same for whom time begins so much later [s]."""
        return Moving(at=lambda time: self.at(time + seconds), end=max(self.end - seconds, 0.0))

    def clearances(self, points: FloatArray, heights: FloatArray, times: FloatArray) -> FloatArray:
        """Distance [m] to the nearest one's margin at each time, negative inside.

        Args:
            points: (x, z) [m], shape (T, N, 2).
            heights: Of the ground there [m], shape (N,).
            times: [s], shape (T,).

        Returns:
            Shape (T, N), infinite where there is none.
        """
        found = np.empty(points.shape[:2])
        for row, time in enumerate(times.tolist()):
            found[row] = clearances(self._world(time), points[row], heights)
        return found

    def clearances_then(self, points: FloatArray, heights: FloatArray, times: FloatArray) -> FloatArray:
        """As `clearances`, of points (N, 2) each at its own time (N,) [s], shape (N,)."""
        found, instants = np.empty(len(points)), np.rint(times / INSTANT).astype(np.intp)
        order = np.argsort(instants, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(instants[order])) + 1):
            found[rows] = clearances(self._world(instants[rows[0]] * INSTANT), points[rows], heights[rows])
        return found

    def resting(self, now: float, *, seconds: float) -> tuple[Obstacle, ...]:
        """Those that stay where they are for so long [s] from a time [s] on."""
        known = self.at(now)
        for later in np.linspace(0.0, seconds, 4)[1:].tolist():
            then = {obstacle.name: obstacle for obstacle in self.at(now + later)}
            known = [one for one in known if one.name in then and _is_still(one, then[one.name])]
        return tuple(known)

    def _world(self, time: float) -> World:
        """What they are at a time [s], as if they stood there."""
        number = round(min(time, self.end) / INSTANT)
        if number not in self._worlds:
            stopped = tuple(replace(obstacle, velocity=None) for obstacle in self.at(number * INSTANT))
            self._worlds[number] = World(obstacles=stopped)
        return self._worlds[number]


def measure_velocities(world: World, before: World, *, seconds: float) -> World:
    """The world with the velocities of obstacles that say none and that were elsewhere before.

    Args:
        world: As it is now.
        before: As it was; obstacles of one name in each are the same.
        seconds: How long ago [s].
    """
    if seconds <= 0.0 or world is before:
        return world
    names = [Counter(obstacle.name for obstacle in one.obstacles) for one in (world, before)]
    then = {obstacle.name: obstacle for obstacle in before.obstacles}
    known = {name for name in then if names[0][name] == names[1][name] == 1}
    obstacles = tuple(
        _with_velocity(obstacle, then[obstacle.name], seconds) if obstacle.name in known else obstacle
        for obstacle in world.obstacles
    )
    same = all(now is one for now, one in zip(obstacles, world.obstacles, strict=True))
    return world if same else replace(world, obstacles=obstacles)


def with_velocity(obstacles: Sequence[Obstacle], later: Sequence[Obstacle], *, seconds: float) -> list[Obstacle]:
    """Obstacles that are one body with the velocity at which it gets to where it is so much later.

    Args:
        obstacles: As they are now.
        later: The same then.
        seconds: How much later [s].
    """
    then, now = (np.concatenate([one.outline for one in parts]).mean(axis=0) for parts in (later, obstacles))
    x, z = (then - now) / seconds
    velocity = (float(x), float(z)) if np.hypot(x, z) <= FASTEST else None
    return [replace(obstacle, velocity=velocity) for obstacle in obstacles]


def moved_on(world: World, *, seconds: float) -> World:
    """The world with its obstacles where they are after a time [s]; itself if none moves."""
    if not world.moves:
        return world
    return replace(
        world,
        obstacles=tuple(
            replace(obstacle, outline=obstacle.outline + seconds * np.array(obstacle.velocity))
            if obstacle.moves
            else obstacle
            for obstacle in world.obstacles
        ),
    )


def _is_still(obstacle: Obstacle, later: Obstacle) -> bool:
    """Whether an obstacle is where it was."""
    same = len(obstacle.outline) == len(later.outline)
    return same and bool(np.abs(obstacle.outline - later.outline).max() <= STILL)


def _with_velocity(obstacle: Obstacle, before: Obstacle, seconds: float) -> Obstacle:
    """The obstacle with the velocity at which it has come from where it was, unless it says one or has changed."""
    if obstacle is before or obstacle.velocity is not None or len(obstacle.outline) != len(before.outline):
        return obstacle
    x, z = (obstacle.outline.mean(axis=0) - before.outline.mean(axis=0)) / seconds
    return replace(obstacle, velocity=(float(x), float(z))) if np.hypot(x, z) <= FASTEST else obstacle
