"""usdfoot inspect: look at a written crowd."""

from __future__ import annotations

import argparse
import math

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.model.overlay import KINDS

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "inspect"
HELP = "draw what happened on every footstep of a written crowd"
DESCRIPTION = (
    "Draws footsteps by status, errors as columns, contacts, the centre of mass by phase, the footstep space with the "
    "blend weights at the current step, and timing over a written crowd, as guides below /__usdfoot in a layer."
)
EPILOG = """\
example:
  usdfoot inspect build/walk/crowd.usd -o inspect.usda
  usdview --sessionLayer inspect.usda build/walk/crowd.usd    # View > Display Purposes > Guide
  usdfoot inspect build/city/crowd.usd -o inspect.usdc --agents 'Hero*' --kinds Errors Com
  usdfoot inspect build/walk/crowd.usd --html report.html

exit codes: 0 all agents drawn, 1 some could not be read (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.inspect import inspect
  report = inspect("build/walk/crowd.usd", "inspect.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("crowd", metavar="CROWD", help="crowd.usd written by usdfoot animate")
    parser.add_argument("-o", "--output", metavar="LAYER", help="overlay to write: .usd, .usda or .usdc")
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names of the agents to draw (default: all)")
    parser.add_argument(
        "--error-scale",
        metavar="X",
        type=above_zero,
        default=100.0,
        help="height of the columns over the errors (default: %(default)g)",
    )
    parser.add_argument(
        "--second-length",
        metavar="METRES",
        type=above_zero,
        default=0.5,
        help="length of a timing dagger that stands for a second (default: %(default)g)",
    )
    parser.add_argument(
        "--kinds",
        metavar="KIND",
        nargs="+",
        choices=KINDS,
        default=KINDS,
        help=f"what to draw, of {', '.join(KINDS)} (default: all; the space needs the clips to be analysed again)",
    )


def above_zero(text: str) -> float:
    """A number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return value


def run(arguments: argparse.Namespace) -> int:
    """Inspect; 0 = all agents drawn, 1 = some could not be read."""
    from usdfoot.errors import UsdfootError
    from usdfoot.pipeline.inspect import InspectOptions, inspect

    if arguments.output is None:
        raise UsdfootError("inspect", "has nothing to write", "give -o LAYER")
    with shown_progress(quiet=arguments.quiet) as progress:
        report = inspect(
            arguments.crowd,
            arguments.output,
            agents=arguments.agents,
            options=InspectOptions(
                error_scale=arguments.error_scale,
                second_length=arguments.second_length,
                kinds=tuple(arguments.kinds),
            ),
            progress=progress,
        )
    print_problems(report.problems, quiet=arguments.quiet)
    results_console().print(f"wrote {report.file}", soft_wrap=True)
    return 1 if report.skipped else 0
