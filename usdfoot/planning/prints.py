"""Prints on the ground: feet that take on the ground's height and slope ([P] 2.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.agent import Crowd
from usdfoot.model.ground import Ground
from usdfoot.planning.proportions import Proportions

__all__ = [
    "EDGE",
    "STEP_UP",
    "Prints",
    "conform_plans",
    "lay_prints",
    "print_orientations",
    "put_on_ground",
    "settle_landings",
    "settle_on_treads",
]

STEP_UP = 0.5
"""Ground this far above [m] is still the same level."""
POKE = 0.03
"""Ground may rise this much through the sole [m]."""
EDGE = 0.05
"""Ground that rises this much through a corner of the sole is an edge, as of a tread [m]."""
ROOM = 1.5
"""Ground up to this far above a foot is a riser, not another level [m]."""
CLEAR = 0.02
"""Between a sole's ends and the riser behind or before it [m]."""
WAY_SAMPLES = 16
"""Places between two footsteps at which the ground between them is looked at."""
SHIFTS = 0.02 * np.array([0, -1, 1, -2, 2, -3, 3, -4, 4, -5, 5, -6, 6, -7, 7, -8, 8])
"""Along the foot, the nearest first [m]."""


@dataclass(frozen=True, kw_only=True)
class Prints:
    """Footprints as the ground takes them."""

    positions: FloatArray
    """Ground under the balls [m], shape (N, 3)."""
    orientations: FloatArray
    """Turns +Z into the foot's forward and +Y into the ground's normal, unit xyzw, shape (N, 4)."""
    walkable: BoolArray
    """Whether feet may stand there, shape (N,)."""


def lay_prints(
    ground: Ground, points: FloatArray, yaws: FloatArray, *, near: FloatArray, step_up: float = STEP_UP
) -> Prints:
    """Prints that take on the height and slope of the ground ([P] 2.1).

    Args:
        ground: The terrain.
        points: Under the balls, (x, z) [m], shape (N, 2).
        yaws: Where the feet point [rad], shape (N,).
        near: Height of the way there [m], shape (N,); off the terrain it is the print's.
        step_up: Ground is looked for up to this far above `near` [m].
    """
    sample = ground.heights(points, near, step_up=step_up)
    return Prints(
        positions=np.stack([points[:, 0], np.where(sample.hit, sample.heights, near), points[:, 1]], axis=-1),
        orientations=print_orientations(yaws, sample.normals),
        walkable=sample.walkable,
    )


def conform_plans(crowd: Crowd) -> Crowd:
    """The crowd with the footsteps of its plans laid on the terrain, at its height and with its slope ([P] 2.1).

    A footstep keeps its place seen from above and its yaw. Of several levels it takes the highest up to `STEP_UP` above
    it, else the one next above. Beyond the terrain it stays as given.
    """
    ground = Ground(crowd.terrain)
    if not (ground.has_terrain and crowd.agents):
        return crowd
    plans = [agent.plan for agent in crowd.agents]
    positions, yaws = np.concatenate([plan.positions for plan in plans]), np.concatenate([plan.yaws for plan in plans])
    sample = ground.heights(positions[:, [0, 2]], positions[:, 1])
    off, given = ~sample.hit, np.concatenate([plan.orientations for plan in plans])
    positions[:, 1] = np.where(off, positions[:, 1], sample.heights)
    orientations = np.where(off[:, None], given, print_orientations(yaws, sample.normals))
    ends = np.cumsum([len(plan) for plan in plans])[:-1]
    laid = zip(plans, np.split(positions, ends), np.split(orientations, ends), strict=True)
    conformed = [replace(plan, positions=own, orientations=turned) for plan, own, turned in laid]
    agents = tuple(replace(agent, plan=plan) for agent, plan in zip(crowd.agents, conformed, strict=True))
    return replace(crowd, agents=agents)


def settle_on_treads(
    ground: Ground,
    points: FloatArray,
    yaws: FloatArray,
    *,
    near: FloatArray,
    heels: FloatArray,
    toes: FloatArray,
    half_widths: FloatArray,
) -> FloatArray:
    """The points (N, 2), those of feet with the edge of a tread in their soles moved along the foot to where it is not.

    Where all places have an edge in a corner of the sole, to where there is none along its middle.

    Args:
        ground: The terrain.
        points: Under the balls, (x, z) [m], shape (N, 2).
        yaws: Where the feet point [rad], shape (N,).
        near: Height of the way there [m], shape (N,).
        heels: From the ball back to the heel [m], shape (N,).
        toes: From the ball ahead to the toes [m], shape (N,).
        half_widths: From the soles' middle lines to their edges [m], shape (N,).
    """
    if not ground.has_terrain:
        return points
    settled, rows = points.copy(), np.arange(len(points))
    forward, across = planar.direction(yaws), planar.direction(yaws + 0.5 * np.pi)
    middle = np.stack([forward * (toes + CLEAR)[:, None], -forward * (heels + CLEAR)[:, None]])
    corners = np.stack(
        [
            reach[:, None] * forward + side * half_widths[:, None] * across
            for reach in (toes, -heels)
            for side in (-1.0, 1.0)
        ]
    )
    for outline in (np.concatenate([middle, corners]), middle):  # (K, N, 2)
        limits = np.where(np.arange(len(outline)) < len(middle), POKE, EDGE)
        for shift in SHIFTS:
            tried = points[rows] + shift * forward[rows]
            clear = _is_clear(ground, tried, near[rows], outline[:, rows], limits)
            settled[rows[clear]] = tried[clear]
            rows = rows[~clear]
            if not rows.size:
                return settled
    return settled


def _is_clear(
    ground: Ground, points: FloatArray, near: FloatArray, outline: FloatArray, limits: FloatArray
) -> BoolArray:
    """Whether feet may stand at points (N, 2), no ground higher than limits (K,) in outlines (K, N, 2) round them."""
    ball = ground.heights(points, near, step_up=STEP_UP)
    slopes = -ball.normals[:, [0, 2]] / ball.normals[:, [1]]
    soles = ball.heights + np.einsum("kni,ni->kn", outline, slopes)
    from_ball = np.broadcast_to(ball.heights, soles.shape).ravel()
    under = ground.heights((points + outline).reshape(-1, 2), from_ball, step_up=ROOM)
    pokes = np.where(under.hit, under.heights, -np.inf).reshape(soles.shape) - soles
    clear = ball.walkable & (np.abs(ball.heights - near) <= STEP_UP)
    return np.asarray(clear & (pokes <= limits[:, None]).all(axis=0))


def settle_landings(
    ground: Ground, starts: FloatArray, landings: FloatArray, *, yaws: FloatArray, body: Proportions
) -> FloatArray:
    """Landings (N, 3) of feet that step from `starts` (N, 3), on the ground, no edge of a tread in their soles.

    Their level is the one the ground between leads to, up stairs of which a step passes several. Beyond a drop it is
    the one below.
    """
    if not ground.has_terrain:
        return landings
    shares = np.linspace(0.0, 1.0, WAY_SAMPLES)[:, None]
    ways = (starts[:, None] + shares * (landings - starts)[:, None])[..., [0, 2]].reshape(-1, 2)
    firsts = WAY_SAMPLES * np.arange(len(starts) + 1)
    found = ground.follow(ways, np.repeat(starts[:, 1], WAY_SAMPLES), first=firsts)
    last = firsts[1:] - 1
    near = np.where(found.hit[last], found.heights[last], starts[:, 1])
    heels, toes, half_widths = (np.full(len(starts), size) for size in (body.heel, body.toe, body.half_width))
    settled = landings.copy()
    settled[:, [0, 2]] = settle_on_treads(
        ground, landings[:, [0, 2]], yaws, near=near, heels=heels, toes=toes, half_widths=half_widths
    )
    return put_on_ground(ground, settled, near)


def put_on_ground(ground: Ground, positions: FloatArray, near: FloatArray, *, step_up: float = STEP_UP) -> FloatArray:
    """Positions (N, 3) on the highest level of the ground up to `step_up` [m] over heights `near` (N,) [m].

    Beyond the terrain they keep those heights; without any they stay as they are.
    """
    if not ground.has_terrain:
        return positions
    found = ground.heights(positions[:, [0, 2]], near, step_up=step_up)
    laid = positions.copy()
    laid[:, 1] = np.where(found.hit, found.heights, near)
    return laid


def print_orientations(yaws: FloatArray, normals: FloatArray) -> FloatArray:
    """Orientations of prints that point along yaws [rad] (N,) seen from above and lie on normals (N, 3), (N, 4)."""
    sine, cosine = np.sin(yaws), np.cos(yaws)
    rise = -(normals[:, 0] * sine + normals[:, 2] * cosine) / normals[:, 1]
    forward = np.stack([sine, rise, cosine], axis=-1)
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    return quaternion.from_matrix(np.stack([np.cross(normals, forward), normals, forward], axis=-1))
