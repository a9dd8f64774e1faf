"""Instanced meshes: those that instances share or a PointInstancer scatters, and where."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from usdfoot.bridge.tokens import Terrain as Token
from usdfoot.errors import TerrainError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.readers.attributes import array_at, check_own_array
from usdfoot.readers.authored import authored
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.stage import start_code
from usdfoot.readers.transform_faults import place_fault

__all__ = ["SOLIDS", "PlacedMesh", "is_scattered", "meshes_in_place", "placed_meshes"]

SOLIDS = ("Cube", "Plane")
"""Types of shapes that are read as meshes where they have UsdfootTerrainAPI."""


@dataclass(frozen=True, kw_only=True)
class PlacedMesh:
    """A mesh and all places where it is."""

    prim: Usd.Prim
    """The mesh, in the first of them."""
    paths: tuple[str, ...]
    """Its path in each of K places, or that of the outermost PointInstancer that scatters it."""
    matrices: FloatArray
    """From the mesh's space to the world (row vectors), shape (K, 4, 4)."""
    walkable: bool
    """Whether feet may stand on it."""


def meshes_in_place(prims: Sequence[Usd.Prim], transforms: StartTransforms) -> list[PlacedMesh]:
    """Meshes or other shapes where they are at the stage's start, those of instances that share a prototype as one."""
    walkability = _Walkability()
    found: dict[tuple[Sdf.Path, bool], list[tuple[Usd.Prim, FloatArray]]] = {}
    for prim in prims:
        matrix = transforms.matrix_of(prim)
        is_shared = prim.IsInstanceProxy() and np.isfinite(matrix).all()  # one that is not finite is its own problem
        shared = prim.GetPrimInPrototype() if is_shared else prim
        found.setdefault((shared.GetPath(), walkability.of(prim, prim)), []).append((prim, matrix))
    return [
        PlacedMesh(
            prim=members[0][0],
            paths=tuple(str(prim.GetPath()) for prim, _ in members),
            matrices=np.stack([matrix for _, matrix in members]),
            walkable=walkable,
        )
        for (_, walkable), members in found.items()
    ]


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
        TerrainError: If its arrays do not match, a prototype is missing or cannot be placed, it scatters itself, or it
            shows no mesh.
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
            with _placing(prim):
                inside = np.array(cache.ComputeRelativeTransform(prim, prototype)[0]) @ own
            if prim in instancers:
                raise TerrainError(
                    instancers[-1].GetPath(), f"scatters {prim.GetPath()} and so itself", "break the circle"
                )
            if prim.IsA(UsdGeom.PointInstancer):
                found += _scattered(stage, (*instancers, prim), inside, limits)
                below.PruneChildren()
            elif prim.IsA(UsdGeom.Mesh) or prim.GetTypeName() in SOLIDS:
                paths = (str(instancers[0].GetPath()),) * len(inside)
                walkable = _Walkability().of(prim, instancers[0])
                found.append(PlacedMesh(prim=prim, paths=paths, matrices=inside, walkable=walkable))
    return found


@contextmanager
def _placing(prim: Usd.Prim) -> Iterator[None]:
    """Raises TerrainError if USD cannot say where a prim of a prototype is."""
    try:
        yield
    except Tf.ErrorException as error:
        fault = place_fault(prim, error)
        raise TerrainError(fault.where, fault.what, fault.remedy) from error


class _Walkability:
    """Whether prims are walkable; each prim above them is asked once."""

    def __init__(self) -> None:
        self._said: dict[Sdf.Path, bool | None] = {}

    def of(self, mesh: Usd.Prim, instancer: Usd.Prim) -> bool:
        """The value authored nearest to the mesh, on itself or above, or else to its instancer; without, true."""
        said = self._nearest(mesh)
        said = self._nearest(instancer) if said is None else said
        return True if said is None else said

    def _nearest(self, prim: Usd.Prim) -> bool | None:
        if not prim or prim.IsPseudoRoot():
            return None
        path = prim.GetPath()
        if path not in self._said:
            value = authored(prim, Token.WALKABLE)
            self._said[path] = self._nearest(prim.GetParent()) if value is None else bool(value)
        return self._said[path]


def _instances(stage: Usd.Stage, instancer: Usd.Prim) -> tuple[IntArray, list[Usd.Prim], FloatArray]:
    """Prototype of each instance that is shown (K,), the prototypes, and where the instances are (K, 4, 4).

    Raises:
        TerrainError: If its arrays do not match, or a prototype is missing.
    """
    where, code, schema = instancer.GetPath(), start_code(stage), UsdGeom.PointInstancer(instancer)
    kinds = np.array(array_at(schema.GetProtoIndicesAttr(), code, error=TerrainError), dtype=int)
    prototypes = [stage.GetPrimAtPath(path) for path in schema.GetPrototypesRel().GetForwardedTargets()]
    if len(array_at(schema.GetPositionsAttr(), code, error=TerrainError)) != len(kinds):
        raise TerrainError(where, "has not as many positions as protoIndices", "repair the PointInstancer")
    if np.any((kinds < 0) | (kinds >= len(prototypes))) or not all(prototypes):
        raise TerrainError(where, "names prototypes that do not exist", "repair prototypes and protoIndices")
    for name in ("protoIndices", "positions", "orientations", "orientationsf", "scales"):
        check_own_array(instancer.GetAttribute(name), code, len(kinds), error=TerrainError)
    for prototype in filter(UsdGeom.Xformable, prototypes):
        with _placing(prototype):
            UsdGeom.Xformable(prototype).GetLocalTransformation(code)
    placed = schema.ComputeInstanceTransformsAtTime(
        code, code, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    if len(placed) != len(kinds):
        raise TerrainError(where, "has arrays that USD cannot combine", "repair the PointInstancer")
    shown = np.array(schema.ComputeMaskAtTime(code) or np.ones(len(kinds)), dtype=bool)
    return kinds[shown], prototypes, np.array(placed, dtype=float).reshape(-1, 4, 4)[shown]
