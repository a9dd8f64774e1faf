"""Reading: a layer that `write_layer` wrote, of which another is to have prims as they are."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.writers.crate.kept import KeptLayer, KeptPrim, SetsOfFields
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
    SpecKind,
    Text,
    TokenSamples,
    Type,
    Value,
)

__all__ = ["read_data", "read_layer"]

_PAYLOAD = (1 << 48) - 1
_SIZES = {
    **{kind.code & ~ARRAY: np.dtype(kind.number).itemsize * kind.width for kind in VALUE_KINDS.values()},
    **{code: np.dtype(number).itemsize * width for (number, width), code in PLAIN_KINDS.items()},
}
"""Bytes of a value, by its type."""
_ARRAY_SIZES = {ARRAY | code: size for code, size in _SIZES.items()}
"""The same of each value of an array."""


_DATA = "customLayerData"
_MOST_DATA = 1 << 21
"""Bytes at the beginning of a layer's values of which these data, of 50,000 agents, are part."""
_STEP = struct.Struct("<IqQ")
"""Of a dictionary: a key, how far ahead its value is, and the value."""
_COUNT, _SAMPLES = struct.Struct("<Q"), struct.Struct("<qQqQ")


def read_layer(file: Path, scope: str) -> tuple[dict[str, Any], dict[str, KeptPrim]]:
    """Custom layer data, and the prims below a scope by name, in their order, with all that is below them.

    Raises:
        OSError: If the file cannot be read.
        ValueError, LookupError, struct.error: If something else wrote it.
    """
    read = _Layer(read_part(file))
    return read.data(), read.prims(scope)


def read_data(file: Path) -> dict[str, Any]:
    """Custom layer data alone; raises as `read_layer`."""
    return _Layer(read_part(file, most=_MOST_DATA)).data()


class _Layer:
    """A layer in parts."""

    def __init__(self, part: CratePart) -> None:
        self._part = part
        self._tokens = [token.decode() for token in part.tokens]
        if (part.paths != np.arange(len(part.paths))).any():
            raise ValueError("paths are numbered otherwise")
        self._paths: dict[int, str] = {}
        self._times: dict[int, bytes] = {}

    def data(self) -> dict[str, Any]:
        """What the layer says of itself."""
        (spec,) = np.flatnonzero(self._part.spec_paths == 0)
        value = self._part.fields_of(int(spec)).get(_DATA.encode())
        return {} if value is None else self._dictionary(value)

    def _dictionary(self, value: int) -> dict[str, Any]:
        place, found = (value & _PAYLOAD) - VALUES_PLACE, {}
        if value & ~_PAYLOAD != Type.DICTIONARY:
            raise ValueError("data are written otherwise")
        (count,) = _COUNT.unpack_from(self._part.values, place)
        for index in range(count):
            key, step, entry = _STEP.unpack_from(self._part.values, place + 8 + index * _STEP.size)
            if step != 8:
                raise ValueError("data are written otherwise")
            is_text = entry & ~_PAYLOAD == INLINED | Type.STRING
            found[self._string(key)] = self._string(entry & _PAYLOAD) if is_text else self._dictionary(entry)
        return found

    def _string(self, number: int) -> str:
        return self._tokens[int(self._part.strings[number])]

    def prims(self, scope: str) -> dict[str, KeptPrim]:
        """Prims below a scope by name."""
        part, layer = self._part, self._kept()
        _, below = part.outline(scope)
        found, row = {}, below.start
        while row < below.stop:
            jump = int(part.jumps[row])
            end = row + jump if jump > 0 else below.stop if jump == -1 else row + 1
            if layer.kinds[row] == SpecKind.PRIM:  # else only somebody's path
                found[self._tokens[part.elements[row]]] = KeptPrim(layer, slice(row, end))
            row = end
        return found

    def _kept(self) -> KeptLayer:
        """The layer with all of its values read: of what something else wrote nothing is to be kept."""
        part = self._part
        self._paths = self._named_paths()
        ends = np.flatnonzero(part.field_sets == END_OF_SET)
        sets = SetsOfFields(fields=part.field_sets, starts=np.append(0, ends[:-1] + 1), ends=ends)
        kinds, owns = np.zeros(len(part.paths), dtype=np.int64), np.full(len(part.paths), -1)
        kinds[part.spec_paths] = part.spec_kinds
        owns[part.spec_paths] = np.searchsorted(sets.starts, part.spec_sets)
        names = [self._tokens[name] for name in part.field_names.tolist()]
        values = [self._value(value) for value in part.field_values.tolist()]
        return KeptLayer(
            tokens=self._tokens,
            elements=part.elements,
            jumps=part.jumps,
            kinds=kinds,
            sets=sets,
            own_sets=owns,
            fields=[*zip(names, values, strict=True)],
            prim_rows=np.array([*self._paths]),
            paths=[*self._paths.values()],
        )

    def _named_paths(self) -> dict[int, str]:
        """Paths of prims by number; nothing refers to a property."""
        above, paths = [("", len(self._part.paths))], {}
        rows = np.flatnonzero(self._part.elements >= 0)
        elements, jumps = self._part.elements[rows].tolist(), self._part.jumps[rows].tolist()
        for row, element, jump in zip(rows.tolist(), elements, jumps, strict=True):
            while row >= above[-1][1]:
                above.pop()
            parent, end = above[-1]
            own = paths[row] = f"{parent}/{self._tokens[element]}" if row else ""
            if jump == -1 or jump > 0:
                above.append((own, row + jump if jump > 0 else end))
        return paths

    def _value(self, value: int) -> Value:
        kind, payload = value & ~_PAYLOAD, value & _PAYLOAD
        place = payload - VALUES_PLACE
        if kind in _ARRAY_SIZES and payload:
            (count,) = _COUNT.unpack_from(self._part.values, place)
            return Numbers(kind, bytes(self._part.values[place : place + 8 + _ARRAY_SIZES[kind] * count]))
        if kind in _SIZES:
            return Numbers(kind, bytes(self._part.values[place : place + _SIZES[kind]]))
        if kind == Type.SAMPLES:
            return self._samples(place)
        if kind == INLINED | Type.TOKEN:
            return Names(kind, (self._tokens[payload],))
        if kind == INLINED | Type.STRING:
            return Text(self._string(payload))
        if kind in (ARRAY | Type.TOKEN, Type.TOKENS):
            return Names(kind, self._tokens_at(place) if payload else ())
        if kind == Type.TOKEN_EDITS:
            return Items(kind, self._part.values[place], self._tokens_at(place + 1))
        if kind == Type.PATH_EDITS:
            paths = tuple(self._paths[path] for path in self._listed(place + 1))
            return Items(kind, self._part.values[place], paths)
        if kind == Type.REFERENCES:
            return self._reference(place)
        if kind == Type.DICTIONARY:
            return self._dictionary(value)
        if kind & INLINED or kind in _ARRAY_SIZES:
            return value
        raise ValueError(f"values of USD's type {kind >> 48:x} are not written here")

    def _listed(self, place: int) -> tuple[int, ...]:
        (count,) = _COUNT.unpack_from(self._part.values, place)
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
        ahead, times, further, count = _SAMPLES.unpack_from(values, place)
        if (ahead, times & ~_PAYLOAD, further) != (8, Type.DOUBLES, 8):
            raise ValueError("samples are written otherwise")
        codes = self._codes((times & _PAYLOAD) - VALUES_PLACE, count)
        samples = np.frombuffer(values, dtype="<u8", count=count, offset=place + _SAMPLES.size)
        first = int(samples[0])
        kind, start = first & ~_PAYLOAD, (first & _PAYLOAD) - VALUES_PLACE
        if kind == INLINED | Type.TOKEN:
            names = [self._tokens[number] for number in (samples & np.uint64(_PAYLOAD)).tolist()]
            return TokenSamples(tuple(names), codes)
        if kind & INLINED:
            return SmallSamples(tuple(samples.tolist()), codes)
        stride = _SIZES.get(kind) or 8 + _ARRAY_SIZES[kind] * _COUNT.unpack_from(values, start)[0]
        offsets = samples - np.uint64(first)
        steps = offsets[1:] - offsets[:-1]
        if (steps[steps != 0] != stride).any():
            raise ValueError("samples are not written one after the other")
        return PackedSamples(kind, values[start : start + int(offsets[-1]) + stride], offsets, codes)

    def _codes(self, place: int, count: int) -> bytes:
        """Number of samples and their time codes."""
        if place not in self._times:
            self._times[place] = bytes(self._part.values[place : place + 8 + 8 * count])
        return self._times[place]
