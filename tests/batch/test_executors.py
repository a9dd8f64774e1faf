"""Processes that animate chunks."""

import os
import signal
import subprocess
import sys

import pytest

SCRIPT = """
import os, signal
from usdfoot.batch.executors import open_executor
with open_executor(workers=2) as executor:
    print(executor.submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_workers_end_when_the_command_is_killed():
    with subprocess.Popen([sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, text=True) as command:
        worker = int(command.stdout.readline())
        try:
            command.communicate(timeout=30.0)  # until nobody has its output open any more
        except subprocess.TimeoutExpired:
            os.kill(worker, signal.SIGKILL)
            pytest.fail("the worker goes on")
    assert command.returncode == -signal.SIGKILL
