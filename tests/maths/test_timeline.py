"""Rows of many agents found by time, against a loop over them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from usdfoot.maths.timeline import locate

BEGINS = st.lists(st.lists(st.floats(0.0, 50.0), min_size=1, max_size=5), min_size=1, max_size=40)


@given(BEGINS, st.integers(0, 10**6), st.data())
def test_a_query_at_the_very_begin_of_a_row_finds_it(begins, start, data):
    rows = [np.sort(own) + start for own in begins]
    agents = np.repeat(np.arange(len(rows)), [len(own) for own in rows])
    times = np.concatenate(rows)
    asked = data.draw(st.lists(st.integers(0, len(times) - 1), min_size=1, max_size=8))
    offsets = np.array(data.draw(st.lists(st.sampled_from([0.0, -1e-9, 1e-9, 1.0]), min_size=8, max_size=8)))
    queries = times[asked] + offsets[: len(asked)]
    found = locate(agents, times, np.array([own[0] for own in rows]), agents=agents[asked], times=queries)
    for row, agent, query in zip(found, agents[asked], queries, strict=True):
        own = np.flatnonzero(agents == agent)
        assert row == max([own[0], *own[times[own] <= query]])
