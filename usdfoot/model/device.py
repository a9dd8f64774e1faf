"""Starts Warp without a word on the console."""

from __future__ import annotations

import functools
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import warp as wp

__all__ = ["start_warp"]

DRIVER_NOTICE = b"Could not find or load the NVIDIA CUDA driver"


@functools.cache
def start_warp() -> None:
    """Warp initialised once a process: no banner, no compile messages, no notice that there is no CUDA driver.

    To be called before the first Warp array, mesh or launch. Other warnings of Warp still reach stderr.
    """
    if hasattr(wp.config, "log_level"):
        wp.config.log_level = max(wp.config.log_level, wp.LOG_WARNING)
    else:  # before Warp 1.13
        setattr(wp.config, "quiet", True)  # noqa: B010
    with _without_driver_notice():
        wp.init()


@contextmanager
def _without_driver_notice() -> Iterator[None]:
    """Holds back the file descriptor of stderr, since the notice is printed by native code, and drops that one line."""
    try:
        stderr = os.dup(2)
    except OSError:  # a program without a console
        yield
        return
    with tempfile.TemporaryFile() as held:
        sys.stderr.flush()
        os.dup2(held.fileno(), 2)
        try:
            yield
        finally:
            sys.stderr.flush()
            os.dup2(stderr, 2)
            os.close(stderr)
            held.seek(0)
            os.write(2, b"".join(line for line in held if DRIVER_NOTICE not in line))
