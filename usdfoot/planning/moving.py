"""Moving obstacles: how fast they go, and where they are later."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.planning.world import Obstacle, World

__all__ = ["measure_velocities", "moved_on", "with_velocity"]

FASTEST = 10.0
"""What seems to go faster than that has been put elsewhere [m/s]."""


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


def _with_velocity(obstacle: Obstacle, before: Obstacle, seconds: float) -> Obstacle:
    """The obstacle with the velocity at which it has come from where it was, unless it says one or has changed."""
    if obstacle is before or obstacle.velocity is not None or len(obstacle.outline) != len(before.outline):
        return obstacle
    x, z = (obstacle.outline.mean(axis=0) - before.outline.mean(axis=0)) / seconds
    return replace(obstacle, velocity=(float(x), float(z))) if np.hypot(x, z) <= FASTEST else obstacle
