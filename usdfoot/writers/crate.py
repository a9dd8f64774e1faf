"""Crate: time samples in USD's binary format, written from whole arrays.

Only what a prim with sampled attributes takes of the format, at the version that USD itself writes unless a value needs
a younger one. After the values come the sections: tokens, fields (a name and a value each), sets of fields, paths and
specs, as columns of integers. Columns are compressed by LZ4, and a block without any match, as here, is LZ4 too.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from usdfoot.maths.types import FloatArray

__all__ = ["SAMPLES_PRIM", "Samples", "attribute_name", "write_samples"]

SAMPLES_PRIM = "Samples"
"""Name of the root prim that has the attributes."""

_VERSION = bytes([0, 8, 0, 0, 0, 0, 0, 0])
_HEADER = struct.Struct("<8s8sq64x")
"""Identifier, version and place of the table of contents."""
_ARRAY, _INLINED = 1 << 63, 1 << 62
_BOOL, _TOKEN, _TOKENS, _SPECIFIER, _VARIABILITY, _TIME_SAMPLES, _DOUBLES = (
    kind << 48 for kind in (1, 11, 41, 42, 44, 46, 48)
)
"""What a value is, in the upper 16 bits of 64; the others have the place in the file, or the value itself."""
_ATTRIBUTE, _PRIM, _ROOT = 1, 6, 7
"""Kinds of specs."""
_END = -1
"""Ends a field set."""


@dataclass(frozen=True, kw_only=True)
class _Kind:
    """How a type's values are written."""

    code: int
    number: str
    """Type of its components."""


_KINDS = {
    "double": _Kind(code=9 << 48, number="<f8"),
    "double3": _Kind(code=23 << 48, number="<f8"),
    "float[]": _Kind(code=_ARRAY | 8 << 48, number="<f4"),
    "float3[]": _Kind(code=_ARRAY | 24 << 48, number="<f4"),
    "quatf[]": _Kind(code=_ARRAY | 17 << 48, number="<f4"),
}


@dataclass(frozen=True, kw_only=True)
class Samples:
    """An attribute over time."""

    type_name: str
    """USD's name of its type: double, double3, float[], float3[] or quatf[]."""
    codes: FloatArray
    """Time codes, increasing, shape (F,)."""
    values: FloatArray
    """Shape (F,) of double, (F, 3) of double3, (F, n) of float[], (F, n, 3) of float3[], xyzw (F, n, 4) of quatf[]."""


def attribute_name(index: int) -> str:
    """Name of the attribute at an index of those written."""
    return f"sampled{index}"


def write_samples(stream: BinaryIO, attributes: Sequence[Samples]) -> None:
    """Writes a whole file in which the prim `SAMPLES_PRIM` has the attributes.

    Args:
        stream: Empty.
        attributes: To write, in order.
    """
    file = _File(stream)
    places = [_append_samples(file, samples) for samples in attributes]
    types = [samples.type_name for samples in attributes]
    tokens = _Tokens(["", SAMPLES_PRIM, *map(attribute_name, range(len(attributes)))])
    field_sets = _field_sets(file, tokens, [*zip(types, places, strict=True)])
    sections = _sections(tokens, field_sets, len(attributes))
    contents = [(name, file.append(part), len(part)) for name, part in sections.items()]
    table = b"".join(struct.pack("<16sqq", name.encode(), *extent) for name, *extent in contents)
    place = file.append(struct.pack("<Q", len(contents)) + table)
    stream.seek(0)
    stream.write(_HEADER.pack(b"PXR-USDC", _VERSION, place))


class _File:
    """A file that grows, after room for its header."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = stream.write(bytes(_HEADER.size))

    def append(self, content: bytes | memoryview) -> int:
        """Adds content; gives back where it is."""
        place = self._size
        self._size += self._stream.write(content)
        return place


class _Tokens:
    """Strings by number."""

    def __init__(self, first: Iterable[str]) -> None:
        self.numbers = {token: number for number, token in enumerate(first)}

    def number(self, token: str) -> int:
        return self.numbers.setdefault(token, len(self.numbers))


def _append_samples(file: _File, samples: Samples) -> int:
    """Adds an attribute's values and times; gives back where its time samples are."""
    kind, frames = _KINDS[samples.type_name], len(samples.codes)
    rows = np.ascontiguousarray(samples.values, dtype=kind.number).reshape(frames, samples.values[0].size)
    if kind.code & _ARRAY:
        lengths = np.full((frames, 1), samples.values.shape[1], dtype="<u8")
        rows = np.concatenate([lengths.view(np.uint8), rows.view(np.uint8)], axis=1)
    values = file.append(rows.data) + rows.strides[0] * np.arange(frames, dtype="<u8") + np.uint64(kind.code)
    times = file.append(struct.pack("<Q", frames) + samples.codes.astype("<f8").tobytes())
    step = 8  # from before what says how far ahead the next part is
    return file.append(struct.pack("<qQqQ", step, _DOUBLES | times, step, frames) + values.tobytes())


def _field_sets(file: _File, tokens: _Tokens, attributes: Sequence[tuple[str, int]]) -> list[dict[str, int]]:
    """Values of the fields of root, prim and attributes, by name.

    Args:
        file: Lists of names go there.
        tokens: By number.
        attributes: Type and place of the time samples of each.
    """

    def listed(names: Iterable[str]) -> int:
        numbers = [tokens.number(name) for name in names]
        return _TOKENS | file.append(struct.pack("<Q", len(numbers)) + np.array(numbers, dtype="<u4").tobytes())

    names = map(attribute_name, range(len(attributes)))
    return [
        {"primChildren": listed([SAMPLES_PRIM])},
        {"specifier": _INLINED | _SPECIFIER, "properties": listed(names)},
        *(
            {
                "custom": _INLINED | _BOOL,
                "typeName": _INLINED | _TOKEN | tokens.number(type_name),
                "variability": _INLINED | _VARIABILITY,
                "timeSamples": _TIME_SAMPLES | place,
            }
            for type_name, place in attributes
        ),
    ]


def _sections(tokens: _Tokens, field_sets: Sequence[Mapping[str, int]], attributes: int) -> dict[str, bytes]:
    """The sections by name. Root, prim and attributes follow one another as paths, specs and field sets."""
    fields = [(tokens.number(name), value) for field_set in field_sets for name, value in field_set.items()]
    sizes = np.array([len(field_set) for field_set in field_sets])
    ends = np.cumsum(sizes)
    specs = len(field_sets)
    elements = [tokens.number(""), tokens.number(SAMPLES_PRIM)]
    properties = [-tokens.number(attribute_name(index)) for index in range(attributes)]  # negative = of the prim
    jumps = ([-1, -1] + [0] * attributes)[: specs - 1] + [-2]  # a child alone, a sibling alone, neither
    kinds = [_ROOT, _PRIM] + [_ATTRIBUTE] * attributes
    text = b"".join(token.encode() + b"\0" for token in tokens.numbers)
    values = np.array([value for _, value in fields], dtype="<u8").tobytes()
    return {
        "TOKENS": struct.pack("<QQ", len(tokens.numbers), len(text)) + _packed(text),
        "STRINGS": struct.pack("<Q", 0),
        "FIELDS": struct.pack("<Q", len(fields)) + _column([number for number, _ in fields]) + _packed(values),
        "FIELDSETS": struct.pack("<Q", len(fields) + specs) + _column(np.insert(np.arange(len(fields)), ends, _END)),
        "PATHS": struct.pack("<QQ", specs, specs)
        + _column(np.arange(specs))
        + _column(elements + properties)
        + _column(jumps),
        "SPECS": struct.pack("<Q", specs)
        + _column(np.arange(specs))
        + _column(ends - sizes + np.arange(specs))
        + _column(kinds),
    }


def _column(integers: Sequence[int] | np.ndarray) -> bytes:
    """Integers as a value that is frequent, two bits each that say how wide they are, and their differences."""
    differences = np.diff(np.asarray(integers, dtype=np.int64), prepend=0).astype("<i4")
    widths = b"\xff" * ((2 * len(differences) + 7) // 8)  # 32 bits all
    return _packed(struct.pack("<i", 0) + widths + differences.tobytes())


def _packed(content: bytes) -> bytes:
    """Size and LZ4 block, in one piece, all of it literals."""
    more = len(content) - 15
    length = b"\xff" * (more // 255) + bytes([more % 255]) if more >= 0 else b""
    block = b"\0" + bytes([min(len(content), 15) << 4]) + length + content
    return struct.pack("<Q", len(block)) + block
