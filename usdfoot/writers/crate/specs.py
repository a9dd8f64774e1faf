"""Specs: prims and properties with their fields, and values as USD's binary format has them."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = [
    "ARRAY",
    "INLINED",
    "PLAIN_KINDS",
    "VALUE_KINDS",
    "Items",
    "Names",
    "Numbers",
    "PackedSamples",
    "Reference",
    "Samples",
    "SmallSamples",
    "Spec",
    "SpecKind",
    "Text",
    "TokenSamples",
    "Type",
    "Value",
    "ValueKind",
    "number",
    "numbers",
    "pack_numbers",
    "pack_samples",
    "prepended",
    "small_samples",
    "switch",
    "targets",
    "token",
    "token_samples",
]

ARRAY, INLINED = 1 << 63, 1 << 62
"""Bits of a value that say that it is an array, and that it is no place in the file."""
_EXPLICIT, _PREPENDED = 0b11, 1 << 5
"""What lists of edits have: all items, or those that come before others."""


class Type:
    """What a value is, in the upper 16 bits of 64; the others have the place in the file, or the value itself."""

    BOOL, INT, FLOAT, DOUBLE, STRING, TOKEN, QUATD, QUATF, QUATH, DOUBLE3, FLOAT3, HALF3 = (
        kind << 48 for kind in (1, 3, 8, 9, 10, 11, 16, 17, 18, 23, 24, 25)
    )
    INT64, DOUBLE2, FLOAT2, DOUBLE4, FLOAT4 = (kind << 48 for kind in (5, 19, 20, 27, 28))
    DICTIONARY, TOKEN_EDITS, PATH_EDITS, REFERENCES, TOKENS, SPECIFIER, VARIABILITY, SAMPLES, DOUBLES, TIME_CODE = (
        kind << 48 for kind in (31, 32, 34, 35, 41, 42, 44, 46, 48, 56)
    )


class SpecKind:
    """Kinds of specs; 0 = only somebody's path."""

    PATH, ATTRIBUTE, PRIM, ROOT, RELATIONSHIP = 0, 1, 6, 7, 8


@dataclass(frozen=True, kw_only=True)
class ValueKind:
    """How an attribute's values are written."""

    code: int
    number: str
    """Type of its components."""
    width: int
    """How many a value has, or each value of an array."""

    @property
    def is_array(self) -> bool:
        """Whether the number of values comes before them."""
        return bool(self.code & ARRAY)


VALUE_KINDS = {
    "float": ValueKind(code=Type.FLOAT, number="<f4", width=1),
    "double": ValueKind(code=Type.DOUBLE, number="<f8", width=1),
    "double3": ValueKind(code=Type.DOUBLE3, number="<f8", width=3),
    "quatd": ValueKind(code=Type.QUATD, number="<f8", width=4),
    "int[]": ValueKind(code=ARRAY | Type.INT, number="<i4", width=1),
    "float[]": ValueKind(code=ARRAY | Type.FLOAT, number="<f4", width=1),
    "float3[]": ValueKind(code=ARRAY | Type.FLOAT3, number="<f4", width=3),
    "point3f[]": ValueKind(code=ARRAY | Type.FLOAT3, number="<f4", width=3),
    "normal3f[]": ValueKind(code=ARRAY | Type.FLOAT3, number="<f4", width=3),
    "color3f[]": ValueKind(code=ARRAY | Type.FLOAT3, number="<f4", width=3),
    "half3[]": ValueKind(code=ARRAY | Type.HALF3, number="<f2", width=3),
    "quath[]": ValueKind(code=ARRAY | Type.QUATH, number="<f2", width=4),
    "quatf[]": ValueKind(code=ARRAY | Type.QUATF, number="<f4", width=4),
    "timecode[]": ValueKind(code=ARRAY | Type.TIME_CODE, number="<f8", width=1),
}
"""By USD's name of the type of an attribute whose values are numbers."""

PLAIN_KINDS = {
    ("|u1", 1): Type.BOOL,
    ("<i4", 1): Type.INT,
    ("<i8", 1): Type.INT64,
    ("<f4", 1): Type.FLOAT,
    ("<f8", 1): Type.DOUBLE,
    ("<f4", 2): Type.FLOAT2,
    ("<f4", 3): Type.FLOAT3,
    ("<f4", 4): Type.FLOAT4,
    ("<f8", 2): Type.DOUBLE2,
    ("<f8", 3): Type.DOUBLE3,
    ("<f8", 4): Type.DOUBLE4,
}
"""What values are written as, by the type of their components and how many there are."""


class Numbers(NamedTuple):
    """A value that refers to nothing, in the file once however often it comes."""

    kind: int
    content: bytes


class Names(NamedTuple):
    """Tokens: one, an array, or a list of a field."""

    kind: int
    names: tuple[str, ...]


class Items(NamedTuple):
    """An edit of a list of tokens or paths."""

    kind: int
    edit: int
    items: tuple[str, ...]


class Reference(NamedTuple):
    """A reference before others."""

    asset: str
    path: str


class PackedSamples(NamedTuple):
    """Time samples of numbers, those that stay the same once."""

    kind: int
    """Of each value."""
    rows: Any
    """Bytes of different values one after the other, as a buffer."""
    offsets: Any
    """Where in there each sample is [bytes], uint64, shape (F,)."""
    times: bytes
    """Number of samples and their time codes."""

    @property
    def codes(self) -> FloatArray:
        """Time codes, shape (F,)."""
        return np.frombuffer(self.times, dtype="<f8", offset=8)


class TokenSamples(NamedTuple):
    """Time samples of tokens."""

    names: tuple[str, ...]
    times: bytes


class SmallSamples(NamedTuple):
    """Time samples of values that are no place in the file, each an integer that refers to nothing."""

    values: tuple[int, ...]
    times: bytes


class Text(NamedTuple):
    """A string."""

    text: str


Value = int | Numbers | Names | Text | Items | Reference | PackedSamples | TokenSamples | SmallSamples | dict[str, Any]
"""An integer is a whole value that refers to nothing; a dictionary has strings and dictionaries."""


class Spec(NamedTuple):
    """Of the root, a prim or a property."""

    kind: int
    """Of SpecKind."""
    fields: Mapping[str, Value]
    """By name, without the lists of what is below."""
    below: dict[str, Any]
    """Specs of properties, named with a dot before, and of prims, or prims that are kept instead."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """An attribute over time."""

    type_name: str
    """One of VALUE_KINDS."""
    codes: FloatArray
    """Time codes, increasing, shape (F,)."""
    values: FloatArray
    """Shape (F,) of double, (F, 3) of double3, (F, n) of float[], (F, n, 3) of float3[], xyzw (F, n, 4) of quatf[]."""


def token(name: str) -> Names:
    """A token."""
    return Names(INLINED | Type.TOKEN, (name,))


def switch(is_on: bool) -> int:
    """A bool."""
    return INLINED | Type.BOOL | is_on


def number(value: float) -> Value:
    """A double, which is a float where that is as exact."""
    single = struct.pack("<f", value)
    if struct.unpack("<f", single)[0] == value:
        return INLINED | Type.DOUBLE | int.from_bytes(single, "little")
    return Numbers(Type.DOUBLE, struct.pack("<d", value))


def numbers(type_name: str, values: FloatArray | IntArray | float) -> Value:
    """An attribute's value of one of VALUE_KINDS, of the kind's shape."""
    kind = VALUE_KINDS[type_name]
    content = np.ascontiguousarray(values, dtype=kind.number)
    if kind.code == Type.FLOAT:
        return INLINED | kind.code | int.from_bytes(content.tobytes(), "little")
    if not kind.is_array:
        return Numbers(kind.code, content.tobytes())
    size = struct.pack("<Q", content.size // kind.width)
    return Numbers(kind.code, size + content.tobytes()) if content.size else kind.code


def prepended(names: Sequence[str]) -> Items:
    """Tokens before others."""
    return Items(Type.TOKEN_EDITS, _PREPENDED, tuple(names))


def targets(paths: Sequence[str]) -> Items:
    """Exactly these paths."""
    return Items(Type.PATH_EDITS, _EXPLICIT, tuple(paths))


def pack_samples(samples: Samples) -> PackedSamples:
    """Samples as they are written."""
    kind, frames = VALUE_KINDS[samples.type_name], len(samples.codes)
    rows = np.ascontiguousarray(samples.values, dtype=kind.number).reshape(frames, samples.values[0].size)
    return pack_numbers(kind.code, samples.codes, rows, length=samples.values.shape[1] if kind.is_array else 0)


def pack_numbers(code: int, codes: FloatArray, rows: FloatArray, *, length: int = 0) -> PackedSamples:
    """Samples as they are written, numbers of each in a row, shape (F, C) or (F, length * C) of arrays."""
    bits = rows.view(np.uint32)
    changed = np.append(True, (bits[1:] != bits[:-1]).any(axis=1))
    rows = rows if changed.all() else rows[changed]
    if code & ARRAY:
        lengths = np.full((len(rows), 1), length, dtype="<u8")
        rows = np.concatenate([lengths.view(np.uint8), rows.view(np.uint8)], axis=1)
    rows = rows.view(np.uint8)
    offsets = rows.shape[1] * (np.cumsum(changed) - 1)
    return PackedSamples(code, rows.data, offsets.astype("<u8"), _times(codes))


def small_samples(codes: Sequence[float], values: Sequence[int]) -> SmallSamples:
    """Values over time that are no place in the file."""
    return SmallSamples(tuple(values), _times(np.array(codes)))


def token_samples(codes: Sequence[float], names: Sequence[str]) -> TokenSamples:
    """Tokens over time."""
    return TokenSamples(tuple(names), _times(np.array(codes)))


def _times(codes: FloatArray) -> bytes:
    return struct.pack("<Q", len(codes)) + codes.astype("<f8").tobytes()
