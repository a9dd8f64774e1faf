"""usdfoot completion: verbs and flags completed by the shell."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from usdfoot.errors import UsdfootError

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "SHELLS", "add_arguments", "completion_script", "run"]

NAME = "completion"
HELP = "print a script that makes a shell complete verbs, flags and files"
DESCRIPTION = "Prints a completion script for a shell, to be loaded by it or put where it looks for such scripts."
EPILOG = """\
example:
  usdfoot completion bash > ~/.local/share/bash-completion/completions/usdfoot
  usdfoot completion zsh > ~/.zfunc/_usdfoot    # a folder of $fpath
  usdfoot completion fish > ~/.config/fish/completions/usdfoot.fish

exit codes: 0 printed, 2 shtab is not installed

in Python:
  from usdfoot.cli.completion import completion_script
  from usdfoot.cli.main import build_parser
  print(completion_script(build_parser(), "bash"))
"""
SHELLS = ("bash", "zsh", "fish")
FOLDERS = {"DIR"}
FILES = {"CASE", "CHARACTER", "CLIPS", "CROWD", "FILE", "FIXED", "LAYER"} | {
    "OUT",
    "PAGE",
    "PLANS",
    "SCENE",
    "SOURCE",
    "USD",
}
"""Names arguments have in usage where they are folders or files."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("shell", choices=SHELLS, help="whose script to print")


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    print(completion_script(arguments.command, arguments.shell))
    return 0


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The completion script of a parser; the parser's arguments are told which of them are files.

    Args:
        parser: Of the whole command.
        shell: One of `SHELLS`.

    Raises:
        UsdfootError: If shtab, which writes the script, is not installed.
    """
    try:
        import shtab
    except ImportError as error:
        raise UsdfootError("shtab", "is not installed", "pip install shtab") from error
    for action in _actions(parser):
        if action.metavar in FILES:
            setattr(action, "complete", shtab.FILE)  # noqa: B010 - argparse knows no such attribute
        elif action.metavar in FOLDERS:
            setattr(action, "complete", shtab.DIRECTORY)  # noqa: B010
    return str(shtab.complete(parser, shell=shell))


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Arguments of a parser and of all verbs below it."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _actions(below)
