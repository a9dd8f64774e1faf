"""usdfoot analyze: what clips contain."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.quantities import distance
from usdfoot.cli.tables import clip_table, coverage_table, empty_lines

if TYPE_CHECKING:
    from usdfoot.spaces.holes import HoleOptions

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "analyze"
HELP = "find the contacts and steps of clips"
DESCRIPTION = (
    "Prints what every clip of a USD file contains, and can write its contact events for an artist to correct."
)
EPILOG = """\
example:
  usdfoot analyze clips.usdc
  usdfoot analyze clips.usdc --styles -o clips_events.usda
  usdfoot analyze clips.usdc --plots build/spaces
  usdfoot analyze clips.usdc --coverage coverage.usda
  usdfoot analyze clips.usdc --fill -o clips_filled.usda

exit codes: 0 all clips analysed, 1 some could not be (listed), 2 none or nothing written

in Python:
  from usdfoot.pipeline.analyze import analyze
  report = analyze("clips.usdc", output="clips_events.usda")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("clips", metavar="CLIPS", help="USD file with SkelAnimations")
    parser.add_argument(
        "--styles",
        action="store_true",
        help="group clips without a style by flight, height of the root and speed; with -o write usdfoot:clip:style",
    )
    parser.add_argument(
        "--plots", metavar="DIR", help="draw footstep and root velocity spaces with their errors (extra: report)"
    )
    parser.add_argument(
        "--coverage",
        metavar="MAP",
        help="stage (and picture beside it) that shows where steps can land, how well, and what to capture next",
    )
    parser.add_argument(
        "--fill",
        action="store_true",
        help="make steps of physics, in the style of the nearest clips, for landings no clip shows; -o adds them. "
        "It is for libraries that lack a movement: runs are made from runs only, never from walks",
    )
    parser.add_argument(
        "--fill-gap", type=distance, metavar="METRES", help="altitude of a triangle of landings that is a hole (0.2)"
    )
    parser.add_argument("-o", "--output", metavar="OUT", help="layer over CLIPS to write the events to")


def run(arguments: argparse.Namespace) -> int:
    """Analyze; 0 = all clips, 1 = some could not be used."""
    from usdfoot.pipeline.analyze import analyze

    with shown_progress(quiet=arguments.quiet) as progress:
        report = analyze(
            arguments.clips,
            output=arguments.output,
            styles=arguments.styles,
            plots=arguments.plots,
            coverage=arguments.coverage,
            fill=_holes(arguments),
            progress=progress,
        )
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(clip_table(report.summaries))
    if arguments.coverage:
        console.print(coverage_table(report.coverage))
        for line in empty_lines(report.coverage):
            console.print(line, soft_wrap=True)
    for file in filter(None, (report.coverage_file,)):
        console.print(f"wrote {file}", soft_wrap=True)
    if report.output is not None:
        console.print(f"wrote {report.output}", soft_wrap=True)
    for filled in report.filled:
        name, holes = filled.source.skeleton.name, len(filled.holes)
        console.print(f"{name}: {len(filled.clips)} of {holes} holes filled with synthetic clips", soft_wrap=True)
        if filled.styles_without_runs:
            styles = ", ".join(filled.styles_without_runs)
            console.print(f"{name}: no clip of style {styles} runs, and no run is made from walks", soft_wrap=True)
    for picture in report.plots:
        console.print(f"drew {picture}", soft_wrap=True)
    return 1 if any(problem.severity == "error" for problem in report.problems) else 0


def _holes(arguments: argparse.Namespace) -> HoleOptions | None:
    """What a hole is, if holes are to be filled."""
    from usdfoot.spaces.holes import HoleOptions

    if arguments.fill_gap is not None:
        return HoleOptions(gap=arguments.fill_gap)
    return HoleOptions() if arguments.fill else None
