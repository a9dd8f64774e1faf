"""Hashing: one number for everything a chunk is made from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass

import numpy as np

__all__ = ["content_hash"]


def content_hash(*values: object) -> str:
    """SHA-256 of values: frozen dataclasses, arrays, sequences, mappings, numbers and strings.

    Values that are equal have the same hash in any process; arrays also by type and shape.
    """
    digest = hashlib.sha256()
    for part in _parts(values):
        digest.update(part)
    return digest.hexdigest()


def _parts(value: object) -> Iterator[bytes]:
    """The value as bytes, each part saying what it is, so that no two values run into each other."""
    if isinstance(value, np.ndarray):
        yield f"array {value.dtype.str} {value.shape} ".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        yield f"{type(value).__name__} ".encode()
        for field in fields(value):
            yield f"{field.name} ".encode()
            yield from _parts(getattr(value, field.name))
    elif isinstance(value, Mapping):
        yield f"mapping {len(value)} ".encode()
        for key in sorted(value):
            yield from _parts((key, value[key]))
    elif isinstance(value, (tuple, list)):
        yield f"sequence {len(value)} ".encode()
        for item in value:
            yield from _parts(item)
    elif not isinstance(value, (str, int, float, complex, type(None), np.generic)):
        raise TypeError(f"{type(value).__name__} has no content to hash")
    else:
        text = repr(value)
        yield f"{type(value).__name__} {len(text)} {text} ".encode()
