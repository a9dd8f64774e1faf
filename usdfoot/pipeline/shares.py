"""Shares: the agents of a written crowd dealt out to workers, each of which opens the crowd for itself."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from typing import TypeVar

from usdfoot.errors import UsdfootError

__all__ = ["SHARE", "in_shares"]

SHARE = 50
"""Agents that a worker measures before it hands them over; for each share it opens the crowd again."""

Result = TypeVar("Result")


def in_shares(
    measure: Callable[[str, Sequence[str]], list[Result]],
    crowd_file: str | os.PathLike[str],
    names: Sequence[str],
    *,
    executor: Executor,
    progress: Callable[[str, int, int], None],
) -> Iterator[Result]:
    """What is measured of every agent, in the order of the names.

    Args:
        measure: A function of a module, of the crowd's file and some agents' names.
        crowd_file: Where the workers find the crowd.
        names: Of all agents.
        executor: Whose workers measure.
        progress: Told "measure", how many are done, and of how many.

    Raises:
        UsdfootError: If a worker vanished.
    """
    shares = [names[first : first + SHARE] for first in range(0, len(names), SHARE)]
    futures = [executor.submit(measure, os.fspath(crowd_file), share) for share in shares]
    for number, future in enumerate(futures):
        progress("measure", number * SHARE, len(names))
        try:
            yield from future.result()
        except BrokenExecutor as error:
            raise UsdfootError(crowd_file, "a worker that measured it vanished", "try --workers 1") from error
