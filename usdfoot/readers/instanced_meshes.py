"""Instanced meshes: those a PointInstancer scatters, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.errors import TerrainError
from usdfoot.maths.types import FloatArray
from usdfoot.readers.stage import start_code

__all__ = ["PlacedMesh", "placed_meshes"]


@dataclass(frozen=True, kw_only=True)
class PlacedMesh:
    """A mesh and all places where it is."""

    prim: Usd.Prim
    """The mesh."""
    instancer: Usd.Prim
    """The PointInstancer that scatters it, or the mesh itself, which is in one place."""
    matrices: FloatArray
    """From the mesh's space to the world (row vectors), shape (K, 4, 4)."""


def placed_meshes(stage: Usd.Stage, instancer: Usd.Prim) -> list[PlacedMesh]:
    """The meshes of a PointInstancer's prototypes where they are at the stage's start, without those hidden.

    Raises:
        TerrainError: If its arrays do not match, a prototype is missing, or its prototypes have no mesh or are
            PointInstancers themselves.
    """
    where, code, schema = instancer.GetPath(), start_code(stage), UsdGeom.PointInstancer(instancer)
    kinds = np.array(schema.GetProtoIndicesAttr().Get(code) or (), dtype=int)
    prototypes = [stage.GetPrimAtPath(path) for path in schema.GetPrototypesRel().GetForwardedTargets()]
    if len(schema.GetPositionsAttr().Get(code) or ()) != len(kinds):
        raise TerrainError(where, "has not as many positions as protoIndices", "repair the PointInstancer")
    if np.any((kinds < 0) | (kinds >= len(prototypes))) or not all(prototypes):
        raise TerrainError(where, "names prototypes that do not exist", "repair prototypes and protoIndices")
    placed = schema.ComputeInstanceTransformsAtTime(
        code, code, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    if len(placed) != len(kinds):
        raise TerrainError(where, "has not as many orientations or scales as protoIndices", "repair the PointInstancer")
    cache = UsdGeom.XformCache(code)
    shown = np.array(schema.ComputeMaskAtTime(code) or np.ones(len(kinds)), dtype=bool)
    matrices = np.array(placed, dtype=float).reshape(-1, 4, 4) @ np.array(cache.GetLocalToWorldTransform(instancer))
    found = []
    for kind, prototype in enumerate(prototypes):
        own = matrices[shown & (kinds == kind)]
        for prim in Usd.PrimRange(prototype, Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)):
            if prim.IsA(UsdGeom.PointInstancer):
                raise TerrainError(where, f"scatters the PointInstancer {prim.GetPath()}", "give it meshes instead")
            if prim.IsA(UsdGeom.Mesh) and len(own):
                inside = np.array(cache.ComputeRelativeTransform(prim, prototype)[0])
                found.append(PlacedMesh(prim=prim, instancer=instancer, matrices=inside @ own))
    if not found:
        raise TerrainError(where, "shows no mesh of its prototypes", "give it meshes, or remove UsdfootTerrainAPI")
    return found
