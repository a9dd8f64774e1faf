"""Instanced meshes: those a PointInstancer scatters, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.errors import TerrainError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.readers.stage import start_code

__all__ = ["PlacedMesh", "is_scattered", "placed_meshes"]


@dataclass(frozen=True, kw_only=True)
class PlacedMesh:
    """A mesh and all places where it is."""

    prim: Usd.Prim
    """The mesh."""
    instancer: Usd.Prim
    """The outermost PointInstancer that scatters it, or the mesh itself, which is in one place."""
    matrices: FloatArray
    """From the mesh's space to the world (row vectors), shape (K, 4, 4)."""


def is_scattered(prim: Usd.Prim) -> bool:
    """Whether a prim is below a PointInstancer: where it is, it is not shown."""
    above = prim.GetParent()
    while above and not above.IsA(UsdGeom.PointInstancer):
        above = above.GetParent()
    return bool(above)


def placed_meshes(stage: Usd.Stage, instancer: Usd.Prim, *, limits: Limits = DEFAULT_LIMITS) -> list[PlacedMesh]:
    """The meshes of a PointInstancer's prototypes where they are at the stage's start, without those hidden.

    Where a prototype is or holds a PointInstancer, what that scatters is in each place of the prototype.

    Raises:
        TerrainError: If its arrays do not match, a prototype is missing, it scatters itself, or it shows no mesh.
        SceneError: If a prototype is in more places than the limits allow triangles.
    """
    to_world = np.array(UsdGeom.XformCache(start_code(stage)).GetLocalToWorldTransform(instancer))
    found = _scattered(stage, (instancer,), to_world[None], limits)
    if not found:
        what = "shows no mesh of its prototypes"
        raise TerrainError(instancer.GetPath(), what, "give it meshes, or remove UsdfootTerrainAPI")
    return found


def _scattered(
    stage: Usd.Stage, instancers: tuple[Usd.Prim, ...], places: FloatArray, limits: Limits
) -> list[PlacedMesh]:
    """The meshes that the last of instancers, each scattered by the one before, scatters from its places (K, 4, 4)."""
    cache, found = UsdGeom.XformCache(start_code(stage)), []
    kinds, prototypes, instances = _instances(stage, instancers[-1])
    for kind, prototype in enumerate(prototypes):
        own = instances[kinds == kind]
        check_limit(instancers[-1].GetPath(), "triangles", len(own) * len(places), limit=limits.triangles)
        own = (own @ places[:, None]).reshape(-1, 4, 4)
        below = iter(Usd.PrimRange(prototype, Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)))
        for prim in below if len(own) else ():
            inside = np.array(cache.ComputeRelativeTransform(prim, prototype)[0]) @ own
            if prim in instancers:
                raise TerrainError(
                    instancers[-1].GetPath(), f"scatters {prim.GetPath()} and so itself", "break the circle"
                )
            if prim.IsA(UsdGeom.PointInstancer):
                found += _scattered(stage, (*instancers, prim), inside, limits)
                below.PruneChildren()
            elif prim.IsA(UsdGeom.Mesh):
                found.append(PlacedMesh(prim=prim, instancer=instancers[0], matrices=inside))
    return found


def _instances(stage: Usd.Stage, instancer: Usd.Prim) -> tuple[IntArray, list[Usd.Prim], FloatArray]:
    """Prototype of each instance that is shown (K,), the prototypes, and where the instances are (K, 4, 4).

    Raises:
        TerrainError: If its arrays do not match, or a prototype is missing.
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
    shown = np.array(schema.ComputeMaskAtTime(code) or np.ones(len(kinds)), dtype=bool)
    return kinds[shown], prototypes, np.array(placed, dtype=float).reshape(-1, 4, 4)[shown]
