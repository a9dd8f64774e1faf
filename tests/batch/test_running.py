"""Chunks whose workers vanish are named; what is a fault of the program stays one."""

import time
from concurrent.futures import BrokenExecutor, CancelledError, Future, ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from usdfoot.batch import workshop
from usdfoot.batch.running import run_chunks
from usdfoot.errors import OutputError


class KilledWorker(Exception):
    """As Dask names it."""


class Losing:
    """An executor that does every task but the first."""

    def __init__(self, error):
        self.error = error

    def submit(self, function, task):
        future = Future()
        future.set_exception(self.error) if task.index == 0 else future.set_result(task.index)
        return future


def tasks(count):
    return [
        SimpleNamespace(index=index, folder="out", files=SimpleNamespace(anims=f"anims.{index:04d}.usdc"))
        for index in range(count)
    ]


@pytest.mark.parametrize("error", [CancelledError(), KilledWorker("make_chunk", "worker", 3)])
def test_chunks_that_a_cluster_lost_are_named_after_the_others_are_done(error):
    made = run_chunks(tasks(3), None, executor=Losing(error))
    assert sorted([next(made), next(made)]) == [(1, 1), (2, 2)]
    with pytest.raises(OutputError, match=r"1 of 3 chunks were not made: anims\.0000\.usdc \(.*vanished\)\. run again"):
        next(made)


def test_threads_of_one_process_make_one_chunk_at_a_time(monkeypatch):
    """They share its scene: of two that read a character each, one could be given the other's."""
    busy, most = [], []

    class Slow:
        def make(self, task):
            busy.append(task)
            most.append(len(busy))
            time.sleep(0.02)
            busy.remove(task)

    monkeypatch.setattr(workshop, "_workshop", lambda *state: Slow())
    names = ("scene", "inputs", "frames", "options", "limits", "folder", "keeps_examples")
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(workshop.make_chunk, [SimpleNamespace(**dict.fromkeys(names)) for _ in range(6)]))
    assert most == [1] * 6


def test_a_fault_of_the_program_is_none_of_the_workers():
    with pytest.raises(ZeroDivisionError):
        list(run_chunks(tasks(3), None, executor=Losing(ZeroDivisionError())))


class Broken:
    """An executor whose workers vanished before they were asked for chunks."""

    def submit(self, function, task):
        raise BrokenExecutor


def test_chunks_that_nobody_is_left_for_are_named():
    with pytest.raises(OutputError, match=r"2 of 2 chunks were not made: .*its worker vanished.*run again"):
        list(run_chunks(tasks(2), None, executor=Broken()))


def test_a_worker_and_this_process_make_every_other_chunk():
    """So that all are there as far as anybody has come."""
    asked, own, ready = [], [], Future()
    ready.set_result(None)

    class Worker:
        """Is done with a chunk when this process makes one, and with the last at once."""

        def submit(self, function, task):
            future = Future()
            asked.append((task.index, future))
            if task.index == 6:
                future.set_result(6)
            return future

    def make(task):
        own.append(task.index)
        index, future = asked[-1]
        future.set_result(index)
        return task.index

    made = dict(run_chunks(tasks(7), make, executor=Worker(), starting=[ready]))
    assert own == [1, 3, 5] and [index for index, _ in asked] == [0, 2, 4, 6]
    assert made == {index: index for index in range(7)}
