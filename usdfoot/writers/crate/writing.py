"""Writing: layers in USD's binary format from their specs.

At the version that USD itself writes for the same: 0.8, and 0.9 where there are time codes. After the values come the
sections: tokens, fields (a name and a value each), sets of fields, paths and specs, as columns of integers. The same
specs in the same order give the same bytes, whether they were made or read from another layer.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, BinaryIO

import numpy as np

from usdfoot.writers.crate.columns import pack_bytes, pack_column
from usdfoot.writers.crate.parts import END_OF_SET, IDENTIFIER, VALUES_PLACE
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

__all__ = ["LISTS", "write_layer"]

_VERSION, _VERSION_OF_TIME_CODES = (bytes([0, minor, 0, 0, 0, 0, 0, 0]) for minor in (8, 9))
_CHILD, _LEAF = -1, -2
"""Of a path's jump."""
_ONCE = (PackedSamples, dict)
"""Values that are not looked for among earlier ones."""
LISTS = "primChildren", "properties"
"""Fields that say what is below."""
_STEP = 8
"""From before what says how far ahead the next part is."""


def write_layer(stream: BinaryIO, root: Spec) -> None:
    """Writes a whole file.

    Args:
        stream: Empty.
        root: Of the layer; paths that values refer to are added to what is below.
    """
    for path in [*_mentioned(root)]:
        _add_path(root, path)
    _Layer(stream).write(root)


def _mentioned(spec: Spec) -> Iterator[str]:
    """Paths that values of a spec and those below refer to."""
    for value in spec.fields.values():
        if isinstance(value, Items) and value.kind == Type.PATH_EDITS:
            yield from value.items
        elif isinstance(value, Reference):
            yield value.path
    for below in spec.below.values():
        if below.kind != SpecKind.ATTRIBUTE:
            yield from _mentioned(below)


def _add_path(root: Spec, path: str) -> None:
    """Has a layer know a prim's path."""
    spec = root
    for name in path.split("/")[1:]:
        spec = spec.below.setdefault(name, Spec(SpecKind.PATH, {}, {}))


class _Layer:
    """A layer on its way into a file."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = stream.write(bytes(VALUES_PLACE))
        self._version = _VERSION
        self._shared: dict[bytes, int] = {}
        self._tokens = {"": 0}
        self._strings: dict[int, int] = {}
        self._paths: dict[str, int] = {}
        """Rows of prims in the tree of paths."""
        self._elements: list[int] = []
        self._jumps: list[int] = []
        self._walked: list[tuple[int, Spec]] = []
        """Specs with their rows."""
        self._fields: list[tuple[int, int]] = []
        self._known: dict[tuple[str, Value], int] = {}
        """Fields whose values may come again."""
        self._sets: dict[tuple[int, ...], int] = {}
        self._set_entries: list[int] = []
        self._own_sets: dict[int, int] = {}
        """Sets of fields of specs that come again, as prims of several do and as fields of properties."""
        self._trees: dict[int, tuple[str, slice, slice]] = {}
        """Prims with their first path, its rows and the specs in them."""

    def write(self, root: Spec) -> None:
        """Writes all of it."""
        self._walk("", root, is_last=True)
        specs = [(row, self._set_of(spec), spec.kind) for row, spec in self._walked]
        places = [(name, self._append(part), len(part)) for name, part in self._sections(specs).items()]
        entries = [struct.pack("<16sqq", name.encode(), place, size) for name, place, size in places]
        contents = self._append(struct.pack("<Q", len(entries)) + b"".join(entries))
        self._stream.seek(0)
        self._stream.write(struct.pack("<8s8sq", IDENTIFIER, self._version, contents))

    def _walk(self, path: str, spec: Spec, *, is_last: bool) -> None:
        """Numbers a prim's path and those below it."""
        if id(spec) in self._trees:
            self._walk_again(path, spec, is_last=is_last)
            return
        row = self._paths[path] = len(self._jumps)
        first = len(self._walked)
        last = len(spec.below)
        self._step(self._token(path.rpartition("/")[2]), spec, (_CHILD if last else _LEAF) if is_last else 0)
        for count, (name, below) in enumerate(spec.below.items(), start=1):
            if name[0] == ".":
                self._step(-self._token(name[1:]), below, _LEAF if count == last else 0)
            else:
                self._walk(f"{path}/{name}", below, is_last=count == last)
        if last and not is_last:
            self._jumps[row] = len(self._jumps) - row
        self._trees[id(spec)] = path, slice(row, len(self._jumps)), slice(first, len(self._walked))

    def _walk_again(self, path: str, spec: Spec, *, is_last: bool) -> None:
        """Numbers paths as those of the same spec elsewhere, of which there may be thousands."""
        first_path, rows, specs = self._trees[id(spec)]
        row, size = len(self._jumps), rows.stop - rows.start
        self._elements += [self._token(path.rpartition("/")[2]), *self._elements[rows][1:]]
        own = (_CHILD if size > 1 else _LEAF) if is_last else (size if size > 1 else 0)
        self._jumps += [own, *self._jumps[rows][1:]]
        self._walked += [(row - rows.start + index, below) for index, below in self._walked[specs]]
        self._number_again(path, spec, first_path, row - rows.start)

    def _number_again(self, path: str, spec: Spec, first_path: str, ahead: int) -> None:
        """Paths of prims of a tree that is so far ahead of where it was first."""
        self._paths[path] = self._paths[first_path] + ahead
        for name, below in spec.below.items():
            if name[0] != ".":
                self._number_again(f"{path}/{name}", below, f"{first_path}/{name}", ahead)

    def _step(self, element: int, spec: Spec, jump: int) -> None:
        """Goes on to a path in the tree."""
        if spec.kind != SpecKind.PATH:
            self._walked.append((len(self._jumps), spec))
        self._elements.append(element)
        self._jumps.append(jump)

    def _set_of(self, spec: Spec) -> int:
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
            lists = zip(LISTS, (prims, properties), strict=True)
            own += [self._field(name, Names(Type.TOKENS, names)) for name, names in lists if names]
        key = tuple(own)
        if key not in self._sets:
            self._sets[key] = len(self._set_entries)
            self._set_entries += [*own, END_OF_SET]
        return self._sets[key]

    def _field(self, name: str, value: Value) -> int:
        """Number of a field, which is added if it is not there yet."""
        if isinstance(value, _ONCE):
            self._fields.append((self._token(name), self._value(value)))
            return len(self._fields) - 1
        field = self._known.get((name, value))
        if field is None:
            field = self._known[name, value] = len(self._fields)
            self._fields.append((self._token(name), self._value(value)))
        return field

    def _value(self, value: Value) -> int:
        """64 bits that are a value, or say where it is."""
        if isinstance(value, int):
            return value
        if isinstance(value, Numbers):
            if value.kind == ARRAY | Type.TIME_CODE:
                self._version = _VERSION_OF_TIME_CODES
            return value.kind | self._share(value.content)
        if isinstance(value, Names):
            if value.kind & INLINED:
                return value.kind | self._token(value.names[0])
            return value.kind | (self._share(self._listed(value.names)) if value.names else 0)
        if isinstance(value, Items):
            if value.kind == Type.PATH_EDITS:
                content = _listed([self._paths[path] for path in value.items])
            else:
                content = self._listed(value.items)
            return value.kind | self._share(bytes([value.edit]) + content)
        if isinstance(value, PackedSamples):
            start = self._append(value.rows.data) + value.kind
            return self._samples(value.times, start + value.rows.shape[1] * value.order.astype("<u8"))
        if isinstance(value, TokenSamples):
            seen = [INLINED | Type.TOKEN | self._token(name) for name in value.names]
            return self._samples(value.times, np.array(seen))
        if isinstance(value, SmallSamples):
            return self._samples(value.times, np.array(value.values, dtype="<u8"))
        if isinstance(value, Text):
            return INLINED | Type.STRING | self._string(value.text)
        if isinstance(value, Reference):
            numbers = self._string(value.asset), self._paths[value.path]
            return Type.REFERENCES | self._share(struct.pack("<BQIIddQ", 1 << 5, 1, *numbers, 0.0, 1.0, 0))
        return self._dictionary(value)

    def _samples(self, times: bytes, values: np.ndarray) -> int:
        place = self._share(times)
        head = struct.pack("<qQqQ", _STEP, Type.DOUBLES | place, _STEP, len(values))
        return Type.SAMPLES | self._append(head + values.astype("<u8").tobytes())

    def _dictionary(self, entries: Mapping[str, Any]) -> int:
        content = struct.pack("<Q", len(entries))
        for key, entry in entries.items():
            is_text = isinstance(entry, str)
            value = INLINED | Type.STRING | self._string(entry) if is_text else self._dictionary(entry)
            content += struct.pack("<IqQ", self._string(key), _STEP, value)
        return Type.DICTIONARY | self._append(content)

    def _token(self, name: str) -> int:
        return self._tokens.setdefault(name, len(self._tokens))

    def _string(self, text: str) -> int:
        return self._strings.setdefault(self._token(text), len(self._strings))

    def _listed(self, names: Sequence[str]) -> bytes:
        return _listed([self._tokens.setdefault(name, len(self._tokens)) for name in names])

    def _append(self, content: bytes | memoryview) -> int:
        """Adds content; gives back where it is."""
        place = self._size
        self._size += self._stream.write(content)
        return place

    def _share(self, content: bytes) -> int:
        """Where content is, which is added if it is not there yet."""
        if content not in self._shared:
            self._shared[content] = self._append(content)
        return self._shared[content]

    def _sections(self, specs: Sequence[tuple[int, int, int]]) -> dict[str, bytes]:
        text = b"".join(token.encode() + b"\0" for token in self._tokens)
        values = np.array([value for _, value in self._fields], dtype="<u8").tobytes()
        tree = range(len(self._jumps)), self._elements, self._jumps
        return {
            "TOKENS": struct.pack("<QQ", len(self._tokens), len(text)) + pack_bytes(text),
            "STRINGS": struct.pack("<Q", len(self._strings)) + np.array([*self._strings], dtype="<u4").tobytes(),
            "FIELDS": struct.pack("<Q", len(self._fields))
            + pack_column([name for name, _ in self._fields])
            + pack_bytes(values),
            "FIELDSETS": struct.pack("<Q", len(self._set_entries)) + pack_column(self._set_entries),
            "PATHS": struct.pack("<QQ", len(self._jumps), len(self._jumps)) + b"".join(map(pack_column, tree)),
            "SPECS": struct.pack("<Q", len(specs)) + b"".join(map(pack_column, zip(*specs, strict=True))),
        }


def _listed(numbers: Sequence[int]) -> bytes:
    return struct.pack(f"<Q{len(numbers)}I", len(numbers), *numbers)
