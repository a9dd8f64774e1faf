"""Writing: layers in USD's binary format from their specs.

At the version that USD itself writes for the same: 0.8, and 0.9 where there are time codes. After the values come the
sections: tokens, fields (a name and a value each), sets of fields, paths and specs, as columns of integers. The same
prims in the same order give the same bytes, whether they were made or are those of another layer.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from usdfoot.writers.crate.columns import pack_column
from usdfoot.writers.crate.kept import KeptLayer, KeptPrim, mentioned_by
from usdfoot.writers.crate.parts import IDENTIFIER
from usdfoot.writers.crate.specs import Spec, SpecKind
from usdfoot.writers.crate.tables import LayerTables

__all__ = ["write_layer"]

_CHILD, _LEAF = -1, -2
"""Of a path's jump."""


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
        yield from mentioned_by(value)
    for below in spec.below.values():
        if isinstance(below, KeptPrim):
            yield from below.layer.mentioned(below.rows)
        elif below.kind != SpecKind.ATTRIBUTE:
            yield from _mentioned(below)


def _add_path(root: Spec, path: str) -> None:
    """Has a layer know a prim's path; prims that are kept have those below them."""
    spec: Spec | KeptPrim = root
    for name in path.split("/")[1:]:
        if isinstance(spec, KeptPrim):
            break
        spec = spec.below.setdefault(name, Spec(SpecKind.PATH, {}, {}))


class _KeptRows(NamedTuple):
    """Prims of another layer that are neighbours there and here."""

    layer: KeptLayer
    rows: slice


class _Layer:
    """A layer on its way into a file."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._tables = LayerTables(stream)
        self._elements: list[int] = []
        self._jumps: list[int] = []
        self._walked: list[tuple[int, Spec | _KeptRows]] = []
        """Specs with their rows."""
        self._trees: dict[int, tuple[str, slice, slice]] = {}
        """Prims with their first path, its rows and the specs in them."""

    def write(self, root: Spec) -> None:
        """Writes all of it."""
        self._walk("", root, is_last=True)
        specs = self._specs()
        tree = range(len(self._jumps)), self._elements, self._jumps
        append = self._tables.append
        sections = {
            **self._tables.sections(),
            "PATHS": struct.pack("<QQ", len(self._jumps), len(self._jumps)) + b"".join(map(pack_column, tree)),
            "SPECS": struct.pack("<Q", len(specs[0])) + b"".join(map(pack_column, specs)),
        }
        places = [(name, append(part), len(part)) for name, part in sections.items()]
        entries = [struct.pack("<16sqq", name.encode(), place, size) for name, place, size in places]
        contents = append(struct.pack("<Q", len(entries)) + b"".join(entries))
        self._stream.seek(0)
        self._stream.write(struct.pack("<8s8sq", IDENTIFIER, self._tables.version, contents))

    def _walk(self, path: str, spec: Spec, *, is_last: bool) -> None:
        """Numbers a prim's path and those below it."""
        if id(spec) in self._trees:
            self._walk_again(path, spec, is_last=is_last)
            return
        row = self._tables.paths[path] = len(self._jumps)
        first = len(self._walked)
        left = len(spec.below)
        self._step(self._tables.token(path.rpartition("/")[2]), spec, (_CHILD if left else _LEAF) if is_last else 0)
        if not left:
            return
        for name, group in _neighbours(spec.below):
            left -= len(group)
            below = group[0]
            if isinstance(below, KeptPrim):
                self._walk_kept(group, is_last=not left)
            elif name[0] == ".":
                self._step(-self._tables.token(name[1:]), below, 0 if left else _LEAF)
            else:
                self._walk(f"{path}/{name}", below, is_last=not left)
        if not is_last:
            self._jumps[row] = len(self._jumps) - row
        self._trees[id(spec)] = path, slice(row, len(self._jumps)), slice(first, len(self._walked))

    def _walk_again(self, path: str, spec: Spec, *, is_last: bool) -> None:
        """Numbers paths as those of the same spec elsewhere, of which there may be thousands."""
        first_path, rows, specs = self._trees[id(spec)]
        row, size = len(self._jumps), rows.stop - rows.start
        self._elements += [self._tables.token(path.rpartition("/")[2]), *self._elements[rows][1:]]
        own = (_CHILD if size > 1 else _LEAF) if is_last else (size if size > 1 else 0)
        self._jumps += [own, *self._jumps[rows][1:]]
        self._walked += [(row - rows.start + index, below) for index, below in self._walked[specs]]
        self._number_again(path, spec, first_path, row - rows.start)

    def _number_again(self, path: str, spec: Spec, first_path: str, ahead: int) -> None:
        """Paths of prims of a tree that is so far ahead of where it was first."""
        self._tables.paths[path] = self._tables.paths[first_path] + ahead
        for name, below in spec.below.items():
            if name[0] != ".":
                self._number_again(f"{path}/{name}", below, f"{first_path}/{name}", ahead)

    def _walk_kept(self, prims: Sequence[KeptPrim], *, is_last: bool) -> None:
        """Numbers paths of prims of another layer that follow each other there."""
        layer, rows = prims[0].layer, slice(prims[0].rows.start, prims[-1].rows.stop)
        ahead = len(self._jumps) - rows.start
        self._walked.append((len(self._jumps), _KeptRows(layer, rows)))
        self._elements += self._tables.elements_of(layer, rows)
        self._jumps += layer.jumps[rows].tolist()
        for prim in prims:
            size = prim.rows.stop - prim.rows.start
            self._jumps[ahead + prim.rows.start] = size if size > 1 else 0
        if is_last:
            self._jumps[ahead + prims[-1].rows.start] = _CHILD if size > 1 else _LEAF
        self._tables.paths |= {path: own + ahead for path, own in layer.paths_in(rows).items()}

    def _step(self, element: int, spec: Spec, jump: int) -> None:
        """Goes on to a path in the tree."""
        if spec.kind != SpecKind.PATH:
            self._walked.append((len(self._jumps), spec))
        self._elements.append(element)
        self._jumps.append(jump)

    def _specs(self) -> tuple[list[int], list[int], list[int]]:
        """Row, set of fields and kind of each spec."""
        rows: list[int] = []
        sets: list[int] = []
        kinds: list[int] = []
        for row, spec in self._walked:
            if isinstance(spec, _KeptRows):
                own = spec.rows.start + np.flatnonzero(spec.layer.kinds[spec.rows])
                rows += (own + (row - spec.rows.start)).tolist()
                sets += self._tables.sets_of(spec.layer, spec.layer.own_sets[own])
                kinds += spec.layer.kinds[own].tolist()
            else:
                rows.append(row)
                sets.append(self._tables.set_of(spec))
                kinds.append(spec.kind)
        return rows, sets, kinds


def _neighbours(below: Mapping[str, Spec | KeptPrim]) -> Iterator[tuple[str, list[Any]]]:
    """What is below a prim: one spec with its name, or prims of another layer that follow each other there."""
    kept: list[KeptPrim] = []
    for name, prim in below.items():
        if kept and not (isinstance(prim, KeptPrim) and prim.follows(kept[-1])):
            yield "", kept
            kept = []
        if isinstance(prim, KeptPrim):
            kept.append(prim)
        else:
            yield name, [prim]
    if kept:
        yield "", kept
