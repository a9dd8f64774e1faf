"""Joins layers in USD's binary format: prims below one scope, some in each, become one layer.

USD itself would read every value and write it again, which takes a third of the time to make it. Here values stay the
bytes they are, and only what refers to something is changed. What a younger USD writes in a way that is not known here
is an error, and then USD's to copy.
"""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from usdfoot.writers.crate.columns import pack_bytes, pack_column
from usdfoot.writers.crate.parts import CHILDREN, END_OF_SET, IDENTIFIER, VALUES_PLACE, CratePart, read_part
from usdfoot.writers.crate.values import Renumbering, move_values

__all__ = ["CrateError", "JoinedLayer"]

_CHILD, _SIBLING, _NOTHING = -1, 0, -2
"""What is next to a path in the tree, or else how far ahead its sibling is."""
_NO_PROPERTY = b";-)"
"""First token: its number's sign could not say what is a property."""
_TOKEN_VECTOR = 41 << 48


class CrateError(ValueError):
    """A layer that cannot be joined as bytes."""


class JoinedLayer:
    """A binary layer to which what others have below a scope is added, one after the other.

    Args:
        file: Of a binary layer with the scope, which is empty; written anew.
        scope: Path of a prim.

    Raises:
        OSError: If the file cannot be read or written, also by the methods.
    """

    def __init__(self, file: Path, *, scope: str) -> None:
        self._file, self._scope = file, scope
        self._size = VALUES_PLACE
        self._unwritten: list[bytes | memoryview] = []
        self._version = b""
        self._tokens: dict[bytes, int] = {_NO_PROPERTY: 0}
        self._strings: dict[int, int] = {}
        self._outer: dict[str, int] = {}
        """Paths that are not below the scope."""
        self._inner: list[tuple[int, np.ndarray, np.ndarray]] = []
        """First path, elements and jumps of what each part has below it."""
        self._children: list[np.ndarray] = []
        """Tokens of their names."""
        self._path_count = 0
        self._names: list[np.ndarray] = []
        self._fields: list[np.ndarray] = []
        self._sets: list[np.ndarray] = []
        self._specs: list[np.ndarray] = []
        """Path, fields and kind, (3, P) of each part."""
        head = read_part(file)
        file.write_bytes(bytes(VALUES_PLACE))
        self._add(head, whole=True)

    def add(self, part: Path) -> None:
        """Adds a part, a binary layer that has the scope too, with children of other names than any before.

        Raises:
            CrateError: If it is none, or has values of a kind that is not known; then nothing more can be added.
        """
        try:
            self._add(read_part(part))
        except (ValueError, LookupError, struct.error) as error:
            raise CrateError(f"{part} cannot be joined with others ({error})") from error

    def _add(self, part: CratePart, *, whole: bool = False) -> None:
        """Adds a part: what is below the scope, or all of it."""
        self._version = max(self._version, part.version)
        tokens = np.array([self._tokens.setdefault(token, len(self._tokens)) for token in part.tokens])
        strings = [self._strings.setdefault(int(token), len(self._strings)) for token in tokens[part.strings]]
        rows, below = part.outline(self._scope)
        paths = self._add_paths(part, tokens, rows, below)
        numbers = Renumbering(
            shift=self._size - VALUES_PLACE, tokens=tokens, strings=np.array(strings, dtype=np.int64), paths=paths
        )
        self._children.append(tokens[part.children(part.paths[rows[self._scope]])])
        is_inner = np.zeros(len(paths), dtype=bool)
        is_inner[part.paths[below]] = True
        chosen = np.full(len(part.spec_paths), True) if whole else is_inner[part.spec_paths]
        starts = self._add_sets(part, part.spec_sets[chosen], numbers)
        self._specs.append(np.stack([paths[part.spec_paths[chosen]], starts, part.spec_kinds[chosen]]))
        self._append(part.values)
        self._write()

    def _add_paths(self, part: CratePart, tokens: np.ndarray, rows: Mapping[str, int], below: slice) -> np.ndarray:
        """New number of each of a part's paths."""
        paths = np.zeros(part.paths.max() + 1, dtype=np.int64)
        for path, row in rows.items():
            if path not in self._outer:
                self._outer[path] = self._path_count
                self._path_count += 1
            paths[part.paths[row]] = self._outer[path]
        elements, jumps = part.elements[below], part.jumps[below].copy()
        if len(elements):
            paths[part.paths[below]] = self._path_count + np.arange(len(elements))
            self._inner.append((self._path_count, np.sign(elements) * tokens[np.abs(elements)], jumps))
            self._path_count += len(elements)
        return paths

    def _add_sets(self, part: CratePart, starts: np.ndarray, numbers: Renumbering) -> np.ndarray:
        """Adds the sets of fields that begin there, with their fields and values; where they begin now."""
        is_end = part.field_sets == END_OF_SET
        owners = np.cumsum(is_end) - is_end
        is_used = np.isin(owners, owners[starts])
        used = part.field_sets[is_used]
        fields = np.unique(used[used != END_OF_SET])
        first = sum(map(len, self._names))
        places = sum(map(len, self._sets)) + np.cumsum(is_used) - 1
        self._names.append(numbers.tokens[part.field_names[fields]])
        self._fields.append(move_values(part.field_values[fields], part.values, numbers))
        self._sets.append(np.where(used == END_OF_SET, END_OF_SET, first + np.searchsorted(fields, used)))
        return np.asarray(places[starts])

    def _append(self, content: bytes | memoryview) -> int:
        """Has content be written, up to a multiple of 8 bytes; gives back where it is."""
        place, missing = self._size, bytes(-len(content) % 8)
        self._size += len(content) + len(missing)
        self._unwritten += [content, missing]
        return place

    def _write(self) -> None:
        with self._file.open("ab") as stream:
            stream.writelines(self._unwritten)
        self._unwritten.clear()

    def finish(self) -> None:
        """Writes what says what the values are."""
        self._list_children()
        elements, jumps, paths = self._tree()  # also names tokens that are written below
        specs = np.concatenate(self._specs, axis=1)
        names, sets = np.concatenate(self._names), np.concatenate(self._sets)
        text = b"".join(token + b"\0" for token in self._tokens)
        strings = np.array([*self._strings], dtype="<u4")
        sections = {
            "TOKENS": struct.pack("<QQ", len(self._tokens), len(text)) + pack_bytes(text),
            "STRINGS": struct.pack("<Q", len(strings)) + strings.tobytes(),
            "FIELDS": struct.pack("<Q", len(names))
            + pack_column(names)
            + pack_bytes(np.concatenate(self._fields).astype("<u8").tobytes()),
            "FIELDSETS": struct.pack("<Q", len(sets)) + pack_column(sets),
            "PATHS": struct.pack("<QQ", len(paths), len(paths)) + b"".join(map(pack_column, (paths, elements, jumps))),
            "SPECS": struct.pack("<Q", specs.shape[1]) + b"".join(map(pack_column, specs)),
        }
        places = [(name, self._append(part), len(part)) for name, part in sections.items()]
        entries = [struct.pack("<16sqq", name.encode(), place, size) for name, place, size in places]
        contents = self._append(struct.pack("<Q", len(entries)) + b"".join(entries))
        self._write()
        with self._file.open("r+b") as stream:
            stream.write(struct.pack("<8s8sq", IDENTIFIER, self._version, contents))

    def _list_children(self) -> None:
        """Has the scope say which children it has."""
        children = np.concatenate(self._children).astype("<u4")
        place = self._append(struct.pack("<Q", len(children)) + children.tobytes())
        specs, sets = self._specs[0], self._sets[0]
        (scope,) = np.flatnonzero(specs[0] == self._outer[self._scope])
        start = specs[1, scope]
        own = sets[start : start + int(np.flatnonzero(sets[start:] == END_OF_SET)[0])]
        specs[1, scope] = sum(map(len, self._sets))
        self._sets.append(np.array([*own, sum(map(len, self._names)), END_OF_SET]))
        self._names.append(np.array([self._tokens.setdefault(CHILDREN, len(self._tokens))]))
        self._fields.append(np.array([_TOKEN_VECTOR | place], dtype=np.uint64))

    def _tree(self) -> np.ndarray:
        """Elements, jumps and paths as the tree is walked, shape (3, N)."""
        children = defaultdict(list)
        for path in [*self._outer][1:]:
            children[path.rpartition("/")[0]].append(path)
        inner = self._inner_tree()
        rows: list[list[int]] = []
        cuts: list[int] = []

        def walk(path: str, *, is_last: bool) -> int:
            """Adds rows of a path and of those below it, but for what is below the scope; how many there are in all."""
            name = path.rpartition("/")[2].encode()
            row = [self._tokens.setdefault(name, len(self._tokens)), _SIBLING, self._outer[path]]
            rows.append(row)
            size = 0
            if path == self._scope:
                size = sum(part.shape[1] for part in inner)
                cuts.append(len(rows))
            for child in children[path]:
                size += walk(child, is_last=child == children[path][-1])
            if size or is_last:
                row[1] = (_CHILD if is_last else 1 + size) if size else _NOTHING
            return 1 + size

        walk("", is_last=True)
        before, after = np.split(np.array(rows).T, cuts, axis=1)
        return np.concatenate([before, *inner, after], axis=1)

    def _inner_tree(self) -> list[np.ndarray]:
        """The same of what is below the scope, part after part."""
        for _, elements, jumps in self._inner[:-1]:
            last = _last_sibling(jumps)
            jumps[last] = _SIBLING if jumps[last] == _NOTHING else len(elements) - last
        return [np.stack([elements, jumps, first + np.arange(len(jumps))]) for first, elements, jumps in self._inner]


def _last_sibling(jumps: np.ndarray) -> int:
    """Row of the last of the siblings that a part of the tree begins with."""
    row = 0
    while jumps[row] >= 0:
        row += max(1, int(jumps[row]))
    return row
