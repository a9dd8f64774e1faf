"""What the planners' verbs have in common: arguments and how results are shown."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from usdfoot.cli.batch_flags import add_limits
from usdfoot.cli.console import print_problems, results_console
from usdfoot.cli.quantities import above_zero
from usdfoot.cli.tables import plan_table

if TYPE_CHECKING:
    from usdfoot.pipeline.plan import PlanReport

__all__ = ["SCENE_LIMITS", "add_agent_arguments", "add_scene_arguments", "print_plans"]

SCENE_LIMITS = ("agents", "joints", "triangles", "prims")
"""What planners may find too much of in a scene."""


def add_scene_arguments(
    parser: argparse.ArgumentParser, scene: str, *, limited: tuple[str, ...] = SCENE_LIMITS
) -> None:
    """Add the scene, how much of it is read, and the layer to write."""
    parser.add_argument("scene", metavar="SCENE", help=scene)
    parser.add_argument("-o", "--output", metavar="PLANS", required=True, help="layer to write: .usd, .usda or .usdc")
    add_limits(parser, *limited)


def add_agent_arguments(parser: argparse.ArgumentParser) -> None:
    """Add who is planned for, and how wide they are."""
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names or prim paths of agents (default: all)")
    parser.add_argument(
        "--radius",
        metavar="METRES",
        type=above_zero,
        default=0.25,
        help="of their bodies seen from above (default: %(default)s)",
    )


def print_plans(report: PlanReport, *, quiet: bool) -> int:
    """Problems on stderr, the plans on stdout; gives back the exit code."""
    print_problems(report.problems, quiet=quiet)
    console = results_console()
    console.print(plan_table(report.plans))
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if report.skipped else 0
