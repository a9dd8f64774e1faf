"""Processes that animate chunks."""

import os
import signal
import subprocess
import sys
import time
import weakref
from concurrent.futures import Future
from types import SimpleNamespace

import pytest

from usdfoot.batch import executors
from usdfoot.batch.executors import load_early, open_executor

SCRIPT = """
import os, signal, time
from usdfoot.batch.executors import open_executor
with open_executor(workers=2) as executor:
    worker = executor.submit(os.getpid).result()
    futures = [executor.submit(time.sleep, SECONDS) for _ in range(60)]
    print(worker, flush=True)
    LAST
"""


def test_workers_end_when_the_command_is_killed():
    script = SCRIPT.replace("LAST", "os.kill(os.getpid(), signal.SIGKILL)").replace("SECONDS", "1")
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as command:
        worker = int(command.stdout.readline())
        try:
            command.communicate(timeout=30.0)  # until nobody has its output open any more
        except subprocess.TimeoutExpired:
            os.kill(worker, signal.SIGKILL)
            pytest.fail("the worker goes on")
    assert command.returncode == -signal.SIGKILL


@pytest.mark.parametrize("at_all", [True, False])
def test_ctrl_c_ends_the_command_with_the_work_that_is_begun(at_all):
    """In a terminal all processes get it and end at once; the command alone begins nothing more."""
    script = SCRIPT.replace("LAST", "time.sleep(60)").replace("SECONDS", "60" if at_all else "1")
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as command:
        worker, begin = int(command.stdout.readline()), time.monotonic()
        try:
            (os.killpg if at_all else os.kill)(command.pid, signal.SIGINT)
            command.communicate(timeout=25.0)
        except subprocess.TimeoutExpired:
            os.killpg(command.pid, signal.SIGKILL)
            pytest.fail(f"worker {worker} goes on for {time.monotonic() - begin:.0f} s")
    assert command.returncode == -signal.SIGINT


def test_what_nobody_waits_for_any_more_ends_with_the_block(capfd):
    """As workers do that open a scene of which nothing is left to animate."""
    begin = time.monotonic()
    with open_executor(workers=2) as executor:
        assert executor.submit(os.getpid).result() != os.getpid()
        executor.submit(time.sleep, 60)
    assert time.monotonic() - begin < 40.0 and capfd.readouterr().err == ""


def test_an_error_is_not_told_later_for_workers_that_only_open_a_scene(monkeypatch):
    monkeypatch.setattr(executors, "_open_early", time.sleep)
    begin = time.monotonic()
    with pytest.raises(ZeroDivisionError), open_executor(workers=2) as executor:
        executor.submit(executors._open_early, 300.0)
        raise ZeroDivisionError
    assert time.monotonic() - begin < 60.0


def test_a_worker_that_loads_early_is_no_reason_to_wait_and_takes_work_later(capfd):
    """As of a scene that turns out to be small."""
    load_early(None)
    with pytest.raises(ZeroDivisionError), open_executor(workers=2, beside=True) as executor:
        load_early(executor)
        assert not executor.is_making and len(executor._processes) == 1
        assert executor.submit(os.getpid).result() in executor._processes
        executor.is_making = False
        raise ZeroDivisionError
    assert capfd.readouterr().err == ""


def test_what_a_cluster_has_made_is_not_held_on_to():
    """Dask would make it again, into a folder that is done, if the worker vanished that made it."""
    asked: Future[int] = Future()
    cluster = executors._Cluster(SimpleNamespace(submit=lambda function: asked))
    answer = cluster.submit(os.getpid)
    asked.set_result(1)
    held, asked = weakref.ref(asked), None
    assert answer.result() == 1 and held() is None
