"""Terrain: what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from usdfoot.errors import TerrainError
from usdfoot.model.terrain import Terrain


def terrain(points: np.ndarray, mesh_indices: list[int]) -> Terrain:
    return Terrain(
        meshes=("/World/Floor", "/World/Step"),
        points=points,
        triangles=np.tile([0, 1, 2], (len(mesh_indices), 1)),
        mesh_indices=np.array(mesh_indices),
        walkable=np.array([True, True]),
    )


def test_a_mesh_without_faces_is_named() -> None:
    with pytest.raises(TerrainError, match=r"/World/Step: has no faces\. remove the mesh or UsdfootTerrainAPI"):
        terrain(np.eye(3), [0])


def test_points_that_are_not_finite_are_refused() -> None:
    with pytest.raises(TerrainError, match="/World/Floor, /World/Step: has points that are not finite"):
        terrain(np.full((3, 3), np.nan), [0, 1])
