"""Attributes as they are to be: authored in a layer, or specs of a file that is written as bytes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge.tokens import Prim
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.writers.crate.kept import KeptPrim
from usdfoot.writers.crate.specs import (
    ARRAY,
    INLINED,
    VALUE_KINDS,
    Names,
    Samples,
    Spec,
    SpecKind,
    Type,
    Value,
    number,
    numbers,
    pack_samples,
    prepended,
    targets,
    token,
    token_samples,
)
from usdfoot.writers.layers import MODEL_KINDS, LayerFormat, author, rounded_codes

__all__ = [
    "UNIFORM",
    "Attribute",
    "author_attributes",
    "code_array",
    "layer_spec",
    "prim_spec",
    "relationship_spec",
    "sampled_spec",
    "seen_spec",
    "specs_of",
]

_DEFINED = INLINED | Type.SPECIFIER
UNIFORM = INLINED | Type.VARIABILITY | 1


class Attribute(NamedTuple):
    """An attribute that has a value at no time."""

    type_name: str
    """USD's."""
    value: Any
    """Numbers of the type's shape, a token or tokens."""
    uniform: bool = False
    interpolation: str = ""


def author_attributes(prim: Sdf.PrimSpec, attributes: Mapping[str, Attribute]) -> None:
    """Has a prim of a layer have the attributes, by name."""
    for name, attribute in attributes.items():
        type_name = Sdf.ValueTypeNames.Find(attribute.type_name)
        spec = author(prim, name, type_name, value=_usd_value(attribute), uniform=attribute.uniform)
        if attribute.interpolation:
            spec.SetInfo("interpolation", attribute.interpolation)


def _usd_value(attribute: Attribute) -> Any:
    """An attribute's value as USD's Python has it."""
    value = attribute.value
    if attribute.type_name == "token":
        return value
    if attribute.type_name == "token[]":
        return Vt.TokenArray(value)
    if attribute.type_name == "timecode[]":
        return Sdf.TimeCodeArray(value.tolist())
    if attribute.type_name == "quatd":
        x, y, z, w = value
        return Gf.Quatd(w, x, y, z)
    kind = VALUE_KINDS[attribute.type_name]
    if not kind.is_array:
        return float(value) if kind.width == 1 else Gf.Vec3d(*value)
    arrays = {
        "<i4": Vt.IntArray,
        "<f4": Vt.FloatArray,
        "<f43": Vt.Vec3fArray,
        "<f23": Vt.Vec3hArray,
        "<f24": Vt.QuathArray,
    }
    array = arrays[f"{kind.number}{kind.width if kind.width > 1 else ''}"]
    return array.FromNumpy(np.ascontiguousarray(value, dtype=kind.number))


def specs_of(attributes: Mapping[str, Attribute]) -> dict[str, Spec]:
    """Specs of attributes, as they are below their prim."""
    return {f".{name}": _spec(attribute) for name, attribute in attributes.items()}


def _spec(attribute: Attribute) -> Spec:
    fields = _fields(attribute.type_name, attribute.uniform).copy()
    if attribute.interpolation:
        fields["interpolation"] = token(attribute.interpolation)
    if attribute.type_name == "token":
        fields["default"] = token(attribute.value)
    elif attribute.type_name == "token[]":
        fields["default"] = Names(ARRAY | Type.TOKEN, tuple(attribute.value))
    else:
        fields["default"] = numbers(attribute.type_name, attribute.value)
    return Spec(SpecKind.ATTRIBUTE, fields, {})


@lru_cache
def _fields(type_name: str, uniform: bool) -> dict[str, Value]:
    """What attributes of a type have in common."""
    return {"typeName": token(type_name), **({"variability": UNIFORM} if uniform else {})}


def sampled_spec(samples: Samples) -> Spec:
    """Spec of an attribute over time."""
    return Spec(SpecKind.ATTRIBUTE, {**_fields(samples.type_name, False), "timeSamples": pack_samples(samples)}, {})


def seen_spec(default: str, codes: Sequence[float], names: Sequence[str]) -> Spec:
    """Spec of a token with a value at no time and others over time."""
    fields = {**_fields("token", False), "default": token(default)}
    if codes:
        fields["timeSamples"] = token_samples(codes, names)
    return Spec(SpecKind.ATTRIBUTE, fields, {})


def relationship_spec(paths: Sequence[str]) -> Spec:
    """Spec of a relationship with exactly these targets."""
    return Spec(SpecKind.RELATIONSHIP, {"variability": UNIFORM, "targetPaths": targets(paths)}, {})


def prim_spec(
    type_name: str, below: dict[str, Spec], *, schemas: Sequence[str] = (), fields: Mapping[str, Value] | None = None
) -> Spec:
    """Spec of a prim.

    Args:
        type_name: Of the prim.
        below: Its properties and prims.
        schemas: API schemas it has.
        fields: What else it has.
    """
    applied = {"apiSchemas": prepended(schemas)} if schemas else {}
    return Spec(
        SpecKind.PRIM, {"specifier": _DEFINED, "typeName": token(type_name), **applied, **(fields or {})}, below
    )


def layer_spec(
    layer_format: LayerFormat, scope: str, prims: Mapping[str, Spec | KeptPrim], *, data: Mapping[str, Any]
) -> Spec:
    """Spec of a layer, as `new_layer` begins it.

    Args:
        layer_format: What its metadata say.
        scope: Path of the prim above the prims, which is a scope.
        prims: By name.
        data: Custom layer data, strings and dictionaries of strings.
    """
    units = layer_format.units
    below: dict[str, Any] = dict(prims)
    for path in reversed(Sdf.Path(scope).GetPrefixes()):
        kind = MODEL_KINDS.get(str(path))
        kinds = {"kind": token(kind)} if kind else {}
        below = {path.name: prim_spec("Xform" if path == Prim.CROWD else "Scope", below, fields=kinds)}
    fields: dict[str, Value] = {
        "metersPerUnit": number(units.meters_per_unit),
        "upAxis": token(units.up_axis),
        "timeCodesPerSecond": number(units.time_codes_per_second),
        "framesPerSecond": number(layer_format.frames_per_second),
        "startTimeCode": number(layer_format.start_code),
        "endTimeCode": number(layer_format.end_code),
        "defaultPrim": token(Sdf.Path(Prim.CROWD).name),
        "customLayerData": dict(data),
    }
    return Spec(SpecKind.ROOT, fields, below)


def code_array(times: FloatArray, units: StageUnits) -> Attribute:
    """A uniform timecode[] of times [s]."""
    return Attribute("timecode[]", rounded_codes(units.times_to_codes(times)), uniform=True)
