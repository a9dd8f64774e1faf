"""Running: chunks made here, by any executor, or by both, in whatever order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from contextlib import suppress
from functools import partial
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from usdfoot.errors import OutputError, UsdfootError

if TYPE_CHECKING:  # loaded by who makes chunks, when workers have been given theirs
    from usdfoot.batch.tasks import ChunkTask
    from usdfoot.batch.workshop import MadeChunk

__all__ = ["run_chunks"]

_KILLED = "KilledWorker"
"""Dask's error for what several workers died of, one after the other; Dask need not be installed."""

Outcome = tuple[int, Callable[[], "MadeChunk"]]
"""Index of a chunk, and what gives what became of it or raises why there is nothing."""


def run_chunks(
    tasks: Sequence[ChunkTask],
    make: Callable[[ChunkTask], MadeChunk],
    *,
    executor: Executor | None = None,
    starting: Sequence[Future[Any]] | None = None,
) -> Iterator[tuple[int, MadeChunk]]:
    """Index of every chunk and what became of it, as they are done.

    Args:
        tasks: What to make.
        make: Makes a chunk in this process.
        executor: Whose processes make the chunks, from the first on; None = this process does.
        starting: One a worker, done when it can begin: this process makes chunks too, those between the workers', and a
            worker has none but the one it works at. None = the executor alone has all of them.

    Raises:
        OutputError: After all others are done, if chunks could not be made: their worker vanished or could not write.
    """
    if executor is None:
        for index, task in enumerate(tasks):
            yield index, make(task)
        return
    failed: dict[str, str] = {}
    outcomes = _given(tasks, executor) if starting is None else _shared(tasks, executor, starting, make)
    for index, result in outcomes:
        try:
            yield index, result()
        except (BrokenExecutor, CancelledError):  # as by Dask where its scheduler vanished
            failed[tasks[index].files.anims] = "its worker vanished"
        except (UsdfootError, OSError, MemoryError) as error:
            failed[tasks[index].files.anims] = str(error) or type(error).__name__
        except Exception as error:
            if type(error).__name__ != _KILLED:
                raise
            failed[tasks[index].files.anims] = "every worker that took it vanished"
    if failed:
        raise OutputError(
            tasks[0].folder,
            f"{len(failed)} of {len(tasks)} chunks were not made",
            "run again: what is done is kept",
            [f"{name} ({reason})" for name, reason in sorted(failed.items())],
        )


def _given(tasks: Sequence[ChunkTask], executor: Executor) -> Iterator[Outcome]:
    """Outcomes of chunks that the executor has all at once."""
    futures = {_asked(executor, task): index for index, task in enumerate(tasks)}
    for future in as_completed(futures):
        yield futures[future], future.result


def _asked(executor: Executor, task: ChunkTask) -> Future[MadeChunk]:
    """A chunk that an executor is to make; its workers may have vanished already, when they opened the scene."""
    try:
        return executor.submit(_make_chunk, task)
    except BrokenExecutor as error:
        lost: Future[MadeChunk] = Future()
        lost.set_exception(error)
        return lost


def _shared(
    tasks: Sequence[ChunkTask],
    executor: Executor,
    starting: Sequence[Future[Any]],
    make: Callable[[ChunkTask], MadeChunk],
) -> Iterator[Outcome]:
    """Outcomes of chunks of which workers and this process take one at a time; here they are made when asked for.

    Workers begin with every other one (`workshop.open_early`), so that all are there as far as anybody has come.
    """
    left = deque([*range(0, len(tasks), 2), *reversed(range(1, len(tasks), 2))])
    done = SimpleQueue[Outcome]()

    def give(last: Future[Any]) -> None:
        if last.cancelled() or isinstance(last.exception(), BrokenExecutor):  # by whom nothing more is made
            return
        with suppress(IndexError):
            index = left.popleft()
            try:
                executor.submit(_make_chunk, tasks[index]).add_done_callback(partial(take, index))
            except RuntimeError:  # the executor broke or was shut down
                done.put((index, partial(make, tasks[index])))

    def take(index: int, future: Future[MadeChunk]) -> None:
        give(future)
        done.put((index, future.result))

    for worker in starting:
        worker.add_done_callback(give)
    for _ in tasks:
        try:
            index = left.pop() if done.empty() else None
        except IndexError:
            index = None
        yield done.get() if index is None else (index, partial(make, tasks[index]))


def _make_chunk(task: ChunkTask) -> MadeChunk:
    """As `workshop.make_chunk`, loaded by the worker and not by who asks it to."""
    from usdfoot.batch.workshop import make_chunk

    return make_chunk(task)
