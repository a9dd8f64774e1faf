"""Terrain: the meshes feet stand on, as triangles in the canonical world."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import TerrainError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.readers.instanced_meshes import PlacedMesh, is_scattered, meshes_in_place, placed_meshes
from usdfoot.readers.plans import is_plan
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.skins import inherited_target
from usdfoot.readers.stage import StagePrims, start_code
from usdfoot.readers.transform_codes import changes_place, changes_value
from usdfoot.readers.triangles import cut_polygons

__all__ = ["no_terrain", "read_terrain"]

_logger = logging.getLogger(__name__)

_NAMES = ("ground", "terrain")
_SOLIDS = ("Cube", "Plane")
"""Types of shapes that are read as meshes where they have UsdfootTerrainAPI."""
_THINNEST = 1e-12
"""Triangles of a smaller area [m2] are dropped."""


@dataclass(frozen=True, kw_only=True)
class _MeshTriangles:
    """Triangles of one mesh in K places, each a mesh of its own."""

    paths: tuple[str, ...]
    """In each place."""
    points: FloatArray
    """World positions [m], shape (K, P, 3)."""
    triangles: IntArray
    """Indices into all K * P points, shape (T, 3)."""
    places: IntArray
    """Of each triangle, shape (T,)."""
    walkable: bool
    lost: int = 0
    """Faces left out, as they have corners that are not finite."""


def read_terrain(
    stage: Usd.Stage, prims: StagePrims, units: StageUnits, *, limits: Limits = DEFAULT_LIMITS
) -> tuple[Terrain, tuple[Problem, ...]]:
    """Triangles of the terrain at the stage's start, and what could not be used.

    Terrain are the meshes, cubes and planes with UsdfootTerrainAPI on them or on a prim above, and the meshes of
    PointInstancers with it, each instance one mesh; without any, the meshes whose own or parent's name contains ground
    or terrain. Skinned meshes are characters. Subdivision is ignored: the control cage counts. Meshes of purpose proxy
    stand for those of purpose render: where there are both, they are left out.

    Raises:
        SceneError: If it has more triangles than the limits allow.
    """
    marked = prims.with_apis.get(Schema.TERRAIN, ())
    meshes = [mesh for mesh in prims.meshes if not _is_skinned(mesh)]
    solids = [shape for shape in prims.shapes if marked and shape.GetTypeName() in _SOLIDS and _is_marked(shape)]
    chosen = _without_proxies([*(mesh for mesh in meshes if _is_marked(mesh)), *solids] if marked else _named(meshes))
    outermost = [prim for prim in prims.instancers if marked and not is_plan(prim) and not is_scattered(prim)]
    scattered = [prim for prim in outermost if _is_marked(prim)]
    if not marked and chosen:
        _logger.info("no UsdfootTerrainAPI, terrain by name: %s", ", ".join(str(mesh.GetPath()) for mesh in chosen))
    parts, transforms = [], StartTransforms(stage)
    problems = [*_without_meshes(marked, [*meshes, *solids, *scattered]), *_moving([*chosen, *scattered], transforms)]
    if not marked and not chosen:
        problems += _shapes_named(prims.shapes)
    placed = meshes_in_place(chosen, transforms)
    for instancer in scattered:
        try:
            placed += placed_meshes(stage, instancer, limits=limits)
        except TerrainError as error:
            problems.append(Problem(severity="error", where=str(instancer.GetPath()), message=str(error)))
    _check_size(placed, limits)
    for mesh in placed:
        try:
            parts.append(_read_mesh(stage, mesh, units))
            problems += _with_holes(parts[-1])
        except TerrainError as error:
            problems.append(Problem(severity="error", where=str(mesh.prim.GetPath()), message=str(error)))
    return _joined(parts), tuple(problems)


def no_terrain() -> Terrain:
    """Terrain without meshes."""
    return _joined([])


def _joined(parts: Sequence[_MeshTriangles]) -> Terrain:
    counts = [len(part.points) for part in parts]
    points = [part.points.reshape(-1, 3) for part in parts]
    starts, firsts = np.cumsum([0, *map(len, points)]), np.cumsum([0, *counts])
    triangles = [part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)]
    meshes = [part.places + first for part, first in zip(parts, firsts[:-1], strict=True)]
    return Terrain(
        meshes=tuple(path for part in parts for path in part.paths),
        points=np.concatenate([np.zeros((0, 3)), *points]),
        triangles=np.concatenate([np.zeros((0, 3), dtype=int), *triangles]),
        mesh_indices=np.concatenate([np.zeros(0, dtype=int), *meshes]),
        walkable=np.repeat(np.array([part.walkable for part in parts], dtype=bool), counts),
    )


def _read_mesh(stage: Usd.Stage, placed: PlacedMesh, units: StageUnits) -> _MeshTriangles:
    """Its triangles in each place where they have area, without those of faces that have corners that are not finite.

    Raises:
        TerrainError: If there are none, or what is authored is inconsistent.
    """
    prim = placed.prim
    where = prim.GetPath()
    points, counts, indices, holes = _polygons(stage, prim)
    remedy = "give the mesh points and faces, or remove UsdfootTerrainAPI from it"
    if not len(points) or not len(counts):
        raise TerrainError(where, f"is an empty mesh ({len(points)} points, {len(counts)} faces)", remedy)
    strays = counts.min() < 0 or indices.min(initial=0) < 0 or indices.max(initial=0) >= len(points)
    if strays or counts.sum() != len(indices):
        raise TerrainError(where, "has faces that do not match its points", "repair faceVertexCounts and -Indices")
    is_finite = np.all(np.isfinite(points), axis=1)
    lost = np.unique(np.repeat(np.arange(len(counts)), counts)[~is_finite[indices]])
    if len(lost) == len(counts) or not np.isfinite(placed.matrices).all():
        raise TerrainError(where, "has points that are not finite", "repair the mesh")
    points = np.where(is_finite[:, None], points, points[np.argmax(is_finite)])
    triangles = cut_polygons(points, counts, indices, holes=np.concatenate([holes, lost]))
    linear, shifts = placed.matrices[:, :3, :3], placed.matrices[:, 3:, :3]
    world = units.points_to_canonical(points @ linear + shifts)  # (K, P, 3)
    turned = (np.linalg.det(linear) < 0.0) != _is_flipped(UsdGeom.Gprim(prim))
    has_area = _areas(world, triangles) > _THINNEST  # (K, T)
    shown = np.any(has_area, axis=1)  # instances are often hidden by a scale of zero
    if not shown.any():
        raise TerrainError(where, "has only faces without area", remedy)
    faces = np.where(turned[shown, None, None], triangles[:, [0, 2, 1]], triangles)
    faces += len(points) * np.arange(len(faces))[:, None, None]
    return _MeshTriangles(
        paths=tuple(path for path, is_shown in zip(placed.paths, shown.tolist(), strict=True) if is_shown),
        points=world[shown],
        triangles=faces[has_area[shown]],
        places=np.nonzero(has_area[shown])[0],
        walkable=placed.walkable,
        lost=len(lost),
    )


def _with_holes(part: _MeshTriangles) -> list[Problem]:
    """A warning where faces of a mesh are left out."""
    path = part.paths[0]
    message = f"{path}: {part.lost} of its faces have points that are not finite and are left out. repair the mesh"
    return [Problem(severity="warning", where=path, message=message)] if part.lost else []


def _polygons(stage: Usd.Stage, prim: Usd.Prim) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Points (P, 3) in the prim's space, corners of each face, points of the corners, and the faces that are holes."""
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        points = np.array(_value(mesh.GetPointsAttr(), stage), dtype=float).reshape(-1, 3)
        attributes = mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetHoleIndicesAttr()
        counts, indices, holes = (np.array(_value(attribute, stage), dtype=int) for attribute in attributes)
        return points, counts, indices, holes
    corners = _corners(stage, prim)
    return corners.reshape(-1, 3), np.full(len(corners), 4), np.arange(corners.size // 3), np.zeros(0, dtype=int)


def _corners(stage: Usd.Stage, prim: Usd.Prim) -> FloatArray:
    """Corners of the faces of a cube or plane, counterclockwise from outside, shape (faces, 4, 3)."""
    axes = np.eye(3)
    if prim.IsA(UsdGeom.Cube):
        half = np.full(3, 0.5 * float(UsdGeom.Cube(prim).GetSizeAttr().Get(start_code(stage))))
        normals = np.concatenate([axes, -axes])
    else:
        plane = UsdGeom.Plane(prim)
        normal = "XYZ".index(str(plane.GetAxisAttr().Get()))
        width, length = (float(a.Get(start_code(stage))) for a in (plane.GetWidthAttr(), plane.GetLengthAttr()))
        half = 0.5 * np.array([(0.0, length, width), (width, 0.0, length), (width, length, 0.0)][normal])
        normals = axes[[normal]]
    across = np.roll(normals, 1, axis=1)
    along = np.cross(normals, across)
    corners = [normals - across - along, normals + across - along, normals + across + along, normals - across + along]
    return np.stack(corners, axis=1) * half


def _is_flipped(mesh: UsdGeom.Gprim) -> bool:
    return mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded


def _areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Areas of triangles (T, 3) of points in K places (K, P, 3), shape (K, T)."""
    a, b, c = (points[:, triangles[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1)


def _is_marked(prim: Usd.Prim) -> bool:
    """Whether a mesh or a prim above it has UsdfootTerrainAPI; from above a SkelRoot what is in it is not meant."""
    while prim and not prim.IsPseudoRoot():
        if has_api(prim, Schema.TERRAIN):
            return True
        if prim.IsA(UsdSkel.Root):
            return False
        prim = prim.GetParent()
    return False


def _named(prims: Sequence[Usd.Prim]) -> list[Usd.Prim]:
    """Prims named ground or terrain, themselves or by the transform above them, as Blender writes them."""

    def is_named(prim: Usd.Prim) -> bool:
        return any(name in prim.GetName().lower() for name in _NAMES)

    return [prim for prim in prims if is_named(prim) or is_named(prim.GetParent())]


def _without_proxies(prims: Sequence[Usd.Prim]) -> list[Usd.Prim]:
    """Those that are no proxies, or all where none is rendered instead of a proxy."""
    purposes = [UsdGeom.Imageable(prim).ComputePurpose() for prim in prims]
    if not {UsdGeom.Tokens.proxy, UsdGeom.Tokens.render} <= set(purposes):
        return list(prims)
    return [prim for prim, purpose in zip(prims, purposes, strict=True) if purpose != UsdGeom.Tokens.proxy]


def _shapes_named(shapes: Sequence[Usd.Prim]) -> list[Problem]:
    """A warning for each shape that is the ground by its name, where no mesh is."""
    reason = "is no mesh, so the ground is taken to be the plane through the lowest footstep. convert it to a Mesh"
    return [
        Problem(
            severity="warning",
            where=str(shape.GetPath()),
            message=f"{shape.GetPath()}: a {shape.GetTypeName()} {reason}",
        )
        for shape in _named(shapes)
    ]


def _without_meshes(marked: Sequence[Usd.Prim], meshes: Sequence[Usd.Prim]) -> list[Problem]:
    """A problem for each marked prim with no mesh at or below it."""
    problems = []
    for prim in marked:
        if not any(mesh.GetPath().HasPrefix(prim.GetPath()) for mesh in meshes):
            error = TerrainError(
                prim.GetPath(),
                "has UsdfootTerrainAPI but no mesh, cube or plane at or below it",
                "convert it to a Mesh",
            )
            problems.append(Problem(severity="error", where=error.where, message=str(error)))
    return problems


def _moving(prims: Sequence[Usd.Prim], transforms: StartTransforms) -> list[Problem]:
    """A warning for each prim that moves or changes its shape."""
    remedy = "feet keep to where it is at the stage's start. let a terrain stand still"
    return [
        Problem(
            severity="warning", where=str(prim.GetPath()), message=f"{prim.GetPath()}: is terrain that moves, {remedy}"
        )
        for prim in prims
        if (transforms.is_moving(prim) and changes_place(prim))
        or (prim.IsA(UsdGeom.PointBased) and changes_value(UsdGeom.PointBased(prim).GetPointsAttr()))
    ]


def _is_skinned(prim: Usd.Prim) -> bool:
    return inherited_target(prim, "skel:skeleton") is not None


def _value(attribute: Usd.Attribute, stage: Usd.Stage) -> object:
    value = attribute.Get(start_code(stage))
    return () if value is None else value


def _check_size(meshes: Sequence[PlacedMesh], limits: Limits) -> None:
    """Raises SceneError if meshes have too many triangles together; a face of n corners has n - 2 at most.

    Faces count as one each even without corners: a small file can hold billions of those.
    """
    count = 0
    for placed in meshes:
        mesh = UsdGeom.Mesh(placed.prim)
        if not mesh:
            continue
        corners = mesh.GetFaceVertexIndicesAttr().Get(Usd.TimeCode.EarliestTime()) or ()
        faces = mesh.GetFaceVertexCountsAttr().Get(Usd.TimeCode.EarliestTime()) or ()
        count += max(len(faces), len(corners) - 2 * len(faces)) * len(placed.matrices)
        check_limit(placed.paths[0], "triangles", count, limit=limits.triangles)
