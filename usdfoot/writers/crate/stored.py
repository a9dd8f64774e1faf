"""Samples read from USD's binary format as the arrays that `write_samples` wrote: USD gives them one by one."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from usdfoot.writers.crate.parts import VALUES_PLACE, CratePart, read_part
from usdfoot.writers.crate.sampled import SAMPLE_KINDS, Samples

__all__ = ["read_samples"]

_SIMPLE = ~np.uint64((1 << 48) - 1)
"""What a value says of itself beside where it is."""


def read_samples(file: Path, scope: str) -> dict[str, dict[str, Samples]]:
    """Attributes with time samples of the prims below a scope, by the prim's and the attribute's name.

    Args:
        file: Of a binary layer whose samples `write_samples` wrote, whatever USD added.
        scope: Path of the prim above.

    Raises:
        OSError: If it cannot be read.
        ValueError: If samples are written otherwise.
    """
    part = read_part(file)
    _, below = part.outline(scope)
    fields = {path: part.fields_of(spec) for spec, path in enumerate(part.spec_paths.tolist())}
    found: dict[str, dict[str, Samples]] = {}
    for prim, attribute, path in _attributes(part, below):
        values = fields[path]
        if b"timeSamples" in values:
            type_name = part.tokens[values[b"typeName"] % (1 << 32)].decode()
            if type_name in SAMPLE_KINDS:
                place = values[b"timeSamples"] % (1 << 48) - VALUES_PLACE
                found.setdefault(prim, {})[attribute] = _samples_at(part.values, place, type_name)
    return found


def _attributes(part: CratePart, below: slice) -> Iterator[tuple[str, str, int]]:
    """Names of prim and property, and the property's path, of the prims that a part of the tree begins with."""
    rows = zip(part.elements[below].tolist(), part.jumps[below].tolist(), part.paths[below].tolist(), strict=True)
    prim, end = "", 0
    for row, (element, jump, path) in enumerate(rows):
        name = part.tokens[abs(element)].decode()
        if element < 0:
            yield prim, name, path
        elif row < end:
            raise ValueError(f"{prim} has prims below it")
        else:
            prim, end = name, below.stop if jump == -1 else row + max(1, jump)


def _samples_at(values: bytearray, place: int, type_name: str) -> Samples:
    """Samples of which the times are at a place."""
    kind = SAMPLE_KINDS[type_name]
    place += struct.unpack_from("<q", values, place)[0]
    times_place = struct.unpack_from("<Q", values, place)[0] % (1 << 48) - VALUES_PLACE
    place += 8
    place += struct.unpack_from("<q", values, place)[0]
    (count,) = struct.unpack_from("<Q", values, place)
    samples = np.frombuffer(values, dtype="<u8", count=count, offset=place + 8)
    codes = np.frombuffer(values, dtype="<f8", count=count, offset=times_place + 8)
    if (samples & _SIMPLE != np.uint64(kind.code)).any():
        raise ValueError("samples are not written as whole arrays")
    places = (samples - np.uint64(kind.code)).astype(np.int64) - VALUES_PLACE
    number = np.dtype(kind.number)
    head = 8 if kind.is_array else 0
    size = struct.unpack_from("<Q", values, places[0])[0] if kind.is_array else 1
    stride = head + size * kind.width * number.itemsize
    rows = np.frombuffer(values, dtype=np.uint8, count=int(places[-1] - places[0]) + stride, offset=int(places[0]))
    index, rest = np.divmod(places - places[0], stride)
    if rest.any() or len(rows) % stride or (np.diff(index) > 1).any():
        raise ValueError("samples are not written as whole arrays")
    rows = rows.reshape(-1, stride)
    if kind.is_array and (rows[:, :8].view("<u8") != size).any():
        raise ValueError("samples are not written as whole arrays")
    components = np.ascontiguousarray(rows[index, head:]).view(number)
    shape = (count, *([size] if kind.is_array else []), *([kind.width] if kind.width > 1 else []))
    return Samples(type_name=type_name, codes=codes, values=components.reshape(shape))
