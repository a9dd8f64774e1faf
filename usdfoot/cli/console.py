"""Where the command line talks: results on stdout, progress and complaints on stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from usdfoot.model.report import Problem

__all__ = ["logging_on_stderr", "print_error", "print_problems", "results_console", "shown_progress"]

WIDTH_WITHOUT_TERMINAL = 160
"""Columns of tables that go to a file or pipe."""


def results_console() -> Console:
    """The console results go to."""
    from rich.console import Console

    console = Console(file=sys.stdout, highlight=False, markup=False)  # names and paths may have brackets
    if not console.is_terminal:
        console.width = WIDTH_WITHOUT_TERMINAL
    return console


def print_error(message: str) -> None:
    """One line on stderr."""
    print(f"usdfoot: {message}", file=sys.stderr)


def print_problems(problems: Iterable[Problem], *, quiet: bool) -> None:
    """Problems on stderr; only errors if quiet."""
    for problem in problems:
        if problem.severity == "error" or not quiet:
            print_error(str(problem))


@contextmanager
def logging_on_stderr(*, quiet: bool, verbose: bool) -> Iterator[None]:
    """Messages of the package on stderr, each once: warnings, with `verbose` everything, with `quiet` errors only.

    What is read by several parts of a job is doubted by each. A program that calls `main` finds its own logging
    unchanged afterwards.
    """
    package = logging.getLogger("usdfoot")
    # The scene's reader logs the problems that the verbs print themselves.
    scene = logging.getLogger("usdfoot.readers.scene")
    levels = package.level, scene.level
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("usdfoot: %(levelname)s: %(message)s"))
    handler.addFilter(_said_once())
    package.addHandler(handler)
    package.setLevel(logging.INFO if verbose else logging.ERROR if quiet else logging.WARNING)
    scene.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        package.removeHandler(handler)
        package.setLevel(levels[0])
        scene.setLevel(levels[1])


def _said_once() -> Callable[[logging.LogRecord], bool]:
    """Whether a message is one that was not said before."""
    said: set[tuple[int, str]] = set()

    def is_new(record: logging.LogRecord) -> bool:
        message = record.levelno, record.getMessage()
        is_first = message not in said
        said.add(message)
        return is_first

    return is_new


@contextmanager
def shown_progress(*, quiet: bool) -> Iterator[Callable[[str, int, int], None]]:
    """Something to call with what is being done, how much of it is done, and of how much (0 = unknown).

    A bar on stderr shows it, with the time that is left, while the block runs.
    """
    if quiet:
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("start", total=None)

        def show(stage: str, done: int, total: int) -> None:
            if progress.tasks[0].description != stage:
                progress.reset(bar)
            progress.update(bar, description=stage, completed=done, total=total or None)

        yield show
