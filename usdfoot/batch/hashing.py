"""Hashing: one number for everything a chunk is made from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache, lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from usdfoot.model.clip import ClipLibrary

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["content_hash", "library_hash"]

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


def _add_parts(parts: list[bytes], value: Any) -> None:
    """Adds the value as bytes, each part saying what it is, so that no two values run into each other."""
    kind = type(value)
    if isinstance(value, np.ndarray):
        parts += _array_label(value.dtype, value.shape), value.tobytes()
    elif isinstance(value, _PLAIN):
        text = repr(value)
        parts.append(f"{kind.__name__} {len(text)} {text} ".encode())
    elif isinstance(value, (tuple, list)):
        parts.append(b"sequence %d " % len(value))
        for item in value:
            _add_parts(parts, item)
    elif is_dataclass(value) and not isinstance(value, type):
        _add_fields(parts, value)
    elif isinstance(value, Mapping):
        parts.append(b"mapping %d " % len(value))
        for key in sorted(value):
            _add_parts(parts, (key, value[key]))
    else:
        raise TypeError(f"{kind.__name__} has no content to hash")


def _add_fields(parts: list[bytes], value: DataclassInstance) -> None:
    """Adds a dataclass: fields of plain values all at once, in their order, and the others each with its name."""
    names, values = _labelled_names(type(value)), _values_of(type(value))(value)
    plain = [item for item in values if type(item) in _TOLD_APART]
    parts.append(f"{type(value).__name__} {len(values)} {len(plain)} {plain!r} ".encode())
    for name, item in zip(names, values, strict=True):
        if type(item) not in _TOLD_APART:
            parts.append(name)
            _add_parts(parts, item)


@lru_cache(maxsize=1024)
def _array_label(kind: np.dtype[Any], shape: tuple[int, ...]) -> bytes:
    """What the hash of an array says before its bytes."""
    return f"array {kind.str} {shape} ".encode()


@cache
def _labelled_names(kind: type) -> tuple[bytes, ...]:
    """Names of a dataclass's fields, as its hash says them."""
    return tuple(f"{field.name} ".encode() for field in fields(kind))


@cache
def _values_of(kind: type) -> Callable[[Any], tuple[Any, ...]]:
    """Gives the values of a dataclass's fields."""
    names = [field.name for field in fields(kind)]
    return attrgetter(*names) if len(names) > 1 else lambda value: tuple(getattr(value, name) for name in names)
