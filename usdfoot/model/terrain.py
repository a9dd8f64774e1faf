"""Terrain: the meshes read; Ground: the height query on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import TerrainError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["Terrain", "no_terrain"]


@dataclass(frozen=True, kw_only=True)
class Terrain:
    """Triangles of all terrain meshes in the canonical world.

    Raises:
        TerrainError: If a mesh is empty or points are not finite.
    """

    meshes: tuple[str, ...]
    """Prim paths of the meshes, M of them; empty = no terrain."""
    points: FloatArray
    """World positions [m], shape (P, 3)."""
    triangles: IntArray
    """Point indices, counter-clockwise seen from above, shape (T, 3)."""
    mesh_indices: IntArray
    """Mesh of each triangle, shape (T,)."""
    walkable: BoolArray
    """Whether feet may stand on the mesh, shape (M,)."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.points).all():
            raise TerrainError(", ".join(self.meshes), "has points that are not finite", "author numbers")
        empty = np.setdiff1d(np.arange(len(self.meshes)), self.mesh_indices)
        if empty.size:
            raise TerrainError(self.meshes[empty[0]], "has no faces", "remove the mesh or UsdfootTerrainAPI from it")


def no_terrain() -> Terrain:
    """A terrain without meshes: feet stand on the levels of their footsteps."""
    none = np.zeros(0, dtype=int)
    return Terrain(
        meshes=(), points=np.zeros((0, 3)), triangles=none.reshape(0, 3), mesh_indices=none, walkable=none.astype(bool)
    )
