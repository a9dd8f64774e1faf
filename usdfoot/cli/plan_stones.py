"""usdfoot plan stones: a way over given footholds."""

from __future__ import annotations

import argparse

from usdfoot.cli.batch_flags import limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import add_scene_arguments, print_plans
from usdfoot.cli.quantities import above_zero

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "stones"
HELP = "a comfortable way over stepping stones"
DESCRIPTION = (
    "Finds for each agent with usdfoot:agent:goal the most comfortable steps from where its prim stands to its last "
    "goal, standing only on given footholds: the tops of the walkable terrain, or what --on names: terrain meshes, "
    "Points, PointInstancers."
)
EPILOG = """\
example:
  usdfoot plan stones river.usda -o plans.usda
  usdfoot plan stones river.usda -o plans.usda --on '/World/Terrain/*' --reach biped

where there is no way the error says how far one leads, and from where the next foothold is how far.

exit codes: 0 all planned, 1 some agents skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_goals import plan_scene_stones
  report = plan_scene_stones("river.usda", "plans.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_scene_arguments(parser, "USD file with agents, goals and footholds")
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names or prim paths of agents (default: all)")
    parser.add_argument("--on", metavar="GLOB", help="prim paths of footholds (default: all walkable terrain)")
    parser.add_argument(
        "--spacing",
        metavar="METRES",
        type=above_zero,
        default=0.12,
        help="between the footholds tried on a mesh (default: %(default)s)",
    )
    parser.add_argument(
        "--reach",
        choices=("clips", "biped"),
        default="clips",
        help="how far a step goes: as far as the clips land, or as the legs allow, from hips spaced as "
        "usdfoot:agent:hipSpacing says (default: %(default)s)",
    )
    parser.add_argument("--leaps", action="store_true", help="count clips with a flight too")


def run(arguments: argparse.Namespace) -> int:
    """Plan; 0 = all agents, 1 = some skipped."""
    from usdfoot.pipeline.goal_scene import GoalOptions
    from usdfoot.pipeline.plan_goals import plan_scene_stones

    with shown_progress(quiet=arguments.quiet) as progress:
        report = plan_scene_stones(
            arguments.scene,
            arguments.output,
            options=GoalOptions(agents=arguments.agents),
            on=arguments.on,
            spacing=arguments.spacing,
            reach=arguments.reach,
            leaps=arguments.leaps,
            limits=limits_of(arguments),
            progress=progress,
        )
    return print_plans(report, quiet=arguments.quiet)
