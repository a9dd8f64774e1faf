"""Ground: what a foot would stand on at any point, from the terrain's triangles."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.model.ground_kernel import GroundFaces, find_ground, follow_ground
from usdfoot.model.terrain import Terrain

__all__ = ["Ground", "GroundSample"]

FLATTEST_NORMAL = 1e-6
"""Faces whose unit normal rises less than this are walls: nothing stands on them."""


@dataclass(frozen=True, kw_only=True)
class GroundSample:
    """The ground at N points."""

    heights: FloatArray
    """Height of the ground [m], shape (N,)."""
    normals: FloatArray
    """Unit normals of the ground, pointing up, shape (N, 3)."""
    walkable: BoolArray
    """Whether feet may stand there, shape (N,)."""
    hit: BoolArray
    """Whether there is terrain at all; where not, the height is the fallback's, shape (N,)."""


class Ground:
    """Vertical height query on a terrain, exact to 1e-9 m, with any number of levels above one another.

    Holds the triangles as a Warp mesh, so it is built once and does not travel between processes.

    Args:
        terrain: Triangles in the canonical world; without meshes the ground is the fallback plane.
        fallback_height: Height of the plane that stands in where there is no terrain [m].
        device: Warp device of the query.

    Attributes:
        faces: What kernels ask for the ground (`find_level`), around `centre`; None without any.
        centre: Of the mesh [m], shape (3,).
    """

    def __init__(self, terrain: Terrain, *, fallback_height: float = 0.0, device: str = "cpu") -> None:
        self.fallback_height = fallback_height
        self.device = device
        self.has_terrain = bool(terrain.meshes)
        corners = np.asarray(terrain.points, dtype=float)[terrain.triangles]  # (T, 3, 3)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        level = np.abs(normals[:, 1]) > FLATTEST_NORMAL * np.maximum(lengths, np.finfo(float).tiny)
        walkable = np.asarray(terrain.walkable, dtype=bool)[terrain.mesh_indices]
        faces = np.flatnonzero(level)
        faces = faces[np.argsort(~walkable[faces], kind="stable")]  # where two faces coincide the first is the ground
        upward = normals[faces] * (np.sign(normals[faces, 1]) / lengths[faces])[:, None]
        self._walkable = np.append(walkable[faces], False)  # the last, which face -1 is, stands for the fallback plane
        self._normals = np.vstack([upward, [0.0, 1.0, 0.0]])
        self.faces: Any = None
        if len(faces):
            self._build_mesh(corners[faces])

    def falling_back(self, height: float) -> Ground:
        """The same terrain, whose mesh it shares, with another fallback plane [m]."""
        ground = copy.copy(self)
        ground.fallback_height = height
        return ground

    def heights(self, points: FloatArray, near: FloatArray, *, step_up: float = 0.5) -> GroundSample:
        """The ground below or, failing that, above each point.

        Args:
            points: Ground points (x, z) [m], shape (N, 2).
            near: Height the foot comes from [m], shape (N,).
            step_up: The ground is the highest level at or below `near + step_up` [m]; with none there, the lowest
                above it.

        Returns:
            The sample; off the terrain it is the fallback plane, neither hit nor walkable, but both if there is no
            terrain at all.
        """
        limits = np.broadcast_to(np.asarray(near, dtype=float) + step_up, (len(points),))
        if self.faces is None or not len(points):
            return self._level(len(points))
        found, faces = self._query(find_ground, len(points), [self.around_centre(points, limits)])
        return self._on_faces(found, faces)

    def follow(self, points: FloatArray, near: FloatArray, *, first: IntArray, step_up: float = 0.5) -> GroundSample:
        """The ground along ways, each keeping to the level it begins on.

        The level of a point is the highest at most `step_up` above the point before it, so a way goes up the spiral
        stairs and over or under the bridge as a walker would. A drop or rise of more than `step_up` is a gap: behind it
        the level before it is looked for again.

        Args:
            points: Densely sampled ways one after the other, (x, z) [m], shape (N, 2).
            near: Heights the ways are drawn at [m], shape (N,); those of first points choose the level.
            first: Index of each way's first point, shape (P + 1,), increasing; the last entry is N.
            step_up: Highest step along the way [m].

        Returns:
            The ground; where a way has left the terrain, at the height it had before.
        """
        if self.faces is None or not len(points):
            sample, drawn = self._level(len(points)), np.repeat(near[first[:-1]], np.diff(first))
            return replace(sample, heights=drawn) if self.has_terrain else sample
        ways: Any = wp.array(first.astype(np.int32), dtype=wp.int32, device=self.device)
        found, faces = self._query(
            follow_ground, len(first) - 1, [self.around_centre(points, near), ways, wp.float64(step_up)]
        )
        return replace(self._on_faces(found, faces), heights=found + self.centre[1])

    def _level(self, count: int) -> GroundSample:
        """The fallback plane at so many points."""
        hit = np.full(count, not self.has_terrain)
        heights, normals = np.full(count, float(self.fallback_height)), np.tile([0.0, 1.0, 0.0], (count, 1))
        return GroundSample(heights=heights, normals=normals, walkable=hit.copy(), hit=hit)

    def _on_faces(self, found: FloatArray, faces: IntArray) -> GroundSample:
        """The sample at heights (N,) above the mesh's centre, on faces (N,); -1 = it is the fallback plane."""
        hit = faces >= 0
        heights = np.where(hit, found + self.centre[1], self.fallback_height)
        return GroundSample(heights=heights, normals=self._normals[faces], walkable=self._walkable[faces], hit=hit)

    def around_centre(self, points: FloatArray, heights: FloatArray) -> Any:
        """Ground points (N, 2) at heights (N,) as a Warp array of the places kernels ask `faces` about."""
        places = np.column_stack([points[:, 0], heights, points[:, 1]]) - self.centre
        return wp.array(places, dtype=wp.vec3d, device=self.device)

    def _build_mesh(self, corners: FloatArray) -> None:
        """The Warp mesh of triangles (T, 3, 3), around its own centre since its search tree is float32."""
        start_warp()
        lowest, highest = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.centre = 0.5 * (lowest + highest)
        vertices = (corners - self.centre).reshape(-1, 3)
        self._mesh = wp.Mesh(
            points=wp.array(vertices.astype(np.float32), dtype=wp.vec3, device=self.device),
            indices=wp.array(np.arange(len(vertices), dtype=np.int32), dtype=wp.int32, device=self.device),
        )
        self.faces = GroundFaces()
        self.faces.mesh = self._mesh.id
        self.faces.corners = wp.array(vertices, dtype=wp.vec3d, device=self.device)
        self.faces.normals = wp.array(self._normals[:-1], dtype=wp.vec3d, device=self.device)
        self.faces.walkable = wp.array(self._walkable[:-1], dtype=wp.bool, device=self.device)
        self.faces.margin = 1e-5 + 2.0 * float(np.finfo(np.float32).eps) * float(np.max(highest - lowest))

    def _query(self, kernel: Any, threads: int, places: list[Any]) -> tuple[FloatArray, IntArray]:
        """Heights above the mesh's centre and faces (-1 = none) that a kernel finds at places, shape (N,)."""
        count = len(places[0])
        heights = wp.empty(count, dtype=wp.float64, device=self.device)
        faces = wp.empty(count, dtype=wp.int32, device=self.device)
        wp.launch(kernel, dim=threads, inputs=[self.faces, *places], outputs=[heights, faces], device=self.device)
        return heights.numpy(), faces.numpy()
