"""Times, in a way that other programs on the machine disturb little."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from unittest.mock import patch

__all__ = ["best_time", "function_times"]


def best_time(run: Callable[[], object], *, repeats: int = 5, processor: bool = False) -> float:
    """Shortest duration, or processor time, of several runs, after one that is not counted [s]."""
    clock = time.process_time if processor else time.perf_counter
    run()
    times = []
    for _ in range(repeats):
        begin = clock()
        run()
        times.append(clock() - begin)
    return min(times)


def function_times(run: Callable[[], object], names: tuple[str, ...], *, repeats: int = 5) -> dict[str, float]:
    """Processor time spent in functions of usdfoot and what they call, of the run in which each was quickest [s].

    Args:
        run: What to time; called once before, not counted.
        names: Names of functions; calls of all functions of one name count together.
        repeats: How often to run.

    Raises:
        KeyError: If there is no function of a name.
    """
    run()
    modules = [module for name, module in sys.modules.items() if name.startswith("usdfoot.")]
    spent = dict.fromkeys(names, 0.0)
    best = dict.fromkeys(names, float("inf"))
    with ExitStack() as stack:
        for name in names:
            holders = [module for module in modules if name in vars(module)]
            if not holders:
                raise KeyError(name)
            for module in holders:
                stack.enter_context(patch.object(module, name, _timed(getattr(module, name), name, spent)))
        for _ in range(repeats):
            spent.update(dict.fromkeys(names, 0.0))
            run()
            best = {name: min(spent[name], best[name]) for name in names}
    return best


def _timed(function: Callable[..., object], name: str, spent: dict[str, float]) -> Callable[..., object]:
    """The function, which adds what it takes to what is spent under its name."""

    def call(*args: object, **options: object) -> object:
        begin = time.process_time()
        result = function(*args, **options)
        spent[name] += time.process_time() - begin
        return result

    return call
