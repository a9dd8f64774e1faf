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
_TIMES = np.uint64(48)
"""Upper 16 bits of times."""
_SAMPLED = np.isin(np.arange(256), [*_PLAIN, _TOKEN])
"""Whether samples may be of each type."""
_LISTS = np.array([(flags >> 1).bit_count() for flags in range(256)])
"""How many lists there are by the flags before them, of which the first says whether they are explicit."""


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
        fields: 64 bits each, shape (F,).
        values: Of the file they are from, from `VALUES_PLACE` on; changed.
        numbers: Of the other file.

    Raises:
        ValueError: If a value is of a type that is not known.
    """
    changes: Mapping[int, Callable[[_Held, np.ndarray, Renumbering], None]] = {
        _TOKEN: _change_tokens,
        _TOKENS: _change_tokens,
        _TOKEN_LISTS: lambda held, places, to: _change_lists(held, places, to.tokens),
        _PATH_LISTS: lambda held, places, to: _change_lists(held, places, to.paths),
        _REFERENCE_LISTS: _change_references,
        _TIME_SAMPLES: _change_samples,
    }
    kinds = _kinds(fields)
    unknown = sorted({*kinds.tolist()} - _PLAIN - {_STRING, _ASSET} - set(changes))
    if unknown:
        raise ValueError(f"values of USD's type {unknown[0]} cannot be moved")
    is_elsewhere = _are_elsewhere(fields)
    held = _Held(values)
    for kind in sorted({*kinds[is_elsewhere].tolist()} - _PLAIN):
        if kind not in changes:
            raise ValueError(f"arrays of USD's type {kind} cannot be moved")
        places = np.unique(fields[is_elsewhere & (kinds == kind)] & _PAYLOAD)  # fields may share what is there
        changes[kind](held, places.astype(np.int64) - VALUES_PLACE, numbers)
    return _moved(fields, numbers)


class _Held:
    """Values as numbers that begin at any byte.

    Args:
        values: Which change with them.
    """

    def __init__(self, values: memoryview) -> None:
        self.bytes = np.frombuffer(values, dtype=np.uint8)
        self.halves, self.words = (
            np.ndarray((max(len(values) - kind.itemsize + 1, 0),), kind, values, strides=(1,))
            for kind in (np.dtype("<u4"), np.dtype("<u8"))
        )

    def counts(self, places: np.ndarray) -> np.ndarray:
        """How much is listed at each place, (P,)."""
        return self.words[places].astype(np.int64)

    def items(self, places: np.ndarray, counts: np.ndarray, *, size: int) -> np.ndarray:
        """Where each of so many items of a size is that are listed at places (P,), after how many they are."""
        firsts = np.cumsum(counts) - counts
        return np.repeat(places + 8 - size * firsts, counts) + size * np.arange(counts.sum())


def _kinds(fields: np.ndarray) -> np.ndarray:
    """Types of values."""
    return (fields >> _TYPE_PLACE) & np.uint64(0xFF)


def _moved(fields: np.ndarray, numbers: Renumbering) -> np.ndarray:
    """Values with the places and numbers of the other file."""
    moved = fields + _are_elsewhere(fields) * np.uint64(numbers.shift)
    small = np.flatnonzero(fields & _INLINED)
    kinds = _kinds(fields[small])
    for kind, new in ((_TOKEN, numbers.tokens), (_ASSET, numbers.tokens), (_STRING, numbers.strings)):
        chosen = small[kinds == kind]
        own = fields[chosen]
        moved[chosen] = (own & ~_PAYLOAD) | new[(own & _PAYLOAD).astype(np.int64)].astype(np.uint64)
    return np.asarray(moved)


def _are_elsewhere(fields: np.ndarray) -> np.ndarray:
    """Whether values say where they are, as those do that are not small; an empty array is nowhere."""
    return np.asarray((fields & _INLINED == 0) & (fields & _PAYLOAD != 0))


def _change_tokens(held: _Held, places: np.ndarray, numbers: Renumbering) -> None:
    _renumber(held, places, numbers.tokens)


def _renumber(held: _Held, places: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Gives what is listed at places (P,) its new numbers; where the lists end, (P,)."""
    counts = held.counts(places)
    items = held.items(places, counts, size=4)
    held.halves[items] = numbers[held.halves[items]]
    return np.asarray(places + 8 + 4 * counts)


def _change_lists(held: _Held, places: np.ndarray, numbers: np.ndarray) -> None:
    lists = _LISTS[held.bytes[places]]
    places = places + 1
    while lists.any():
        has_more = lists > 0
        places, lists = _renumber(held, places[has_more], numbers), lists[has_more] - 1


def _change_references(held: _Held, places: np.ndarray, numbers: Renumbering) -> None:
    values = held.bytes.data
    for place in places.tolist():
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


def _change_samples(held: _Held, places: np.ndarray, numbers: Renumbering) -> None:
    """Times are a value that may be anywhere, and so are the values; each is said to be so far ahead."""
    places = places + held.counts(places)
    times = held.words[places]
    if (times >> _TYPE_PLACE != _TIMES).any():
        raise ValueError("times of samples are no numbers")
    held.words[places] = times + np.uint64(numbers.shift)
    places = places + 8
    places = places + held.counts(places)
    items = held.items(places, held.counts(places), size=8)
    samples = held.words[items]
    if not _SAMPLED[_kinds(samples).astype(np.uint8)].all():
        raise ValueError("time samples of this type cannot be moved")
    held.words[items] = _moved(samples, numbers)
