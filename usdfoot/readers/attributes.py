"""Attributes of USD's own schemas: their values, which any layer may author as another type than the schema's."""

from __future__ import annotations

import math
from collections.abc import Sized
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdfoot.errors import SceneError, UsdfootError

__all__ = ["array_at", "axis_of", "check_own_array", "checked", "length_at", "size_at", "value_at"]

_AXES = ("X", "Y", "Z")


def value_at(
    attribute: Usd.Attribute, code: Usd.TimeCode | None = None, *, error: type[UsdfootError] = SceneError
) -> Any:
    """The value of an attribute, authored or its schema's; None where there is none.

    Args:
        attribute: Of a prim, which may not have it.
        code: When; None = the one value of what does not change.
        error: What is raised.

    Raises:
        UsdfootError: If it is authored as a type that cannot stand for the schema's, as text cannot for a number.
    """
    value = attribute.Get(Usd.TimeCode.Default() if code is None else code) if attribute else None
    return value if value is None else checked(attribute, value, error=error)


def array_at(
    attribute: Usd.Attribute, code: Usd.TimeCode | None = None, *, error: type[UsdfootError] = SceneError
) -> Any:
    """As `value_at` of an array; an empty one where there is none."""
    value = value_at(attribute, code, error=error)
    return () if value is None else value


def check_own_array(
    attribute: Usd.Attribute, code: Usd.TimeCode, count: int, *, error: type[UsdfootError] = SceneError
) -> None:
    """Raise if an array that USD itself will read is of another type than the schema's, or has not `count` entries.

    USD passes over the one, and reads beyond the end of the other. Empty is as good as not there.
    """
    value = attribute.Get(code) if attribute else None
    if value is None:
        return
    if type(value) is not type(attribute.GetTypeName().defaultValue):
        raise _wrong_type(attribute, _authored_type(attribute, value), attribute.GetTypeName(), error)
    if len(value) not in (0, count):
        what = f"{attribute.GetName()} has {len(value)} entries for {count} instances"
        raise error(attribute.GetPrimPath(), what, "author one for each")


def length_at(attribute: Usd.Attribute, code: Usd.TimeCode) -> float:
    """The length that an attribute of a shape says, at least 0 [stage units].

    Raises:
        SceneError: If it is negative or not finite, or of a type that is no number.
    """
    length = float(value_at(attribute, code) or 0.0)
    if not (math.isfinite(length) and length >= 0.0):
        raise SceneError(attribute.GetPrimPath(), f"{attribute.GetName()} is {length:g}", "author a number above 0")
    return length


def size_at(attribute: Usd.Attribute, code: Usd.TimeCode | None = None) -> int:
    """How long an array is; 0 where there is none, or what is no array: that is said by who reads it."""
    value = attribute.Get(Usd.TimeCode.Default() if code is None else code) if attribute else None
    return len(value) if isinstance(value, Sized) else 0


def axis_of(prim: Usd.Prim) -> int:
    """Which axis a Plane, Cylinder, Capsule or Cone has; 2 for what has none.

    Raises:
        SceneError: If it is none of X, Y and Z.
    """
    attribute = prim.GetAttribute(str(UsdGeom.Tokens.axis))
    axis = str(value_at(attribute) or UsdGeom.Tokens.z)
    if axis not in _AXES:
        raise SceneError(prim.GetPath(), f"axis is {axis}", f"author one of {', '.join(_AXES)}")
    return _AXES.index(axis)


def checked(
    attribute: Usd.Attribute,
    value: Any,
    expected: Sdf.ValueTypeName | None = None,
    *,
    error: type[UsdfootError] = SceneError,
) -> Any:
    """A value that an attribute was found to have; of another type only if that can stand for the expected.

    Args:
        attribute: Whose value it is.
        value: Not None.
        expected: Its right type; None = that of the attribute, which is the schema's whatever is authored.
        error: What is raised.

    Raises:
        UsdfootError: As `value_at`.
    """
    expected = expected or attribute.GetTypeName()
    if type(value) is type(expected.defaultValue):
        return value
    found = _authored_type(attribute, value)
    if _form(expected) != _form(found or expected):
        raise _wrong_type(attribute, found, expected, error)
    return value


def _authored_type(attribute: Usd.Attribute, value: Any) -> Sdf.ValueTypeName | None:
    """The type that a value of an attribute was authored as."""
    authored = (spec.typeName for spec in attribute.GetPropertyStack())
    return next((own for own in authored if type(own.defaultValue) is type(value)), None)


def _wrong_type(
    attribute: Usd.Attribute,
    found: Sdf.ValueTypeName | None,
    expected: Sdf.ValueTypeName,
    error: type[UsdfootError],
) -> UsdfootError:
    what = f"{attribute.GetName()} is of type {found}"
    return error(attribute.GetPrimPath(), what, f"author it as {expected}")


def _form(type_name: Sdf.ValueTypeName) -> tuple[bool, bool, tuple[int, ...]]:
    """Whether values are arrays, whether they are text, and the shape of one; float, double and timecode are alike."""
    value = type_name.scalarType.defaultValue
    shape = (4,) if isinstance(value, (Gf.Quath, Gf.Quatf, Gf.Quatd)) else np.shape(value)
    return type_name.isArray, isinstance(value, (str, Sdf.AssetPath)), shape
