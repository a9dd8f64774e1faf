"""usdfoot plan trajectories: footsteps for everyone who moves."""

from __future__ import annotations

import argparse
from pathlib import Path

from usdfoot.cli.batch_flags import add_limits, limits_of
from usdfoot.cli.console import shown_progress
from usdfoot.cli.plan_arguments import SCENE_LIMITS, print_plans
from usdfoot.cli.quantities import duration, rate

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "trajectories"
HELP = "footsteps for everyone who moves: animated prims, pedestrian data"
DESCRIPTION = (
    "Plans footsteps along trajectories: agents with usdfoot:agent:trajectory, or animated Points and PointInstancers "
    "with ids, or animated Xforms and SkelRoots of a USD scene; or a file of pedestrian data (ETH, UCY, Juelich, "
    "PedPy, JuPedSim, CSV). People and their feet are kept apart."
)
EPILOG = """\
example:
  usdfoot plan trajectories crowd_zara.usda -o plans.usdc
  usdfoot plan trajectories students001.txt --unit m --rate 25 --scene plaza.usda -o plans.usdc

units and rates are never guessed: where a file does not state them, --unit and --rate are needed. y of a file is
north, -Z on a Y-up stage.

to animate: sublayer plans.usdc and the scene in one stage (.usdc keeps times exactly, .usda to six digits).

exit codes: 0 all planned, 1 some skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.plan_trajectories import TrackFormat, plan_track_file
  report = plan_track_file("students001.txt", "plans.usdc", track_format=TrackFormat(unit="m", rate=25))
"""
USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
FILE_FLAGS = {"unit": "", "rate": 0.0, "layout": "auto", "scene": None}
"""Flags that mean nothing with a scene, and what they are when not given."""
SCENE_FLAGS = {"agents": "*", "prims": ""}
"""Those that mean nothing with a file."""
LAYOUTS = ("auto", "eth", "obsmat", "juelich", "vsp")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("source", metavar="SOURCE", help="USD scene, or file of pedestrian data")
    parser.add_argument("-o", "--output", metavar="PLANS", required=True, help="layer to write: .usd, .usda or .usdc")
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names or prim paths of agents (default: all)")
    parser.add_argument("--prims", metavar="GLOB", default="", help="paths of animated prims to take, agents or not")
    parser.add_argument("--unit", default="", help="of a file's positions: m, cm, mm, ft, in, or metres a unit")
    parser.add_argument("--rate", metavar="HZ", type=rate, default=0.0, help="frames a second of a file")
    parser.add_argument(
        "--layout", choices=LAYOUTS, default="auto", help="columns of a file that does not name them (default: auto)"
    )
    parser.add_argument("--scene", help="USD file whose units, terrain and character the plans of a file are for")
    parser.add_argument(
        "--smoothing", metavar="SECONDS", type=duration, default=0.3, help="filter on positions (default: 0.3)"
    )
    parser.add_argument(
        "--apart",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="move people and feet that are in each other (default: on)",
    )
    add_limits(parser, *SCENE_LIMITS)


def run(arguments: argparse.Namespace) -> int:
    """Plan; 0 = everyone, 1 = some skipped."""
    from usdfoot.errors import TrackError
    from usdfoot.pipeline.plan_trajectories import TrackFormat, plan_scene_trajectories, plan_track_file
    from usdfoot.planning.trajectories import TrajectoryOptions

    is_scene = Path(arguments.source).suffix.lower() in USD_SUFFIXES
    for flag, default in (FILE_FLAGS if is_scene else SCENE_FLAGS).items():
        if getattr(arguments, flag) != default:
            kind = "a file of pedestrian data" if is_scene else "a USD scene"
            raise TrackError(f"--{flag}", f"is for {kind}", f"leave it out with {arguments.source}")
    options = TrajectoryOptions(smoothing_time=arguments.smoothing, apart=arguments.apart)
    with shown_progress(quiet=arguments.quiet) as progress:
        if is_scene:
            report = plan_scene_trajectories(
                arguments.source,
                arguments.output,
                agents=arguments.agents,
                prims=arguments.prims,
                options=options,
                limits=limits_of(arguments),
                progress=progress,
            )
        else:
            report = plan_track_file(
                arguments.source,
                arguments.output,
                track_format=TrackFormat(unit=arguments.unit, rate=arguments.rate, layout=arguments.layout),
                scene=arguments.scene,
                options=options,
                limits=limits_of(arguments),
                progress=progress,
            )
    return print_plans(report, quiet=arguments.quiet)
