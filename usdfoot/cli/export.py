"""usdfoot export: footstep plans as a table."""

from __future__ import annotations

import argparse

from usdfoot.cli.console import print_problems, results_console
from usdfoot.cli.tables import plan_table

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "export"
HELP = "footstep plans as a CSV file"
DESCRIPTION = (
    "Writes all footstep plans of a stage, planned or executed, as a CSV file: a row a footstep, with the columns "
    "plan, foot, x, y, z, yaw, strike, liftoff, nx, ny, nz, style, root_weight. Metres with +Y up, degrees (0 faces "
    "+Z, 90 faces +X), seconds. Columns that would say nothing (one plan, level ground, no style) are left out."
)
EPILOG = """\
example:
  usdfoot export plans.usda -o plans.csv
  usdfoot import plans.csv -o plans.usda

exit codes: 0 all exported, 1 some plans skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.import_plans import export_plans
  report = export_plans("plans.usda", "plans.csv")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="USD file with footstep plans")
    parser.add_argument("-o", "--output", metavar="CSV", required=True, help="file to write: .csv")


def run(arguments: argparse.Namespace) -> int:
    """Export; 0 = all plans, 1 = some skipped."""
    from usdfoot.pipeline.import_plans import export_plans

    report = export_plans(arguments.scene, arguments.output)
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(plan_table(report.plans))
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if report.skipped else 0
