"""Transforms that USD cannot compute, and which operation is to blame."""

from __future__ import annotations

from pxr import Sdf, Tf, Usd, UsdGeom

from usdfoot.bridge.usd_errors import usd_reason
from usdfoot.errors import SceneError
from usdfoot.readers.attributes import array_at, checked

__all__ = ["check_operation", "place_fault"]

_PREFIX, _INVERTED = "xformOp:", "!invert!"
_KINDS = {str(UsdGeom.XformOp.GetOpTypeToken(kind)) for kind in UsdGeom.XformOp.Type.allValues} - {""}
"""Operations, by their names without prefix and suffix."""


def place_fault(prim: Usd.Prim, error: Tf.ErrorException) -> SceneError:
    """Why USD cannot say where a prim is: the first fault among its operations and those above it."""
    above = prim
    try:
        while above and not above.IsPseudoRoot():
            for name in array_at(above.GetAttribute(str(UsdGeom.Tokens.xformOpOrder))):
                check_operation(above.GetAttribute(str(name).removeprefix(_INVERTED)))
            above = above.GetParent()
    except SceneError as fault:
        return fault
    return SceneError(prim.GetPath(), "has a transform that USD cannot compute", usd_reason(error))


def check_operation(attribute: Usd.Attribute) -> None:
    """Raises SceneError if an attribute is none of USD's operations, or authored as a type that is not its own.

    Operations that are only named, which USD leaves out, are none.
    """
    if not attribute:
        return
    name = attribute.GetName()
    kind = name.removeprefix(_PREFIX).split(":")[0] if name.startswith(_PREFIX) else ""
    if kind not in _KINDS:
        raise SceneError(attribute.GetPrimPath(), f"{name} is no operation of USD's", "correct xformOpOrder")
    value = attribute.Get(Usd.TimeCode.EarliestTime())
    if value is not None:
        checked(attribute, value, _value_type(kind))


def _value_type(kind: str) -> Sdf.ValueTypeName:
    """Type of what an operation is given: one number about or along one axis, else three, unless it has its own."""
    types = {"transform": Sdf.ValueTypeNames.Matrix4d, "orient": Sdf.ValueTypeNames.Quatd}
    has_axis = len(kind) - len(kind.rstrip("XYZ")) == 1
    return types.get(kind, Sdf.ValueTypeNames.Double if has_axis else Sdf.ValueTypeNames.Double3)
