"""Hashing: one number for everything a chunk is made from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache

import numpy as np

__all__ = ["content_hash"]


def content_hash(*values: object) -> str:
    """SHA-256 of values: frozen dataclasses, arrays, sequences, mappings, numbers and strings.

    Values that are equal have the same hash in any process; arrays also by type and shape.
    """
    parts: list[bytes] = []
    _add_parts(parts, values)
    return hashlib.sha256(b"".join(parts)).hexdigest()


def _add_parts(parts: list[bytes], value: object) -> None:
    """Adds the value as bytes, each part saying what it is, so that no two values run into each other."""
    if isinstance(value, np.ndarray):
        parts += f"array {value.dtype.str} {value.shape} ".encode(), np.ascontiguousarray(value).tobytes()
    elif isinstance(value, (str, int, float, complex, type(None), np.generic)):
        text = repr(value)
        parts.append(f"{type(value).__name__} {len(text)} {text} ".encode())
    elif isinstance(value, (tuple, list)):
        parts.append(f"sequence {len(value)} ".encode())
        for item in value:
            _add_parts(parts, item)
    elif is_dataclass(value) and not isinstance(value, type):
        parts.append(f"{type(value).__name__} ".encode())
        for name in _field_names(type(value)):
            parts.append(f"{name} ".encode())
            _add_parts(parts, getattr(value, name))
    elif isinstance(value, Mapping):
        parts.append(f"mapping {len(value)} ".encode())
        for key in sorted(value):
            _add_parts(parts, (key, value[key]))
    else:
        raise TypeError(f"{type(value).__name__} has no content to hash")


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))
