"""Times, in a way that other programs on the machine disturb little."""

from __future__ import annotations

import cProfile
import pstats
import time
from collections.abc import Callable

__all__ = ["best_time", "function_times"]


def best_time(run: Callable[[], object], *, repeats: int = 5) -> float:
    """Shortest duration of several runs, after one that is not counted [s]."""
    run()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return min(times)


def function_times(run: Callable[[], object], names: tuple[str, ...], *, repeats: int = 5) -> dict[str, float]:
    """Time spent in functions and what they call, of the run in which each was quickest [s].

    Args:
        run: What to profile; called once before, not counted.
        names: Names of functions; calls of all functions of one name count together.
        repeats: How often to profile.

    Raises:
        KeyError: If a function was never called.
    """
    run()
    best: dict[str, float] = {}
    for _ in range(repeats):
        profile = cProfile.Profile()
        profile.runcall(run)
        spent: dict[str, float] = {}
        for (_, _, name), (_, _, _, cumulative, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
            spent[name] = spent.get(name, 0.0) + cumulative
        best = {name: min(spent[name], best.get(name, float("inf"))) for name in names}
    return best
