"""usdfoot plan timing: times for footprints that have none."""

from __future__ import annotations

import argparse

from usdfoot.cli.batch_flags import limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import add_scene_arguments, print_plans
from usdfoot.cli.quantities import above_zero, number

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "timing"
HELP = "times for given footprints"
DESCRIPTION = (
    "Gives footprints strike and liftoff times from how far apart they are: people keep the ratio of step length to "
    "cadence, and long steps are leaps. Times that are there are replaced. The layer written sublayers the scene."
)
EPILOG = """\
example:
  usdfoot plan timing prints.usda -o timed.usda
  usdfoot plan timing prints.usda -o timed.usda --speed 1.5 --flight-distance 0.9 --end walking

then edit the times in timed.usda, or animate it: usdfoot animate timed.usda -o shot

exit codes: 0 all timed, 1 some plans skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_timing import time_scene_plans
  report = time_scene_plans("prints.usda", "timed.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    limited = ("footsteps", "joints", "prims")
    add_scene_arguments(parser, "USD file with PointInstancers of footprints", limited=limited)
    parser.add_argument("--plans", metavar="GLOB", default="*", help="names or prim paths of plans (default: all)")
    parser.add_argument(
        "--speed",
        metavar="M/S",
        type=above_zero,
        default=0.0,
        help="mean speed of each plan (default: as the lengths of its steps ask for)",
    )
    parser.add_argument(
        "--flight-distance",
        metavar="METRES",
        type=above_zero,
        default=0.0,
        help="longer steps have a flight (default: where walking would be faster than Froude number 0.5)",
    )
    parser.add_argument(
        "--start-time", metavar="SECONDS", type=number, help="of the first strikes (default: the stage's start)"
    )
    stances = ("standing", "walking")
    parser.add_argument("--start", choices=stances, default="standing", help="stance at the start (default: standing)")
    parser.add_argument("--end", choices=stances, default="standing", help="stance at the end (default: standing)")


def run(arguments: argparse.Namespace) -> int:
    """Time; 0 = all plans, 1 = some skipped."""
    from usdfoot.pipeline.plan_timing import time_scene_plans
    from usdfoot.planning.retiming import TimingOptions

    with shown_progress(quiet=arguments.quiet) as progress:
        report = time_scene_plans(
            arguments.scene,
            arguments.output,
            plans=arguments.plans,
            limits=limits_of(arguments),
            options=TimingOptions(
                speed=arguments.speed,
                flight_distance=arguments.flight_distance,
                start_time=arguments.start_time,
                starts_standing=arguments.start == "standing",
                ends_standing=arguments.end == "standing",
            ),
            progress=progress,
        )
    return print_plans(report, quiet=arguments.quiet)
