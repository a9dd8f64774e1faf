"""Executors: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from usdfoot.errors import UsdfootError
from usdfoot.model.limits import Limits

__all__ = ["open_executor", "open_scene_early"]

_logger = logging.getLogger(__name__)

SCHEDULER_TIMEOUT = 30.0
"""How long a scheduler may take to answer [s]."""
WITHOUT_WORKERS = 15.0
"""How often a cluster is asked whether it has workers [s]."""


@contextmanager
def open_executor(
    *, workers: int | None = None, scheduler: str | None = None, beside: bool = False
) -> Iterator[Executor | None]:
    """An executor for as long as the block runs; None if one process is enough.

    Processes are started when there is work for them.

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
    executor = _Processes(count - beside, mp_context=context, initializer=_follow_parent)
    is_done = False
    try:
        yield executor
        is_done = True
    finally:
        executor.shutdown(cancel_futures=not is_done)  # as by Ctrl-C: what waits is not begun


class _Processes(ProcessPoolExecutor):
    """Processes of this machine, who know how many they are."""

    def __init__(self, workers: int, **options: Any) -> None:
        super().__init__(workers, **options)
        self.workers = workers


def _follow_parent() -> None:
    """Has a worker end at once by Ctrl-C, and when the process that started it is gone.

    One that is killed cannot tell its workers to.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
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
    with client, _told_of_idleness(client, scheduler):
        yield client.get_executor(pure=False)


@contextmanager
def _told_of_idleness(client: Any, scheduler: str) -> Iterator[None]:
    """While the block runs, says so when a cluster has had no workers for a while: Dask waits for some, in silence."""
    over = threading.Event()

    def watch() -> None:
        told = idle = False
        while not over.wait(WITHOUT_WORKERS):
            was_idle, idle = idle, not client.scheduler_info()["workers"]
            if idle and was_idle and not told:
                _logger.warning("%s has no workers; waiting for some", scheduler)
            told = idle and was_idle

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()


def open_scene_early(executor: Executor, scene: str, inputs: str, limits: Limits) -> list[Future[None]]:
    """Has all workers of this machine open a scene; who cannot says so when it is asked for a chunk.

    Args:
        executor: Whose workers.
        scene: The scene's file.
        inputs: State of its files, as chunks' tasks have it.
        limits: How much of a scene is read.

    Returns:
        One a worker, done when it has opened the scene.
    """
    from usdfoot.batch.workshop import open_early

    workers = getattr(executor, "workers", _cores())
    return [executor.submit(open_early, scene, inputs, limits) for _ in range(workers)]


def _cores() -> int:
    """Cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
