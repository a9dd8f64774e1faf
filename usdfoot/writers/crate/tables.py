"""Tables: values, tokens, fields and sets of fields of a layer on its way into a file."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any, BinaryIO

import numpy as np

from usdfoot.maths.types import IntArray
from usdfoot.writers.crate.columns import pack_bytes, pack_column
from usdfoot.writers.crate.kept import KeptLayer, in_order
from usdfoot.writers.crate.parts import END_OF_SET, VALUES_PLACE
from usdfoot.writers.crate.specs import (
    ARRAY,
    INLINED,
    Items,
    Names,
    Numbers,
    PackedSamples,
    Reference,
    SmallSamples,
    Spec,
    SpecKind,
    Text,
    TokenSamples,
    Type,
    Value,
)

__all__ = ["LayerTables"]

_VERSION, _VERSION_OF_TIME_CODES = (bytes([0, minor, 0, 0, 0, 0, 0, 0]) for minor in (8, 9))
_ONCE = (PackedSamples, dict)
"""Values that are not looked for among earlier ones."""
_LISTS = "primChildren", "properties"
"""Fields that say what is below."""
_STEP = 8
"""From before what says how far ahead the next part is."""


class LayerTables:
    """What a layer's specs refer to by number; values go into the file as they come.

    Args:
        stream: Empty.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = stream.write(bytes(VALUES_PLACE))
        self.version = _VERSION
        """Of the format, as far as the values need it."""
        self.paths: dict[str, int] = {}
        """Rows of prims in the tree of paths."""
        self._shared: dict[bytes, int] = {}
        self._tokens = {"": 0}
        self._strings: dict[int, int] = {}
        self._fields: list[tuple[int, int]] = []
        self._known: dict[tuple[str, Value], int] = {}
        """Fields whose values may come again."""
        self._sets: dict[tuple[int, ...], int] = {}
        self._set_entries: list[int] = []
        self._own_sets: dict[int, int] = {}
        """Sets of fields of specs that come again, as prims of several do and as fields of properties."""
        self._taken: dict[int, _Taken] = {}
        """What is here of other layers."""

    def elements_of(self, layer: KeptLayer, rows: slice) -> list[int]:
        """Last names of paths that another layer has in some rows, as `KeptLayer` has them."""
        numbers, names = np.zeros(len(layer.tokens), dtype=np.int64), np.abs(layer.elements[rows])
        for name in in_order(names).tolist():
            numbers[name] = self.token(layer.tokens[name])
        elements: list[int] = (np.sign(layer.elements[rows]) * numbers[names]).tolist()
        return elements

    def sets_of(self, layer: KeptLayer, sets: IntArray) -> list[int]:
        """Where sets of fields of another layer begin here, those added that are not here yet."""
        taken = self._taken.setdefault(id(layer), _Taken(layer))
        ordered = in_order(sets)
        new = ordered[taken.sets[ordered] < 0]
        fields = layer.sets.fields_of(new)
        ordered = in_order(fields)
        added = ordered[taken.fields[ordered] < 0]
        taken.fields[added] = [self._field(*layer.fields[field]) for field in added.tolist()]
        numbers = iter(taken.fields[fields].tolist())
        sizes = layer.sets.sizes(new).tolist()
        taken.sets[new] = [self._share_set(tuple(islice(numbers, size))) for size in sizes]
        starts: list[int] = taken.sets[sets].tolist()
        return starts

    def set_of(self, spec: Spec) -> int:
        """Where the set of a spec's fields begins, which is added if it is not there yet."""
        own = id(spec) if spec.below else id(spec.fields)
        if own not in self._own_sets:
            self._own_sets[own] = self._add_set(spec)
        return self._own_sets[own]

    def _add_set(self, spec: Spec) -> int:
        own = [self._field(name, value) for name, value in spec.fields.items()]
        if spec.below:
            prims = tuple([name for name, below in spec.below.items() if below.kind == SpecKind.PRIM])
            properties = tuple([name[1:] for name in spec.below if name[0] == "."])
            lists = zip(_LISTS, (prims, properties), strict=True)
            own += [self._field(name, Names(Type.TOKENS, names)) for name, names in lists if names]
        return self._share_set(tuple(own))

    def _share_set(self, fields: tuple[int, ...]) -> int:
        if fields not in self._sets:
            self._sets[fields] = len(self._set_entries)
            self._set_entries += [*fields, END_OF_SET]
        return self._sets[fields]

    def _field(self, name: str, value: Value) -> int:
        """Number of a field, which is added if it is not there yet."""
        if isinstance(value, _ONCE):
            self._fields.append((self.token(name), self._value(value)))
            return len(self._fields) - 1
        field = self._known.get((name, value))
        if field is None:
            field = self._known[name, value] = len(self._fields)
            self._fields.append((self.token(name), self._value(value)))
        return field

    def _value(self, value: Value) -> int:
        """64 bits that are a value, or say where it is."""
        if isinstance(value, int):
            return value
        if isinstance(value, Numbers):
            if value.kind == ARRAY | Type.TIME_CODE:
                self.version = _VERSION_OF_TIME_CODES
            return value.kind | self._share(value.content)
        if isinstance(value, Names):
            if value.kind & INLINED:
                return value.kind | self.token(value.names[0])
            return value.kind | (self._share(self._listed(value.names)) if value.names else 0)
        if isinstance(value, Items):
            if value.kind == Type.PATH_EDITS:
                content = _listed([self.paths[path] for path in value.items])
            else:
                content = self._listed(value.items)
            return value.kind | self._share(bytes([value.edit]) + content)
        if isinstance(value, PackedSamples):
            start = self.append(value.rows) + value.kind
            return self._samples(value.times, start + value.offsets)
        if isinstance(value, TokenSamples):
            seen = [INLINED | Type.TOKEN | self.token(name) for name in value.names]
            return self._samples(value.times, np.array(seen))
        if isinstance(value, SmallSamples):
            return self._samples(value.times, np.array(value.values, dtype="<u8"))
        if isinstance(value, Text):
            return INLINED | Type.STRING | self._string(value.text)
        if isinstance(value, Reference):
            numbers = self._string(value.asset), self.paths[value.path]
            return Type.REFERENCES | self._share(struct.pack("<BQIIddQ", 1 << 5, 1, *numbers, 0.0, 1.0, 0))
        return self._dictionary(value)

    def _samples(self, times: bytes, values: np.ndarray) -> int:
        place = self._share(times)
        head = struct.pack("<qQqQ", _STEP, Type.DOUBLES | place, _STEP, len(values))
        return Type.SAMPLES | self.append(head + values.astype("<u8").tobytes())

    def _dictionary(self, entries: Mapping[str, Any]) -> int:
        content = struct.pack("<Q", len(entries))
        for key, entry in entries.items():
            is_text = isinstance(entry, str)
            value = INLINED | Type.STRING | self._string(entry) if is_text else self._dictionary(entry)
            content += struct.pack("<IqQ", self._string(key), _STEP, value)
        return Type.DICTIONARY | self.append(content)

    def token(self, name: str) -> int:
        """Number of a name."""
        return self._tokens.setdefault(name, len(self._tokens))

    def _string(self, text: str) -> int:
        return self._strings.setdefault(self.token(text), len(self._strings))

    def _listed(self, names: Sequence[str]) -> bytes:
        return _listed([self._tokens.setdefault(name, len(self._tokens)) for name in names])

    def append(self, content: bytes | memoryview) -> int:
        """Adds content; gives back where it is."""
        place = self._size
        self._size += self._stream.write(content)
        return place

    def _share(self, content: bytes) -> int:
        """Where content is, which is added if it is not there yet."""
        if content not in self._shared:
            self._shared[content] = self.append(content)
        return self._shared[content]

    def sections(self) -> dict[str, bytes]:
        """The file's sections of all this."""
        text = b"".join(token.encode() + b"\0" for token in self._tokens)
        values = np.array([value for _, value in self._fields], dtype="<u8").tobytes()
        return {
            "TOKENS": struct.pack("<QQ", len(self._tokens), len(text)) + pack_bytes(text),
            "STRINGS": struct.pack("<Q", len(self._strings)) + np.array([*self._strings], dtype="<u4").tobytes(),
            "FIELDS": struct.pack("<Q", len(self._fields))
            + pack_column([name for name, _ in self._fields])
            + pack_bytes(values),
            "FIELDSETS": struct.pack("<Q", len(self._set_entries)) + pack_column(self._set_entries),
        }


class _Taken:
    """Numbers here of another layer's fields and sets of fields, -1 of those that are not here."""

    def __init__(self, layer: KeptLayer) -> None:
        self.fields = np.full(len(layer.fields), -1)
        self.sets = np.full(len(layer.sets.starts), -1)


def _listed(numbers: Sequence[int]) -> bytes:
    return struct.pack(f"<Q{len(numbers)}I", len(numbers), *numbers)
