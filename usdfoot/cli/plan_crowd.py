"""usdfoot plan crowd: footsteps of many agents with goals."""

from __future__ import annotations

import argparse

from usdfoot.cli.batch_flags import limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import add_agent_arguments, add_scene_arguments, print_plans
from usdfoot.cli.quantities import above_zero

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "crowd"
HELP = "footsteps of many agents with goals, past obstacles and each other"
DESCRIPTION = (
    "Plans the footsteps of all agents with usdfoot:agent:goal (prims to visit one after the other), from where the "
    "agents' prims stand, over the walkable terrain of all levels, by ramps and stairs, around what has "
    "UsdfootObstacleAPI and around each other. Feet never come down in one place. Needs JuPedSim: "
    "pip install 'usdfoot[crowd]'."
)
EPILOG = """\
example:
  usdfoot plan crowd plaza.usda -o plans.usda
  usdfoot plan crowd plaza.usda -o plans.usda --radius 0.3 --speed 1.1

to animate: sublayer plans.usda and plaza.usda in one stage; the agents then walk their plans.

exit codes: 0 all planned, 1 some agents skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_goals import plan_scene_crowd
  report = plan_scene_crowd("plaza.usda", "plans.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_scene_arguments(parser, "USD file with agents, goals, terrain and obstacles")
    add_agent_arguments(parser)
    parser.add_argument(
        "--speed", metavar="M/S", type=above_zero, default=1.3, help="of agents that author none (default: %(default)s)"
    )
    parser.add_argument(
        "--duration",
        metavar="SECONDS",
        type=above_zero,
        default=600.0,
        help="simulate no longer (default: %(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Plan; 0 = all agents, 1 = some skipped."""
    from usdfoot.pipeline.goal_scene import GoalOptions
    from usdfoot.pipeline.plan_goals import plan_scene_crowd

    with shown_progress(quiet=arguments.quiet) as progress:
        report = plan_scene_crowd(
            arguments.scene,
            arguments.output,
            options=GoalOptions(agents=arguments.agents, speed=arguments.speed, radius=arguments.radius),
            duration=arguments.duration,
            limits=limits_of(arguments),
            progress=progress,
        )
    return print_plans(report, quiet=arguments.quiet)
