"""usdfoot inspect: look at a written crowd."""

from __future__ import annotations

import argparse

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.quantities import above_zero, count
from usdfoot.model.overlay_kinds import KINDS

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "inspect"
HELP = "draw what happened on every footstep of a written crowd"
DESCRIPTION = (
    "Draws footsteps by status, errors as columns, contacts, the centre of mass by phase, the footstep space with the "
    "blend weights at the current step, and timing over a written crowd, as guides below /__usdfoot in a layer; or "
    "shows figures, plans and playing stick figures on one web page."
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
  from usdfoot.pipeline.page import write_page
  report = write_page("build/walk/crowd.usd", "report.html")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("crowd", metavar="CROWD", help="crowd.usd written by usdfoot animate")
    parser.add_argument("-o", "--output", metavar="LAYER", help="overlay to write: .usd, .usda or .usdc")
    parser.add_argument("--html", metavar="PAGE", help="one web page with all of it, and a 3-D view that plays")
    parser.add_argument(
        "--workers",
        metavar="N",
        type=count,
        help="processes that measure many agents for the page (default: a core each)",
    )
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


def run(arguments: argparse.Namespace) -> int:
    """Inspect; 0 = all agents drawn, 1 = some could not be read."""
    from usdfoot.batch.executors import open_executor
    from usdfoot.errors import UsdfootError
    from usdfoot.pipeline.inspect import InspectOptions, InspectReport, inspect
    from usdfoot.pipeline.page import PageReport, write_page

    if arguments.output is None and arguments.html is None:
        raise UsdfootError("inspect", "has nothing to write", "give -o LAYER or --html PAGE")
    reports: list[InspectReport | PageReport] = []
    with shown_progress(quiet=arguments.quiet) as progress:
        if arguments.output is not None:
            options = InspectOptions(
                error_scale=arguments.error_scale,
                second_length=arguments.second_length,
                kinds=tuple(arguments.kinds),
            )
            overlay = inspect(
                arguments.crowd, arguments.output, agents=arguments.agents, options=options, progress=progress
            )
            reports.append(overlay)
        if arguments.html is not None:
            with open_executor(workers=arguments.workers) as executor:
                page = write_page(
                    arguments.crowd, arguments.html, agents=arguments.agents, executor=executor, progress=progress
                )
            reports.append(page)
    print_problems(dict.fromkeys(problem for report in reports for problem in report.problems), quiet=arguments.quiet)
    for report in reports:
        results_console().print(f"wrote {report.file}", soft_wrap=True)
    return 1 if any(report.skipped for report in reports) else 0
