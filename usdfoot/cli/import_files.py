"""usdfoot import: files of other programs as USD."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from usdfoot.cli.batch_flags import add_limits, limits_of
from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.quantities import distance, number, rate
from usdfoot.cli.tables import plan_table
from usdfoot.errors import UsdfootError

if TYPE_CHECKING:
    from rich.table import Table

    from usdfoot.model.capture import Capture

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "import"
HELP = "motion capture as clips, footsteps as plans, meshes and height maps as terrain"
DESCRIPTION = (
    "Writes the clips of motion capture files (BVH, Acclaim's ASF with AMC) and of glTF as one USD stage: clips on the "
    "same bones share a Skeleton, whose rest pose stands on level feet, facing +Z, even where the file's own does not. "
    "Or writes footsteps (CSV, .stp of 3ds Max's Biped, recordings of SteerSuite) as a layer of plans, or meshes (OBJ, "
    "PLY, STL) and heights (PNG, TIFF, ESRI grids, numpy, text) as a layer of terrain. One kind a call."
)
EPILOG = """\
example:
  usdfoot import walk.bvh run.bvh --unit cm -o clips.usd
  usdfoot import 02.asf 02_01.amc 02_03.amc --unit in --rate 120 -o clips.usd
  usdfoot analyze clips.usd
  usdfoot import plan.csv -o plan.usda
  usdfoot import biped.stp --unit in -o plan.usda
  usdfoot import hills.png --unit m --cell 0.04 --height 0.6 --scene shot.usda -o hills.usd

columns of a CSV plan: foot (left, right), x, y, z (metres, +Y up), yaw (degrees, 0 faces +Z, 90 faces +X), strike,
liftoff (seconds); optional: plan (its name), nx, ny, nz (ground's normal), style, root_weight.

units and rates are never guessed: where a file does not state them, --unit and --rate are needed. Lengths of ASF files
are in that unit divided by their `:units length`; glTF is in metres. glTF and terrain need the extra `import`
(pip install 'usdfoot[import]'). Plans and terrain are sublayers of the scene they are for: --scene gives its units.

exit codes: 0 all imported, 1 some files skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.import_clips import ClipFormat, import_clips
  report = import_clips(["walk.bvh", "run.bvh"], "clips.usd", clip_format=ClipFormat(unit="cm"))
  from usdfoot.pipeline.import_plans import import_plans
  report = import_plans(["plan.csv"], "plan.usda")
  from usdfoot.importers.terrain_files import TerrainFormat
  from usdfoot.pipeline.import_terrain import import_terrain
  report = import_terrain(["hills.png"], "hills.usd", terrain_format=TerrainFormat(unit="m", cell=0.04, height=0.6))
"""


KINDS = ".bvh, .asf with its .amc, .gltf, .glb; .csv, .stp, .foot, .rec; .obj, .ply, .stl, .png, .tif, .asc, .npz, .txt"
"""Suffixes of clips; plans; terrain."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("files", metavar="FILE", nargs="+", help=KINDS)
    parser.add_argument("-o", "--output", metavar="USD", required=True, help="stage to write: .usd, .usda or .usdc")
    parser.add_argument("--unit", default="", help="of lengths: m, cm, mm, ft, in, or metres a unit")
    parser.add_argument(
        "--rate", metavar="HZ", type=rate, default=0.0, help="of AMC files and glTF's clips; ticks of .stp"
    )
    parser.add_argument("--up", choices=("Y", "Z"), default="Y", help="axis that points up (default: %(default)s)")
    parser.add_argument("--scene", help="USD file whose units and axes plans and terrain are for")
    parser.add_argument(
        "--cell", metavar="LENGTH", type=distance, default=0.0, help="distance of a height map's columns"
    )
    parser.add_argument(
        "--row-cell", metavar="LENGTH", type=distance, default=0.0, help="of its rows, where it is another one"
    )
    parser.add_argument(
        "--height", metavar="LENGTH", type=number, default=0.0, help="of white in a picture, of 1 in other height maps"
    )
    add_limits(parser, "agents", "footsteps", "joints", "frames", "triangles")


def run(arguments: argparse.Namespace) -> int:
    """Import; 0 = all files, 1 = some skipped."""
    from usdfoot.pipeline.import_clips import CLIP_SUFFIXES
    from usdfoot.pipeline.import_plans import PLAN_SUFFIXES
    from usdfoot.pipeline.import_terrain import TERRAIN_SUFFIXES

    suffixes = {Path(file).suffix.lower() for file in arguments.files}
    if suffixes.isdisjoint((*CLIP_SUFFIXES, *PLAN_SUFFIXES, *TERRAIN_SUFFIXES)):
        first = Path(arguments.files[0])
        if first.is_dir():
            raise UsdfootError(first, "is a folder", "name the files in it")
        remedy = f"{KINDS} can be imported; Blender, for one, turns FBX into glTF"
        raise UsdfootError(first, f"{first.suffix or 'a name without suffix'} is unknown", remedy)
    for kind, run_kind in ((PLAN_SUFFIXES, _run_plans), (TERRAIN_SUFFIXES, _run_terrain)):
        if suffixes <= set(kind):
            return run_kind(arguments)
    mixed = sorted(suffixes.intersection((*PLAN_SUFFIXES, *TERRAIN_SUFFIXES)))
    if mixed:
        raise UsdfootError(", ".join(arguments.files), "are of several kinds", "import clips, plans and terrain apart")
    return _run_clips(arguments)


def _run_plans(arguments: argparse.Namespace) -> int:
    from usdfoot.pipeline.import_plans import PlanFormat, import_plans

    said = PlanFormat(unit=arguments.unit, rate=arguments.rate, up=arguments.up, limits=limits_of(arguments))
    with shown_progress(quiet=arguments.quiet) as progress:
        report = import_plans(
            arguments.files, arguments.output, plan_format=said, scene=arguments.scene, progress=progress
        )
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(plan_table(report.plans))
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if report.skipped else 0


def _run_terrain(arguments: argparse.Namespace) -> int:
    import numpy as np

    from usdfoot.importers.terrain_files import TerrainFormat
    from usdfoot.pipeline.import_terrain import import_terrain

    said = TerrainFormat(
        unit=arguments.unit,
        cell=arguments.cell,
        row_cell=arguments.row_cell,
        height=arguments.height,
        up=arguments.up,
        limits=limits_of(arguments),
    )
    with shown_progress(quiet=arguments.quiet) as progress:
        report = import_terrain(
            arguments.files, arguments.output, terrain_format=said, scene=arguments.scene, progress=progress
        )
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    for name, terrain in report.terrains.items():
        width, height, depth = (float(size) for size in np.ptp(terrain.points, axis=0))
        console.print(f"{name}: {len(terrain.triangles)} triangles, {width:g} x {depth:g} m, {height:g} m high")
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if any(problem.severity == "error" for problem in report.problems) else 0


def _run_clips(arguments: argparse.Namespace) -> int:
    from usdfoot.pipeline.import_clips import ClipFormat, import_clips

    for name in ("scene", "cell", "row_cell", "height"):
        if getattr(arguments, name):
            remedy = "leave it out; clips are written in metres, +Y up"
            raise UsdfootError(f"--{name.replace('_', '-')}", "is for plans and terrain", remedy)
    said = ClipFormat(unit=arguments.unit, rate=arguments.rate, up=arguments.up, limits=limits_of(arguments))
    with shown_progress(quiet=arguments.quiet) as progress:
        report = import_clips(arguments.files, arguments.output, clip_format=said, progress=progress)
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(_table(report.captures))
    console.print(f"wrote {report.file}", soft_wrap=True)
    return 1 if any(problem.severity == "error" for problem in report.problems) else 0


def _table(captures: Mapping[str, Capture]) -> Table:
    """What was imported: clips and the skeletons they move."""
    from rich.table import Table

    table = Table(title="clips")
    table.add_column("clip")
    table.add_column("skeleton")
    for heading in ("joints", "frames", "frames/s", "seconds"):
        table.add_column(heading, justify="right")
    for name, capture in captures.items():
        for clip in capture.clips:
            frames, joints = clip.rotations.shape[:2]
            seconds = (frames - 1) / clip.rate
            table.add_row(clip.name, name, str(joints), str(frames), f"{clip.rate:g}", f"{seconds:.2f}")
    return table
