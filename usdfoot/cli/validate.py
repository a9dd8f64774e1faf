"""usdfoot validate: measures a written crowd."""

from __future__ import annotations

import argparse
import json

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.quantities import count
from usdfoot.cli.tables import figure_table, target_table, unpromised_table

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "validate"
HELP = "measure a written crowd against its targets"
DESCRIPTION = (
    "Recomputes every figure from the files of a written crowd, through UsdSkel, and compares it with its target."
)
EPILOG = """\
example:
  usdfoot validate build/walk/crowd.usd
  usdfoot validate build/walk/crowd.usd --json > figures.json

exit codes: 0 all figures within their targets, 1 one is not, 2 nothing could be measured

in Python:
  from usdfoot.pipeline.validate import validate
  print(validate("build/walk/crowd.usd").passed)
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("crowd", metavar="CROWD", help="crowd.usd written by usdfoot animate")
    parser.add_argument(
        "--workers", metavar="N", type=count, help="processes that measure many agents (default: a core each)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")


def run(arguments: argparse.Namespace) -> int:
    """Validate; 0 = passed."""
    from usdfoot.batch.executors import open_executor
    from usdfoot.pipeline.validate import validate

    with (
        open_executor(workers=arguments.workers) as executor,
        shown_progress(quiet=arguments.quiet) as progress,
    ):
        validation = validate(arguments.crowd, executor=executor, progress=progress)
    if arguments.json:
        print(json.dumps(validation.to_json(), indent=1, allow_nan=False))
    else:
        console = results_console()
        console.print(figure_table(validation.agents))
        console.print(target_table(validation.total))
        if validation.total.unpromised:
            console.print(unpromised_table(validation.agents))
        console.print("passed" if validation.passed else "NOT passed")
    print_problems(validation.problems, quiet=arguments.quiet)
    return 0 if validation.passed else 1
