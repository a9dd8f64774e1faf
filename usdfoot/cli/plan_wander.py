"""usdfoot plan wander: one footstep at a time, at random or to goals."""

from __future__ import annotations

import argparse

from usdfoot.cli.batch_flags import limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import add_agent_arguments, add_scene_arguments, print_plans
from usdfoot.cli.quantities import area, seed, several

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "wander"
HELP = "agents that wander at random or to goals around obstacles"
DESCRIPTION = (
    "Plans agents that follow nothing yet, one footstep at a time: at random, or to their usdfoot:agent:goal, on "
    "walkable terrain and around what has UsdfootObstacleAPI, where that will be as they get there. "
    "Agents do not see each other; that is what usdfoot plan crowd is for."
)
EPILOG = """\
example:
  usdfoot plan wander park.usda -o plans.usda --steps 200 --seed 7
  usdfoot plan wander park.usda -o plans.usda --bounds=-10,-10,10,10

exit codes: 0 all planned, 1 some agents skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_goals import plan_scene_wander
  report = plan_scene_wander("park.usda", "plans.usda", steps=200, seed=7)

step by step: usdfoot.planning.wander.wander is a generator of footsteps; its send() tells it how the world has changed,
obstacles that move among it, or its goals (usdfoot.planning.wander.News).
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_scene_arguments(parser, "USD file with agents, terrain and obstacles")
    add_agent_arguments(parser)
    parser.add_argument(
        "--steps",
        metavar="N",
        type=several,
        default=100,
        help="footsteps at most; who does not arrive is named (default: 100)",
    )
    parser.add_argument("--seed", metavar="N", type=seed, default=0, help="of the random numbers (default: 0)")
    parser.add_argument(
        "--bounds",
        metavar="X0,Z0,X1,Z1",
        type=area,
        help="area to stay in [m]: x, and z, or on a Z-up stage minus y (default: the terrain alone ends it)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Plan; 0 = all agents, 1 = some skipped."""
    from usdfoot.pipeline.goal_scene import GoalOptions
    from usdfoot.pipeline.plan_goals import plan_scene_wander

    with shown_progress(quiet=arguments.quiet) as progress:
        report = plan_scene_wander(
            arguments.scene,
            arguments.output,
            options=GoalOptions(agents=arguments.agents, radius=arguments.radius),
            steps=arguments.steps,
            seed=arguments.seed,
            bounds=arguments.bounds,
            limits=limits_of(arguments),
            progress=progress,
        )
    return print_plans(report, quiet=arguments.quiet)
