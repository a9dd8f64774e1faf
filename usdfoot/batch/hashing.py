"""Hashing: one number for everything a chunk is made from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np

from usdfoot.model.clip import ClipLibrary

__all__ = ["content_hash", "library_hash"]

_PLAIN = (str, int, float, complex, type(None), np.generic)
"""Types whose values say all they are when printed."""


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
    kind = type(value)
    if kind in _PLAIN or isinstance(value, _PLAIN):
        text = repr(value)
        parts.append(f"{kind.__name__} {len(text)} {text} ".encode())
    elif isinstance(value, np.ndarray):
        parts += f"array {value.dtype.str} {value.shape} ".encode(), value.tobytes()
    elif isinstance(value, (tuple, list)):
        parts.append(b"sequence %d " % len(value))
        for item in value:
            _add_parts(parts, item)
    elif is_dataclass(value) and not isinstance(value, type):
        parts.append(f"{kind.__name__} ".encode())
        for name, label in _labelled_fields(type(value)):
            parts.append(label)
            _add_parts(parts, getattr(value, name))
    elif isinstance(value, Mapping):
        parts.append(b"mapping %d " % len(value))
        for key in sorted(value):
            _add_parts(parts, (key, value[key]))
    else:
        raise TypeError(f"{kind.__name__} has no content to hash")


@cache
def _labelled_fields(kind: type) -> tuple[tuple[str, bytes], ...]:
    """Names of a dataclass's fields, also as what its hash says before each."""
    return tuple((field.name, f"{field.name} ".encode()) for field in fields(kind))
