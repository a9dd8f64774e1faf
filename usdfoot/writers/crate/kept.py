"""Kept prims: those of a layer that was written before, which go into another as they are, many at once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from usdfoot.maths.types import IntArray
from usdfoot.writers.crate.specs import Items, Reference, SpecKind, Type, Value

__all__ = ["KeptLayer", "KeptPrim", "SetsOfFields", "in_order", "mentioned_by"]


@dataclass(frozen=True, kw_only=True)
class SetsOfFields:
    """Sets of fields, one after the other."""

    fields: IntArray
    """Number of each field, and something else between the sets."""
    starts: IntArray
    """Where each set begins, shape (S,)."""
    ends: IntArray
    """Where each ends, shape (S,)."""

    def sizes(self, sets: IntArray) -> IntArray:
        """How many fields some of them have, shape (n,)."""
        return self.ends[sets] - self.starts[sets]

    def fields_of(self, sets: IntArray) -> IntArray:
        """Fields of some of them, one set after the other."""
        sizes = self.sizes(sets)
        before = np.cumsum(sizes) - sizes
        return self.fields[np.repeat(self.starts[sets] - before, sizes) + np.arange(sizes.sum())]


@dataclass(frozen=True, kw_only=True)
class KeptLayer:
    """A layer as it was written."""

    tokens: Sequence[str]
    elements: IntArray
    """Token of each path's last name as their tree is walked, negative of properties, shape (N,)."""
    jumps: IntArray
    """As of `CratePart`, shape (N,)."""
    kinds: IntArray
    """Of each path's spec, of `SpecKind`, shape (N,)."""
    sets: SetsOfFields
    own_sets: IntArray
    """Set of each path's spec, -1 of those without, shape (N,)."""
    fields: Sequence[tuple[str, Value]]
    """Name and value of each field."""
    prim_rows: IntArray
    """Paths that are no properties', shape (n,)."""
    paths: Sequence[str]
    """The same in words."""

    def paths_in(self, rows: slice) -> dict[str, int]:
        """Paths of prims in some rows, and their rows."""
        first, last = np.searchsorted(self.prim_rows, (rows.start, rows.stop)).tolist()
        return dict(zip(self.paths[first:last], self.prim_rows[first:last].tolist(), strict=True))

    def mentioned(self, rows: slice) -> Iterator[str]:
        """Paths that values of the specs in some rows refer to."""
        found, paths = self._mentions
        first, last = found.searchsorted((rows.start, rows.stop)).tolist()
        return chain.from_iterable(paths[first:last])

    @cached_property
    def _mentions(self) -> tuple[IntArray, Sequence[Sequence[str]]]:
        """Rows with values that refer to paths, and these."""
        every = np.arange(len(self.sets.starts))
        fields, owners = self.sets.fields_of(every), np.repeat(every, self.sets.sizes(every))
        chosen = np.isin(fields, [field for field, (_, value) in enumerate(self.fields) if mentioned_by(value)])
        paths: dict[int, list[str]] = defaultdict(list)
        for own, field in zip(owners[chosen].tolist(), fields[chosen].tolist(), strict=True):
            paths[own] += mentioned_by(self.fields[field][1])
        rows = np.flatnonzero(np.isin(self.own_sets, [*paths]))
        return rows, [paths[own] for own in self.own_sets[rows].tolist()]

    def field(self, rows: slice, attribute: str, name: str) -> Value:
        """Value of a field of an attribute that one of the rows has.

        Raises:
            LookupError: If none has.
        """
        number = -self.tokens.index(attribute)
        row = rows.start + np.flatnonzero(self.elements[rows] == number)[:1]
        fields = dict(self.fields[field] for field in self.sets.fields_of(self.own_sets[row]).tolist())
        return fields[name]


class KeptPrim(NamedTuple):
    """A prim of a layer with all below it, instead of its spec."""

    layer: KeptLayer
    rows: slice
    """Its path, and those of what is below."""

    @property
    def kind(self) -> int:
        """As of a spec."""
        return SpecKind.PRIM

    def follows(self, other: KeptPrim) -> bool:
        """Whether it comes right after another in their layer."""
        return self.layer is other.layer and self.rows.start == other.rows.stop


def mentioned_by(value: Value) -> Sequence[str]:
    """Paths that a value refers to."""
    if isinstance(value, Items) and value.kind == Type.PATH_EDITS:
        return value.items
    return (value.path,) if isinstance(value, Reference) else ()


def in_order(numbers: IntArray) -> IntArray:
    """Each of several numbers once, in the order in which they come first."""
    found, first = np.unique(numbers, return_index=True)
    return found[np.argsort(first)]
