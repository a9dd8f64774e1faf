"""Own attributes and bindings of agents, as specs of their prims, which share their prototypes whatever these say."""

from __future__ import annotations

from typing import Any

import numpy as np

from usdfoot.bridge.own_attributes import OwnAttribute, OwnAttributes, OwnBinding
from usdfoot.writers.attributes import UNIFORM, relationship_spec
from usdfoot.writers.crate.specs import (
    ARRAY,
    INLINED,
    PLAIN_KINDS,
    Names,
    Numbers,
    Spec,
    SpecKind,
    Text,
    Type,
    Value,
    pack_numbers,
    small_samples,
    switch,
    token,
    token_samples,
)

__all__ = ["own_specs"]

_SMALL = Type.BOOL, Type.INT, Type.FLOAT
"""Types whose values are no place in the file."""


def own_specs(own: OwnAttributes, *, character: str) -> dict[str, Spec]:
    """Specs of attributes and bindings, as they are below their prim.

    Args:
        own: What there is.
        character: Path of the written character.
    """
    return {
        f".{name}": _binding(said, character)
        if isinstance(said, OwnBinding)
        else Spec(SpecKind.ATTRIBUTE, _fields(said), {})
        for name, said in own.items()
    }


def _binding(own: OwnBinding, character: str) -> Spec:
    spec = relationship_spec([own.material if own.source else f"{character}/{own.material}"])
    return spec._replace(fields={**spec.fields, "bindMaterialAs": token(own.strength)}) if own.strength else spec


def _fields(own: OwnAttribute) -> dict[str, Value]:
    fields: dict[str, Value] = {"typeName": token(own.type_name)}
    if own.is_custom:
        fields["custom"] = switch(True)
    if own.is_uniform:
        fields["variability"] = UNIFORM
    if own.interpolation:
        fields["interpolation"] = token(own.interpolation)
    if own.element_size is not None:
        fields["elementSize"] = _small(np.array([own.element_size], dtype="<i4"))
    if own.value is not None:
        fields["default"] = _value(own.type_name, own.value)
    if own.codes:
        fields["timeSamples"] = _samples(own)
    return fields


def _value(type_name: str, value: Any) -> Value:
    """A value at no time."""
    if isinstance(value, str):
        return Text(value) if type_name == "string" else token(value)
    if isinstance(value, tuple):
        return Names(ARRAY | Type.TOKEN, value)
    kind, is_array = _kind(value)
    if not is_array:
        return _small(value) if kind in _SMALL else Numbers(kind, value.tobytes())
    size = np.array(len(value), dtype="<u8").tobytes()
    return Numbers(ARRAY | kind, size + value.tobytes()) if len(value) else ARRAY | kind


def _samples(own: OwnAttribute) -> Value:
    if isinstance(own.samples[0], str):
        return token_samples(own.codes, own.samples)
    kind, is_array = _kind(own.samples[0])
    if kind in _SMALL and not is_array:
        return small_samples(own.codes, [_small(value) for value in own.samples])
    rows = np.stack(own.samples).reshape(len(own.samples), -1)
    code = ARRAY | kind if is_array else kind
    return pack_numbers(code, np.array(own.codes), rows, length=len(own.samples[0]))


def _kind(value: np.ndarray) -> tuple[int, bool]:
    """Type of numbers, of shape (C,) or (n, C), and whether they are an array."""
    return PLAIN_KINDS[value.dtype.str, value.shape[-1]], value.ndim > 1


def _small(value: np.ndarray) -> int:
    """A whole value, of shape (1,)."""
    return INLINED | _kind(value)[0] | int.from_bytes(value.tobytes(), "little")
