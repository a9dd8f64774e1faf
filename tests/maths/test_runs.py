"""Runs against loops over them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.testing import assert_allclose, assert_array_equal

from usdfoot.maths.runs import Runs, expand, first_where, flags_of, last_where, means_of, medians_of

LENGTHS = st.lists(st.integers(1, 9), min_size=1, max_size=5)


@st.composite
def runs_and_flags(draw: st.DrawFn) -> tuple[Runs, np.ndarray]:
    runs = Runs.of_lengths(np.array(draw(LENGTHS)))
    return runs, draw(arrays.arrays(bool, int(runs.first[-1])))


@given(runs_and_flags())
def test_intervals_cover_the_flags_and_stay_within_runs(case: tuple[Runs, np.ndarray]) -> None:
    runs, flags = case
    starts, ends = runs.intervals(flags)
    assert_array_equal(flags_of(starts, ends, len(flags)), flags)
    assert_array_equal(runs.owners_of(starts), runs.owners_of(ends))
    same = runs.owners[ends[:-1]] == runs.owners[starts[1:]]
    assert np.all(starts[1:][same] > ends[:-1][same] + 1)


@given(runs_and_flags(), st.integers(0, 12))
def test_counts_near_are_those_of_each_run_with_its_ends_repeated(case: tuple[Runs, np.ndarray], reach: int) -> None:
    runs, flags = case
    expected = []
    for part in np.split(flags, runs.first[1:-1]):
        padded = np.pad(part, reach, mode="edge")
        expected += [int(padded[i : i + 2 * reach + 1].sum()) for i in range(len(part))]
    assert_array_equal(runs.counts_near(flags, np.full(len(runs.lengths), reach)), expected)


@given(runs_and_flags())
def test_figures_of_intervals_are_those_of_their_samples(case: tuple[Runs, np.ndarray]) -> None:
    runs, flags = case
    starts, ends = runs.intervals(flags)
    values = np.cos(np.arange(len(flags)) ** 2)
    hits = values > 0.3
    indices, owners = expand(starts, ends)
    parts = [np.arange(start, end + 1) for start, end in zip(starts, ends, strict=True)]
    assert_array_equal(indices, np.concatenate([[], *parts]))
    missing = np.full(len(starts), -7)
    first = first_where(hits[indices], indices, owners, missing=missing)
    last = last_where(hits[indices], indices, owners, missing=missing)
    for number, part in enumerate(parts):
        inside = part[hits[part]]
        assert (first[number], last[number]) == ((inside[0], inside[-1]) if len(inside) else (-7, -7))
    assert_allclose(means_of(values, starts, ends), [values[part].mean() for part in parts], atol=1e-12)
    assert_allclose(medians_of(values, starts, ends), [np.median(values[part]) for part in parts], atol=1e-15)
