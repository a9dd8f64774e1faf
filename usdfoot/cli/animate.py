"""usdfoot animate: footsteps in, a crowd out."""

from __future__ import annotations

import argparse
import os
from contextlib import suppress
from typing import TYPE_CHECKING

from usdfoot.cli.batch_flags import add_batch_flags, limits_of
from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.physics_flags import add_physics_flags, body_tuning, physics_options
from usdfoot.cli.quantities import count, distance, duration, frame_range, root_weight, warp_range
from usdfoot.cli.tables import step_table

if TYPE_CHECKING:
    from usdfoot.model.levels import DetailLevels
    from usdfoot.physics.motion_options import MotionOptions

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "animate"
HELP = "animate the agents of a scene along their footsteps"
DESCRIPTION = (
    "Reads a USD scene, animates every agent along its footstep plan, and writes a layered crowd into a folder."
)
EPILOG = """\
example:
  usdfoot animate scenes/walk_flat.usda -o build/walk
  usdfoot animate city.usd -o build/city --agents 'Extra_*' --frames 1:240
  usdfoot animate city.usd -o build/city --max-root-weight-within 0.02
  usdfoot animate tracks.usd -o build/tracks --motion physics --crouch 0.1
  usdfoot animate city.usd -o build/city --every 2 --near 15 --camera /World/Camera
  usdfoot animate city.usd -o build/city --lod full:15:mid:40:low
  usdfoot animate city.usd -o build/city --scheduler tcp://farm:8786

exit codes: 0 all written, 1 some agents or clips skipped (listed), 2 nothing written

in Python:
  from usdfoot.pipeline.animate import animate
  report = animate("scenes/walk_flat.usda", "build/walk")
"""


LARGE_FILE = 4_000_000
"""A scene's file with more bytes is taken to be a crowd's: workers take as long to start as it takes to read."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="USD file with characters, clips and footstep plans")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder for crowd.usd and its layers")
    parser.add_argument("--agents", metavar="GLOB", default="*", help="names or prim paths of agents (default: all)")
    parser.add_argument(
        "--frames", metavar="A:B", type=frame_range, help="first and last time code (default: those of the plans)"
    )
    parser.add_argument(
        "--conform",
        action="store_true",
        help="first lay the footsteps of plans on the terrain, at its height and with its slope (default: as given)",
    )
    _add_blend_flags(parser)
    parser.add_argument(
        "--smoothing",
        metavar="SECONDS",
        type=duration,
        default=0.25,
        help="window in which trajectories that agents follow are smoothed (default: %(default)s)",
    )
    add_physics_flags(parser)
    _add_far_flags(parser)
    parser.add_argument("--collect", action="store_true", help="copy the characters' files into DIR")
    add_batch_flags(parser)


def _add_blend_flags(parser: argparse.ArgumentParser) -> None:
    """Add the arguments on how clips are blended."""
    parser.add_argument(
        "--correction",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="correct the blended landings before IK (default: on)",
    )
    parser.add_argument(
        "--seam",
        choices=("inertialise", "crossfade", "none"),
        default="inertialise",
        help="how one step passes into the next (default: %(default)s)",
    )
    parser.add_argument(
        "--space",
        choices=("neighbours", "delaunay", "3d"),
        default="neighbours",
        help="blend the examples most like the step, those of the paper's triangle, or those of the tetrahedron of "
        "landing and root speed (default: %(default)s)",
    )
    parser.add_argument(
        "--landing-frame",
        choices=("support", "root"),
        default="support",
        help="look for footsteps from the support ball, or from the root, as the paper does, whose error IK then has "
        "to mend in every step; not with root weights (default: %(default)s)",
    )
    parser.add_argument(
        "--band",
        choices=("polar", "cartesian"),
        default="polar",
        help="weigh root velocities by bearing and speed, as the paper does, or by x and z (default: %(default)s)",
    )
    parser.add_argument(
        "--blend",
        choices=("sum", "slerp"),
        default="sum",
        help="blend rotations by sums, or by slerps one after the other, as the paper does (default: %(default)s)",
    )
    parser.add_argument(
        "--root-weight",
        metavar="X",
        type=root_weight,
        help="0 = land exactly on the footsteps, 1 = keep the root's velocity exactly (default: as the scene says)",
    )
    parser.add_argument(
        "--max-root-weight-within",
        metavar="METRES",
        type=distance,
        help="give each step the largest root weight, X at most, that plants it this near its footstep",
    )
    parser.add_argument(
        "--warp-range",
        metavar="A:B",
        type=warp_range,
        default=(0.5, 2.0),
        help="steps that take less than A or more than B times as long as their clips are named (default: 0.5:2)",
    )


def _add_far_flags(parser: argparse.ArgumentParser) -> None:
    """Add the arguments on agents that are far away."""
    parser.add_argument(
        "--every",
        metavar="K",
        type=count,
        default=1,
        help="write far agents at every K-th frame, in turns, and wherever a planted foot would drift (default: 1)",
    )
    parser.add_argument(
        "--near",
        metavar="METRES",
        type=distance,
        default=0.0,
        help="agents that come this near to the camera are not far (default: without --camera, all agents are far)",
    )
    parser.add_argument("--camera", metavar="PRIM", default="", help="path of the camera that --near counts from")
    parser.add_argument(
        "--lod",
        metavar="LEVELS",
        type=detail_levels,
        help="variants of the characters from near to far with the distances in metres between them, like "
        "full:15:low, as levels of detail (UsdLod); other programs show the first",
    )


def detail_levels(text: str) -> DetailLevels:
    """Levels of detail as given."""
    from usdfoot.errors import UsdfootError
    from usdfoot.model.levels import DetailLevels

    try:
        return DetailLevels.parse(text)
    except UsdfootError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def run(arguments: argparse.Namespace) -> int:
    """Animate; 0 = all agents, 1 = some skipped."""
    from usdfoot.batch.executors import load_early, open_executor

    if arguments.chunk is not None:
        return _run_chunk(arguments)
    with (
        open_executor(workers=arguments.workers, scheduler=arguments.scheduler, beside=True) as executor,
        shown_progress(quiet=arguments.quiet) as progress,
    ):
        if _is_large_and_new(arguments):
            load_early(executor)
        from usdfoot.pipeline.animate import animate
        from usdfoot.readers.stage import keep_open, open_stage

        progress("read", 0, 0)
        stage = open_stage(arguments.scene)
        if arguments.is_own:
            keep_open(stage)
        report = animate(
            stage,
            arguments.output,
            agents=arguments.agents,
            frames=arguments.frames,
            options=_options(arguments),
            collect=arguments.collect,
            levels=arguments.lod,
            chunk_size=arguments.chunk_size,
            limits=limits_of(arguments),
            executor=executor,
            beside=arguments.scheduler is None,
            progress=progress,
        )
    print_problems(report.problems, quiet=arguments.quiet)
    console = results_console()
    console.print(step_table(report.results, report.totals))
    if report.kept_agents:
        agents = f"{report.kept_agents} of {len(report.results)} agents"
        console.print(f"kept {report.kept} of {report.chunks} chunks, in which nothing changed: {agents} in all")
    console.print(f"wrote {report.crowd_file}", soft_wrap=True)
    return 1 if report.skipped else 0


def _is_large_and_new(arguments: argparse.Namespace) -> bool:
    """Whether a scene's file is as large as a crowd's, of which nothing is made yet: then workers will be needed."""
    folder = arguments.output
    with suppress(OSError):
        return os.path.getsize(arguments.scene) > LARGE_FILE and not (os.path.exists(folder) and os.listdir(folder))
    return False


def _run_chunk(arguments: argparse.Namespace) -> int:
    """Make one chunk; 0 = all of its agents, 1 = some skipped."""
    from usdfoot.pipeline.animate import animate_chunk

    record = animate_chunk(
        arguments.scene,
        arguments.output,
        arguments.chunk,
        agents=arguments.agents,
        frames=arguments.frames,
        options=_options(arguments),
        collect=arguments.collect,
        levels=arguments.lod,
        chunk_size=arguments.chunk_size,
        limits=limits_of(arguments),
    )
    print_problems(record.problems, quiet=arguments.quiet)
    done = "kept" if record.is_kept else "made"
    results_console().print(f"{done} chunk {arguments.chunk} with {len(record.agents)} agents", soft_wrap=True)
    return 1 if any(problem.severity == "error" for problem in record.problems) else 0


def _options(arguments: argparse.Namespace) -> MotionOptions:
    """The options as given."""
    from usdfoot.engine.follow_options import FollowOptions
    from usdfoot.model.sampling import SamplingOptions
    from usdfoot.physics.motion_options import MotionOptions

    return MotionOptions(
        motion=arguments.motion,
        conform=arguments.conform,
        physics=physics_options(arguments),
        tuning=body_tuning(arguments),
        correction=arguments.correction,
        seam=arguments.seam,
        space=arguments.space,
        frame=arguments.landing_frame,
        blend=arguments.blend,
        band=arguments.band,
        root_weight=arguments.root_weight,
        root_weight_within=arguments.max_root_weight_within,
        least_time_warp=arguments.warp_range[0],
        most_time_warp=arguments.warp_range[1],
        sampling=SamplingOptions(every=arguments.every, near=arguments.near, camera=arguments.camera),
        follow=FollowOptions(smoothing_time=arguments.smoothing),
    )
