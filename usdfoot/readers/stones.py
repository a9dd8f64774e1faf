"""Stones: footholds of a stage, from its terrain, from meshes or from points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.model.terrain import Terrain
from usdfoot.planning.crossings import Stones
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.stone_tops import given_stones, stones_on
from usdfoot.readers.attributes import array_at
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import start_code

__all__ = ["read_stones"]


def read_stones(
    stage: Usd.Stage, units: StageUnits, terrain: Terrain, *, pattern: str | None, body: Proportions, spacing: float
) -> Stones:
    """Footholds: the tops of the terrain's walkable meshes, or of what a glob names: meshes of it, Points, instances.

    Args:
        stage: Open stage, read at its start.
        units: Its units.
        terrain: As read.
        pattern: Glob on prim paths; None = the whole terrain.
        body: Whose feet.
        spacing: Of footholds on meshes [m].

    Raises:
        SceneError: If the glob names nothing that can be stood on.
        PlanError: If a mesh is too large for the spacing or nothing can be stood on.
    """
    if pattern is None:
        return stones_on(terrain, body=body, spacing=spacing)
    chosen = np.array([fnmatchcase(path, pattern) for path in terrain.meshes], dtype=bool)
    scattered = set(terrain.meshes)
    prims = [prim for prim in _point_prims(stage, pattern) if str(prim.GetPath()) not in scattered]
    parts = [_points_of(stage, prim, units, terrain, body) for prim in prims]
    if chosen.any():
        parts.append(stones_on(replace(terrain, walkable=terrain.walkable & chosen), body=body, spacing=spacing))
    if not parts:
        raise SceneError(pattern, "names no terrain mesh, Points or PointInstancer", "give a glob of their prim paths")
    return Stones(
        name=pattern,
        positions=np.concatenate([part.positions for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        discomforts=np.concatenate([part.costs for part in parts]),
    )


def _point_prims(stage: Usd.Stage, pattern: str) -> Sequence[Usd.Prim]:
    """Points and PointInstancers of that path, in stage order."""
    return [
        prim
        for prim in stage.Traverse(Usd.TraverseInstanceProxies())
        if (prim.IsA(UsdGeom.Points) or prim.IsA(UsdGeom.PointInstancer)) and fnmatchcase(str(prim.GetPath()), pattern)
    ]


def _points_of(stage: Usd.Stage, prim: Usd.Prim, units: StageUnits, terrain: Terrain, body: Proportions) -> Stones:
    """A foothold at every point, on its normal or on that of the terrain."""
    name = "points" if prim.IsA(UsdGeom.Points) else "positions"
    values = np.array(array_at(prim.GetAttribute(name), start_code(stage)), dtype=float).reshape(-1, 3)
    matrix = matrices_of(prim, np.array([start_code(stage).GetValue()]))[0]
    positions = units.points_to_canonical(values @ matrix[:3, :3] + matrix[3, :3])
    normals = _normals(prim, len(values), start_code(stage))
    if normals is not None:
        normals = units.directions_to_canonical(normals @ np.linalg.inv(matrix[:3, :3]).T)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    return given_stones(str(prim.GetPath()), positions, normals, terrain=terrain, body=body)


def _normals(prim: Usd.Prim, count: int, time: Usd.TimeCode) -> FloatArray | None:
    """The normals of Points in their own space, shape (N, 3); None where it has not one that is none for each."""
    if not prim.IsA(UsdGeom.Points):
        return None
    normals = np.array(array_at(prim.GetAttribute("normals"), time), dtype=float).reshape(-1, 3)
    usable = len(normals) == count and np.isfinite(normals).all() and bool(normals.any(axis=1).all())
    return normals if usable else None
