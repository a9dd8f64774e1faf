"""Crate: time samples in USD's binary format, written from whole arrays.

Only what prims with sampled attributes take of the format, at the version that USD itself writes unless a value needs
a younger one. After the values come the sections: tokens, fields (a name and a value each), sets of fields, paths and
specs, as columns of integers. Columns are compressed by LZ4, and a block without any match, as here, is LZ4 too.
USD writes the sections anew where it saves such a file, and leaves the values where they are.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.writers.crate.columns import pack_bytes, pack_column

__all__ = ["SAMPLE_KINDS", "SampleKind", "Samples", "write_samples"]

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
_DEFINED = _INLINED | _SPECIFIER
_END = -1
"""Ends a field set."""
_CHILD, _LEAF = -1, -2
"""Of a spec's jump."""


@dataclass(frozen=True, kw_only=True)
class SampleKind:
    """How a type's values are written."""

    code: int
    number: str
    """Type of its components."""
    width: int
    """How many a value has, or each value of an array."""

    @property
    def is_array(self) -> bool:
        """Whether the number of values comes before them."""
        return bool(self.code & _ARRAY)


SAMPLE_KINDS = {
    "double": SampleKind(code=9 << 48, number="<f8", width=1),
    "double3": SampleKind(code=23 << 48, number="<f8", width=3),
    "float[]": SampleKind(code=_ARRAY | 8 << 48, number="<f4", width=1),
    "float3[]": SampleKind(code=_ARRAY | 24 << 48, number="<f4", width=3),
    "quatf[]": SampleKind(code=_ARRAY | 17 << 48, number="<f4", width=4),
}
"""By USD's name of the type of an attribute."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """An attribute over time."""

    type_name: str
    """One of SAMPLE_KINDS."""
    codes: FloatArray
    """Time codes, increasing, shape (F,)."""
    values: FloatArray
    """Shape (F,) of double, (F, 3) of double3, (F, n) of float[], (F, n, 3) of float3[], xyzw (F, n, 4) of quatf[]."""


def write_samples(stream: BinaryIO, scope: Sequence[str], prims: Mapping[str, Mapping[str, Samples]]) -> None:
    """Writes a whole file in which prims without a type have the attributes.

    Args:
        stream: Empty.
        scope: Names of the prims above, from the root on.
        prims: Attributes of one or more prims, by name; each has at least one.
    """
    file, tokens = _File(stream), _Tokens()
    places = [[_append_samples(file, samples) for samples in prim.values()] for prim in prims.values()]
    specs = [*_specs_above(file, tokens, scope, prims), *_specs_of(file, tokens, prims, places)]
    contents = [(name, file.append(part), len(part)) for name, part in _sections(tokens, specs).items()]
    table = b"".join(struct.pack("<16sqq", name.encode(), *extent) for name, *extent in contents)
    place = file.append(struct.pack("<Q", len(contents)) + table)
    stream.seek(0)
    stream.write(_HEADER.pack(b"PXR-USDC", _VERSION, place))


class _File:
    """A file that grows, after room for its header."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = stream.write(bytes(_HEADER.size))
        self._shared: dict[bytes, int] = {}

    def append(self, content: bytes | memoryview) -> int:
        """Adds content; gives back where it is."""
        place = self._size
        self._size += self._stream.write(content)
        return place

    def share(self, content: bytes) -> int:
        """Where content is, which is added if it is not there yet."""
        if content not in self._shared:
            self._shared[content] = self.append(content)
        return self._shared[content]


class _Tokens:
    """Strings by number."""

    def __init__(self) -> None:
        self.numbers = {"": 0}

    def number(self, token: str) -> int:
        return self.numbers.setdefault(token, len(self.numbers))


def _append_samples(file: _File, samples: Samples) -> int:
    """Adds an attribute's values, those that stay the same once, and times; gives back where its time samples are."""
    kind, frames = SAMPLE_KINDS[samples.type_name], len(samples.codes)
    rows = np.ascontiguousarray(samples.values, dtype=kind.number).reshape(frames, samples.values[0].size)
    bits = rows.view(np.uint32)
    changed = np.append(True, (bits[1:] != bits[:-1]).any(axis=1))
    rows = rows if changed.all() else rows[changed]
    if kind.is_array:
        lengths = np.full((len(rows), 1), samples.values.shape[1], dtype="<u8")
        rows = np.concatenate([lengths.view(np.uint8), rows.view(np.uint8)], axis=1)
    start = file.append(rows.data) + kind.code
    values = start + rows.strides[0] * (np.cumsum(changed, dtype="<u8") - np.uint64(1))
    times = file.share(struct.pack("<Q", frames) + samples.codes.astype("<f8").tobytes())
    step = 8  # from before what says how far ahead the next part is
    return file.append(struct.pack("<qQqQ", step, _DOUBLES | times, step, frames) + values.tobytes())


@dataclass(frozen=True, kw_only=True)
class _Spec:
    """Of the root, a prim or an attribute, which follow one another as a tree is walked."""

    kind: int
    element: int
    """Number of its name's token; negative = of an attribute."""
    jump: int
    """_CHILD = has children alone, 0 = a sibling alone, _LEAF = neither; else how far ahead the sibling is."""
    fields: Mapping[str, int]
    """Values by name."""


def _specs_above(file: _File, tokens: _Tokens, scope: Sequence[str], children: Iterable[str]) -> list[_Spec]:
    """Root and prims above those that have the attributes."""
    names = [*([name] for name in scope), [*children]]
    lists = [{"primChildren": _listed(file, tokens, below)} for below in names]
    return [
        _Spec(kind=_ROOT, element=0, jump=_CHILD, fields=lists[0]),
        *(
            _Spec(kind=_PRIM, element=tokens.number(name), jump=_CHILD, fields={"specifier": _DEFINED, **below})
            for name, below in zip(scope, lists[1:], strict=True)
        ),
    ]


def _specs_of(
    file: _File, tokens: _Tokens, prims: Mapping[str, Mapping[str, Samples]], places: Sequence[Sequence[int]]
) -> list[_Spec]:
    """Prims with their attributes, whose time samples are in these places."""
    specs = []
    for number, (name, attributes) in enumerate(prims.items(), start=1):
        fields = {"specifier": _DEFINED, "properties": _listed(file, tokens, [*attributes])}
        jump = _CHILD if number == len(prims) else 1 + len(attributes)
        specs.append(_Spec(kind=_PRIM, element=tokens.number(name), jump=jump, fields=fields))
        for left, (attribute, place) in enumerate(
            zip(attributes, places[number - 1], strict=True), 1 - len(attributes)
        ):
            fields = {
                "custom": _INLINED | _BOOL,
                "typeName": _INLINED | _TOKEN | tokens.number(attributes[attribute].type_name),
                "variability": _INLINED | _VARIABILITY,
                "timeSamples": _TIME_SAMPLES | place,
            }
            jump = 0 if left else _LEAF
            specs.append(_Spec(kind=_ATTRIBUTE, element=-tokens.number(attribute), jump=jump, fields=fields))
    return specs


def _listed(file: _File, tokens: _Tokens, names: Sequence[str]) -> int:
    """Value that is a list of names."""
    numbers = np.array([tokens.number(name) for name in names], dtype="<u4")
    return _TOKENS | file.share(struct.pack("<Q", len(numbers)) + numbers.tobytes())


def _sections(tokens: _Tokens, specs: Sequence[_Spec]) -> dict[str, bytes]:
    """The sections by name. Specs, their paths and field sets follow one another."""
    fields = [(tokens.number(name), value) for spec in specs for name, value in spec.fields.items()]
    sizes = np.array([len(spec.fields) for spec in specs])
    ends, count = np.cumsum(sizes), len(specs)
    text = b"".join(token.encode() + b"\0" for token in tokens.numbers)
    values = np.array([value for _, value in fields], dtype="<u8").tobytes()
    return {
        "TOKENS": struct.pack("<QQ", len(tokens.numbers), len(text)) + pack_bytes(text),
        "STRINGS": struct.pack("<Q", 0),
        "FIELDS": struct.pack("<Q", len(fields)) + pack_column([number for number, _ in fields]) + pack_bytes(values),
        "FIELDSETS": struct.pack("<Q", len(fields) + count)
        + pack_column(np.insert(np.arange(len(fields)), ends, _END)),
        "PATHS": struct.pack("<QQ", count, count)
        + pack_column(np.arange(count))
        + pack_column([spec.element for spec in specs])
        + pack_column([spec.jump for spec in specs]),
        "SPECS": struct.pack("<Q", count)
        + pack_column(np.arange(count))
        + pack_column(ends - sizes + np.arange(count))
        + pack_column([spec.kind for spec in specs]),
    }
