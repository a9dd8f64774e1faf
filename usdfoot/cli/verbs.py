"""How a verb is put on a parser, at the top and below `usdfoot plan`."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_verb"]


def add_verb(verbs: Any, verb: Any, *, talks: bool = True) -> None:
    """Add a verb, a module of this package, to sub-parsers.

    Args:
        verbs: From `ArgumentParser.add_subparsers`.
        verb: Module with NAME, HELP, DESCRIPTION, EPILOG, add_arguments and run.
        talks: Give it -q and -v; a group of verbs gives them to each of its own.
    """
    sub = verbs.add_parser(
        verb.NAME,
        help=verb.HELP,
        description=verb.DESCRIPTION,
        epilog=verb.EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    verb.add_arguments(sub)
    if talks:
        talk = sub.add_mutually_exclusive_group()
        talk.add_argument("-q", "--quiet", action="store_true", help="no progress, no warnings")
        talk.add_argument("-v", "--verbose", action="store_true", help="say what is found and assumed")
        sub.set_defaults(run=verb.run)
