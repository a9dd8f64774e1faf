"""Executors: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, InvalidStateError, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING, Any

from usdfoot.batch.garbage import collect_seldom
from usdfoot.errors import UsdfootError

if TYPE_CHECKING:
    from usdfoot.batch.tasks import EarlyTask

__all__ = ["Starting", "examples_of", "load_early", "open_executor", "open_scene_early"]

_logger = logging.getLogger(__name__)

Starting = Future[dict[str, bytes]]
"""Of a worker that gets ready: done with files of what it cut of the clips, by name."""

SCHEDULER_TIMEOUT = 30.0
"""How long a scheduler may take to answer [s]."""
WITHOUT_WORKERS = 15.0
"""How often a cluster is asked whether it has workers [s]."""
ABANDONED = 600.0
"""A cluster that has had no workers for so long is given up [s]."""


@contextmanager
def open_executor(
    *, workers: int | None = None, scheduler: str | None = None, beside: bool = False
) -> Iterator[Executor | None]:
    """An executor for as long as the block runs; None if one process is enough.

    Processes are started when there is work for them. What nobody waited for ends with the block.

    Args:
        workers: Number of processes; None = one a core.
        scheduler: Address of a Dask scheduler, whose workers are used instead.
        beside: Whether this process, which works too, counts as one of them.

    Raises:
        UsdfootError: If Dask is not installed or the scheduler does not answer.
    """
    if scheduler is not None:
        with _dask(scheduler) as executor:
            yield executor
        return
    count = workers or _cores()
    if count == 1:
        yield None
        return
    # A fork would copy USD's and Warp's threads half alive.
    context = multiprocessing.get_context("spawn")
    end, ends = context.Pipe(duplex=False)
    executor = _Processes(count - beside, mp_context=context, initializer=_begin_worker, initargs=(end,))
    try:
        yield executor
        executor.is_making = False
    finally:
        if not executor.is_making:  # else, by an error or Ctrl-C, what is begun is made: the next run keeps it
            ends.close()
        executor.shutdown(cancel_futures=True)


class _Processes(ProcessPoolExecutor):
    """Processes of this machine, who know how many they are."""

    def __init__(self, workers: int, **options: Any) -> None:
        super().__init__(workers, **options)
        self.workers = workers
        self.is_making = False
        """Whether more was asked for than to get ready."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As any executor does."""
        self.is_making = self.is_making or fn not in (_load, _open_early)
        return super().submit(fn, *args, **kwargs)


def _begin_worker(end: Connection) -> None:
    """Has a worker end at once by Ctrl-C, by the `end` of a pipe, and when the process that started it is gone.

    One that is killed cannot tell its workers to.
    """
    collect_seldom()
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        wait([end, *([parent.sentinel] if parent else [])])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _dask(scheduler: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise UsdfootError(scheduler, "Dask is not installed", "pip install 'usdfoot[dask]'") from error
    try:
        client = Client(scheduler, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsdfootError(
            scheduler, f"no Dask scheduler answers ({error})", "give its address, like tcp://host:8786"
        ) from error
    executor = _Cluster(client.get_executor(pure=False))
    with client, _watched(client, scheduler, executor):
        yield executor


class _Cluster(Executor):
    """The workers of a cluster, who can be given up: Dask waits for some for ever, in silence."""

    def __init__(self, workers: Executor) -> None:
        self._workers = workers
        self._asked: dict[Future[Any], Future[Any]] = {}

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As any executor does."""
        answer: Future[Any] = Future()
        self._asked[answer] = self._workers.submit(fn, *args, **kwargs)
        self._asked[answer].add_done_callback(partial(self._pass_on, answer))
        return answer

    def _pass_on(self, answer: Future[Any], asked: Future[Any]) -> None:
        """Gives a future what became of another and lets go of that, which Dask would make again if its worker died."""
        _answer_as(answer, asked)
        self._asked.pop(answer, None)

    def give_up(self, error: Exception) -> None:
        """Has all that was asked for and not answered fail."""
        for answer, asked in [*self._asked.items()]:
            with suppress(InvalidStateError):  # answered
                answer.set_exception(error)
                asked.cancel()


def _answer_as(answer: Future[Any], asked: Future[Any]) -> None:
    """Gives a future what became of another."""
    with suppress(InvalidStateError):  # given up meanwhile
        if asked.cancelled():
            answer.set_exception(CancelledError())
        elif error := asked.exception():
            answer.set_exception(error)
        else:
            answer.set_result(asked.result())


@contextmanager
def _watched(client: Any, scheduler: str, executor: _Cluster) -> Iterator[None]:
    """While the block runs, says so when a cluster has had no workers for a while, and later gives it up."""
    over = threading.Event()

    def watch() -> None:
        times = 0  # in a row that there were none
        while not over.wait(WITHOUT_WORKERS):
            times = 0 if client.scheduler_info()["workers"] else times + 1
            if times == 2:
                _logger.warning("%s has no workers; waiting %.0f s for some", scheduler, ABANDONED)
            if times * WITHOUT_WORKERS >= ABANDONED:
                executor.give_up(UsdfootError(scheduler, f"has had no workers for {ABANDONED:.0f} s", "start some"))

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()


def load_early(executor: Executor | None) -> None:
    """Has one of this machine's workers, if there are any, load what makes chunks: it takes as long as to open a scene.

    One, as there may be nothing to make when the scene is known.
    """
    if isinstance(executor, _Processes):
        executor.submit(_load)


def _load() -> None:
    """Loads what `_open_early` needs."""
    import usdfoot.batch.workshop  # noqa: F401
    from usdfoot.model.device import start_warp

    start_warp()


def open_scene_early(executor: Executor, task: EarlyTask) -> list[Starting]:
    """Has all workers of this machine open a scene; who cannot says so when it is asked for a chunk.

    Args:
        executor: Whose workers.
        task: What to open.

    Returns:
        One a worker, done when it is ready for its chunks; the first has what it cut of the clips.
    """
    workers = getattr(executor, "workers", _cores())
    starting: list[Starting] = []
    with suppress(BrokenExecutor):  # others have vanished before all are asked
        wanted = (number == 0 for number in range(workers))
        starting.extend(executor.submit(_open_early, replace(task, gives_examples=is_first)) for is_first in wanted)
    return starting


def examples_of(starting: Iterable[Starting]) -> dict[str, bytes]:
    """What workers that are ready cut of the clips."""
    ready = [worker for worker in starting if worker.done() and not (worker.cancelled() or worker.exception())]
    return {name: content for worker in ready for name, content in worker.result().items()}


def _open_early(task: EarlyTask) -> dict[str, bytes]:
    """As `workshop.open_early`, all of which is loaded by the worker and not by who asks it to."""
    from usdfoot.batch.workshop import open_early

    return open_early(task)


def _cores() -> int:
    """Cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
