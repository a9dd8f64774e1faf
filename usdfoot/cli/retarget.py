"""usdfoot retarget: clips of one rig on a character of another."""

from __future__ import annotations

import argparse

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.tables import retarget_table

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "retarget"
HELP = "put clips of one rig on a character of another"
DESCRIPTION = (
    "Puts all clips of a USD file on another character and keeps their feet on the ground: limbs keep their "
    "directions, steps are scaled by the length of the legs. Joints correspond by their names and by the shape of the "
    "hierarchy."
)
EPILOG = """\
example:
  usdfoot retarget mocap.usdc --to hero.usd -o hero_clips.usd
  usdfoot retarget mocap.usdc --to cast.usd --prim /Cast/Hero -o hero_clips.usd
  usdfoot analyze hero_clips.usd

to animate: reference hero_clips.usd in a scene with a footstep plan; it holds the character and its clips.

exit codes: 0 all clips written, 1 some skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.retarget import retarget
  report = retarget("mocap.usdc", "hero.usd", "hero_clips.usd")
"""
PLANT = {"auto": None, "always": True, "never": False}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("clips", metavar="CLIPS", help="USD file with SkelAnimations and their Skeletons")
    parser.add_argument("--to", metavar="CHARACTER", required=True, help="USD file with the character")
    parser.add_argument("--prim", metavar="PATH", default="", help="the character's prim, where its file has several")
    parser.add_argument(
        "--plant",
        choices=tuple(PLANT),
        default="auto",
        help="hold the balls of the feet where they stand (auto: unless the legs of both have one shape)",
    )
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help="stage to write: .usd, .usda or .usdc")


def run(arguments: argparse.Namespace) -> int:
    """Retarget; 0 = all clips, 1 = some skipped."""
    from usdfoot.pipeline.retarget import retarget

    with shown_progress(quiet=arguments.quiet) as progress:
        report = retarget(
            arguments.clips,
            arguments.to,
            arguments.output,
            character_prim=arguments.prim,
            plant=PLANT[arguments.plant],
            progress=progress,
        )
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(retarget_table(report.clips))
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if report.skipped else 0
