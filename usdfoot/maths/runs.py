"""Runs: sequences of different lengths end to end in one array, and intervals of samples in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["Runs", "expand", "first_where", "flags_of", "last_where", "means_of", "medians_of", "sums_within"]


@dataclass(frozen=True, kw_only=True)
class Runs:
    """R runs of N samples in all."""

    first: IntArray
    """Index of each run's first sample, shape (R + 1,); the last entry is N."""

    @staticmethod
    def of_lengths(lengths: IntArray) -> Runs:
        """Runs of these lengths (R,)."""
        return Runs(first=np.concatenate([[0], np.cumsum(lengths)]).astype(np.intp))

    def repeated(self, times: int) -> Runs:
        """The runs several times, one set after the other."""
        return Runs.of_lengths(np.tile(self.lengths, times))

    @property
    def lengths(self) -> IntArray:
        """Samples of each run, shape (R,)."""
        return np.diff(self.first)

    @property
    def owners(self) -> IntArray:
        """Run of each sample, shape (N,)."""
        return np.repeat(np.arange(len(self.lengths)), self.lengths)

    def owners_of(self, indices: IntArray) -> IntArray:
        """Run of the samples at indices (K,)."""
        return np.searchsorted(self.first, indices, side="right") - 1

    def intervals(self, flags: BoolArray) -> tuple[IntArray, IntArray]:
        """First and last index of every run of True in flags (N,) that lies within one run."""
        before, after = np.zeros_like(flags), np.zeros_like(flags)
        before[1:], after[:-1] = flags[:-1], flags[1:]
        before[self.first[:-1]] = False
        after[self.first[1:] - 1] = False
        return np.flatnonzero(flags & ~before), np.flatnonzero(flags & ~after)

    def counts_near(self, flags: BoolArray, reach: IntArray) -> IntArray:
        """How many of the flags (N,) are True up to `reach` (R,) samples away; the ends of a run go on as they are."""
        owners = self.owners
        heads, tails = self.first[:-1][owners], self.first[1:][owners] - 1
        near, samples = reach[owners], np.arange(len(flags))
        total = np.concatenate([[0], np.cumsum(flags)])
        low, high = samples - near, samples + near
        inside = total[np.minimum(high, tails) + 1] - total[np.maximum(low, heads)]
        return inside + np.maximum(heads - low, 0) * flags[heads] + np.maximum(high - tails, 0) * flags[tails]


def flags_of(starts: IntArray, ends: IntArray, size: int) -> BoolArray:
    """Flags (size,) that are True from each start to its end, both included."""
    edges = np.zeros(size + 1, dtype=int)
    np.add.at(edges, starts, 1)
    np.add.at(edges, ends + 1, -1)
    return np.cumsum(edges[:-1]) > 0


def expand(starts: IntArray, ends: IntArray) -> tuple[IntArray, IntArray]:
    """Every index from each start to its end, both included, and the interval it is of."""
    counts = ends - starts + 1
    owners = np.repeat(np.arange(len(counts)), counts)
    return np.arange(len(owners)) + np.repeat(starts - np.cumsum(counts) + counts, counts), owners


def first_where(flags: BoolArray, indices: IntArray, owners: IntArray, *, missing: IntArray) -> IntArray:
    """First index of each interval with its flag True, `missing` (K,) where none is; the rest as from `expand`."""
    hits = np.flatnonzero(flags)
    found, places = np.unique(owners[hits], return_index=True)
    result = missing.copy()
    result[found] = indices[hits[places]]
    return result


def last_where(flags: BoolArray, indices: IntArray, owners: IntArray, *, missing: IntArray) -> IntArray:
    """Last index of each interval with its flag True, `missing` (K,) where none is; the rest as from `expand`."""
    return first_where(flags[::-1], indices[::-1], owners[::-1], missing=missing)


def means_of(values: FloatArray, starts: IntArray, ends: IntArray) -> FloatArray:
    """Means of values (N, ...) from each start to its end, both included, shape (K, ...)."""
    if not len(starts):
        return np.zeros((0, *values.shape[1:]))
    bounds = np.stack([starts, ends + 1], axis=1).ravel()
    sums = np.add.reduceat(np.concatenate([values, values[:1]]), bounds, axis=0)[::2]
    return sums / (ends - starts + 1).reshape(-1, *[1] * (values.ndim - 1))


def sums_within(values: FloatArray, first: IntArray) -> FloatArray:
    """Running sums of values (N, ...) that begin anew with each run, whatever the other runs are, shape (N, ...).

    Args:
        values: Of runs end to end.
        first: As of `Runs`, shape (R + 1,).
    """
    runs = Runs(first=first)
    owners = runs.owners
    places = np.arange(len(owners)) - first[:-1][owners]
    table = np.zeros((len(runs.lengths), int(runs.lengths.max(initial=0)), *values.shape[1:]))
    table[owners, places] = values
    sums: FloatArray = np.cumsum(table, axis=1)[owners, places]
    return sums


def medians_of(values: FloatArray, starts: IntArray, ends: IntArray) -> FloatArray:
    """Medians of values (N,) from each start to its end, both included, shape (K,)."""
    sorted_parts = [np.sort(values[start : end + 1]) for start, end in zip(starts, ends, strict=True)]
    return np.array([0.5 * (part[(len(part) - 1) // 2] + part[len(part) // 2]) for part in sorted_parts])
