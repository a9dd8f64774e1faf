"""Running: chunks made here, or by any executor, in whatever order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, as_completed

from usdfoot.batch.tasks import ChunkTask
from usdfoot.batch.workshop import Workshop, make_chunk
from usdfoot.errors import OutputError, UsdfootError

__all__ = ["run_chunks"]


def run_chunks(tasks: Sequence[ChunkTask], workers: Workshop | Executor) -> Iterator[tuple[int, str]]:
    """Index and record of every chunk, as they are done.

    Args:
        tasks: What to make.
        workers: The workshop of this process, or an executor whose processes make the chunks.

    Raises:
        OutputError: After all others are done, if chunks could not be made: their worker vanished or could not write.
    """
    if isinstance(workers, Workshop):
        for index, task in enumerate(tasks):
            yield index, workers.make(task)
        return
    futures = {workers.submit(make_chunk, task): index for index, task in enumerate(tasks)}
    failed: dict[str, str] = {}
    for future in as_completed(futures):
        index = futures[future]
        try:
            yield index, future.result()
        except BrokenExecutor:
            failed[tasks[index].files.anims] = "its worker vanished"
        except (UsdfootError, OSError, MemoryError) as error:
            failed[tasks[index].files.anims] = str(error) or type(error).__name__
    if failed:
        raise OutputError(
            tasks[0].folder,
            f"{len(failed)} of {len(tasks)} chunks were not made",
            "run again: what is done is kept",
            [f"{name} ({reason})" for name, reason in sorted(failed.items())],
        )
