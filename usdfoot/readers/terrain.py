"""Terrain: the meshes feet stand on, as triangles in the canonical world."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, TerrainError
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.readers.attributes import size_at
from usdfoot.readers.hidden import hidden_below, is_hidden
from usdfoot.readers.instanced_meshes import SOLIDS, PlacedMesh, is_scattered, meshes_in_place, placed_meshes
from usdfoot.readers.mesh_triangles import read_triangles
from usdfoot.readers.plans import is_plan
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.skins import inherited_target
from usdfoot.readers.stage import StagePrims
from usdfoot.readers.transform_codes import changes_place, changes_value

__all__ = ["read_terrain"]

_logger = logging.getLogger(__name__)

_NAMES = ("ground", "terrain")


def read_terrain(
    stage: Usd.Stage, prims: StagePrims, units: StageUnits, *, limits: Limits = DEFAULT_LIMITS
) -> tuple[Terrain, tuple[Problem, ...]]:
    """Triangles of the terrain at the stage's start, and what could not be used.

    Terrain are the meshes, cubes and planes with UsdfootTerrainAPI on them or on a prim above, and the meshes of
    PointInstancers with it, each instance one mesh; without any, the meshes whose own or parent's name contains ground
    or terrain. Skinned meshes are characters. Subdivision is ignored: the control cage counts. Meshes of purpose proxy
    stand for those of purpose render: where there are both, they are left out. So are invisible meshes and guides, but
    for those marked as terrain themselves, or with all that is marked with them, and named ones where no other is.

    Raises:
        SceneError: If it has more triangles than the limits allow.
    """
    marked = prims.with_apis.get(Schema.TERRAIN, ())
    meshes = [mesh for mesh in prims.meshes if not _is_skinned(mesh)]
    shapes = [shape for shape in prims.shapes if not marked or _marked_by(shape)]
    solids = [shape for shape in shapes if marked and shape.GetTypeName() in SOLIDS]
    meant = [*(mesh for mesh in meshes if _marked_by(mesh)), *solids] if marked else _named(meshes)
    chosen, doubts = _shown(meant, by_name=not marked)
    chosen = _without_proxies(chosen)
    outermost = [prim for prim in prims.instancers if marked and not is_plan(prim) and not is_scattered(prim)]
    scattered = [prim for prim in outermost if _marked_by(prim)]
    if not marked and chosen:
        _logger.info("no UsdfootTerrainAPI, terrain by name: %s", ", ".join(str(mesh.GetPath()) for mesh in chosen))
    transforms = StartTransforms(stage)
    problems = _without_meshes(marked, [*meshes, *solids, *scattered])
    problems += [*(_unread(shapes, problems) if marked else [] if chosen else _shapes_named(shapes)), *doubts]
    astray = _astray([*chosen, *scattered], transforms)
    problems += astray.values()
    chosen, scattered = ([prim for prim in found if prim not in astray] for found in (chosen, scattered))
    problems += _moving([*chosen, *scattered], transforms)
    placed = meshes_in_place(chosen, transforms)
    for instancer in scattered:
        try:
            placed += placed_meshes(stage, instancer, limits=limits)
        except TerrainError as error:
            problems.append(Problem(severity="error", where=str(instancer.GetPath()), message=str(error)))
    _check_size(placed, limits)
    terrain, found = read_triangles(stage, placed, units)
    return terrain, (*problems, *found)


def _marked_by(prim: Usd.Prim) -> Usd.Prim | None:
    """The nearest prim with UsdfootTerrainAPI, a mesh or above it; from above a SkelRoot what is in it is not meant."""
    while prim and not prim.IsPseudoRoot():
        if has_api(prim, Schema.TERRAIN):
            return prim
        if prim.IsA(UsdSkel.Root):
            return None
        prim = prim.GetParent()
    return None


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


def _shown(prims: Sequence[Usd.Prim], *, by_name: bool) -> tuple[list[Usd.Prim], list[Problem]]:
    """Those to stand on although some are hidden, and a word on these."""
    hidden = [prim for prim in prims if is_hidden(prim)] if by_name else hidden_below(prims, _marked_by)
    if not hidden:
        return list(prims), []
    is_all = by_name and len(hidden) == len(prims)
    paths = {prim.GetPath() for prim in hidden}
    what = "hidden (invisible or guides)"
    said = f"{what}, and the ground by name. rename what is none" if is_all else f"{what}, and so left out as ground"
    remedy = "" if is_all else f". show it, or apply {Schema.TERRAIN} to the mesh itself"
    where = str(hidden[0].GetPath())
    message = f"{where}: {_count(hidden)} {said}{remedy}"
    left = [prim for prim in prims if is_all or prim.GetPath() not in paths]
    return left, [Problem(severity="warning", where=where, message=message)]


def _count(prims: Sequence[Usd.Prim]) -> str:
    return "is" if len(prims) == 1 else f"and {len(prims) - 1} more are"


def _unread(shapes: Sequence[Usd.Prim], named: Sequence[Problem]) -> list[Problem]:
    """A warning for each type of marked shapes that cannot be stood on, where what marks them is not named already."""
    barren = {problem.where for problem in named}
    by_type: dict[str, list[Usd.Prim]] = {}
    for shape in shapes:
        marked = _marked_by(shape)
        if shape.GetTypeName() not in SOLIDS and marked and str(marked.GetPath()) not in barren:
            by_type.setdefault(shape.GetTypeName(), []).append(shape)
    found = []
    for kind, several in by_type.items():
        where = str(several[0].GetPath())
        message = f"{where}: {_count(several)} marked as terrain, but feet pass through a {kind}. convert it to a Mesh"
        found.append(Problem(severity="warning", where=where, message=message))
    return found


def _shapes_named(shapes: Sequence[Usd.Prim]) -> list[Problem]:
    """A warning for each shape that is the ground by its name, where no mesh is."""
    reason = "is no mesh, so the ground is taken to be the plane through the lowest footstep"
    found = []
    for shape in _named(shapes):
        path, kind = shape.GetPath(), shape.GetTypeName()
        remedy = f"apply {Schema.TERRAIN} to it" if kind in SOLIDS else "convert it to a Mesh"
        found.append(Problem(severity="warning", where=str(path), message=f"{path}: a {kind} {reason}. {remedy}"))
    return found


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


def _astray(prims: Sequence[Usd.Prim], transforms: StartTransforms) -> dict[Usd.Prim, Problem]:
    """What is wrong with each prim of which USD cannot say where it is."""
    found = {}
    for prim in prims:
        try:
            transforms.matrix_of(prim)
        except SceneError as error:
            found[prim] = Problem(severity="error", where=error.where, message=str(error))
    return found


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


def _check_size(meshes: Sequence[PlacedMesh], limits: Limits) -> None:
    """Raises SceneError if meshes have too many triangles together; a face of n corners has n - 2 at most.

    Faces count as one each even without corners: a small file can hold billions of those.
    """
    count = 0
    for placed in meshes:
        mesh = UsdGeom.Mesh(placed.prim)
        if not mesh:
            continue
        corners = size_at(mesh.GetFaceVertexIndicesAttr(), Usd.TimeCode.EarliestTime())
        faces = size_at(mesh.GetFaceVertexCountsAttr(), Usd.TimeCode.EarliestTime())
        count += max(faces, corners - 2 * faces) * len(placed.matrices)
        check_limit(placed.paths[0], "triangles", count, limit=limits.triangles)
