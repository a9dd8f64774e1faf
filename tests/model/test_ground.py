"""The ground query against brute force, at its corners, on several levels, and on real terrain."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

from tests.strategies import seeds
from usdfoot.model.ground import Ground, GroundSample
from usdfoot.model.terrain import Terrain


def terrain_of(points: np.ndarray, triangles: np.ndarray, *, walkable: tuple[bool, ...] = (True,)) -> Terrain:
    """Terrain of as many meshes as there are flags, triangles dealt to them in equal blocks."""
    return Terrain(
        meshes=tuple(f"/World/Mesh{i}" for i in range(len(walkable))),
        points=np.asarray(points, dtype=float),
        triangles=np.asarray(triangles),
        mesh_indices=np.repeat(np.arange(len(walkable)), len(triangles) // max(len(walkable), 1)),
        walkable=np.array(walkable, dtype=bool),
    )


def grid(xs: np.ndarray, zs: np.ndarray, height) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a height field; every other triangle is wound the wrong way round."""
    x, z = np.meshgrid(xs, zs, indexing="ij")
    points = np.stack([x, height(x, z), z], axis=-1).reshape(-1, 3)
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = index[:-1, :-1].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    return points, np.concatenate([np.stack([a, d, c], axis=1), np.stack([a, b, c], axis=1)])


def brute_force(terrain: Terrain, points: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Heights by testing every triangle for every point, NaN off the terrain."""
    result = []
    corners = terrain.points[terrain.triangles]
    low, high = corners.min(axis=1) - 1e-6, corners.max(axis=1) + 1e-6
    for (x, z), limit in zip(points, limits, strict=True):
        levels = []
        around = (low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 2] <= z) & (z <= high[:, 2])
        for a, b, c in corners[around]:
            matrix = np.array([[a[0], b[0], c[0]], [a[2], b[2], c[2]], [1.0, 1.0, 1.0]])
            if abs(np.linalg.det(matrix)) > 1e-12:
                weights = np.linalg.solve(matrix, [x, z, 1.0])
                if weights.min() >= -1e-9:
                    levels.append(weights @ [a[1], b[1], c[1]])
        below = [level for level in levels if level <= limit + 1e-9]
        result.append(max(below) if below else min(levels, default=np.nan))
    return np.array(result)


def slab(height: float, *, low: float = -1.0, high: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    corners = [[low, height, low], [low, height, high], [high, height, high], [high, height, low]]
    return np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])


def stack(*parts: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    offsets = np.cumsum([0, *(len(points) for points, _ in parts)])
    triangles = [triangles + offset for (_, triangles), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(triangles)


@given(seeds)
def test_agrees_with_brute_force_on_triangle_soup(seed: int) -> None:
    generator = np.random.default_rng(seed)
    terrain = terrain_of(generator.uniform(-2, 2, (36, 3)), np.arange(36).reshape(12, 3))
    points, near = generator.uniform(-2, 2, (30, 2)), generator.uniform(-2, 2, 30)
    sample = Ground(terrain, fallback_height=-7.0).heights(points, near, step_up=0.3)
    expected = brute_force(terrain, points, near + 0.3)
    assert_array_equal(sample.hit, np.isfinite(expected))
    assert_allclose(sample.heights, np.where(sample.hit, expected, -7.0), rtol=0, atol=1e-7)


def test_every_vertex_and_edge_of_a_mesh_is_hit() -> None:
    axis = np.linspace(-50.0, 50.0, 101)
    points, triangles = grid(axis, axis, lambda x, z: np.sin(0.3 * x) * np.cos(0.2 * z))
    ground = Ground(terrain_of(points, triangles))
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    for fraction in (0.0, 1.0 / 3.0, 0.5):
        on_edge = (1.0 - fraction) * points[ends[:, 0]] + fraction * points[ends[:, 1]]
        sample = ground.heights(on_edge[:, [0, 2]], np.full(len(on_edge), 1.0))
        assert sample.hit.all()
        assert_allclose(sample.heights, on_edge[:, 1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("offset", [0.0, 1.0e4])
def test_plane_of_100_metres_is_exact_far_from_the_origin(offset: float, generator: np.random.Generator) -> None:
    axis = np.linspace(-50.0, 50.0, 11)
    points, triangles = grid(axis, axis, lambda x, z: 0.1 * x - 0.25 * z + 3.0)
    queries = generator.uniform(-50, 50, (5000, 2))
    sample = Ground(terrain_of(points + offset, triangles)).heights(queries + offset, np.full(5000, 30.0 + offset))
    assert_allclose(sample.heights - offset, queries @ [0.1, -0.25] + 3.0, rtol=0, atol=1e-5)
    expected = np.array([-0.1, 1.0, 0.25]) / np.linalg.norm([-0.1, 1.0, 0.25])
    assert_allclose(sample.normals, np.tile(expected, (5000, 1)), atol=1e-12)


def test_under_a_bridge_the_road_and_on_it_the_bridge() -> None:
    ground = Ground(terrain_of(*stack(slab(0.0), slab(3.0))))
    near = np.array([0.0, 2.4, 2.6, 3.0, 9.0])
    assert_allclose(ground.heights(np.zeros((5, 2)), near).heights, [0.0, 0.0, 3.0, 3.0, 3.0])


def test_from_below_everything_the_lowest_level_above() -> None:
    ground = Ground(terrain_of(*stack(slab(2.0), slab(3.0))))
    assert_allclose(ground.heights(np.zeros((1, 2)), np.array([0.0])).heights, [2.0])


def test_level_exactly_at_reach_counts() -> None:
    ground = Ground(terrain_of(*stack(slab(0.0), slab(0.2))))
    assert_allclose(ground.heights(np.zeros((1, 2)), np.array([0.0]), step_up=0.2).heights, [0.2])


def test_walkable_is_that_of_the_mesh_hit() -> None:
    ground = Ground(terrain_of(*stack(slab(0.0), slab(0.2, low=0.0)), walkable=(False, True)))
    sample = ground.heights(np.array([[-0.5, -0.5], [0.5, 0.5]]), np.zeros(2))
    assert_array_equal(sample.walkable, [False, True])


@pytest.mark.parametrize("walkable", [(True, False), (False, True)])
def test_of_two_coinciding_levels_the_walkable_one_counts(walkable: tuple[bool, bool]) -> None:
    ground = Ground(terrain_of(*stack(slab(0.1), slab(0.1)), walkable=walkable))
    assert ground.heights(np.zeros((1, 2)), np.zeros(1)).walkable.all()


def test_walls_and_degenerate_triangles_are_no_ground() -> None:
    points, triangles = slab(0.0)
    wall = np.array([[0.0, 0.0, -1.0], [0.0, 5.0, 0.0], [0.0, 0.0, 1.0], [0.5, 4.0, 0.5]])
    ground = Ground(terrain_of(*stack((points, triangles), (wall, np.array([[0, 1, 2], [3, 3, 3]])))))
    assert_allclose(ground.heights(np.array([[0.0, 0.0], [0.5, 0.5]]), np.full(2, 9.0)).heights, 0.0, atol=1e-12)
    only_walls = Ground(terrain_of(wall, np.array([[0, 1, 2]])), fallback_height=0.7).heights(
        np.zeros((1, 2)), np.zeros(1)
    )
    assert (only_walls.heights[0], only_walls.hit[0]) == (0.7, False)


def test_off_the_terrain_the_fallback_plane() -> None:
    sample = Ground(terrain_of(*slab(1.0)), fallback_height=0.25).heights(np.array([[5.0, 0.0]]), np.zeros(1))
    assert_sample(sample, 0.25, hit=False, walkable=False)


def test_without_terrain_the_fallback_plane_is_the_ground() -> None:
    terrain = terrain_of(np.empty((0, 3)), np.empty((0, 3), dtype=int), walkable=())
    assert_sample(
        Ground(terrain, fallback_height=0.25).heights(np.zeros((1, 2)), np.zeros(1)), 0.25, hit=True, walkable=True
    )


def assert_sample(sample: GroundSample, height: float, *, hit: bool, walkable: bool) -> None:
    assert (sample.heights[0], sample.hit[0], sample.walkable[0]) == (height, hit, walkable)
    assert_array_equal(sample.normals, [[0.0, 1.0, 0.0]])


def test_no_points_give_an_empty_sample() -> None:
    assert Ground(terrain_of(*slab(0.0))).heights(np.empty((0, 2)), np.empty(0)).normals.shape == (0, 3)


def test_nothing_is_printed(repository: Path) -> None:
    program = (
        "import numpy as np; from usdfoot.model.ground import Ground; from usdfoot.model.terrain import Terrain; "
        "t = Terrain(meshes=('/G',), points=np.eye(3), triangles=np.array([[0, 1, 2]]), mesh_indices=np.zeros(1, int), "
        "walkable=np.ones(1, bool)); print(Ground(t).heights(np.full((1, 2), 0.25), np.zeros(1)).heights[0])"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=repository, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("0.5\n", "")


@pytest.mark.parametrize("name", ["straight_stairs", "slope", "jacksboro_hills"])
def test_real_terrain(shared_data: Path, name: str, generator: np.random.Generator) -> None:
    terrain = read_terrain(shared_data / "terrain" / f"{name}.usdc")
    ground, top = Ground(terrain), terrain.points[:, 1].max()
    at_vertices = ground.heights(terrain.points[:, [0, 2]], np.full(len(terrain.points), top))
    assert at_vertices.hit.all()
    assert_allclose(at_vertices.heights, terrain.points[:, 1], rtol=0, atol=1e-6)
    assert at_vertices.normals[:, 1].min() > 0.0
    low, high = terrain.points[:, [0, 2]].min(axis=0), terrain.points[:, [0, 2]].max(axis=0)
    queries = generator.uniform(low, high, (50, 2))
    sample = ground.heights(queries, np.full(50, top))
    assert_allclose(sample.heights, brute_force(terrain, queries, np.full(50, top + 0.5)), rtol=0, atol=1e-6)


def read_terrain(path: Path) -> Terrain:
    """The first mesh of a stage, by its own few lines, independent of the project's reader."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    mesh = UsdGeom.Mesh(prim)
    to_world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    points = np.asarray(mesh.GetPointsAttr().Get(), dtype=float) @ to_world[:3, :3] + to_world[3, :3]
    points *= UsdGeom.GetStageMetersPerUnit(stage)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        points = points[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    counts, indices = (
        np.asarray(mesh.GetFaceVertexCountsAttr().Get()),
        np.asarray(mesh.GetFaceVertexIndicesAttr().Get()),
    )
    starts = np.cumsum(counts) - counts
    fans = [indices[[s, s + i, s + i + 1]] for s, n in zip(starts, counts, strict=True) for i in range(1, n - 1)]
    return terrain_of(points, np.array(fans))
