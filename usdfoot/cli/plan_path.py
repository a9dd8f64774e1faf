"""usdfoot plan path: footsteps along curves."""

from __future__ import annotations

import argparse

from usdfoot.cli.batch_flags import limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import add_scene_arguments, print_plans
from usdfoot.cli.quantities import span

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "path"
HELP = "footsteps along curves"
DESCRIPTION = (
    "Plans footsteps along the BasisCurves and HermiteCurves of a scene, laid on its terrain, and writes them as a "
    "layer. Speed, step length and step width are usdfoot:path attributes of the curve; what is 0 is as in "
    "the clips of who walks, or as people's."
)
EPILOG = """\
example:
  usdfoot plan path city.usda -o plans.usda
  usdfoot plan path city.usda -o plans.usda --start walking --first-foot right

to animate: sublayer plans.usda and city.usda in one stage; agents with usdfoot:agent:path then walk their plans.
(usdfoot animate city.usda plans such agents by itself, standing at both ends.)

a curve that leads where nobody walks is gone round (a warning says how far); where there is no way round the place is
named and nothing is planned. for an obstacle that is animated it goes slower or stands until that has passed (a
warning says how long), and goes round where it stays. usdfoot animate keeps to such curves as drawn.

exit codes: 0 all planned, 1 some agents or curves skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan import plan_scene_paths
  report = plan_scene_paths("city.usda", "plans.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_scene_arguments(parser, "USD file with curves, terrain and perhaps agents")
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names or prim paths of agents (default: all)")
    stances = ("standing", "walking")
    parser.add_argument("--start", choices=stances, default="standing", help="stance at the start (default: standing)")
    parser.add_argument("--end", choices=stances, default="standing", help="stance at the end (default: standing)")
    parser.add_argument(
        "--stand-time", metavar="SECONDS", type=span, default=0.5, help="how long it stands there (default: 0.5)"
    )
    parser.add_argument(
        "--around",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="go round obstacles and ground that is too steep, too low or not walkable, or plan nothing where there is "
        "no way round, and wait for obstacles that are animated; else the curves are kept to as they are drawn "
        "(default: on)",
    )
    parser.add_argument(
        "--first-foot", choices=("left", "right"), default="left", help="the foot that steps first (default: left)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Plan; 0 = all agents and curves, 1 = some skipped."""
    from usdfoot.pipeline.plan import plan_scene_paths
    from usdfoot.planning.path import PathOptions

    with shown_progress(quiet=arguments.quiet) as progress:
        report = plan_scene_paths(
            arguments.scene,
            arguments.output,
            agents=arguments.agents,
            options=PathOptions(
                starts_standing=arguments.start == "standing",
                ends_standing=arguments.end == "standing",
                stand_time=arguments.stand_time,
                first_side=("left", "right").index(arguments.first_foot),
                around=arguments.around,
            ),
            limits=limits_of(arguments),
            progress=progress,
        )
    return print_plans(report, quiet=arguments.quiet)
