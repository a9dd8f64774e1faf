"""Obstacles: prims with UsdfootObstacleAPI as outlines on the ground."""

from __future__ import annotations

import math

import numpy as np
from pxr import Usd, UsdGeom
from scipy.spatial import ConvexHull, QhullError

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Obstacle as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.report import Problem
from usdfoot.planning.world import Obstacle
from usdfoot.readers.attributes import array_at, axis_of, length_at
from usdfoot.readers.authored import authored
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import StagePrims, start_code
from usdfoot.readers.triangles import cut_polygons

__all__ = ["obstacle_prims", "obstacles_of", "read_obstacles"]

CONVEX = 0.98
"""A mesh whose upward faces cover this much of its hull is as good as convex seen from above."""
THIN = 1e-9
"""Area below which a face stands upright [m2]."""
ROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
LENGTHS = {"size", "width", "length", "height", "radius", "radiusTop", "radiusBottom"}
"""What solids of USD have of them."""
ROUND_GPRIMS = ("Sphere", "Cylinder", "Capsule", "Cone")


def read_obstacles(
    stage: Usd.Stage, prims: StagePrims, units: StageUnits
) -> tuple[tuple[Obstacle, ...], tuple[Problem, ...]]:
    """Outlines and heights of all obstacles at the stage's start, and those that could not be used.

    The API on a prim means every Boundable at or below it. A concave mesh gives an outline for each face that looks up.
    """
    obstacles: list[Obstacle] = []
    problems = []
    for prim in obstacle_prims(prims):
        try:
            obstacles += obstacles_of(prim, units, start_code(stage))
        except UsdfootError as error:
            problems.append(Problem(severity="error", where=error.where, message=str(error)))
    return tuple(obstacles), tuple(problems)


def obstacles_of(prim: Usd.Prim, units: StageUnits, code: Usd.TimeCode) -> list[Obstacle]:
    """What a Boundable is in the way with at a time code.

    Raises:
        SceneError: If it has no shape, or one that is not finite.
    """
    margin = _margin(prim) * units.meters_per_unit
    points, faces = _shape(prim, units, code)
    heights = float(points[:, 1].min()), float(points[:, 1].max())
    return [
        Obstacle(name=str(prim.GetPath()), outline=outline, margin=margin, heights=heights)
        for outline in _outlines(prim, points[:, [0, 2]], faces)
    ]


def obstacle_prims(prims: StagePrims) -> list[Usd.Prim]:
    """Every Boundable at or below an obstacle prim, once."""
    found = {}
    for prim in prims.with_apis.get(Schema.OBSTACLE, ()):
        for below in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
            if below.IsA(UsdGeom.Gprim) or (below == prim and below.IsA(UsdGeom.Boundable)):
                found[below.GetPath()] = below
    return list(found.values())


def _margin(prim: Usd.Prim) -> float:
    """The margin authored nearest to the prim, on itself or above [stage units]."""
    while prim and not prim.IsPseudoRoot():
        value = authored(prim, Token.MARGIN) if has_api(prim, Schema.OBSTACLE) else None
        if value is not None:
            if not (math.isfinite(value) and value >= 0.0):
                raise SceneError(prim.GetPath(), f"{Token.MARGIN} is {value:g}", "author a number of at least 0")
            return float(value)
        prim = prim.GetParent()
    return 0.0


def _shape(prim: Usd.Prim, units: StageUnits, code: Usd.TimeCode) -> tuple[FloatArray, IntArray]:
    """Points (P, 3) of a Boundable [m] and the triangles (T, 3) of a mesh, none of anything else.

    Raises:
        SceneError: If it has no extent, a negative length, is not finite, or faces and points do not match.
    """
    faces = np.zeros((0, 3), dtype=int)
    if prim.IsA(UsdGeom.Mesh):
        points, faces = _mesh(UsdGeom.Mesh(prim), code)
    else:
        for name in LENGTHS.intersection(prim.GetPrimDefinition().GetPropertyNames()):
            length_at(prim.GetAttribute(name), code)
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), code)
        if not extent:
            raise SceneError(prim.GetPath(), "is an obstacle without an extent", "author its extent, or make it a Mesh")
        lowest, highest = (np.array(corner, dtype=float) for corner in extent)
        solid = _round_points(prim) if prim.GetTypeName() in ROUND_GPRIMS else _corners()
        points = 0.5 * (lowest + highest) + 0.5 * solid * (highest - lowest)
    matrix = matrices_of(prim, np.array([code.GetValue()]))[0]
    world = units.points_to_canonical(points @ matrix[:3, :3] + matrix[3, :3])
    if not np.isfinite(world).all():
        raise SceneError(prim.GetPath(), "is an obstacle whose points are not finite", "repair it")
    return world, faces


def _mesh(mesh: UsdGeom.Mesh, code: Usd.TimeCode) -> tuple[FloatArray, IntArray]:
    """Points of a mesh in its own space, and its triangles."""
    points = np.array(array_at(mesh.GetPointsAttr(), code), dtype=float).reshape(-1, 3)
    counts = np.array(array_at(mesh.GetFaceVertexCountsAttr(), code), dtype=int)
    indices = np.array(array_at(mesh.GetFaceVertexIndicesAttr(), code), dtype=int)
    strays = counts.min(initial=0) < 0 or indices.min(initial=0) < 0 or indices.max(initial=-1) >= len(points)
    if strays or not len(points) or counts.sum() != len(indices):
        raise SceneError(mesh.GetPath(), "is an obstacle whose faces do not match its points", "repair the mesh")
    return points, cut_polygons(points, counts, indices, holes=np.zeros(0, dtype=int))


def _outlines(prim: Usd.Prim, places: FloatArray, faces: IntArray) -> list[FloatArray]:
    """Outlines (K, 2) of points (P, 2) on the ground: their hull, or of a concave mesh the faces of one side."""
    hull = _hull(prim, places)
    triangles = places[faces]  # (T, 3, 2)
    areas = _areas(triangles)
    sides = triangles[areas > 0.0], triangles[areas < 0.0]  # of a closed mesh each covers what it stands on
    covered = areas[areas > 0.0].sum(), -areas[areas < 0.0].sum()
    if max(covered) < THIN or max(covered) >= CONVEX * abs(_area(hull)):
        return [hull]
    widest = sides[int(np.argmax(covered))]
    return list(widest[np.abs(_areas(widest)) > THIN])


def _areas(triangles: FloatArray) -> FloatArray:
    """Signed areas of triangles (T, 3, 2)."""
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _area(outline: FloatArray) -> float:
    x, z = outline.T
    return 0.5 * float(np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z))


def _hull(prim: Usd.Prim, points: FloatArray) -> FloatArray:
    """Corners of the convex hull; a thin wall seen from its edge is made a millimetre thick."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        spread = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)]) * 5e-4
        thick = (points[:, None] + spread).reshape(-1, 2)
        try:
            return thick[ConvexHull(thick).vertices]
        except QhullError as error:
            raise SceneError(prim.GetPath(), "is an obstacle that covers no ground", "repair or remove it") from error


def _corners() -> FloatArray:
    """Corners of the box from -1 to 1, shape (8, 3)."""
    return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def _round_points(prim: Usd.Prim) -> FloatArray:
    """Points that span a round solid within the box from -1 to 1, shape (P, 3)."""
    circle = np.stack([np.sin(ROUND), np.cos(ROUND)], axis=1)
    axis = axis_of(prim)
    if prim.GetTypeName() in ("Sphere", "Capsule"):
        tilts = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
        return np.concatenate([np.insert(np.cos(t) * circle, axis, np.sin(t), axis=1) for t in tilts])
    return np.concatenate([np.insert(circle, axis, end, axis=1) for end in (-1.0, 1.0)])
