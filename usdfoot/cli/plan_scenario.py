"""usdfoot plan scenario: a SteerSuite test case as a stage."""

from __future__ import annotations

import argparse

from usdfoot.cli.console import print_problems, results_console
from usdfoot.cli.quantities import seed

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "scenario"
HELP = "a SteerSuite test case as a stage with agents, goals and obstacles"
DESCRIPTION = (
    "Reads a SteerSuite test case (XML) and writes a USD stage: agents with usdfoot:agent:goal, obstacles with "
    "UsdfootObstacleAPI, the ground. usdfoot plan crowd plans it."
)
EPILOG = """\
example:
  usdfoot plan scenario hallway.xml -o hallway.usda --character human.usdc --clips clips.usdc
  usdfoot plan crowd hallway.usda -o plans.usda

exit codes: 0 written, 1 written but something was odd (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_scenario import convert_scenario
  report = convert_scenario("hallway.xml", "hallway.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("file", metavar="FILE", help="SteerSuite test case (.xml)")
    parser.add_argument("-o", "--output", metavar="SCENE", required=True, help="stage to write: .usd, .usda or .usdc")
    parser.add_argument("--character", metavar="USD", default="", help="file every agent references as its character")
    parser.add_argument("--clips", metavar="USD", default="", help="file with the agents' clips")
    parser.add_argument("--seed", metavar="N", type=seed, default=0, help="of random places (default: %(default)s)")


def run(arguments: argparse.Namespace) -> int:
    """Convert; 0 = as it is, 1 = something was odd."""
    from usdfoot.pipeline.plan_scenario import convert_scenario

    report = convert_scenario(
        arguments.file,
        arguments.output,
        seed=arguments.seed,
        character=arguments.character,
        clips=arguments.clips,
    )
    print_problems(report.problems, quiet=arguments.quiet)
    agents, obstacles = len(report.scenario.seekers), len(report.scenario.obstacles)
    results_console().print(f"wrote {report.file}: {agents} agents, {obstacles} obstacles", soft_wrap=True)
    return 1 if report.problems else 0
