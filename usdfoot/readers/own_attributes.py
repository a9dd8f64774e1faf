"""Own attributes: those of an agent's prim that say nothing of who walks, and go along to the written agent."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.own_attributes import NUMBER_TYPES, TEXT_TYPES, OwnAttribute

__all__ = ["HARMLESS", "is_own", "read_own"]

HARMLESS = ("xformOp", "usdfoot:", "visibility", "extent", "skel:animationSource")
"""Properties on the character prim that a written agent replaces or does not need."""
_SKINNING = ("skel:", "primvars:skel:")
"""What a Skeleton and what it moves may have from the prim above."""
_PRIMVARS = "primvars:"
_DESCRIPTIONS = (_PRIMVARS, "userProperties:")
_SIMPLE = Usd.ResolveInfoSourceDefault, Usd.ResolveInfoSourceTimeSamples


def is_own(prim: Usd.Prim, name: str) -> bool:
    """Whether a property of a prim only describes it or is inherited, and can be authored on an agent in its place.

    Primvars count that are constant, user properties, custom attributes and the purpose, unless that hides the
    character's geometry from who measures it; of bools, integers, floating-point numbers, vectors of these, tokens and
    strings, arrays too, with samples of the same length. Those that move a skin do not.
    """
    attribute = prim.GetAttribute(name)
    return bool(attribute) and _describes(attribute) and (_is_silent(attribute) or _read(attribute) is not None)


def read_own(prim: Usd.Prim, names: Iterable[str]) -> dict[str, OwnAttribute]:
    """Those of the properties that are the prim's own, without connections, in the order of their names."""
    attributes = {name: prim.GetAttribute(name) for name in sorted(names) if not name.startswith(HARMLESS)}
    found = {name: _read(attribute) for name, attribute in attributes.items() if attribute and _describes(attribute)}
    return {name: own for name, own in found.items() if own}


def _describes(attribute: Usd.Attribute) -> bool:
    name = attribute.GetName()
    if name.startswith((*HARMLESS, *_SKINNING)):
        return False
    if name == UsdGeom.Tokens.purpose:
        return attribute.Get() != UsdGeom.Tokens.guide
    constant = attribute.GetMetadata("interpolation") in (None, UsdGeom.Tokens.constant)
    return (name.startswith(_DESCRIPTIONS) and constant) or (not name.startswith(_PRIMVARS) and attribute.IsCustom())


def _is_silent(attribute: Usd.Attribute) -> bool:
    """Whether an attribute is only declared, or connected."""
    return not attribute.HasAuthoredValue() and not attribute.GetResolveInfo().ValueIsBlocked()


def _read(attribute: Usd.Attribute) -> OwnAttribute | None:
    """An attribute with its values in time; None if they cannot be written."""
    kind = attribute.GetTypeName()
    if attribute.GetResolveInfo().GetSource() not in _SIMPLE:
        return None
    codes = attribute.GetTimeSamples()
    value = _plain(attribute.Get(), kind)
    samples = tuple(_plain(attribute.Get(code), kind) for code in codes)
    if (value is None and not codes) or not _are_alike(samples, kind):
        return None
    return OwnAttribute(
        type_name=str(kind),
        value=value,
        codes=tuple(codes),
        samples=samples,
        is_custom=attribute.IsCustom(),
        is_uniform=attribute.GetVariability() == Sdf.VariabilityUniform,
        interpolation=str(attribute.GetMetadata("interpolation") or ""),
        element_size=attribute.GetMetadata("elementSize") if attribute.HasAuthoredMetadata("elementSize") else None,
    )


def _plain(value: Any, kind: Sdf.ValueTypeName) -> Any:
    """A value without USD's types, None if it is of another type than those that are written, or than it is to be.

    A weaker layer may say something else by the same name.
    """
    scalar = kind.scalarType.cppTypeName
    if type(value) is not type(kind.defaultValue):
        return None
    if scalar in TEXT_TYPES:
        tokens = tuple(map(str, value)) if kind.isArray and scalar == "TfToken" else None
        return tokens if kind.isArray else str(value)
    if scalar not in NUMBER_TYPES or (kind.isArray and scalar == "bool"):
        return None
    number, width = NUMBER_TYPES[scalar]
    return np.array(value, dtype=number).reshape((len(value), width) if kind.isArray else width)


def _are_alike(samples: tuple[Any, ...], kind: Sdf.ValueTypeName) -> bool:
    """Whether samples are numbers, as many each, or single tokens."""
    if kind.cppTypeName == "TfToken":
        return None not in samples
    arrays = [sample for sample in samples if isinstance(sample, np.ndarray) and sample.size]
    return len(arrays) == len(samples) and len({array.shape for array in arrays}) < 2
