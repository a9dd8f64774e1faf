"""Plans on straight and turning ways, what becomes of them under rigid motions, and terrains to lay them on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.terrain import Terrain

MIRROR = np.array([-1.0, 1.0, 1.0])


def way(
    count: int = 8,
    *,
    length: float = 0.55,
    width: float = 0.16,
    sideways: float = 0.0,
    turn: float = 0.0,
    rise: float = 0.0,
    step_time: float = 0.5,
    duty: float = 0.62,
    first: int = 0,
    stand_first: float = 0.0,
    stand_last: float = 0.0,
) -> FootstepPlan:
    """A plan of even steps from the origin along +Z.

    Args:
        count: Footsteps.
        length: Ball to ball along the way [m].
        width: Distance of the feet across the way [m].
        sideways: Shift to the left in each step [m].
        turn: Change of heading in each step [rad].
        rise: Height gained in each step [m].
        step_time: Strike to strike of the other foot [s].
        duty: Contact over stride.
        first: Side of the first footstep.
        stand_first: Time both feet stand at the start [s]; 0 starts in mid gait.
        stand_last: Time both feet stand at the end [s].
    """
    numbers = np.arange(count)
    sides = (numbers + first) % 2
    yaws = turn * numbers
    strides = planar.rotate(yaws[:-1] + 0.5 * turn, np.tile([sideways, length], (count - 1, 1)))
    middle = np.concatenate([np.zeros((1, 2)), np.cumsum(strides, axis=0)])
    heights = rise * numbers
    strikes = step_time * numbers
    liftoffs = strikes + 2.0 * duty * step_time
    if stand_first:
        middle[0], heights[0], yaws[0] = middle[1], heights[1], yaws[1]
        liftoffs[0] = strikes[2] - 0.8 * step_time
        strikes[:2] = liftoffs[0] - stand_first
    if stand_last:
        middle[-1], heights[-1], yaws[-1] = middle[-2], heights[-2], yaws[-2]
        liftoffs[-2:] = strikes[-1] + stand_last
    across = np.stack([np.where(sides == 0, 0.5, -0.5) * width, np.zeros(count)], axis=1)
    ground = middle + planar.rotate(yaws, across)
    return FootstepPlan(
        name="/World/Plan",
        sides=sides,
        positions=np.stack([ground[:, 0], heights, ground[:, 1]], axis=1),
        orientations=quaternion.yaw_quaternion(yaws),
        strike_times=strikes,
        liftoff_times=liftoffs,
        root_weights=np.zeros(count),
    )


def moved(plan: FootstepPlan, *, yaw: float = 0.0, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> FootstepPlan:
    """The plan turned about the world's +Y by `yaw`, then shifted."""
    turn = quaternion.yaw_quaternion(np.array(yaw))
    return replace(
        plan,
        positions=quaternion.rotate(turn, plan.positions) + np.array(shift),
        orientations=quaternion.compose(turn, plan.orientations),
    )


def later(plan: FootstepPlan, time: float) -> FootstepPlan:
    """The plan `time` later [s]."""
    return replace(plan, strike_times=plan.strike_times + time, liftoff_times=plan.liftoff_times + time)


def mirrored(plan: FootstepPlan) -> FootstepPlan:
    """The plan reflected in the plane x = 0."""
    return replace(
        plan,
        sides=1 - plan.sides,
        positions=plan.positions * MIRROR,
        orientations=quaternion.mirror_x(plan.orientations),
    )


def slope(tilt_x: float, tilt_z: float, *, size: float = 20.0, walkable: bool = True) -> Terrain:
    """A plane through the origin that rises by tilt_x along +X and tilt_z along +Z."""
    corners = size * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    heights = corners @ np.array([tilt_x, tilt_z])
    return _terrain([np.stack([corners[:, 0], heights, corners[:, 1]], axis=1)], walkable=walkable)


def stairs(rise: float, tread: float, count: int = 10) -> Terrain:
    """Level treads along +Z, the first from z = -1 to half a tread, each `rise` above the one before."""
    quads = []
    for number in range(count):
        begin = -1.0 if number == 0 else (number - 0.5) * tread
        end = (number + 0.5) * tread
        x, y = 2.0, number * rise
        quads.append(np.array([[-x, y, begin], [-x, y, end], [x, y, end], [x, y, begin]]))
    return _terrain(quads)


def bumps(height: float, length: float, *, cells: int = 160, size: float = 8.0) -> Terrain:
    """Round hills and hollows of `height` [m] above and below 0, about 3 `length` [m] apart, in cells of 5 cm."""
    ticks = np.linspace(-0.25 * size, 0.75 * size, cells + 1)
    x, z = np.meshgrid(ticks, ticks, indexing="ij")
    points = np.stack([x, height * np.sin(x / length) * np.cos(z / length), z], axis=-1).reshape(-1, 3)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1, 1)
    corners = first + np.array([[0, 1, cells + 2], [0, cells + 2, cells + 1]])
    flat = _terrain([points[:4]])
    return replace(
        flat, points=points, triangles=corners.reshape(-1, 3), mesh_indices=np.zeros(2 * cells**2, dtype=int)
    )


def _terrain(quads: Sequence[FloatArray], *, walkable: bool = True) -> Terrain:
    points = np.concatenate(quads)
    corners = 4 * np.arange(len(quads))[:, None, None]
    triangles = (corners + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    return Terrain(
        meshes=("/World/ground",),
        points=points,
        triangles=triangles,
        mesh_indices=np.zeros(len(triangles), dtype=int),
        walkable=np.array([walkable]),
    )


def no_terrain() -> Terrain:
    """Nothing: the ground is the plane through the lowest footstep."""
    none = np.zeros(0, dtype=int)
    return Terrain(
        meshes=(), points=np.zeros((0, 3)), triangles=none.reshape(0, 3), mesh_indices=none, walkable=none.astype(bool)
    )


def frame_times(plans: Sequence[FootstepPlan], rate: float) -> FloatArray:
    """Whole samples that cover all plans [s]."""
    first = np.floor(min(plan.strike_times[0] for plan in plans) * rate + 1e-6)
    last = np.ceil(max(plan.liftoff_times.max() for plan in plans) * rate - 1e-6)
    return np.arange(first, last + 1.0) / rate


def crowd(
    library: ClipLibrary,
    plans: Sequence[FootstepPlan],
    *,
    rate: float = 30.0,
    times: FloatArray | None = None,
    terrain: Terrain | None = None,
    reach: float = 0.3,
) -> Crowd:
    """Agents agent0, agent1, ... that walk the plans."""
    agents = tuple(
        Agent(name=f"agent{index}", source=f"/World/agent{index}", plan=plan, library=0, character=0, ik_reach=reach)
        for index, plan in enumerate(plans)
    )
    return Crowd(
        agents=agents,
        libraries=(library,),
        terrain=terrain or no_terrain(),
        frame_times=frame_times(plans, rate) if times is None else times,
        frame_rate=rate,
    )
