"""Arguments of large crowds: who makes the chunks, and how much is too much."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from usdfoot.cli.quantities import count

if TYPE_CHECKING:
    from usdfoot.model.limits import Limits

__all__ = ["LIMITED", "add_batch_flags", "add_limits", "limits_of"]

LIMITED = ("agents", "footsteps", "joints", "frames", "triangles", "prims")
"""What there may be too much of, as the options' names have it."""


def add_batch_flags(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--workers",
        metavar="N",
        type=count,
        help="processes that animate chunks of agents (default: as many as there are cores and chunks)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="Dask cluster whose workers animate instead, like tcp://host:8786 (needs the extra dask)",
    )
    parser.add_argument(
        "--chunk-size",
        metavar="N",
        type=count,
        default=100,
        help="agents a chunk, fewer of long shots (default: %(default)s)",
    )
    parser.add_argument(
        "--chunk", metavar="INDEX", type=int, help="make this chunk only, as a farm's task does; crowd.usd comes later"
    )
    add_limits(parser, *LIMITED)


def add_limits(parser: argparse.ArgumentParser, *names: str) -> None:
    """Add --max-NAME for each of some of `LIMITED`."""
    for name in names:
        parser.add_argument(f"--max-{name}", metavar="N", type=count, help=f"refuse what has more {name} than this")


def limits_of(arguments: argparse.Namespace) -> Limits:
    """Limits as given, else the defaults."""
    from usdfoot.model.limits import Limits

    given = {name: getattr(arguments, f"max_{name}", None) for name in LIMITED}
    return Limits(**{name: value for name, value in given.items() if value is not None})
