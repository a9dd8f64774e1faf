"""What is authored on a prim: values of attributes and targets of relationships, of the type that their schema says."""

from __future__ import annotations

import logging
from collections.abc import Collection
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.schema import declared_kind, declared_type
from usdfoot.readers.attributes import checked

__all__ = ["authored", "authored_in", "authored_or_primvar", "authored_values", "is_authored", "targets"]

_logger = logging.getLogger(__name__)

_EARLIEST = Usd.TimeCode.EarliestTime()


def authored(prim: Usd.Prim, name: str) -> Any:
    """Value authored for an attribute, None where there is none; the schema's fallback does not count.

    Raises:
        SceneError: If the attribute is of a type that cannot stand for the schema's, as text cannot for a number.
    """
    query = Usd.AttributeQuery(prim, name)  # resolves it once
    value = authored_in(query, prim, name)
    if value is not None and query.ValueMightBeTimeVarying():
        _logger.warning("%s: %s is animated, the first sample is read. author one value", prim.GetPath(), name)
    return value


def authored_in(query: Usd.AttributeQuery, prim: Usd.Prim, name: str) -> Any:
    """As `authored` by a query of the prim's attribute of this name, which may not be there."""
    if not query.HasAuthoredValue():
        return None
    value = query.Get(_EARLIEST)
    return value if declared_kind(name) in (None, type(value)) else _of_type(name, prim.GetAttribute(name), value)


def authored_or_primvar(prim: Usd.Prim, name: str) -> Any:
    """As `authored`; failing that the value of the primvar of this name, which some programs write instead.

    Raises:
        SceneError: As `authored`.
    """
    value = authored(prim, name)
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(name) if value is None else None
    if not primvar or not primvar.HasAuthoredValue():
        return value
    _logger.info("%s: %s is read from the primvar of this name", prim.GetPath(), name)
    return _of_type(name, primvar.GetAttr(), primvar.ComputeFlattened(_EARLIEST))


def _of_type(name: str, attribute: Usd.Attribute, value: Any) -> Any:
    """The value of an attribute, which stands for the schema's `name`; numbers in place of time codes as these.

    Raises:
        SceneError: If the attribute is of a type that cannot stand for it.
    """
    expected = None if declared_kind(name) in (None, type(value)) else declared_type(name)
    if not expected:
        return value
    is_bare = expected.scalarType == Sdf.ValueTypeNames.TimeCode
    return _on_stage(attribute, checked(attribute, value, expected)) if is_bare else checked(attribute, value, expected)


def _on_stage(attribute: Usd.Attribute, codes: Any) -> Any:
    """Time codes of a layer on the stage: USD moves only those of type timecode by the layer's offset, no numbers."""
    stack = attribute.GetPropertyStackWithLayerOffsets(_EARLIEST)
    offset = next(offset for spec, offset in stack if spec.HasInfo("default") or spec.HasInfo("timeSamples"))
    if offset.IsIdentity():
        return codes
    moved = offset.offset + offset.scale * np.array(codes, dtype=float)
    return moved if moved.ndim else float(moved)


def authored_values(prim: Usd.Prim, names: Collection[str]) -> dict[str, Any]:
    """Values authored for attributes, by name; those without are left out. Quick where few are authored."""
    values = {name: authored(prim, name) for name in prim.GetAuthoredPropertyNames() if name in names}
    return {name: value for name, value in values.items() if value is not None}


def is_authored(prim: Usd.Prim, name: str) -> bool:
    """Whether an attribute has a value of its own, whatever that is."""
    attribute = prim.GetAttribute(name)
    return bool(attribute) and attribute.HasAuthoredValue()


def targets(prim: Usd.Prim, name: str) -> list[Sdf.Path]:
    """Targets of a relationship, forwarded; empty where there is none."""
    relationship = prim.GetRelationship(name)
    return list(relationship.GetForwardedTargets()) if relationship else []
