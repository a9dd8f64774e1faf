"""Parts: layers in USD's binary format, taken apart without USD reading every value."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from usdfoot.writers.crate.columns import unpack_bytes, unpack_column

__all__ = ["CHILDREN", "END_OF_SET", "IDENTIFIER", "VALUES_PLACE", "CratePart", "read_part"]

IDENTIFIER = b"PXR-USDC"
CHILDREN = b"primChildren"
"""Name of the field that lists a prim's children."""
END_OF_SET = -1
VALUES_PLACE = 88
"""Where a file's values begin, after its header."""


@dataclass(frozen=True, kw_only=True)
class CratePart:
    """What a binary layer consists of. Tokens, paths and so on refer to each other by number."""

    version: bytes
    """Of the format."""
    values: memoryview
    """All values that are not small, as they are in the file from `VALUES_PLACE` on."""
    tokens: Sequence[bytes]
    strings: np.ndarray
    """Token of each string, (S,)."""
    field_names: np.ndarray
    """Token of each field, (F,)."""
    field_values: np.ndarray
    """Value of each field or where it is, as 64 bits, (F,)."""
    field_sets: np.ndarray
    """Fields of each set, one set after the other, each ended by -1."""
    spec_paths: np.ndarray
    """Path of each spec, (P,)."""
    spec_sets: np.ndarray
    """Where in `field_sets` each spec's fields begin, (P,)."""
    spec_kinds: np.ndarray
    paths: np.ndarray
    """Paths in the order in which their tree is walked, (N,)."""
    elements: np.ndarray
    """Token of each path's last name in that order, negative of properties, (N,)."""
    jumps: np.ndarray
    """-1 = a child is next, 0 = a sibling is, -2 = neither; else a child is, and a sibling so far ahead, (N,)."""

    def outline(self, scope: str) -> tuple[Mapping[str, int], slice]:
        """Rows of the tree by path, without those below a prim, and the rows of these.

        Raises:
            ValueError: If something that is not below the prim has properties.
        """
        rows: dict[str, int] = {}
        above = [("", len(self.paths))]
        below = slice(0, 0)
        row = 0
        while row < len(self.paths):
            while row >= above[-1][1]:
                above.pop()
            parent, parent_end = above[-1]
            element, jump = int(self.elements[row]), int(self.jumps[row])
            if element < 0:
                raise ValueError(f"{parent or '/'} has properties, which only prims below {scope} may have")
            path = f"{parent}/{self.tokens[element].decode()}" if row else ""
            end = row + jump if jump > 0 else parent_end if jump == -1 else row + 1
            rows[path] = row
            if path == scope:
                below, row = slice(row + 1, end), end
            else:
                above.append((path, end))
                row += 1
        return rows, below

    def children(self, path: int) -> np.ndarray:
        """Tokens of the names of a prim's children in their order, which the tree does not tell."""
        (spec,) = np.flatnonzero(self.spec_paths == path)
        value = self.fields_of(int(spec)).get(CHILDREN)
        if value is None:
            return np.zeros(0, dtype=np.int64)
        place = value % (1 << 48) - VALUES_PLACE
        (count,) = struct.unpack_from("<Q", self.values, place)
        return np.frombuffer(self.values, dtype="<u4", count=count, offset=place + 8).astype(np.int64)

    def fields_of(self, spec: int) -> dict[bytes, int]:
        """Values of a spec's fields by name."""
        start = end = int(self.spec_sets[spec])
        while self.field_sets[end] != END_OF_SET:
            end += 1
        fields = self.field_sets[start:end]
        names = [self.tokens[name] for name in self.field_names[fields]]
        return dict(zip(names, self.field_values[fields].tolist(), strict=True))


def read_part(path: Path, *, most: int | None = None) -> CratePart:
    """A binary layer, taken apart.

    The file is read, not mapped, which would end the process if somebody made it shorter meanwhile.

    Args:
        path: Of the file.
        most: How many bytes of its values are enough; None = all.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is none.
    """
    with path.open("rb") as stream:
        if stream.read(len(IDENTIFIER)) != IDENTIFIER:
            raise ValueError(f"{path} is no layer in USD's binary format")
        version = stream.read(8)
        end, readers = _sections(stream)
        stream.seek(VALUES_PLACE)
        count = end - VALUES_PLACE if most is None else min(end - VALUES_PLACE, most)
        values = np.fromfile(stream, dtype=np.uint8, count=max(0, count)).data  # which nobody fills with zeros before
    tokens, strings, fields, sets, paths, specs = (
        readers[name] for name in ("TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS")
    )
    token_count, _ = tokens.number(), tokens.number()
    string_count, field_count, set_count = strings.number(), fields.number(), sets.number()
    _, path_count, spec_count = paths.number(), paths.number(), specs.number()
    return CratePart(
        version=version,
        values=values,
        tokens=tokens.packed().split(b"\0")[:token_count],
        strings=np.frombuffer(strings.rest(), dtype="<u4")[:string_count].astype(np.int64),
        field_names=fields.column(field_count),
        field_values=np.frombuffer(fields.packed(), dtype="<u8"),
        field_sets=sets.column(set_count),
        paths=paths.column(path_count),
        elements=paths.column(path_count),
        jumps=paths.column(path_count),
        spec_paths=specs.column(spec_count),
        spec_sets=specs.column(spec_count),
        spec_kinds=specs.column(spec_count),
    )


class _Reader:
    """Reads a section from its beginning."""

    def __init__(self, content: bytes) -> None:
        self._content, self._place = content, 0

    def number(self) -> int:
        (number,) = struct.unpack_from("<Q", self._content, self._place)
        self._place += 8
        return int(number)

    def column(self, count: int) -> np.ndarray:
        return unpack_column(self._block(), count)

    def packed(self) -> bytes:
        return unpack_bytes(self._block())

    def rest(self) -> bytes:
        return self._content[self._place :]

    def _block(self) -> bytes:
        size = self.number()
        self._place += size
        return self._content[self._place - size : self._place]


def _sections(stream: BinaryIO) -> tuple[int, dict[str, _Reader]]:
    """Where the first section begins, and what is in each by name."""
    stream.seek(_number(stream))
    entries = [struct.unpack("<16sqq", stream.read(32)) for _ in range(_number(stream))]
    first = min(start for _, start, _ in entries)
    stream.seek(first)
    content = stream.read()
    readers = {
        name.rstrip(b"\0").decode(): _Reader(content[start - first : start - first + size])
        for name, start, size in entries
    }
    return first, readers


def _number(stream: BinaryIO) -> int:
    (number,) = struct.unpack("<q", stream.read(8))
    return int(number)
