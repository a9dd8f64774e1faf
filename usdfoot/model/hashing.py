"""Hashing: one number for everything a chunk is made from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache, lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from usdfoot.model.clip import ClipLibrary

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["content_hash", "library_hash"]

_Adder = Callable[[list[bytes], Any], None]
"""Adds a value as bytes."""

_PLAIN = (str, int, float, complex, type(None), np.generic)
"""Types whose values say all they are when printed."""
_TOLD_APART = {str, int, float, bool, type(None)}
"""Those of them that also say so when several are printed at once, as most fields of an agent are."""


def content_hash(*values: object) -> str:
    """SHA-256 of values: frozen dataclasses, arrays, sequences, mappings, numbers and strings.

    Values that are equal have the same hash in any process; arrays also by type and shape.
    """
    parts: list[bytes] = []
    _add_parts(parts, values)
    return hashlib.sha256(b"".join(parts)).hexdigest()


def library_hash(library: ClipLibrary, *values: object) -> str:
    """SHA-256 of a library, and of values, the same whichever of its agents' Skeletons gives it the name."""
    return content_hash(replace(library, skeleton=replace(library.skeleton, name="")), *values)


def _add_parts(parts: list[bytes], value: object) -> None:
    """Adds the value as bytes, each part saying what it is, so that no two values run into each other."""
    _adder_of(type(value))(parts, value)  # type: ignore[arg-type]  # types are hashable


@cache
def _adder_of(kind: type) -> _Adder:
    """What adds values of a type."""
    if issubclass(kind, np.ndarray):
        return _add_array
    if issubclass(kind, _PLAIN):
        return _add_plain
    if issubclass(kind, (tuple, list)):
        return _add_sequence
    if is_dataclass(kind):
        return _fields_adder(kind)
    if issubclass(kind, Mapping):
        return _add_mapping
    raise TypeError(f"{kind.__name__} has no content to hash")


def _add_array(parts: list[bytes], value: np.ndarray) -> None:
    parts += _array_label(value.dtype, value.shape), value.tobytes()


def _add_plain(parts: list[bytes], value: object) -> None:
    text = repr(value)
    parts.append(f"{type(value).__name__} {len(text)} {text} ".encode())


def _add_sequence(parts: list[bytes], value: Sequence[object]) -> None:
    parts.append(b"sequence %d " % len(value))
    for item in value:
        _add_parts(parts, item)


def _add_mapping(parts: list[bytes], value: Mapping[Any, object]) -> None:
    parts.append(b"mapping %d " % len(value))
    for key in sorted(value):
        _add_sequence(parts, (key, value[key]))


def _fields_adder(kind: type[DataclassInstance]) -> _Adder:
    """Adds a dataclass: fields of plain values all at once, in their order, and the others each with its name."""
    names = [field.name for field in fields(kind)]
    labels = [f"{name} ".encode() for name in names]
    values_of = attrgetter(*names) if len(names) > 1 else lambda value: tuple(getattr(value, name) for name in names)

    def add(parts: list[bytes], value: Any) -> None:
        values: tuple[object, ...] = values_of(value)
        plain = [item for item in values if type(item) in _TOLD_APART]
        parts.append(f"{kind.__name__} {len(values)} {len(plain)} {plain!r} ".encode())
        for label, item in zip(labels, values, strict=True):
            if type(item) not in _TOLD_APART:
                parts.append(label)
                _add_parts(parts, item)

    return add


@lru_cache(maxsize=1024)
def _array_label(kind: np.dtype[Any], shape: tuple[int, ...]) -> bytes:
    """What the hash of an array says before its bytes."""
    return f"array {kind.str} {shape} ".encode()
