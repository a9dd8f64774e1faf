"""When a prim's place in the world has to be asked, so that nothing of how it moves is missed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Tf, Usd, UsdGeom

from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, check_limit
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.transform_faults import check_operation, place_fault

__all__ = ["changes_place", "changes_value", "is_animated", "transform_codes"]

_SPLINE_RATE = 24.0
"""Samples a second of what splines move."""
_LARGEST_TURN = 170.0
"""Between samples of a rotation that is authored as angles [degrees]; from 180 on matrices do not tell which way."""


def transform_codes(prim: Usd.Prim) -> FloatArray:
    """Time codes at which to ask where a prim is in the world, increasing, shape (K,).

    Those of the time samples of its transform and of those above it. Splines have knots instead, between which it is
    asked 24 times a second; where angles turn half around or more between two samples it is asked between them too.

    Raises:
        SceneError: If there are more than `DEFAULT_LIMITS.frames`, or USD cannot compute it.
    """
    spacing = prim.GetStage().GetTimeCodesPerSecond() / _SPLINE_RATE
    known, between = [np.zeros(0)], [np.zeros(0)]
    for operation in _operations(prim):
        samples = np.array(operation.GetTimeSamples(), dtype=float)
        known.append(samples)
        if _has_spline(operation):
            samples = np.array(list(operation.GetAttr().GetSpline().GetKnots()), dtype=float)
            known.append(samples)
            pieces = np.ceil(np.diff(samples) / spacing)
        else:
            pieces = np.ceil(_turns(operation, samples) / _LARGEST_TURN)
        check_limit(prim.GetPath(), "frames", float(pieces.sum()), limit=DEFAULT_LIMITS.frames)
        between += [
            np.linspace(samples[index], samples[index + 1], int(pieces[index]) + 1)
            for index in np.flatnonzero(pieces > 1.0)
        ]
    return np.unique(np.concatenate([*known, *between]))


def is_animated(operation: UsdGeom.XformOp) -> bool:
    """Whether an operation has time samples or a spline."""
    return operation.GetNumTimeSamples() > 0 or _has_spline(operation)


def changes_place(prim: Usd.Prim) -> bool:
    """Whether a prim is elsewhere in the world, or turned or scaled otherwise, at one time code than at another."""
    codes = transform_codes(prim)
    return len(codes) > 1 and bool(np.ptp(matrices_of(prim, codes), axis=0).any())


def changes_value(attribute: Usd.Attribute | Usd.AttributeQuery) -> bool:
    """Whether an attribute differs between its time samples."""
    if not attribute.ValueMightBeTimeVarying():  # quickly told by a query
        return False
    codes = attribute.GetTimeSamples()
    return any(attribute.Get(code) != attribute.Get(codes[0]) for code in codes[1:])


def _operations(prim: Usd.Prim) -> Iterator[UsdGeom.XformOp]:
    """The operations that place a prim in the world."""
    while prim and not prim.IsPseudoRoot():
        xformable = UsdGeom.Xformable(prim)
        if xformable:
            try:
                operations = xformable.GetOrderedXformOps()
            except Tf.ErrorException as error:
                raise place_fault(prim, error) from error
            yield from operations
            if xformable.GetResetXformStack():
                return
        prim = prim.GetParent()


def _has_spline(operation: UsdGeom.XformOp) -> bool:
    """Whether a spline moves it, which USD before 25.05 does not know."""
    attribute = operation.GetAttr()
    return hasattr(attribute, "HasSpline") and attribute.HasSpline()


def _turns(operation: UsdGeom.XformOp, codes: FloatArray) -> FloatArray:
    """How far angles turn between time samples (K,) [degrees], 0 for what is no angle, shape (K - 1,)."""
    if "rotate" not in str(operation.GetOpName()) or len(codes) < 2:
        return np.zeros(max(len(codes) - 1, 0))
    check_operation(operation.GetAttr())
    angles = np.array([operation.GetAttr().Get(code) for code in codes], dtype=float).reshape(len(codes), -1)
    return np.nan_to_num(np.abs(np.diff(angles, axis=0)).max(axis=1), posinf=0.0)
