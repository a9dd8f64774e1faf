"""Reading: a layer that `write_layer` wrote, as the specs it was given."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.writers.crate.parts import END_OF_SET, VALUES_PLACE, CratePart, read_part
from usdfoot.writers.crate.specs import (
    ARRAY,
    INLINED,
    PLAIN_KINDS,
    VALUE_KINDS,
    Items,
    Names,
    Numbers,
    PackedSamples,
    Reference,
    SmallSamples,
    Spec,
    Text,
    TokenSamples,
    Type,
    Value,
)
from usdfoot.writers.crate.writing import LISTS

__all__ = ["read_layer"]

_PAYLOAD = (1 << 48) - 1
_SIZES = {
    **{kind.code & ~ARRAY: np.dtype(kind.number).itemsize * kind.width for kind in VALUE_KINDS.values()},
    **{code: np.dtype(number).itemsize * width for (number, width), code in PLAIN_KINDS.items()},
}
"""Bytes of a value, by its type."""


_DATA = "customLayerData"
_STEP = struct.Struct("<IqQ")
"""Of a dictionary: a key, how far ahead its value is, and the value."""


def read_layer(file: Path, scope: str) -> tuple[dict[str, Any], dict[str, Spec]]:
    """Custom layer data, and the prims below a scope by name, in their order, with all that is below them.

    Raises:
        OSError: If the file cannot be read.
        ValueError, LookupError, struct.error: If something else wrote it.
    """
    layer = _Layer(read_part(file))
    return layer.data(), layer.below(scope)


class _Layer:
    """A layer in parts."""

    def __init__(self, part: CratePart) -> None:
        self._part = part
        self._tokens = [token.decode() for token in part.tokens]
        self._names = part.field_names.tolist()
        self._fields = part.field_values.tolist()
        self._sets = part.field_sets.tolist()
        self._rows = [*zip(part.paths.tolist(), part.elements.tolist(), part.jumps.tolist(), strict=True)]
        starts, kinds = part.spec_sets.tolist(), part.spec_kinds.tolist()
        self._specs = {
            path: (start, kind) for path, start, kind in zip(part.spec_paths.tolist(), starts, kinds, strict=True)
        }
        self._paths: dict[int, str] = {}
        self._values: dict[int, Value] = {}
        self._read_sets: dict[int, dict[str, Value]] = {}
        self._trees: dict[tuple[int, bytes], Spec] = {}
        """Prims by their own fields and all of their rows below."""
        self._rows_said = self._said()
        self._name_paths()

    def _said(self) -> np.ndarray:
        """Of each row all that its spec is made of: set of fields, kind, element and jump, shape (N, 4)."""
        part = self._part
        said = np.full((len(part.paths), 4), -1)
        rows = np.empty(int(part.paths.max()) + 1, dtype=np.int64)
        rows[part.paths] = np.arange(len(part.paths))
        said[rows[part.spec_paths], :2] = np.stack([part.spec_sets, part.spec_kinds], axis=1)
        said[:, 2:] = np.stack([part.elements, part.jumps], axis=1)
        return said

    def data(self) -> dict[str, Any]:
        """What the layer says of itself."""
        start, _ = self._specs[self._rows[0][0]]
        own = self._sets[start : self._sets.index(END_OF_SET, start)]
        values = [self._fields[field] for field in own if self._tokens[self._names[field]] == _DATA]
        return self._dictionary(values[0]) if values else {}

    def _dictionary(self, value: int) -> dict[str, Any]:
        place, found = (value & _PAYLOAD) - VALUES_PLACE, {}
        if value & ~_PAYLOAD != Type.DICTIONARY:
            raise ValueError("data are written otherwise")
        (count,) = struct.unpack_from("<Q", self._part.values, place)
        for index in range(count):
            key, step, entry = _STEP.unpack_from(self._part.values, place + 8 + index * _STEP.size)
            if step != 8:
                raise ValueError("data are written otherwise")
            is_text = entry & ~_PAYLOAD == INLINED | Type.STRING
            found[self._string(key)] = self._string(entry & _PAYLOAD) if is_text else self._dictionary(entry)
        return found

    def _string(self, number: int) -> str:
        return self._tokens[int(self._part.strings[number])]

    def below(self, scope: str) -> dict[str, Spec]:
        rows, below = self._part.outline(scope)
        return self._specs_of(below.start, below.stop) if scope in rows else {}

    def _name_paths(self) -> None:
        """Paths of prims by number; nothing refers to a property."""
        above = [("", len(self._rows))]
        for row in np.flatnonzero(self._part.elements >= 0).tolist():
            path, element, jump = self._rows[row]
            while row >= above[-1][1]:
                above.pop()
            parent, end = above[-1]
            own = self._paths[path] = f"{parent}/{self._tokens[element]}" if row else ""
            if jump == -1 or jump > 0:
                above.append((own, row + jump if jump > 0 else end))

    def _specs_of(self, start: int, stop: int) -> dict[str, Spec]:
        """Specs in rows of the tree that are one another's siblings, by name."""
        found, row = {}, start
        while row < stop:
            path, element, jump = self._rows[row]
            end = row + jump if jump > 0 else stop if jump == -1 else row + 1
            name = self._tokens[abs(element)]
            if path not in self._specs:
                pass  # only somebody's path, and all below it
            elif element < 0 and end > row + 1:
                raise ValueError(f"{self._paths[path]} is no prim")
            elif element < 0:
                begin, kind = self._specs[path]
                found[f".{name}"] = Spec(kind, self._fields_at(begin), {})
            else:
                found[name] = self._prim(row, end)
            row = end
        return found

    def _prim(self, row: int, end: int) -> Spec:
        """Spec of a prim in a row, with all below it; the same where the same comes again."""
        begin, kind = self._specs[self._rows[row][0]]
        tree = begin, self._rows_said[row + 1 : end].tobytes()
        if tree not in self._trees:
            self._trees[tree] = Spec(kind, self._fields_at(begin), self._specs_of(row + 1, end))
        return self._trees[tree]

    def _fields_at(self, place: int) -> dict[str, Value]:
        """Fields of a set that begins there."""
        if place not in self._read_sets:
            own = self._sets[place : self._sets.index(END_OF_SET, place)]
            named = [(self._tokens[self._names[field]], field) for field in own]
            self._read_sets[place] = {name: self._value(field) for name, field in named if name not in LISTS}
        return self._read_sets[place]

    def _value(self, index: int) -> Value:
        """Value of a field."""
        if index not in self._values:
            self._values[index] = self._read(self._fields[index])
        return self._values[index]

    def _read(self, value: int) -> Value:
        kind, payload = value & ~_PAYLOAD, value & _PAYLOAD
        place = payload - VALUES_PLACE
        if kind == INLINED | Type.TOKEN:
            return Names(kind, (self._tokens[payload],))
        if kind == INLINED | Type.STRING:
            return Text(self._string(payload))
        if kind & INLINED or (kind & ARRAY and not payload and kind != ARRAY | Type.TOKEN):
            if kind & ~INLINED in (Type.STRING, Type.TOKEN):
                raise ValueError("strings are not written here")
            return value
        if kind in (ARRAY | Type.TOKEN, Type.TOKENS):
            return Names(kind, self._tokens_at(place) if payload else ())
        if kind == Type.TOKEN_EDITS:
            return Items(kind, self._part.values[place], self._tokens_at(place + 1))
        if kind == Type.PATH_EDITS:
            paths = tuple(self._paths[path] for path in self._listed(place + 1))
            return Items(kind, self._part.values[place], paths)
        if kind == Type.REFERENCES:
            return self._reference(place)
        if kind == Type.SAMPLES:
            return self._samples(place)
        size = _SIZES[kind & ~ARRAY]
        count = 8 + size * struct.unpack_from("<Q", self._part.values, place)[0] if kind & ARRAY else size
        return Numbers(kind, bytes(self._part.values[place : place + count]))

    def _listed(self, place: int) -> tuple[int, ...]:
        (count,) = struct.unpack_from("<Q", self._part.values, place)
        return struct.unpack_from(f"<{count}I", self._part.values, place + 8)

    def _tokens_at(self, place: int) -> tuple[str, ...]:
        return tuple([self._tokens[number] for number in self._listed(place)])

    def _reference(self, place: int) -> Reference:
        edit, count, asset, path, offset, scale, notes = struct.unpack_from("<BQIIddQ", self._part.values, place)
        if (edit, count, offset, scale, notes) != (1 << 5, 1, 0.0, 1.0, 0):
            raise ValueError("references are written otherwise")
        return Reference(self._string(asset), self._paths[path])

    def _samples(self, place: int) -> PackedSamples | TokenSamples | SmallSamples:
        values = self._part.values
        ahead, times, further, count = struct.unpack_from("<qQqQ", values, place)
        if (ahead, times & ~_PAYLOAD, further) != (8, Type.DOUBLES, 8):
            raise ValueError("samples are written otherwise")
        start = (times & _PAYLOAD) - VALUES_PLACE
        codes = bytes(values[start : start + 8 + 8 * count])
        samples = np.frombuffer(values, dtype="<u8", count=count, offset=place + 32)
        kind = int(samples[0]) & ~_PAYLOAD
        if kind == INLINED | Type.TOKEN:
            names = [self._tokens[number] for number in (samples & np.uint64(_PAYLOAD)).tolist()]
            return TokenSamples(tuple(names), codes)
        if kind & INLINED:
            return SmallSamples(tuple(samples.tolist()), codes)
        places = (samples - np.uint64(kind)).astype(np.int64) - VALUES_PLACE
        first, size = int(places[0]), _SIZES[kind & ~ARRAY]
        stride = 8 + size * struct.unpack_from("<Q", values, first)[0] if kind & ARRAY else size
        index, rest = np.divmod(places - first, stride)
        if rest.any() or (np.diff(index, prepend=0) >> 1).any():
            raise ValueError("samples are not written as whole arrays")
        rows = np.frombuffer(values, dtype=np.uint8, count=stride * (int(index[-1]) + 1), offset=first)
        rows = rows.reshape(-1, stride)
        if kind & ARRAY and (rows[:, :8] != rows[0, :8]).any():
            raise ValueError("samples are not written as whole arrays")
        return PackedSamples(kind, rows, index, codes)
