"""Mesh triangles: meshes in their places as triangles in the canonical world, many meshes at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Sized
from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, TerrainError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.readers.attributes import array_at, axis_of, length_at
from usdfoot.readers.instanced_meshes import PlacedMesh
from usdfoot.readers.stage import start_code
from usdfoot.readers.triangles import cut_polygons

__all__ = ["read_triangles"]

_THINNEST = 1e-12
"""Triangles of a smaller area [m2] are dropped."""
_AT_ONCE = 1_000_000
"""Corners of meshes, in all of their places, from which on no further mesh is joined to them."""
_REMEDY = "give the mesh points and faces, or remove UsdfootTerrainAPI from it"


@dataclass(frozen=True, kw_only=True)
class _Polygons:
    """A mesh in its own space."""

    placed: PlacedMesh
    points: FloatArray
    """Shape (P, 3)."""
    counts: IntArray
    """Corners of each face, shape (F,)."""
    indices: IntArray
    """Point of each corner, all faces one after the other."""
    holes: IntArray
    """Faces to leave out."""
    fault: str = ""
    """Why it cannot be read."""


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Triangles of meshes in their places, as of a `Terrain`."""

    meshes: tuple[str, ...]
    points: FloatArray
    triangles: IntArray
    mesh_indices: IntArray
    walkable: BoolArray


def read_triangles(stage: Usd.Stage, placed: Sequence[PlacedMesh], units: StageUnits) -> tuple[Terrain, list[Problem]]:
    """Triangles of meshes in each place where they have area, and what is wrong with meshes.

    Meshes are looked at together, since there may be a hundred thousand of a few faces each. Left out are those that
    have an area nowhere or are inconsistent, and faces that have corners that are not finite.
    """
    parts: list[_Part] = []
    problems: list[Problem] = []
    for several in _batches(_polygons(stage, mesh) for mesh in placed):
        finite, wrong = _finite(several, _faults(several))
        good = [index for index in range(len(finite)) if index not in wrong or wrong[index].severity == "warning"]
        if good:
            part, flat = _in_places([finite[index] for index in good], units)
            parts.append(part)
            nowhere = [good[index] for index in flat]
            wrong |= {index: _error(several[index], "has only faces without area", _REMEDY) for index in nowhere}
        problems += [wrong[index] for index in sorted(wrong)]
    return _joined(parts), problems


def _batches(meshes: Iterator[_Polygons]) -> Iterator[list[_Polygons]]:
    """Meshes, as many at once as memory is for."""
    several, size = [], 0
    for mesh in meshes:
        several.append(mesh)
        size += (len(mesh.indices) + len(mesh.points)) * len(mesh.placed.paths)
        if size >= _AT_ONCE:
            yield several
            several, size = [], 0
    if several:
        yield several


def _polygons(stage: Usd.Stage, placed: PlacedMesh) -> _Polygons:
    """What is said of a mesh, a cube or a plane, nothing but its fault where it cannot be read."""
    try:
        return _read_polygons(stage, placed)
    except SceneError as error:
        none = np.zeros(0, dtype=int)
        return _Polygons(
            placed=placed, points=np.zeros((0, 3)), counts=none, indices=none, holes=none, fault=str(error)
        )


def _read_polygons(stage: Usd.Stage, placed: PlacedMesh) -> _Polygons:
    """Raises SceneError if an attribute is of another type than the schema's."""
    prim, code = placed.prim, start_code(stage)
    if not prim.IsA(UsdGeom.Mesh):
        corners = _corners(prim, code)
        return _Polygons(
            placed=placed,
            points=corners.reshape(-1, 3),
            counts=np.full(len(corners), 4),
            indices=np.arange(corners.size // 3),
            holes=np.zeros(0, dtype=int),
        )
    mesh = UsdGeom.Mesh(prim)
    attributes = mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetHoleIndicesAttr()
    counts, indices, holes = (np.array(array_at(attribute, code), dtype=int) for attribute in attributes)
    points = np.array(array_at(mesh.GetPointsAttr(), code), dtype=float).reshape(-1, 3)
    return _Polygons(placed=placed, points=points, counts=counts, indices=indices, holes=holes)


def _corners(prim: Usd.Prim, code: Usd.TimeCode) -> FloatArray:
    """Corners of the faces of a cube or plane, counterclockwise from outside, shape (faces, 4, 3)."""
    axes = np.eye(3)
    if prim.IsA(UsdGeom.Cube):
        half = np.full(3, 0.5 * length_at(UsdGeom.Cube(prim).GetSizeAttr(), code))
        normals = np.concatenate([axes, -axes])
    else:
        plane = UsdGeom.Plane(prim)
        normal = axis_of(prim)
        width, length = (length_at(own, code) for own in (plane.GetWidthAttr(), plane.GetLengthAttr()))
        half = 0.5 * np.array([(0.0, length, width), (width, 0.0, length), (width, length, 0.0)][normal])
        normals = axes[[normal]]
    across = np.roll(normals, 1, axis=1)
    along = np.cross(normals, across)
    corners = [normals - across - along, normals + across - along, normals + across + along, normals - across + along]
    return np.stack(corners, axis=1) * half


def _faults(meshes: Sequence[_Polygons]) -> dict[int, Problem]:
    """What meshes cannot be read for, by index: the first of what can be."""
    counts, corners = (_of([getattr(mesh, name) for mesh in meshes]) for name in ("counts", "indices"))
    sizes = np.array([len(mesh.points) for mesh in meshes])
    faces, indices = (np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in ("counts", "indices"))
    sums = np.zeros(len(meshes), dtype=int)
    np.add.at(sums, counts, faces)
    strays = {*counts[faces < 0].tolist(), *corners[(indices < 0) | (indices >= sizes[corners])].tolist()}
    strays |= {*np.flatnonzero(sums != [len(mesh.indices) for mesh in meshes]).tolist()}
    found = {}
    for index, mesh in enumerate(meshes):
        size = len(mesh.points), len(mesh.counts)
        if mesh.fault:
            found[index] = Problem(severity="error", where=str(mesh.placed.prim.GetPath()), message=mesh.fault)
        elif not all(size):
            found[index] = _error(mesh, f"is an empty mesh ({size[0]} points, {size[1]} faces)", _REMEDY)
        elif index in strays:
            remedy = "repair faceVertexCounts and -Indices"
            found[index] = _error(mesh, "has faces that do not match its points", remedy)
    return found


def _finite(meshes: Sequence[_Polygons], faults: dict[int, Problem]) -> tuple[list[_Polygons], dict[int, Problem]]:
    """The meshes without faces that have corners that are not finite, and what is wrong with any, by index."""
    finite, found = list(meshes), dict(faults)
    are_finite = np.isfinite(np.concatenate([mesh.points for mesh in meshes])).all(axis=1)
    strays = {*_of([mesh.points for mesh in meshes])[~are_finite].tolist()}
    for index, mesh in enumerate(meshes):
        if index in faults or (index not in strays and np.isfinite(mesh.placed.matrices).all()):
            continue
        is_finite = np.all(np.isfinite(mesh.points), axis=1)
        lost = np.unique(_of_counts(mesh.counts)[~is_finite[mesh.indices]])
        if len(lost) == len(mesh.counts) or not np.isfinite(mesh.placed.matrices).all():
            found[index] = _error(mesh, "has points that are not finite", "repair the mesh")
            continue
        points = np.where(is_finite[:, None], mesh.points, mesh.points[np.argmax(is_finite)])
        finite[index] = replace(mesh, points=points, holes=np.concatenate([mesh.holes, lost]))
        if len(lost):
            what = f"{len(lost)} of its faces have points that are not finite and are left out. repair the mesh"
            path = mesh.placed.paths[0]
            found[index] = Problem(severity="warning", where=path, message=f"{path}: {what}")
    return finite, found


def _error(mesh: _Polygons, what: str, remedy: str) -> Problem:
    error = TerrainError(mesh.placed.prim.GetPath(), what, remedy)
    return Problem(severity="error", where=error.where, message=str(error))


def _of_counts(counts: IntArray) -> IntArray:
    """Which of several each item is of that come one after the other."""
    return np.repeat(np.arange(len(counts)), counts)


def _of(arrays: Sequence[Sized]) -> IntArray:
    """Which of the arrays each item is of, all arrays joined."""
    return _of_counts(np.array([len(array) for array in arrays], dtype=int))


def _in_places(meshes: Sequence[_Polygons], units: StageUnits) -> tuple[_Part, list[int]]:
    """Triangles of meshes in their places without those that have no area, and which meshes have none anywhere."""
    triangles, firsts = _cut(meshes)
    mesh_of = _of([mesh.placed.paths for mesh in meshes])  # of each place, of Q in all
    world, turned = _placed(meshes, units)
    sizes = np.array([len(mesh.points) for mesh in meshes])[mesh_of]
    places, rows = _repeated(firsts, mesh_of)
    faces = np.where(turned[places, None], triangles[rows][:, [0, 2, 1]], triangles[rows])  # of each mesh's own points
    has_area = _areas(world, faces + _starts(sizes)[places, None]) > _THINNEST
    places, faces = places[has_area], faces[has_area]
    shown = np.bincount(places, minlength=len(mesh_of)) > 0  # instances are often hidden by a scale of zero
    paths = [path for mesh in meshes for path in mesh.placed.paths]
    part = _Part(
        meshes=tuple(path for path, is_shown in zip(paths, shown.tolist(), strict=True) if is_shown),
        points=world[np.repeat(shown, sizes)],
        triangles=faces + _starts(np.where(shown, sizes, 0))[places, None],
        mesh_indices=(np.cumsum(shown) - 1)[places],
        walkable=np.array([mesh.placed.walkable for mesh in meshes])[mesh_of[shown]],
    )
    return part, np.setdiff1d(np.arange(len(meshes)), mesh_of[shown]).tolist()


def _cut(meshes: Sequence[_Polygons]) -> tuple[IntArray, IntArray]:
    """Triangles of the meshes' own points (T, 3), mesh by mesh, and the first of each mesh and their end (M + 1,)."""
    starts = _starts([len(mesh.points) for mesh in meshes])
    faces = _starts([len(mesh.counts) for mesh in meshes])
    holes = [
        mesh.holes[(mesh.holes >= 0) & (mesh.holes < len(mesh.counts))] + first
        for mesh, first in zip(meshes, faces, strict=True)
        if len(mesh.holes)
    ]
    triangles = cut_polygons(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.counts for mesh in meshes]),
        np.concatenate([mesh.indices + start for mesh, start in zip(meshes, starts, strict=True)]),
        holes=np.concatenate([np.zeros(0, dtype=int), *holes]),
    )
    mesh_of = np.searchsorted(starts, triangles[:, 0], side="right") - 1
    order = np.argsort(mesh_of, kind="stable")
    firsts = np.searchsorted(mesh_of[order], np.arange(len(meshes) + 1))
    return triangles[order] - starts[mesh_of[order], None], firsts


def _starts(sizes: Sequence[int] | IntArray) -> IntArray:
    """Where each of several begins that come one after the other."""
    return np.cumsum(sizes) - np.asarray(sizes, dtype=int)


def _repeated(firsts: IntArray, groups: IntArray) -> tuple[IntArray, IntArray]:
    """Rows of groups, one after the other.

    Args:
        firsts: First row of each group, and the end of the last.
        groups: Which are wanted, each as often as it is wanted, shape (Q,).

    Returns:
        Of each row which of the Q it is for, and its number.
    """
    sizes = np.diff(firsts)[groups]
    owners = np.repeat(np.arange(len(groups)), sizes)
    return owners, np.arange(len(owners)) + (firsts[groups] - _starts(sizes))[owners]


def _placed(meshes: Sequence[_Polygons], units: StageUnits) -> tuple[FloatArray, BoolArray]:
    """World points [m] of all meshes in all places, and of each place whether it turns faces inside out."""
    matrices = np.concatenate([mesh.placed.matrices for mesh in meshes])
    points = [
        (mesh.points @ mesh.placed.matrices[:, :3, :3] + mesh.placed.matrices[:, 3:, :3]).reshape(-1, 3)
        for mesh in meshes
    ]
    flipped = np.array([_is_flipped(UsdGeom.Gprim(mesh.placed.prim)) for mesh in meshes])
    turned = (np.linalg.det(matrices[:, :3, :3]) < 0.0) != np.repeat(flipped, [len(m.placed.paths) for m in meshes])
    return units.points_to_canonical(np.concatenate(points)), turned


def _is_flipped(mesh: UsdGeom.Gprim) -> bool:
    return bool(mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded)


def _areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Areas of triangles (T, 3), shape (T,)."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1)


def _joined(parts: Sequence[_Part]) -> Terrain:
    points = _starts([len(part.points) for part in parts])
    meshes = _starts([len(part.meshes) for part in parts])
    return Terrain(
        meshes=tuple(path for part in parts for path in part.meshes),
        points=np.concatenate([np.zeros((0, 3)), *(part.points for part in parts)]),
        triangles=np.concatenate(
            [np.zeros((0, 3), dtype=int), *(part.triangles + at for part, at in zip(parts, points, strict=True))]
        ),
        mesh_indices=np.concatenate(
            [np.zeros(0, dtype=int), *(part.mesh_indices + at for part, at in zip(parts, meshes, strict=True))]
        ),
        walkable=np.concatenate([np.zeros(0, dtype=bool), *(part.walkable for part in parts)]),
    )
