"""Milliseconds of processor time that a plan of 12 footsteps takes, one of many made together and one alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

import numpy as np

from benching.stopwatch import best_time, function_times
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.model.terrain import Terrain
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.planning.crossings import Stones, stance_at
from usdfoot.planning.crowd import plan_crowd
from usdfoot.planning.path import plan_paths
from usdfoot.planning.reach import reach_of_biped
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.stones import plan_crossings
from usdfoot.planning.trajectories import plan_trajectories
from usdfoot.planning.wander import plan_wanders
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

__all__ = ["plan_times"]

TOGETHER = 200
STEPS = 12
AHEAD = 6.4
"""How far so many steps lead [m]."""
HALF = 20.0
"""Of the area's width [m]."""
BIPED = Biped(
    pelvis=0,
    hips=(1, 5),
    knees=(2, 6),
    ankles=(3, 7),
    balls=(4, 8),
    ball_heights=np.full(2, 0.02),
    nominal_leg_length=0.85,
    maximal_leg_length=0.88,
    com=np.zeros(3),
)
LEVEL = Terrain(
    meshes=(),
    points=np.zeros((0, 3)),
    triangles=np.zeros((0, 3), dtype=int),
    mesh_indices=np.zeros(0, dtype=int),
    walkable=np.zeros(0, dtype=bool),
)


def plan_times(*, together: int = TOGETHER, repeats: int = 3) -> dict[str, dict[str, float]]:
    """Milliseconds by planner, then by "together" and "alone".

    Args:
        together: Plans made at once.
        repeats: How often each is timed; the quickest counts.
    """
    level, hills = Ground(LEVEL), Ground(_hills())
    bounds, obstacles = box_outline(np.full(2, -HALF), np.full(2, HALF)), _obstacles()
    world = World(bounds=bounds, obstacles=obstacles)
    hilly = replace(world, ground=hills)
    planners: dict[str, Callable[[int], object]] = {
        "path, level": partial(_follow, level),
        "path, hills": partial(_follow, hills),
        "path, stairs": partial(_follow, Ground(_stairs())),
        "wander, level": partial(_wander, world, []),
        "wander, hills": partial(_wander, hilly, []),
        "wander, to one goal": partial(_wander, world, [_free_place()]),
        "wander, to own goals": partial(_wander, world, _free_places(together)),
        "wander, to own goals, hills": partial(_wander, hilly, _free_places(together, hills)),
        "over 100 stones": partial(_cross, 100),
        "over 400 stones": partial(_cross, 400),
        "trajectories": partial(_track, level),
    }
    figures = {}
    for name, plan in planners.items():
        many, one = (best_time(partial(plan, count), repeats=repeats, processor=True) for count in (together, 1))
        figures[name] = {"together": 1e3 * many / together, "alone": 1e3 * one}
    if find_spec("jupedsim"):
        figures["crowd"] = _crowd_times(together, repeats)
    return figures


def _crowd_times(count: int, repeats: int) -> dict[str, float]:
    """Milliseconds of a person's simulation, and of its footsteps."""
    side = int(np.ceil(np.sqrt(count)))
    places = 2.0 * np.stack(np.divmod(np.arange(count), side), axis=1)
    seekers = tuple(
        Seeker(name=f"/P{row}", start=np.array([x, 0.0, z]), goals=np.array([[x + 1.0, 0.0, z + AHEAD]]))
        for row, (x, z) in enumerate(places)
    )
    scenario, parts = Scenario(seekers=seekers, obstacles=(), bounds=None), ("simulate", "_plans")
    spent = function_times(lambda: plan_crowd(scenario, LEVEL), parts, repeats=repeats)
    return {"simulated": 1e3 * spent["simulate"] / count, "footsteps, together": 1e3 * spent["_plans"] / count}


def _follow(ground: Ground, count: int) -> object:
    """Plans along straight ways beside each other."""
    across = np.linspace(-0.5 * HALF, 0.5 * HALF, count)
    ahead = np.linspace(0.0, AHEAD, 33)
    points = np.stack(np.broadcast_arrays(across[:, None], 0.0, ahead), axis=-1)  # (N, 33, 3)
    heights = ground.heights(points.reshape(-1, 3)[:, [0, 2]], np.full(points[..., 0].size, HALF)).heights
    points = np.insert(points[..., [0, 2]], 1, heights.reshape(points.shape[:2]), axis=2)
    return plan_paths([WalkingPath(name=f"/Path_{row}", points=own) for row, own in enumerate(points)], ground)


def _track(ground: Ground, count: int) -> object:
    """Plans of people 2 m apart who walk ahead."""
    times = np.linspace(0.0, AHEAD / 1.2, 120)
    places = np.stack([0.0 * times, 0.0 * times, 1.2 * times], axis=1)
    tracks = [
        RootTrajectory(name=f"/T{row}", times=times, positions=places + [2.0 * row, 0.0, 0.0]) for row in range(count)
    ]
    return plan_trajectories(tracks, ground)


def _wander(world: World, goals: list[FloatArray], count: int) -> object:
    """Plans of those who set out from the middle in all directions, to goals in turn if there are any."""
    height = 0.0 if world.ground is None else float(world.ground.heights(np.zeros((1, 2)), np.array([HALF])).heights[0])
    return plan_wanders(
        world,
        np.tile([0.0, height, 0.0], (count, 1)),
        0.3 * np.arange(count),
        generators=[np.random.default_rng(number) for number in range(count)],
        names=[f"/W{number}" for number in range(count)],
        goals=[goals[number % len(goals) :][:1] if goals else [] for number in range(count)],
        steps=STEPS,
    )


def _cross(stones: int, count: int) -> object:
    """Plans along a strip of 1.8 by 5.6 m with so many footholds."""
    reach = reach_of_biped(BIPED)
    places = np.random.default_rng(1).uniform([-0.9, 0.0, 0.4], [0.9, 0.0, 6.0], size=(stones, 3))
    normals = np.tile([0.0, 1.0, 0.0], (stones, 1))
    aside = 0.2 * np.sin(np.arange(count))
    starts, goals = (
        [stance_at(np.array([x, 0.0, z]), 0.0, reach) for x in sign * aside] for sign, z in ((1.0, 0.0), (-1.0, AHEAD))
    )
    footholds = Stones(name="/Stones", positions=places, normals=normals)
    return plan_crossings(footholds, starts, goals, reach=reach, names=[f"/S{row}" for row in range(count)])


def _obstacles() -> tuple[Obstacle, ...]:
    """20 boxes in 20 by 20 m, none where people set out."""
    places = np.random.default_rng(4).uniform(-9.0, 9.0, size=(40, 2))
    places = places[np.linalg.norm(places, axis=1) > 1.5][:20]
    return tuple(Obstacle(name=f"/Box_{row}", outline=box_outline(at, at + 0.6)) for row, at in enumerate(places))


def _free_place() -> FloatArray:
    """A goal 6.4 m away."""
    around = np.linspace(0.0, 2.0 * np.pi, 100)
    places = AHEAD * np.stack([np.sin(around), np.cos(around)], axis=1)
    place = places[np.argmax(clearances(World(obstacles=_obstacles()), places))]
    return np.array([place[0], 0.0, place[1]])


def _free_places(count: int, ground: Ground | None = None) -> list[FloatArray]:
    """Goals of so many in the same area."""
    places = np.random.default_rng(9).uniform(-0.5 * HALF, 0.5 * HALF, size=(4 * count, 2))
    room = clearances(World(obstacles=_obstacles()), places)
    places = places[(room > 0.5) & (np.linalg.norm(places, axis=1) > 3.0)][:count]
    heights = np.zeros(count) if ground is None else ground.heights(places, np.full(count, HALF)).heights
    return list(np.insert(places, 1, heights, axis=1))


def _hills() -> Terrain:
    """Hills 0.6 m high, 12 m from top to top, in cells of 0.2 m."""
    axis = np.arange(-HALF, HALF + 0.1, 0.2)
    x, z = np.meshgrid(axis, axis, indexing="ij")
    heights = 0.3 * np.sin(2.0 * np.pi * x / 12.0) * np.cos(2.0 * np.pi * z / 12.0)
    corner = (np.arange(len(axis) - 1)[:, None] * len(axis) + np.arange(len(axis) - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + len(axis) + 1, corner + len(axis)], axis=1)
    return _mesh(np.stack([x, heights, z], axis=-1).reshape(-1, 3), quads)


def _stairs() -> Terrain:
    """Treads of 0.3 m, 0.15 m high, six up and six down again, and level ground before and behind them."""
    edges = np.concatenate([[-HALF], 1.4 + 0.3 * np.arange(12), [HALF]])
    heights = 0.15 * np.array([*range(6), *range(6, -1, -1)])
    x = np.array([-HALF, -HALF, HALF, HALF])
    corners = [
        np.stack([x, np.full(4, height), [begin, end, end, begin]], axis=1)
        for begin, end, height in zip(edges[:-1], edges[1:], heights, strict=True)
    ]
    return _mesh(np.concatenate(corners), np.arange(4 * len(corners)).reshape(-1, 4))


def _mesh(points: FloatArray, quads: IntArray) -> Terrain:
    """A walkable mesh of quads (Q, 4)."""
    return Terrain(
        meshes=("/Ground",),
        points=points,
        triangles=np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]),
        mesh_indices=np.zeros(2 * len(quads), dtype=int),
        walkable=np.array([True]),
    )
