"""Values in USD's binary format that are moved to another file, where tokens, strings and paths have other numbers."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from usdfoot.writers.crate.parts import VALUES_PLACE

__all__ = ["Renumbering", "move_values"]

_STRING, _TOKEN, _ASSET, _TOKENS, _TIME_SAMPLES = 10, 11, 12, 41, 46
_TOKEN_LISTS, _PATH_LISTS, _REFERENCE_LISTS = 32, 34, 35
_PLAIN = {*range(1, 10), *range(13, 31), 42, 43, 44, 48, 51, 56}
"""Types of numbers, which refer to nothing."""
_ARRAY, _INLINED = np.uint64(1 << 63), np.uint64(1 << 62)
_PAYLOAD = np.uint64((1 << 48) - 1)
_TYPE_PLACE = np.uint64(48)
_TIMES, _SMALL = 48, 1 << 14
"""Upper 16 bits of times, and the one of these that says that a value is no place."""


@dataclass(frozen=True, kw_only=True)
class Renumbering:
    """What becomes of a file's values in another."""

    shift: int
    """How far what is not small is moved."""
    tokens: np.ndarray
    """New number of each token."""
    strings: np.ndarray
    paths: np.ndarray


def move_values(fields: np.ndarray, values: memoryview, numbers: Renumbering) -> np.ndarray:
    """Values of fields as they are in the other file; what they refer to is changed where it is, to what it is there.

    Args:
        fields: 64 bits each, different ones, shape (F,).
        values: Of the file they are from, from `VALUES_PLACE` on; changed.
        numbers: Of the other file.

    Raises:
        ValueError: If a value is of a type that is not known.
    """
    changes: Mapping[int, Callable[[memoryview, int, Renumbering], None]] = {
        _TOKEN: _change_tokens,
        _TOKENS: _change_tokens,
        _TOKEN_LISTS: lambda held, place, to: _change_lists(held, place, to.tokens),
        _PATH_LISTS: lambda held, place, to: _change_lists(held, place, to.paths),
        _REFERENCE_LISTS: _change_references,
        _TIME_SAMPLES: _change_samples,
    }
    kinds = _kinds(fields)
    unknown = sorted({*kinds.tolist()} - _PLAIN - {_STRING, _ASSET} - set(changes))
    if unknown:
        raise ValueError(f"values of USD's type {unknown[0]} cannot be moved")
    is_elsewhere = (fields & _INLINED == 0) & (fields & _PAYLOAD != 0)
    for kind, field in zip(kinds[is_elsewhere].tolist(), fields[is_elsewhere].tolist(), strict=True):
        if kind in (_STRING, _ASSET):
            raise ValueError(f"arrays of USD's type {kind} cannot be moved")
        if kind in changes:
            changes[kind](values, (field & int(_PAYLOAD)) - VALUES_PLACE, numbers)
    return _moved(fields, numbers)


def _kinds(fields: np.ndarray) -> np.ndarray:
    """Types of values."""
    return (fields >> _TYPE_PLACE) & np.uint64(0xFF)


def _moved(fields: np.ndarray, numbers: Renumbering) -> np.ndarray:
    """Values with the places and numbers of the other file."""
    kinds, payloads = _kinds(fields), fields & _PAYLOAD
    is_small = fields & _INLINED != 0
    shifted = payloads + np.uint64(numbers.shift)
    payloads = np.where(is_small | (payloads == 0), payloads, shifted)  # an empty array is nowhere
    for kind, new in ((_TOKEN, numbers.tokens), (_ASSET, numbers.tokens), (_STRING, numbers.strings)):
        chosen = is_small & (kinds == kind)
        payloads[chosen] = new[payloads[chosen].astype(np.int64)]
    return (fields & ~_PAYLOAD) | payloads


def _change_tokens(values: memoryview, place: int, numbers: Renumbering) -> None:
    _renumber(values, place, numbers.tokens)


def _renumber(values: memoryview, place: int, numbers: np.ndarray) -> int:
    """Gives what is listed at a place its new numbers; where the list ends."""
    (count,) = struct.unpack_from("<Q", values, place)
    listed = np.frombuffer(values, dtype="<u4", count=count, offset=place + 8)
    listed[:] = numbers[listed]
    return int(place + 8 + 4 * count)


def _change_lists(values: memoryview, place: int, numbers: np.ndarray) -> None:
    lists = (values[place] >> 1).bit_count()  # the first bit says whether they are explicit
    place += 1
    for _ in range(lists):
        place = _renumber(values, place, numbers)


def _change_references(values: memoryview, place: int, numbers: Renumbering) -> None:
    lists = (values[place] >> 1).bit_count()
    place += 1
    for _ in range(lists):
        (count,) = struct.unpack_from("<Q", values, place)
        place += 8
        for _ in range(count):
            asset, path, _, _, notes = struct.unpack_from("<IIddQ", values, place)
            if notes:
                raise ValueError("references with custom data cannot be moved")
            struct.pack_into("<II", values, place, numbers.strings[asset], numbers.paths[path])
            place += struct.calcsize("<IIddQ")


def _change_samples(values: memoryview, place: int, numbers: Renumbering) -> None:
    """Times are a value that may be anywhere, and so are the values; each is said to be so far ahead."""
    place += struct.unpack_from("<q", values, place)[0]
    (times,) = struct.unpack_from("<Q", values, place)
    if times >> 48 != _TIMES:
        raise ValueError("times of samples are no numbers")
    struct.pack_into("<Q", values, place, times + numbers.shift)
    place += 8
    place += struct.unpack_from("<q", values, place)[0]
    (count,) = struct.unpack_from("<Q", values, place)
    samples = np.frombuffer(values, dtype="<u8", count=count, offset=place + 8)
    least, most = int(samples.min()), int(samples.max())
    upper = least >> 48
    is_alike = upper == most >> 48 and least & int(_PAYLOAD) != 0  # as nearly always
    if is_alike and upper & 0xFF in _PLAIN and not upper & _SMALL:
        samples += np.uint64(numbers.shift)
        return
    if not {*_kinds(samples).tolist()} <= _PLAIN | {_TOKEN}:
        raise ValueError("time samples of this type cannot be moved")
    samples[:] = _moved(samples, numbers)
