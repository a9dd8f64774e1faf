"""Paths: BasisCurves and HermiteCurves to walk along."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Path as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.path import WalkingPath
from usdfoot.planning.curves import sample_curve, sample_hermite
from usdfoot.readers.attributes import array_at, value_at
from usdfoot.readers.authored import authored
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import start_code

__all__ = ["find_paths", "read_paths"]

_DENSITY = 0.02
"""Distance between samples of a curve [m]."""


def find_paths(stage: Usd.Stage) -> tuple[Usd.Prim, ...]:
    """Curves to walk along: those with UsdfootPathAPI; on a stage without any, all curves."""
    prims = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    curves = [prim for prim in prims if prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.HermiteCurves)]
    marked = [prim for prim in curves if has_api(prim, Schema.PATH)]
    return tuple(marked or curves)


def read_paths(prim: Usd.Prim, units: StageUnits) -> tuple[WalkingPath | PlanError, ...]:
    """The curves of a prim, one or more, in the canonical world, or why one of several cannot be walked.

    Args:
        prim: BasisCurves or HermiteCurves.
        units: Of the stage.

    Raises:
        PlanError: If the prim is no curve, its points do not fit its curves, or its only curve cannot be walked.
    """
    where = str(prim.GetPath())
    stage = prim.GetStage()
    if not (prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.HermiteCurves)):
        kind = prim.GetTypeName() or "an untyped prim"
        raise PlanError(where, f"is {kind}", "a path is a BasisCurves or HermiteCurves prim with UsdfootPathAPI")
    curves = UsdGeom.Curves(prim)
    matrix = matrices_of(prim, np.array([start_code(stage).GetValue()]))[0]
    points = _vectors(curves.GetPointsAttr())
    counts = np.array(_value(curves.GetCurveVertexCountsAttr()), dtype=int)
    if not counts.size and len(points):
        counts = np.array([len(points)])
    if counts.sum() != len(points) or not counts.size:
        raise PlanError(where, f"has {len(points)} points but curveVertexCounts of {counts.sum()}", "make them agree")
    world = units.points_to_canonical(points @ matrix[:3, :3] + matrix[3, :3])
    ends = np.cumsum(counts)
    parts = [slice(int(end - count), int(end)) for end, count in zip(ends, counts, strict=True)]
    tangents = _tangents(prim, matrix, units, len(points)) if prim.IsA(UsdGeom.HermiteCurves) else None
    paths: list[WalkingPath | PlanError] = []
    for number, part in enumerate(parts):
        try:
            if tangents is None:
                line = _basis_curve(prim, matrix, units, world[part])
            else:
                line = sample_hermite(world[part], tangents[part], name=where, density=_DENSITY)
            paths.append(_path(prim, units, line))
        except PlanError as error:
            if len(parts) == 1:
                raise
            paths.append(PlanError(f"{where}, curve {number}", error.what, error.remedy))
    return tuple(paths)


def _tangents(prim: Usd.Prim, matrix: FloatArray, units: StageUnits, count: int) -> FloatArray:
    """Those of HermiteCurves in the canonical world, shape (N, 3)."""
    tangents = _vectors(UsdGeom.HermiteCurves(prim).GetTangentsAttr()) @ matrix[:3, :3]
    if len(tangents) != count:
        raise PlanError(prim.GetPath(), f"has {count} points but {len(tangents)} tangents", "author one a point")
    return units.points_to_canonical(tangents)


def _basis_curve(prim: Usd.Prim, matrix: FloatArray, units: StageUnits, points: FloatArray) -> FloatArray:
    curves = UsdGeom.BasisCurves(prim)
    basis = (
        str(value_at(curves.GetBasisAttr(), error=PlanError))
        if value_at(curves.GetTypeAttr(), error=PlanError) == UsdGeom.Tokens.cubic
        else "linear"
    )
    if basis == "hermite":  # tangents are directions, which the world's origin does not move
        origin = units.points_to_canonical(matrix[3, :3])
        points = points - np.where(np.arange(len(points)) % 2, 1.0, 0.0)[:, None] * origin
    return sample_curve(
        points,
        basis=basis,
        wrap=str(value_at(curves.GetWrapAttr(), error=PlanError)),
        name=str(prim.GetPath()),
        density=_DENSITY,
    )


def _path(prim: Usd.Prim, units: StageUnits, points: FloatArray) -> WalkingPath:
    """Raises PlanError if the curve has no length or a number is out of range."""

    def number(name: str) -> float:
        return float(authored(prim, name) or 0.0)

    begin = authored(prim, Token.START_TIME)
    code = prim.GetStage().GetStartTimeCode() if begin is None else float(begin)
    scale = units.meters_per_unit
    return WalkingPath(
        name=str(prim.GetPath()),
        points=points,
        speed=number(Token.SPEED) * scale,
        step_length=number(Token.STEP_LENGTH) * scale,
        step_width=number(Token.STEP_WIDTH) * scale,
        start_time=float(units.codes_to_times(np.array(code))),
        style=str(authored(prim, Token.STYLE) or ""),
    )


def _vectors(attribute: Usd.Attribute) -> FloatArray:
    return np.array(_value(attribute), dtype=float).reshape(-1, 3)


def _value(attribute: Usd.Attribute) -> object:
    return array_at(attribute, start_code(attribute.GetStage()), error=PlanError) if attribute else ()
