"""The usdfoot command: parses, then lets one verb do its work."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
import traceback
from collections.abc import Sequence
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from typing import Any

from usdfoot import __version__
from usdfoot.batch.garbage import collect_no_more, collect_seldom
from usdfoot.cli import (
    analyze,
    animate,
    completion,
    doctor,
    export,
    import_files,
    inspect,
    job,
    plan,
    plugin_path,
    retarget,
    validate,
)
from usdfoot.cli.console import logging_on_stderr, print_error
from usdfoot.cli.verbs import add_verb
from usdfoot.errors import UsdfootError

__all__ = ["build_parser", "main"]

VERBS = (
    animate,
    analyze,
    plan,
    import_files,
    retarget,
    export,
    validate,
    inspect,
    job,
    doctor,
    plugin_path,
    completion,
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb and give back the exit code: 0 = all well, 1 = some skipped or over target, 2 = nothing done.

    Args:
        argv: Arguments without the program's name; None = those of the process, which is usdfoot's own then.
    """
    if argv is None:
        collect_seldom()
    with ExitStack() as stack:
        for stream, redirect in ((sys.stdout, redirect_stdout), (sys.stderr, redirect_stderr)):
            if stream is None:  # closed by the shell, as 2>&- does
                stack.enter_context(redirect(stack.enter_context(open(os.devnull, "w", encoding="utf-8"))))
        code = _run(argv)
    if argv is None:
        collect_no_more()
    return code


def _run(argv: Sequence[str] | None) -> int:
    """As `main`, with somewhere to print to."""
    parser = build_parser()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # names of agents in what a terminal cannot show
    try:
        arguments = parser.parse_args(argv, argparse.Namespace(is_own=argv is None))
    except SystemExit as stop:
        return int(stop.code or 0)
    try:
        with logging_on_stderr(quiet=arguments.quiet, verbose=arguments.verbose):
            return arguments.run(arguments)
    except SystemExit as stop:  # of a parser that a verb uses itself
        return int(stop.code or 0)
    except UsdfootError as error:
        if arguments.verbose:
            traceback.print_exc()
        print_error(str(error))
        return 2
    except KeyboardInterrupt:
        print_error("interrupted; what was there before is as it was")
        return 2
    except OSError as error:
        if arguments.verbose:
            traceback.print_exc()
        print_error(f"{error.filename or 'the output'}: cannot be read or written ({error.strerror or error})")
        return 2
    except Exception as error:  # Python's own exit code would be 1: some skipped
        if arguments.verbose:
            traceback.print_exc()
        print_error(f"usdfoot itself failed, please report it ({type(error).__name__}: {error})")
        return 2


class _Parser(argparse.ArgumentParser):
    """Takes what begins with a minus and a digit, like -5:300, for a value; argparse does so from Python 3.14 on."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"-\.?\d")


def build_parser() -> argparse.ArgumentParser:
    """The parser of all verbs."""
    parser = _Parser(
        prog="usdfoot", description="Footsteps as scene description: planned footsteps become character animation."
    )
    parser.set_defaults(command=parser)
    parser.add_argument("--version", action="version", version=f"usdfoot {__version__}")
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    for verb in VERBS:
        add_verb(verbs, verb, talks=verb is not plan)
    return parser


if __name__ == "__main__":
    sys.exit(main())
