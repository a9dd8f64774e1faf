"""usdfoot plan lint: what is wrong with plans."""

from __future__ import annotations

import argparse
import json

from usdfoot.cli.batch_flags import LIMITED, add_limits, limits_of
from usdfoot.cli.console import print_error, print_problems, results_console
from usdfoot.cli.tables import fault_table

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "lint"
HELP = "check plans before they are animated"
DESCRIPTION = (
    "Checks footstep plans: steps out of reach of the body or its clips, impossible flights, crossing or twisted feet, "
    "steps off the terrain, on steep slopes, against risers or in obstacles, times, feet of different agents in one "
    "place."
)
EPILOG = """\
example:
  usdfoot plan lint shot.usda
  usdfoot plan lint shot.usda --json > faults.json
  usdfoot plan lint shot.usda --fix fixed.usdc

--fix mends times out of order, prints off the ground, crossing feet and colliding feet, and writes what changed of the
plans as a layer; sublayer it over the scene. What is left is listed.

exit codes: 0 no errors (warnings do not count), 1 errors, 2 nothing could be checked

in Python:
  from usdfoot.pipeline.lint import lint_scene
  for fault in lint_scene("shot.usda").faults: print(fault)
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="USD file with footstep plans; best with terrain and agents")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--fix", metavar="FIXED", help="layer to write with the plans that could be mended")
    parser.add_argument(
        "--clips",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="check against the agents' clips too (default: on)",
    )
    add_limits(parser, *LIMITED)


def run(arguments: argparse.Namespace) -> int:
    """Lint; 0 = no errors."""
    from usdfoot.pipeline.lint import lint_scene

    report = lint_scene(arguments.scene, clips=arguments.clips, fix=arguments.fix, most=limits_of(arguments))
    if arguments.json:
        print(json.dumps(report.to_json(), indent=1, allow_nan=False))
    else:
        console = results_console()
        if report.faults:
            console.print(fault_table(report.faults))
        errors = sum(fault.severity == "error" for fault in report.faults)
        footsteps = sum(len(plan) for plan in report.plans.values())
        warnings = len(report.faults) - errors
        console.print(f"plans: {len(report.plans)}, footsteps: {footsteps}, errors: {errors}, warnings: {warnings}")
    print_problems(report.problems, quiet=arguments.quiet)
    if report.file:
        print_error(f"wrote {report.file}")
    return 0 if report.clean else 1
