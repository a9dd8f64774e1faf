"""Running: chunks made here, by any executor, or by both, in whatever order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from functools import partial

from usdfoot.batch.tasks import ChunkTask
from usdfoot.batch.workshop import MadeChunk, Workshop, make_chunk
from usdfoot.errors import OutputError, UsdfootError

__all__ = ["run_chunks"]

_KILLED = "KilledWorker"
"""Dask's error for what several workers died of, one after the other; Dask need not be installed."""


def run_chunks(
    tasks: Sequence[ChunkTask], workshop: Workshop, *, executor: Executor | None = None, beside: bool = False
) -> Iterator[tuple[int, MadeChunk]]:
    """Index of every chunk and what became of it, as they are done.

    Args:
        tasks: What to make.
        workshop: Of this process.
        executor: Whose processes make the chunks, from the first on; None = this process does.
        beside: Whether this process makes chunks too, from the last on.

    Raises:
        OutputError: After all others are done, if chunks could not be made: their worker vanished or could not write.
    """
    if executor is None:
        for index, task in enumerate(tasks):
            yield index, workshop.make(task)
        return
    futures = {executor.submit(make_chunk, task): index for index, task in enumerate(tasks)}
    failed: dict[str, str] = {}
    while futures:
        for index, result in _outcomes(tasks, futures, workshop if beside else None):
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


def _outcomes(
    tasks: Sequence[ChunkTask], futures: dict[Future[MadeChunk], int], workshop: Workshop | None
) -> list[tuple[int, Callable[[], MadeChunk]]]:
    """Index and result of chunks that are done, and of one that is made here when asked; `futures` keeps the others.

    Waits for a worker only if there is no chunk left to make here.
    """
    outcomes: list[tuple[int, Callable[[], MadeChunk]]] = []
    own = next((future for future in reversed(futures) if future.cancel()), None) if workshop else None
    if workshop and own:
        index = futures.pop(own)
        outcomes.append((index, partial(workshop.make, tasks[index])))
    done, _ = wait(futures, timeout=0.0 if own else None, return_when=FIRST_COMPLETED)
    return [(futures.pop(future), future.result) for future in done] + outcomes
